//! Slider with two handles.

use eframe::egui::{Rect, Sense, Stroke, Ui, pos2, vec2};

/// Dragged part of the slider.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Low,
    High,
    Both,
}

/// Shows `range` within 0 and 1; its ends stay at least `gap` apart. Dragging a handle moves one end, dragging
/// between them moves both. Returns whether it changed.
pub fn range_slider(ui: &mut Ui, range: &mut [f64; 2], gap: f64) -> bool {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width().max(60.0), 18.0), Sense::click_and_drag());
    let track = rect.shrink2(vec2(7.0, 0.0));
    let x = |value: f64| track.left() + value as f32 * track.width();
    let before = *range;
    if response.drag_started()
        && let Some(at) = ui.input(|input| input.pointer.press_origin())
    {
        let part = part_at(at.x, range.map(x));
        ui.data_mut(|data| data.insert_temp(response.id, part));
    }
    if response.dragged()
        && let Some(part) = ui.data(|data| data.get_temp::<Part>(response.id))
    {
        let delta = f64::from(response.drag_delta().x / track.width());
        *range = dragged(*range, part, delta, gap);
    }
    if response.double_clicked() {
        *range = [0.0, 1.0];
    }
    let visuals = ui.style().interact(&response);
    let painter = ui.painter();
    let bar = |from: f32, to: f32| {
        Rect::from_min_max(pos2(from, rect.center().y - 3.0), pos2(to, rect.center().y + 3.0))
    };
    painter.rect_filled(bar(track.left(), track.right()), 3.0, ui.visuals().extreme_bg_color);
    painter.rect_filled(bar(x(range[0]), x(range[1])), 3.0, ui.visuals().selection.bg_fill);
    for end in *range {
        let at = pos2(x(end), rect.center().y);
        painter.circle(at, 6.0, visuals.bg_fill, Stroke::new(1.5, visuals.fg_stroke.color));
    }
    response.on_hover_text("Drag the ends, or what is between them. Double click: everything");
    *range != before
}

/// Part of the slider at `x`, given the handles' positions `ends`.
fn part_at(x: f32, ends: [f32; 2]) -> Part {
    let [low, high] = ends.map(|end| (x - end).abs());
    if low.min(high) > 8.0 && (ends[0]..=ends[1]).contains(&x) {
        Part::Both
    } else if low < high || (low == high && x < ends[0]) {
        Part::Low
    } else {
        Part::High
    }
}

fn dragged([low, high]: [f64; 2], part: Part, delta: f64, gap: f64) -> [f64; 2] {
    match part {
        Part::Low => [(low + delta).min(high - gap).max(0.0), high],
        Part::High => [low, (high + delta).max(low + gap).min(1.0)],
        Part::Both => {
            let delta = delta.clamp(-low, 1.0 - high);
            [low + delta, high + delta]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_stay_apart_and_both_keep_their_distance() {
        assert_eq!(dragged([0.2, 0.5], Part::Low, 0.9, 0.1), [0.4, 0.5]);
        assert_eq!(dragged([0.2, 0.5], Part::High, -0.9, 0.1), [0.2, 0.30000000000000004]);
        assert_eq!(dragged([0.25, 0.5], Part::Both, 0.9, 0.1), [0.75, 1.0]);
        assert_eq!(dragged([0.25, 0.5], Part::Both, -0.9, 0.1), [0.0, 0.25]);
    }

    #[test]
    fn the_nearest_part_is_taken() {
        let ends = [20.0, 80.0];
        assert_eq!(
            [18.0, 50.0, 77.0, 95.0].map(|x| part_at(x, ends)),
            [Part::Low, Part::Both, Part::High, Part::High]
        );
        assert_eq!(part_at(30.0, [30.0, 30.0]), Part::High);
    }
}
