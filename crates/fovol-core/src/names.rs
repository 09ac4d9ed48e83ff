//! Names that somebody mistyped.

/// The end of an error about `text`, which is none of `names`: `; did you mean NAME?`, or nothing where no name is close to it.
/// Upper and lower case are alike.
#[must_use]
pub fn did_you_mean(text: &str, names: &[&str]) -> String {
    let text = letters(text);
    // Two slips in a long word, one in a short one; with more of them other words are as close.
    let slips = if text.len() < 5 { 1 } else { 2 };
    let nearest = names.iter().map(|&name| (slips_between(&text, &letters(name)), name)).min();
    nearest
        .filter(|&(distance, _)| distance <= slips)
        .map_or_else(String::new, |(_, name)| format!("; did you mean {name}?"))
}

/// Longer words are no names; nobody should wait for their distance.
const LONGEST: usize = 64;

fn letters(text: &str) -> Vec<char> {
    text.chars().flat_map(char::to_lowercase).take(LONGEST).collect()
}

/// How many letters have to be put in, left out, replaced or swapped with their neighbours to make `a` of `b` (Damerau 1964, no
/// letter touched twice).
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
