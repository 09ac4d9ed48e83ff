//! Rust sources as words and signs.

/// Whether `token` is a name or a keyword.
pub fn is_word(token: &str) -> bool {
    token.starts_with(|letter: char| letter.is_alphanumeric() || letter == '_')
}

/// Splits `text` into words, `::` and single signs, without comments, texts, lifetimes and `$`.
pub fn tokens(text: &str) -> Vec<String> {
    let letters: Vec<char> = text.chars().collect();
    let is = |at: usize, sign: &str| sign.chars().enumerate().all(|(i, c)| letters.get(at + i) == Some(&c));
    let find =
        |from: usize, sign: &str| (from..letters.len()).find(|&at| is(at, sign)).unwrap_or(letters.len());
    let mut tokens: Vec<String> = Vec::new();
    let mut at = 0;
    while at < letters.len() {
        let letter = letters[at];
        let begin = at;
        if is(at, "//") {
            at = find(at, "\n");
        } else if is(at, "/*") {
            at = find(at, "*/") + 2;
        } else if letter == '"' {
            at += 1;
            while at < letters.len() && letters[at] != '"' {
                at += if letters[at] == '\\' { 2 } else { 1 };
            }
            at += 1;
        } else if letter == '\'' {
            // A character, or a lifetime.
            at = if is(at + 1, "\\") {
                find(at + 3, "'") + 1
            } else if is(at + 2, "'") {
                at + 3
            } else {
                at + 1
            };
        } else if letter.is_alphanumeric() || letter == '_' {
            while at < letters.len() && (letters[at].is_alphanumeric() || letters[at] == '_') {
                at += 1;
            }
            let word: String = letters[begin..at].iter().collect();
            let hashes = letters[at..].iter().take_while(|&&letter| letter == '#').count();
            if ["r", "br", "cr"].contains(&word.as_str()) && is(at + hashes, "\"") {
                at = find(at + hashes + 1, &format!("\"{}", "#".repeat(hashes))) + 1 + hashes;
            } else {
                tokens.push(word);
            }
        } else {
            at += if is(at, "::") { 2 } else { 1 };
            tokens.extend(
                (!letter.is_whitespace() && letter != '$').then(|| letters[begin..at].iter().collect()),
            );
        }
    }
    tokens
}

/// Leaves out what has an attribute such as `#[cfg(test)]`.
pub fn without_tests(tokens: &[String]) -> Vec<String> {
    let is = |at: usize, sign: &str| tokens.get(at).is_some_and(|token| token == sign);
    // End of the group, or of the item, that begins at a place.
    let end = |mut at: usize, ends: &[&str]| {
        let mut depth = 0;
        while at < tokens.len() {
            depth += i32::from(["(", "[", "{"].contains(&tokens[at].as_str()));
            depth -= i32::from([")", "]", "}"].contains(&tokens[at].as_str()));
            at += 1;
            if depth == 0 && ends.contains(&tokens[at - 1].as_str()) {
                break;
            }
        }
        at
    };
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if is(at, "#") && is(at + 1, "[") {
            let after = end(at + 1, &["]"]);
            let has = |word: &str| tokens[at..after].iter().any(|token| token == word);
            let is_test = is(at + 2, "cfg") && (has("test") || has("doctest")) && !has("not");
            at = if is_test { end(after, &[";", "}", ","]) } else { after };
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}
