//! Words of a file in messages.

/// The first `most` characters of `text`, without control characters.
pub fn shown(text: &str, most: usize) -> String {
    let mut shown: String = text.chars().filter(|c| !c.is_control()).take(most).collect();
    if text.chars().count() > most {
        shown.push('…');
    }
    shown
}
