//! The names of many files that hold one volume together, as printf patterns give them.

use super::Source;
use crate::Result;

/// More files than this are a mistake or malice.
const MAX_FILES: i128 = 1 << 16;

/// Whether `words` are a pattern and its numbers rather than a file name.
pub fn is_pattern(words: &[&str]) -> bool {
    words.len() >= 3 && words[0].contains('%') && words[1..].iter().all(|word| word.parse::<i64>().is_ok())
}

/// The names that `pattern` (with one `%d` or `%03d`) gives for `first`, `first + step`… up to `last`.
///
/// # Errors
/// A pattern without exactly one number, a step that never ends, or too many files.
pub fn expand(source: &Source, pattern: &str, first: i64, last: i64, step: i64) -> Result<Vec<String>> {
    let (before, digits, after) = parts(pattern).ok_or_else(|| {
        source.malformed(format!("`{pattern}` is no pattern of file names; write it like slice%03d.raw"))
    })?;
    let (first, last, step) = (i128::from(first), i128::from(last), i128::from(step));
    let steps = (last - first)
        .checked_div(step)
        .filter(|&steps| steps >= 0 && (first == last || (last > first) == (step > 0)));
    let steps = steps.ok_or_else(|| {
        source.malformed(format!("its file numbers {first} to {last} never end by steps of {step}"))
    })?;
    if steps >= MAX_FILES {
        return Err(source.malformed(format!("it names more than {MAX_FILES} data files")));
    }
    let width = digits.parse().unwrap_or(0);
    let shown = |number: i128| match digits.starts_with('0') {
        true => format!("{before}{number:0width$}{after}"),
        false => format!("{before}{number:width$}{after}"),
    };
    Ok((0..=steps).map(|i| shown(first + i * step)).collect())
}

/// The text before the number of `pattern`, the digits of its width, and the text after it.
fn parts(pattern: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = pattern.split_once('%')?;
    let end = rest.find(|c: char| !c.is_ascii_digit())?;
    let (digits, rest) = rest.split_at(end);
    let after = rest.strip_prefix(['d', 'i', 'u'])?;
    (digits.len() <= 2 && !after.contains('%')).then_some((before, digits, after))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn names(pattern: &str, first: i64, last: i64, step: i64) -> Result<Vec<String>> {
        expand(&Source::from_bytes(Path::new("x"), vec![]), pattern, first, last, step)
    }

    #[test]
    fn numbers_are_put_in() {
        assert_eq!(names("a%03d.raw", 9, 11, 1).unwrap(), ["a009.raw", "a010.raw", "a011.raw"]);
        assert_eq!(names("%d", 4, 0, -2).unwrap(), ["4", "2", "0"]);
        assert_eq!(names("%2d", 9, 10, 1).unwrap(), [" 9", "10"]);
        assert_eq!(names("q.%d", 7, 7, 1).unwrap(), ["q.7"]);
    }

    #[test]
    fn endless_and_malformed_patterns_are_errors() {
        assert!(names("a%d", 0, 5, 0).is_err());
        assert!(names("a%d", 0, 5, -1).is_err());
        assert!(names("a%d", i64::MIN, i64::MAX, 1).is_err());
        for pattern in ["a", "a%", "a%s", "%d%d", "%999d", "%99999999999999999999d"] {
            assert!(names(pattern, 0, 1, 1).is_err(), "{pattern}");
        }
    }
}
