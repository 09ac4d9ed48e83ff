//! Parts of the window.

use super::Viewer;
use crate::frames::display_mode::DisplayMode;
use crate::frames::gaze::{GazeKind, GazeSource};
use crate::frames::presented::Progress;
use crate::frames::view_request::ViewRequest;
use crate::session::opened::Opened;
use crate::ui::commands::{self, Command, Entry};
use crate::ui::dialogues::files::Purpose;
use crate::ui::dialogues::{Dialogue, FilePrompt, Next};
use crate::ui::slices::slices_view;
use crate::ui::transfer::transfer_editor::presets_ui;
use crate::{ui::panels, ui::picture::picture_view, ui::start_page};
use eframe::egui::{self, Align, CollapsingHeader, Color32, Layout, Rect, Ui, UiBuilder};
use fovolnet::core::FrameSize;
use fovolnet::presets;

/// Colour between the pictures.
const SEAM: Color32 = Color32::from_gray(70);
/// Largest picture on the screen, in pixels along each side.
const LARGEST: f32 = 8192.0;

impl Viewer {
    /// Current pictures per second.
    pub(super) fn rate(&mut self, time: f64) -> f64 {
        while self.arrivals.front().is_some_and(|&arrival| arrival < time - 1.0) {
            self.arrivals.pop_front();
        }
        self.arrivals.len() as f64
    }

