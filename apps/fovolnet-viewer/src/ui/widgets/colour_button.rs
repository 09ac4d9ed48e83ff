//! Button that shows a colour and opens a picker.

use eframe::egui::Ui;

/// Shows `colour` (display values); returns whether it was changed.
pub(crate) fn colour_button(ui: &mut Ui, colour: &mut [f64; 3]) -> bool {
    let before = bytes(*colour);
    let mut after = before;
    let is_changed = ui.color_edit_button_srgb(&mut after).changed();
    if is_changed {
        *colour = changed(*colour, before, after);
    }
    is_changed
}

fn bytes(colour: [f64; 3]) -> [u8; 3] {
    colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// `colour` with the channels that differ between `before` and `after`. The others keep their precision beyond 8
/// bits.
fn changed(colour: [f64; 3], before: [u8; 3], after: [u8; 3]) -> [f64; 3] {
    let channel = |c: usize| if after[c] == before[c] { colour[c] } else { f64::from(after[c]) / 255.0 };
    std::array::from_fn(channel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_picture_and_stay_where_nothing_changes() {
        let colour = [0.05, 0.07, 0.12];
        assert_eq!(bytes(colour), [13, 18, 31]);
        assert_eq!(changed(colour, [13, 18, 31], [13, 18, 31]), colour);
        assert_eq!(changed(colour, [13, 18, 31], [255, 18, 31]), [1.0, 0.07, 0.12]);
    }
}
