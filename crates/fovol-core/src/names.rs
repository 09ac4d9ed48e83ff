//! Suggestions for mistyped names.

/// Suggestion for an error message about the unknown name `text`: `; did you mean NAME?`, or an empty string if none
/// of `names` is close. Ignores case.
#[must_use]
pub fn did_you_mean(text: &str, names: &[&str]) -> String {
    let text = letters(text);
    // Two edits in a long word, one in a short one; with more edits, unrelated words are as close.
    let slips = if text.len() < 5 { 1 } else { 2 };
    let nearest = names.iter().map(|&name| (slips_between(&text, &letters(name)), name)).min();
    nearest
        .filter(|&(distance, _)| distance <= slips)
        .map_or_else(String::new, |(_, name)| format!("; did you mean {name}?"))
}

/// Longest compared prefix, in letters; no name is longer, and comparison must stay fast.
const LONGEST: usize = 64;

fn letters(text: &str) -> Vec<char> {
    text.chars().flat_map(char::to_lowercase).take(LONGEST).collect()
}

/// Edit distance between `a` and `b`: insertions, deletions, replacements and swaps of neighbours (Damerau 1964,
/// optimal string alignment).
fn slips_between(a: &[char], b: &[char]) -> usize {
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let one_side = rows[i - 1][j].min(rows[i][j - 1]) + 1;
            let is_swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            let swapped = if is_swapped { rows[i - 2][j - 2] + 1 } else { usize::MAX };
            rows[i][j] = replaced.min(one_side).min(swapped);
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_other_words_are_not() {
        let names = ["head", "viridis", "wnet-fast"];
        for (text, meant) in [("haed", "head"), ("virdis", "viridis"), ("WNet-fst", "wnet-fast")] {
            assert_eq!(did_you_mean(text, &names), format!("; did you mean {meant}?"));
        }
        for other in ["", "heart-of-gold", "magma", "ha"] {
            assert_eq!(did_you_mean(other, &names), "", "{other}");
        }
        assert_eq!(did_you_mean("head", &[]), "");
    }
}