    pub(super) fn menu(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        egui::MenuBar::new().ui(ui, |ui| {
            let menus: [(&str, &[Entry]); 4] = [
                ("File", commands::FILE),
                ("Edit", commands::EDIT),
                ("View", commands::VIEW),
                ("Help", commands::HELP),
            ];
            for (name, entries) in menus {
                ui.menu_button(name, |ui| {
                    for entry in entries {
                        let mut button = egui::Button::new(entry.name);
                        if let Some(keys) = entry.shortcut {
                            button = button.shortcut_text(context.format_shortcut(&keys));
                        }
                        if ui.add_enabled(self.can(entry.command), button).clicked() {
                            self.run(entry.command, &context);
                        }
                    }
                });
            }
            if let Some(opened) = &self.opened {
                let star = if opened.document.is_changed() { " •" } else { "" };
                let name = start_page::middle_cut(&opened.document.name(), 60);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    ui.weak(format!("{name}{star}")).on_hover_text(&opened.document.session().volume);
                });
            }
        });
    }

    pub(super) fn settings(&mut self, ui: &mut Ui) {
        let time = ui.input(|input| input.time);
        let rate = self.rate(time);
        let folder = self.folder();
        let mut read = None;
        let Some(opened) = &mut self.opened else { return };
        let section = |name: &str| CollapsingHeader::new(name).default_open(true);
        if self.preferences.slices {
            section("Slices").show(ui, |ui| read = panels::slices(ui, &mut self.slices, opened));
        }
        section("Transfer function").show(ui, |ui| {
            ui.horizontal(|ui| {
                let current = opened.document.settings().tf.clone().unwrap_or_default();
                if let Some(chosen) = presets_ui(ui, &current, &opened.volume) {
                    opened.document.settings_mut().tf = Some(chosen);
                }
                for (name, purpose) in [("Read…", Purpose::ReadTransfer), ("Save…", Purpose::SaveTransfer)]
                {
                    if ui.button(name).clicked() {
                        let suggested = folder.join("transfer.json");
                        self.dialogue = Some(Dialogue::File(FilePrompt::new(purpose, &suggested)));
                    }
                }
            });
            let transfer = opened.transfer().clone();
            if let Some(changed) = opened.editor.ui(ui, &transfer, &opened.backdrop) {
                opened.set_transfer(&changed);
            }
            opened.backdrop.ui(ui, &opened.volume);
        });
        if !opened.labels().is_empty() {
            section("Labels").show(ui, |ui| {
                let mut labels = opened.shown_labels();
                if panels::labels(ui, &mut labels)
                    && let Some(transfer) = presets::of_labels(&labels)
                {
                    opened.set_transfer(&transfer);
                }
            });
        }
        section("View").show(ui, |ui| {
            let has_placement = opened.volume.volume.placement().is_some();
            panels::standing(ui, opened.document.settings_mut(), has_placement);
        });
        section("Light").show(ui, |ui| panels::scene(ui, opened.document.settings_mut()));
        section("Mode").show(ui, |ui| {
            panels::mode(ui, opened.document.settings_mut(), opened.volume.volume.range());
            panels::projection(ui, opened.document.settings_mut());
        });
        let has_parts = panels::has_parts(&opened.volume.volume, opened.series());
        CollapsingHeader::new("Data").default_open(has_parts).show(ui, |ui| {
            let session = opened.document.session();
            let changed =
                panels::data(ui, &session.read, (&opened.volume, opened.series()), &mut self.times.plays);
            read = changed.or(read.take());
        });
        CollapsingHeader::new("Clipping").show(ui, |ui| {
            panels::cropping(ui, opened.document.settings_mut(), opened.volume.volume.grid().dims());
            let camera = opened.camera();
            panels::planes(ui, opened.document.settings_mut(), &camera);
        });
        let shown = self.picture.as_ref().map(|picture| &picture.shown);
        section("Frames").show(ui, |ui| {
            panels::budget(ui, &mut self.preferences, shown);
            panels::looks(ui, &mut self.look);
        });
        CollapsingHeader::new("Sampling").show(ui, |ui| {
            panels::sampling(ui, opened.document.settings_mut(), &mut self.gaze_kind);
        });
        if let Some(shown) = shown {
            section("Statistics").show(ui, |ui| panels::statistics(ui, shown, rate, &self.history));
        }
        if let Err(error) = opened.refresh() {
            self.messages.error(error.to_string());
        }
        if self.times.plays {
            ui.ctx().request_repaint_after_secs(0.1);
        }
        if read.is_none() && self.opening.is_none() {
            read = self.times.next(opened);
        }
        if let Some(read) = read {
            let document = opened.document.reading(read);
            let name = format!("reading {}", start_page::middle_cut(&document.name(), 50));
            self.start_opening(ui.ctx(), name, move || Opened::of_document(document));
        }
    }

    pub(super) fn picture(&mut self, ui: &mut Ui) {
        let Some(opened) = &mut self.opened else { return };
        self.slices.follow(opened);
        let whole = ui.available_rect_before_wrap();
        let mut words = None;
        let mut room = whole;
        if self.preferences.slices {
            let (picture, rooms) = slices_view::rooms(whole);
            ui.painter().rect_filled(whole, 0.0, SEAM);
            words = slices_view::show(ui, &mut self.slices, opened, rooms);
            room = picture;
        }
        ui.scope_builder(UiBuilder::new().max_rect(room), |ui| {
            let of_picture = self.rendered(ui);
            self.point_at(ui.ctx(), words.or(of_picture));
        });
    }

    /// Shows the rendered picture. Returns the words on the point under the pointer.
    fn rendered(&mut self, ui: &mut Ui) -> Option<String> {
        let time = ui.input(|input| input.time);
        let opened = self.opened.as_mut()?;
        if self.timeline.is_playing() {
            self.timeline.advance(time, opened);
            // Playback also advances with every new picture. More repaints would take time with software rendering.
            ui.ctx().request_repaint_after_secs(0.1);
        }
        let before = opened.camera();
        let picture = self.picture.as_ref();
        let shape = |rect: Rect| picture.map(|picture| picture.texture.shape(rect));
        let handled = picture_view::show(ui, opened, self.slices.measures, shape);
        if handled.resets {
            opened.go_to(0);
        }
        if opened.camera() != before && opened.document.settings().camera.is_some() {
            self.timeline.pause();
        }
        let frame = opened.frame();
        let gaze = match self.gaze_kind {
            GazeKind::Pointer => self.pointer_gaze.gaze(frame, handled.pointer),
            GazeKind::Session => opened.gaze().gaze(frame),
        };
        if self.preferences.marks
            && let Some(super::Picture { shown, .. }) = &self.picture
        {
            let gaze = (shown.progress == Progress::Moving).then_some(gaze);
            let camera = shown.camera;
            picture_view::marks(ui, opened, &camera, gaze, handled.rect);
        }
        if let Some(super::Picture { shown, .. }) = &self.picture {
            picture_view::rulers(ui, opened, &shown.camera, &self.slices.rulers, handled.rect);
        }
        self.engine.want(ViewRequest {
            volume: opened.volume.clone(),
            settings: opened.screen_settings(pixels(handled.rect, ui.ctx().pixels_per_point())),
            freedom: opened.document.settings().freedom(),
            camera: opened.camera(),
            gaze,
            probe: handled.pointer,
            rate: (self.preferences.rate > 0.0).then_some(self.preferences.rate),
            converges: self.preferences.converges && !self.timeline.is_playing(),
            look: self.look,
        });
        if !self.timeline.is_playing() {
            opened.document.remember(time);
        }
        let at = handled.pointer?;
        self.measure_in_picture(at, handled.is_pressed);
        self.words_on_picture(at)
    }

    pub(super) fn start_page(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        self.thumbnails.prepare(&context);
        match start_page::show(ui, &self.preferences.recent, &self.thumbnails) {
            Some(start_page::Choice::Browse) => self.run(Command::Open, &context),
            Some(start_page::Choice::Open(source)) => self.after_saving(&context, Next::Open(source)),
            None => {}
        }
    }

    /// Shows pending work in the status line.
    pub(super) fn status(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            if let Some(job) = &self.opening {
                ui.spinner();
                ui.label(job.name());
            }
            if let Some(job) = &self.exporting {
                ui.add(egui::ProgressBar::new(job.done()).desired_width(120.0).show_percentage());
                ui.label(job.name());
                if ui.button("Cancel").clicked() {
                    job.cancel();
                }
                ui.ctx().request_repaint_after_secs(0.1);
            }
            match (&self.opened, &self.picture) {
                (Some(opened), Some(super::Picture { shown, .. })) => {
                    let grid = opened.volume.volume.grid();
                    let [x, y, z] = grid.dims();
                    ui.weak(format!("{x}×{y}×{z} {}", opened.volume.volume.dtype()));
                    if let Progress::Converging(share) = shown.progress {
                        ui.weak(format!("measured {:.0} %", share * 100.0));
                    }
                    if let Some(words) = &self.pointed {
                        ui.separator();
                        ui.label(words);
                    }
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let explanation = self.look.explanation();
                        if self.look != DisplayMode::Picture {
                            ui.weak(explanation);
                        }
                    });
                }
                (Some(_), None) => {
                    ui.weak("rendering…");
                }
                _ if self.opening.is_none() => {
                    ui.weak("F1 shows keys and mouse");
                }
                _ => {}
            }
        });
    }
}

/// Size of `rect` in pixels.
fn pixels(rect: Rect, pixels_per_point: f32) -> FrameSize {
    let side = |points: f32| (points * pixels_per_point).round().clamp(1.0, LARGEST) as u32;
    FrameSize { width: side(rect.width()), height: side(rect.height()) }
}
