//! Descriptions of tifffile: `{"shape": [2, 8, 10, 12], "axes": "CZYX"}`.

use super::hyperstack::{Counts, Hyperstack};

/// What `text` says of a file of `pages` pages; none where it is no such description or says nothing of other axes than slices.
pub fn hyperstack(text: &str, pages: usize) -> Option<Hyperstack> {
    let json: serde_json::Value = serde_json::from_str(text).ok()?;
    let shape: Option<Vec<usize>> =
        json.get("shape")?.as_array()?.iter().map(|n| usize::try_from(n.as_u64()?).ok()).collect();
    let axes = json.get("axes")?.as_str()?.to_ascii_uppercase();
    let shape = shape.filter(|shape| shape.len() == axes.chars().count())?;
    // The slowest axis comes first; those of a page are no planes.
    let mut order = String::new();
    let mut counts = Counts::slices(1);
    for (axis, &size) in axes.chars().zip(&shape) {
        match axis {
            'Y' | 'X' | 'S' => continue,
            'Z' => counts.slices = size,
            'C' => counts.channels = size,
            'T' => counts.times = size,
            _ if size != 1 => return None,
            _ => continue,
        }
        order.insert(0, axis);
    }
    (counts.planes() == Some(pages)).then(|| Hyperstack::ordered(counts, &order))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_told_by_their_letters() {
        let stack = hyperstack(r#"{"shape": [2, 3, 10, 12], "axes": "CZYX"}"#, 6).unwrap();
        assert_eq!(stack.counts, Counts { slices: 3, channels: 2, times: 1 });
        assert_eq!(stack.pages[3], Some(3));
        assert!(hyperstack(r#"{"shape": [8, 10, 12]}"#, 8).is_none());
        assert!(hyperstack(r#"{"shape": [2, 3, 10, 12], "axes": "CZYX"}"#, 5).is_none());
        assert!(hyperstack("a scan", 5).is_none());
    }
}
