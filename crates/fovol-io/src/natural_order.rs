//! The order of numbered names that people expect: `img2` before `img10`.

use std::cmp::Ordering;

/// Compares two names; runs of digits count as numbers.
pub fn compare(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while !rest_a.is_empty() && !rest_b.is_empty() {
        let (run_a, run_b) = (run(&mut rest_a), run(&mut rest_b));
        let order = match [run_a, run_b].map(starts_with_digit) {
            [true, true] => magnitude(run_a).cmp(&magnitude(run_b)),
            _ => run_a.cmp(run_b),
        };
        if order.is_ne() {
            return order;
        }
    }
    // Names that differ by leading zeros alone still have one order.
    rest_a.len().cmp(&rest_b.len()).then_with(|| a.cmp(b))
}

/// Takes the longest run of digits, or of other characters, off the start of `rest`.
fn run<'a>(rest: &mut &'a str) -> &'a str {
    let is_number = starts_with_digit(rest);
    let end = rest.find(|c: char| c.is_ascii_digit() != is_number).unwrap_or(rest.len());
    let (run, after) = rest.split_at(end);
    *rest = after;
    run
}

fn starts_with_digit(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
}

/// Longer numbers are larger; of equal length the first different digit decides.
fn magnitude(digits: &str) -> (usize, &str) {
    let digits = digits.trim_start_matches('0');
    (digits.len(), digits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_count() {
        let sorted =
            ["1", "02", "2", "10", "a", "a1b2", "a1b10", "a2", "a10", "a99999999999999999999999", "b"];
        let mut names = sorted;
        names.reverse();
        names.sort_by(|a, b| compare(a, b));
        assert_eq!(names, sorted);
    }

    proptest! {
        #[test]
        fn it_is_an_order(names in prop::array::uniform3("[a0-2é]{0,5}")) {
            let [a, b, c] = names.each_ref().map(String::as_str);
            prop_assert_eq!(compare(a, b), compare(b, a).reverse());
            prop_assert_eq!(compare(a, b).is_eq(), a == b);
            if compare(a, b).is_le() && compare(b, c).is_le() {
                prop_assert!(compare(a, c).is_le());
            }
        }
    }
}
