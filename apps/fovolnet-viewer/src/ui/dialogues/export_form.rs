//! Form for exports.

use super::camera_choice::CameraChoice;
use crate::session::export::{Export, Kind, video_file, y4m_bytes};
use crate::ui::dialogues::answer::Answer;
use crate::ui::dialogues::file_field::{FileField, warning, will_be_replaced};
use crate::ui::dialogues::files::Purpose;
use crate::ui::widgets::accept_buttons::accept_buttons;
use eframe::egui::{DragValue, Grid, Ui};
use fovolnet::core::{Camera, FrameSize, MAX_FRAME_SIDE};
use fovolnet::{RenderOverrides, RenderSettings};
use std::path::Path;

/// Form for exports.
#[derive(Debug)]
pub struct ExportForm {
    file: FileField,
    size: [u32; 2],
    is_full: bool,
    is_transparent: bool,
    with_session: bool,
    /// Settings of a clip, or `None` for a picture.
    sequence: Option<SequenceForm>,
}

/// Settings of a clip.
#[derive(Debug)]
struct SequenceForm {
    frames: u32,
    fps: u32,
    course: CameraChoice,
    has_ffmpeg: bool,
}

/// File size in bytes from which on a warning is shown.
const LARGE: u64 = 500_000_000;

impl ExportForm {
    /// Form for a picture with `settings`.
    pub fn picture(settings: &RenderOverrides, suggested: &Path) -> Self {
        let usual = RenderSettings::default();
        Self {
            file: FileField::new(Purpose::SavePicture, suggested),
            size: settings.size.unwrap_or(usual.size).into(),
            is_full: true,
            is_transparent: settings.transparent.unwrap_or(usual.transparent),
            with_session: true,
            sequence: None,
        }
    }

    /// Form for a video of `frames` frames with `settings`, currently seen from `camera`.
    pub fn video(settings: &RenderOverrides, camera: Camera, frames: u32, suggested: &Path) -> Self {
        let course = CameraChoice::new(settings, camera);
        let has_ffmpeg = fovolnet::io::video::ffmpeg_installed();
        let suggested = suggested.with_extension(if has_ffmpeg { "mp4" } else { "y4m" });
        Self {
            file: FileField::new(Purpose::SaveVideo, &suggested),
            is_transparent: false,
            sequence: Some(SequenceForm { frames, fps: 30, course, has_ffmpeg }),
            ..Self::picture(settings, &suggested)
        }
    }

    pub(crate) fn ui(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.heading(self.file.purpose().title());
        self.file.ui(ui);
        Grid::new("export").num_columns(2).show(ui, |ui| {
            ui.label("Size");
            ui.horizontal(|ui| {
                let [width, height] = &mut self.size;
                for (side, suffix) in [(width, " wide"), (height, " high")] {
                    ui.add(DragValue::new(side).range(1..=MAX_FRAME_SIDE).suffix(suffix));
                }
            });
            ui.end_row();
            if let Some(clip) = &mut self.sequence {
                clip.ui(ui);
            }
        });
        self.options_ui(ui);
        let export = self.export();
        if let (Some(clip), Some(export)) = (&self.sequence, &export) {
            clip.remarks_ui(ui, export);
        }
        if let Some(export) = export.as_ref().filter(|_| self.file.problem().is_none()) {
            will_be_replaced(ui, &export.files());
        }
        match accept_buttons(ui, "Export", self.file.problem())? {
            true => Some(Answer::Export(Box::new(export?))),
            false => Some(Answer::Cancel),
        }
    }

    fn options_ui(&mut self, ui: &mut Ui) {
        ui.add_enabled_ui(!self.is_transparent, |ui| {
            let hint = "Otherwise sampled and reconstructed as the session says: faster, not exact";
            let mut is_full = self.is_full || self.is_transparent;
            if ui
                .checkbox(&mut is_full, "Measure every pixel")
                .on_hover_text(hint)
                .on_disabled_hover_text("What is reconstructed has no transparency")
                .changed()
            {
                self.is_full = is_full;
            }
        });
        if self.sequence.is_none() {
            ui.checkbox(&mut self.is_transparent, "Transparent background");
        }
        ui.checkbox(&mut self.with_session, "Write the session beside it")
            .on_hover_text("`fovolnet render` makes the same pixels of it");
    }

    /// The export; `None` if its size is invalid.
    fn export(&self) -> Option<Export> {
        let path = self.file.target();
        let (path, kind) = match &self.sequence {
            Some(SequenceForm { frames, fps, course, has_ffmpeg }) => {
                let course = course.course(*frames);
                (video_file(path, *has_ffmpeg), Kind::Video { course, frames: *frames, fps: *fps })
            }
            None => (path, Kind::Picture { is_transparent: self.is_transparent }),
        };
        Some(Export {
            path,
            size: FrameSize::new(self.size[0], self.size[1]).ok()?,
            is_full: self.is_full || self.is_transparent,
            with_session: self.with_session,
            kind,
        })
    }
}

impl SequenceForm {
    /// Shows the clip's settings as rows of a grid.
    fn ui(&mut self, ui: &mut Ui) {
        self.course.ui(ui);
        ui.end_row();
        ui.label("Length");
        ui.horizontal(|ui| {
            ui.add(DragValue::new(&mut self.frames).range(1..=100_000).suffix(" frames"));
            ui.add(DragValue::new(&mut self.fps).range(1..=240).suffix(" a second"));
        });
        ui.end_row();
    }

    /// Shows remarks about `export` before it begins.
    fn remarks_ui(&self, ui: &mut Ui, export: &Export) {
        let seconds = f64::from(self.frames) / f64::from(self.fps);
        let mut text = format!("{} frames of {}, {seconds:.1} s", self.frames, export.size);
        let bytes = y4m_bytes(export.size, self.frames);
        let is_y4m = export.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("y4m"));
        if is_y4m {
            text += &format!(": {} as .y4m, which is not compressed", readable(bytes));
        }
        ui.weak(text);
        if is_y4m && bytes >= LARGE {
            let advice = match self.has_ffmpeg {
                true => "Name it .mp4 for a small one, or choose fewer frames or a smaller size.",
                false => "Install ffmpeg for small .mp4 files, or choose fewer frames or a smaller size.",
            };
            warning(ui, format!("This is a large file. {advice}"));
        } else if !self.has_ffmpeg {
            ui.weak("Formats other than .y4m need ffmpeg, which is not installed.");
        }
        if self.course.stands_still() && self.frames > 1 {
            let frames = self.frames;
            warning(
                ui,
                format!(
                    "The view stands still: all {frames} frames are the same picture. Choose an orbit or the fly-through, \
                     or make views keyframes of the timeline first (K)."
                ),
            );
        }
    }
}

/// Formats `bytes` in a suitable unit.
fn readable(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e6 => format!("{:.0} KB", b / 1e3),
        b if b < 1e9 => format!("{:.0} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_clip_without_ffmpeg_is_large() {
        let bytes = y4m_bytes(FrameSize::default(), 500);
        assert!(bytes > LARGE);
        assert_eq!(readable(bytes), "1.4 GB");
        assert_eq!((readable(2_345_678).as_str(), readable(9_999).as_str()), ("2 MB", "10 KB"));
    }

    #[test]
    fn transparent_pictures_are_measured_pixel_by_pixel() {
        let mut form = ExportForm::picture(&RenderOverrides::default(), Path::new("a"));
        form.is_full = false;
        assert!(!form.export().unwrap().is_full);
        form.is_transparent = true;
        assert!(form.export().unwrap().is_full);
    }
}
