//! Timeline of the camera path.

use crate::session::opened::Opened;
use crate::ui::widgets::outline::outline;
use eframe::egui::{Align2, ComboBox, DragValue, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};
use fovolnet::PathChoice;
use fovolnet::core::CameraPath;

/// Playback rate in frames a second.
pub const FPS: f64 = 30.0;

/// State of the timeline.
#[derive(Debug, Clone, Default)]
pub struct Timeline {
    /// Start of playback in seconds, and its first frame.
    playing: Option<(f64, u32)>,
    /// Index of the dragged keyframe, and its new frame.
    moving: Option<(usize, f64)>,
}

impl Timeline {
    /// Whether the path is playing.
    pub fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Starts playback from `frame` at `time`, or pauses.
    pub fn play_or_pause(&mut self, time: f64, frame: u32) {
        self.playing = if self.is_playing() { None } else { Some((time, frame)) };
    }

    /// Pauses playback.
    pub fn pause(&mut self) {
        self.playing = None;
    }

    /// Shows the frame of `time`, in a loop.
    pub fn advance(&mut self, time: f64, opened: &mut Opened) {
        if let Some((began, first)) = self.playing {
            let passed = ((time - began) * FPS).max(0.0) as u32;
            opened.go_to((first + passed) % opened.path_length());
        }
    }

    /// Shows the timeline.
    pub fn ui(&mut self, ui: &mut Ui, opened: &mut Opened) {
        let time = ui.input(|input| input.time);
        ui.horizontal(|ui| {
            let name = if self.is_playing() { "Pause" } else { "Play" };
            if ui.button(name).on_hover_text("Play or pause (Space)").clicked() {
                self.play_or_pause(time, opened.frame());
            }
            let mut frame = opened.frame();
            let last = opened.path_length().saturating_sub(1).max(frame);
            if ui.add(DragValue::new(&mut frame).range(0..=last).prefix("frame ")).changed() {
                self.pause();
                opened.go_to(frame);
            }
            path_choice(ui, opened);
            if ui
                .button("Add keyframe")
                .on_hover_text("Make this view a keyframe at this frame (K)")
                .clicked()
            {
                self.pause();
                add_keyframe(opened);
            }
            if let Some(i) = opened.keyframes().iter().position(|key| key.frame == f64::from(opened.frame()))
                && ui.button("Remove").on_hover_text("Remove the keyframe of this frame").clicked()
            {
                let mut keys = opened.keyframes().to_vec();
                keys.remove(i);
                opened.set_keyframes(keys);
            }
            if opened.document.settings().camera.is_some() {
                ui.weak("free view");
            }
        });
        self.track(ui, opened);
    }

    /// Shows the frames from left to right, with the keyframes.
    fn track(&mut self, ui: &mut Ui, opened: &mut Opened) {
        let (rect, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), 26.0), Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        outline(&painter, rect, ui.visuals());
        let last = f64::from(opened.path_length().saturating_sub(1).max(1));
        let track = rect.shrink2(vec2(8.0, 0.0));
        let x = |frame: f64| track.left() + (frame / last) as f32 * track.width();
        let frame_at =
            |x: f32| (f64::from((x - track.left()) / track.width()).clamp(0.0, 1.0) * last).round();
        let font = FontId::proportional(9.0);
        for frame in ticks(last) {
            let stroke = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.5));
            painter
                .line_segment([pos2(x(frame), rect.bottom() - 4.0), pos2(x(frame), rect.bottom())], stroke);
            let at = pos2(x(frame), rect.top());
            let anchor = [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP]
                [usize::from(frame > 0.0) + usize::from(frame == last)];
            painter.text(at, anchor, format!("{frame:.0}"), font.clone(), ui.visuals().weak_text_color());
        }
        let keys = opened.keyframes().to_vec();
        if response.drag_started()
            && let Some(at) = ui.input(|input| input.pointer.press_origin())
        {
            let near = keys.iter().position(|key| (x(key.frame) - at.x).abs() < 6.0);
            self.moving = near.map(|i| (i, keys[i].frame));
        }
        if let Some(at) = response.interact_pointer_pos()
            && (response.dragged() || response.clicked())
        {
            self.pause();
            match &mut self.moving {
                Some((_, frame)) => *frame = frame_at(at.x),
                None => opened.go_to(frame_at(at.x) as u32),
            }
        }
        if response.drag_stopped()
            && let Some((i, frame)) = self.moving.take()
        {
            let mut keys = keys.clone();
            keys[i].frame = frame;
            opened.set_keyframes(keys);
            opened.go_to(frame as u32);
        }
        for (i, key) in keys.iter().enumerate() {
            let frame = self.moving.filter(|(moved, _)| *moved == i).map_or(key.frame, |(_, to)| to);
            let colour = ui.visuals().selection.bg_fill;
            let diamond = [(0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0)];
            let middle = pos2(x(frame), rect.center().y + 4.0);
            let corners = diamond.iter().map(|&(dx, dy)| middle + vec2(dx, dy)).collect();
            painter.add(eframe::egui::Shape::convex_polygon(corners, colour, Stroke::NONE));
        }
        let now = x(f64::from(opened.frame()));
        let marker = Rect::from_x_y_ranges(now - 1.0..=now + 1.0, rect.y_range());
        painter.rect_filled(marker, 0.0, ui.visuals().strong_text_color());
    }
}

