//! Descriptions of tifffile: `{"shape": [2, 8, 10, 12], "axes": "CZYX"}`.

use super::hyperstack::{Counts, Hyperstack};

/// Parses the JSON description `text` of a TIFF file; none if it is not such a description.
///
/// The file has `pages` pages of `size` pixels along x and y, and room for `most` planes.
pub fn hyperstack(text: &str, pages: usize, size: [usize; 2], most: usize) -> Option<Hyperstack> {
    let json: serde_json::Value = serde_json::from_str(text).ok()?;
    let shape: Option<Vec<usize>> =
        json.get("shape")?.as_array()?.iter().map(|n| usize::try_from(n.as_u64()?).ok()).collect();
    let axes = json.get("axes").and_then(serde_json::Value::as_str).map(str::to_ascii_uppercase);
    let (counts, order) = planes(&shape?, axes.as_deref(), size)?;
    let planes = counts.planes()?;
    if planes == pages {
        return Some(Hyperstack::ordered(counts, &order));
    }
    // Of planes that follow each other only the first may have a page.
    let is_truncated = json.get("truncated").is_some_and(|flag| flag == true);
    if pages == 1 && is_truncated && (2..=most).contains(&planes) {
        return Some(Hyperstack { is_one_page: true, ..Hyperstack::ordered(counts, &order) });
    }
    let note = format!("its description says {planes} planes, it has {pages} pages; all are shown as slices");
    Some(Hyperstack { notes: vec![note], ..Hyperstack::plain(pages) })
}

/// The planes of an array of `shape`, and the order of their axes, fastest first.
fn planes(shape: &[usize], axes: Option<&str>, [x, y]: [usize; 2]) -> Option<(Counts, String)> {
    let Some(axes) = axes else {
        let slices = match shape {
            [slices @ .., height, width] if [*width, *height] == [x, y] => slices,
            [slices @ .., height, width, _] if [*width, *height] == [x, y] => slices,
            _ => return None,
        };
        let slices = slices.iter().try_fold(1usize, |product, &size| product.checked_mul(size))?;
        return Some((Counts::slices(slices), "Z".into()));
    };
    if axes.chars().count() != shape.len() {
        return None;
    }
    // The slowest axis comes first; those of a page are no planes.
    let mut order = String::new();
    let mut counts = Counts::slices(1);
    let (mut is_known, mut all) = (true, 1usize);
    for (axis, &size) in axes.chars().zip(shape) {
        match axis {
            'Y' | 'X' | 'S' => continue,
            'Z' => counts.slices = size,
            'C' => counts.channels = size,
            'T' => counts.times = size,
            _ if size != 1 => is_known = false,
            _ => continue,
        }
        order.insert(0, axis);
        all = all.checked_mul(size)?;
    }
    // Planes along axes that nobody knows are slices, as they follow each other.
    Some(if is_known { (counts, order) } else { (Counts::slices(all), "Z".into()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [12, 10];

    #[test]
    fn axes_are_told_by_their_letters() {
        let stack = hyperstack(r#"{"shape": [2, 3, 10, 12], "axes": "CZYX"}"#, 6, SIZE, 999).unwrap();
        assert_eq!(stack.counts, Counts { slices: 3, channels: 2, times: 1 });
        assert_eq!(stack.pages[3], Some(3));
        let stack = hyperstack(r#"{"shape": [8, 10, 12]}"#, 8, SIZE, 999).unwrap();
        assert_eq!((stack.counts, stack.notes.len()), (Counts::slices(8), 0));
        assert!(hyperstack("a scan", 5, SIZE, 999).is_none());
    }

    #[test]
    fn planes_without_pages_are_found() {
        for text in [
            r#"{"shape": [3, 10, 12], "truncated": true}"#,
            r#"{"shape": [3, 10, 12, 2], "truncated": true}"#,
            r#"{"shape": [3, 10, 12], "axes": "ZYX", "truncated": true}"#,
            r#"{"shape": [3, 1, 10, 12], "axes": "QZYX", "truncated": true}"#,
        ] {
            let stack = hyperstack(text, 1, SIZE, 999).unwrap();
            assert!(stack.is_one_page && stack.counts == Counts::slices(3), "{text}");
        }
        let huge = r#"{"shape": [1000, 10, 12], "truncated": true}"#;
        assert!(!hyperstack(huge, 1, SIZE, 999).unwrap().is_one_page);
    }

    #[test]
    fn what_cannot_be_is_said() {
        let stack = hyperstack(r#"{"shape": [2, 3, 10, 12], "axes": "CZYX"}"#, 5, SIZE, 999).unwrap();
        assert!(stack.counts == Counts::slices(5) && stack.notes[0].contains("6 planes"), "{stack:?}");
    }
}