/// Adds the current view as a keyframe at the current frame. If that frame has a keyframe, a free camera is added one
/// second after the last one.
pub fn add_keyframe(opened: &mut Opened) {
    let here = f64::from(opened.frame());
    let is_free = opened.document.settings().camera.is_some();
    let keys = opened.keyframes();
    let taken = keys.iter().any(|key| key.frame == here);
    let last = keys.last().map_or(0.0, |key| key.frame);
    let frame = if taken && is_free { last + FPS } else { here };
    opened.add_keyframe(frame as u32);
}

fn path_choice(ui: &mut Ui, opened: &mut Opened) {
    let name = match opened.path() {
        CameraPath::Orbit => "orbit",
        CameraPath::Flythrough => "flythrough",
        CameraPath::Turntable { .. } => "turntable",
        CameraPath::Still(_) => "still",
        CameraPath::Keyframes(_) => "keyframes",
    };
    let label = ui.label("Path").id;
    let list = ComboBox::from_id_salt("path").selected_text(name).width(90.0).show_ui(ui, |ui| {
        for ready in [PathChoice::Turntable, PathChoice::Orbit, PathChoice::Flythrough] {
            let label = ready.to_string();
            if ui.selectable_label(name == label, label).clicked() {
                opened.document.settings_mut().path = Some(ready);
                opened.go_to(0);
            }
        }
    });
    list.response.labelled_by(label);
}

/// Frames with tick marks up to `last`: about ten, at multiples of 1, 2 or 5 times a power of ten, and the last
/// frame.
fn ticks(last: f64) -> Vec<f64> {
    let least = (last / 10.0).max(1.0);
    let power = 10f64.powf(least.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|step| *step >= least).unwrap_or(least);
    // Ticks too close to the last one are left out, since their numbers would overlap.
    let before = (0..).map(|i| f64::from(i) * step).take_while(|frame| *frame < last - 0.5 * step);
    before.chain([last]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::opened::tests::opened;
    use fovolnet::core::Camera;

    #[test]
    fn marks_are_round_and_the_last_frame_has_one() {
        assert_eq!(ticks(499.0), [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0, 499.0]);
        assert_eq!(ticks(3.0), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(ticks(1.0), [0.0, 1.0]);
        for last in 1..2000 {
            let marks = ticks(f64::from(last));
            assert!(marks.len() <= 12 && marks[marks.len() - 1] == f64::from(last), "{last}: {marks:?}");
            assert!(marks.windows(2).all(|pair| pair[0] < pair[1]), "{marks:?}");
        }
    }

    #[test]
    fn playback_shows_the_frame_of_the_time_and_begins_anew() {
        let (mut timeline, mut opened) = (Timeline::default(), opened());
        timeline.play_or_pause(10.0, 490);
        timeline.advance(10.11, &mut opened);
        assert_eq!(opened.frame(), 493);
        timeline.advance(10.51, &mut opened);
        assert_eq!(opened.frame(), 5);
        timeline.play_or_pause(10.6, 5);
        timeline.advance(30.0, &mut opened);
        assert_eq!(opened.frame(), 5);
    }

    #[test]
    fn views_become_keyframes_a_second_apart() {
        let mut opened = opened();
        for azimuth in [0.0, 40.0, 80.0] {
            opened.stand_at(&Camera::on_sphere(azimuth, 0.0, 2.0, 35.0));
            add_keyframe(&mut opened);
        }
        let frames: Vec<f64> = opened.keyframes().iter().map(|key| key.frame).collect();
        assert_eq!(frames, [0.0, 30.0, 60.0]);
    }
}
