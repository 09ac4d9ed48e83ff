//! The window.

use crate::commands::{self, Command, Entry};
use crate::dialogue::{Answer, Dialogue, ExportForm, FilePrompt, Next};
use crate::document::Document;
use crate::engine::{Engine, Said};
use crate::export::Export;
use crate::files::Purpose;
use crate::gaze::{GazeKind, GazeSource, PointerGaze};
use crate::job::Job;
use crate::layout_form::LayoutForm;
use crate::look::Look;
use crate::messages::Messages;
use crate::opened::Opened;
use crate::places::{Places, Preferences};
use crate::studio::{Progress, Shown, Wanted};
use crate::thumbnails::Thumbnails;
use crate::timeline::{Timeline, add_keyframe};
use crate::{navigation, panels, picture_view, start_page};
use anyhow::Result;
use eframe::egui::{
    self, Align, CentralPanel, CollapsingHeader, ColorImage, Context, Layout, Panel, Rect, ScrollArea,
    TextureHandle, TextureOptions, Theme, Ui, ViewportCommand,
};
use fovolnet::core::FrameSize;
use fovolnet::io::transfer_function;
use fovolnet::{RenderSettings, SpeedSettings, Timings, VolumeSettings};
use glam::DVec3;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// What the viewer is started with.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// A volume or a session.
    pub source: Option<String>,
    /// What its file does not say.
    pub read: VolumeSettings,
    /// How it is shown.
    pub render: RenderSettings,
    /// What computes it.
    pub speed: SpeedSettings,
}

/// The window.
pub struct Viewer {
    speed: SpeedSettings,
    places: Places,
    preferences: Preferences,
    saved_preferences: Preferences,
    engine: Engine,
    opened: Option<Opened>,
    /// What was said of the file that is opened last.
    read: VolumeSettings,
    opening: Option<Job<(Opened, Vec<String>)>>,
    exporting: Option<Job<String>>,
    dialogue: Option<Dialogue>,
    /// What is to be done when the session is saved.
    after_save: Option<Next>,
    messages: Messages,
    thumbnails: Thumbnails,
    picture: Option<(TextureHandle, Shown)>,
    rect: Rect,
    look: Look,
    gaze_kind: GazeKind,
    pointer_gaze: PointerGaze,
    timeline: Timeline,
    history: VecDeque<Timings>,
    arrivals: VecDeque<f64>,
    kept_at: f64,
    may_quit: bool,
}

/// Seconds between two looks at whether there is unsaved work to keep.
const KEEP_EVERY: f64 = 3.0;
/// The largest picture on the screen, in pixels along each side.
const LARGEST: f32 = 8192.0;

impl Viewer {
    /// A window that remembers things at `places`.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn new(context: &Context, start: Start, places: Places) -> Result<Self> {
        let preferences = places.preferences();
        let wake = context.clone();
        let engine = Engine::start(start.speed.clone(), move || wake.request_repaint())?;
        let mut viewer = Self {
            speed: start.speed,
            saved_preferences: preferences.clone(),
            preferences,
            engine,
            opened: None,
            read: VolumeSettings::default(),
            opening: None,
            exporting: None,
            dialogue: places.unsaved().map(|session| Dialogue::Restore(Box::new(session))),
            places,
            after_save: None,
            messages: Messages::default(),
            thumbnails: Thumbnails::default(),
            picture: None,
            rect: Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(64.0, 64.0)),
            look: Look::default(),
            gaze_kind: if start.render.gaze.is_some() { GazeKind::Session } else { GazeKind::default() },
            pointer_gaze: PointerGaze::default(),
            timeline: Timeline::default(),
            history: VecDeque::new(),
            arrivals: VecDeque::new(),
            kept_at: 0.0,
            may_quit: false,
        };
        if let Some(source) = start.source {
            viewer.open(context, &source, start.read, start.render);
        }
        Ok(viewer)
    }

    /// Makes the window dark, or light.
    pub fn set_dark(&mut self, is_dark: bool) {
        self.preferences.dark = is_dark;
    }

    /// What is open.
    pub fn opened(&self) -> Option<&Opened> {
        self.opened.as_ref()
    }

    /// What is open, to change it.
    pub fn opened_mut(&mut self) -> Option<&mut Opened> {
        self.opened.as_mut()
    }

    /// The picture that is shown, without its pixels.
    pub fn shown(&self) -> Option<&Shown> {
        self.picture.as_ref().map(|(_, shown)| shown)
    }

    /// Whether nothing is under way, and the picture is all that it will be.
    pub fn is_settled(&self) -> bool {
        self.opening.is_none()
            && self.exporting.is_none()
            && !self.timeline.is_playing()
            && self.engine.is_done()
            && (self.opened.is_none() || self.picture.is_some())
    }

    /// What was said to the person at the window.
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// The question that is asked now.
    pub fn dialogue(&self) -> Option<&Dialogue> {
        self.dialogue.as_ref()
    }

    /// Shows everything.
    pub fn show(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        context.set_theme(if self.preferences.dark { Theme::Dark } else { Theme::Light });
        self.receive(&context);
        if self.dialogue.is_none() {
            for command in commands::pressed(&context) {
                self.run(command, &context);
            }
        }
        Panel::top("menu").show(ui, |ui| self.menu(ui));
        Panel::bottom("status").show(ui, |ui| self.status(ui));
        if self.opened.is_some() {
            Panel::bottom("timeline").show(ui, |ui| {
                if let Some(opened) = &mut self.opened {
                    ui.add_space(3.0);
                    self.timeline.ui(ui, opened);
                    ui.add_space(3.0);
                }
            });
            Panel::right("settings").default_size(330.0).size_range(260.0..=560.0).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.settings(ui));
            });
            CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.picture(ui));
        } else {
            CentralPanel::default().show(ui, |ui| self.start_page(ui));
        }
        self.ask(&context);
        self.messages.show(&context);
        self.keep(&context);
        self.guard_close(&context);
    }

    /// Takes what threads have made.
    fn receive(&mut self, context: &Context) {
        let time = context.input(|input| input.time);
        if let Some(result) = self.opening.as_ref().and_then(Job::take) {
            self.opening = None;
            match result {
                Ok((opened, notes)) => self.take_opened(opened, notes, time),
                Err(error) => self.not_opened(&error),
            }
        }
        if let Some(job) = &self.exporting
            && let Some(result) = job.take()
        {
            match result {
                Ok(done) => self.messages.note(done, time),
                Err(_) if job.is_cancelled() => self.messages.note("the export was cancelled".into(), time),
                Err(error) => self.messages.error(format!("{error:#}")),
            }
            self.exporting = None;
        }
        for said in self.engine.take_said() {
            match said {
                Said::Note(text) => self.messages.note(text, time),
                Said::Error(text) => self.messages.set_picture_error(Some(text)),
            }
        }
        if let Some(shown) = self.engine.take_shown() {
            self.take_shown(context, shown, time);
        }
        let dropped =
            context.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.after_saving(context, Next::Open(path.display().to_string()));
        }
    }

    /// Asks for what is missing to open a file, or says what is wrong with it.
    fn not_opened(&mut self, error: &anyhow::Error) {
        use fovolnet::Error::Io;
        use fovolnet::io::Error::UnknownLayout;
        if let Some(Io(UnknownLayout { path, .. })) = error.downcast_ref::<fovolnet::Error>() {
            let form = LayoutForm::new(&path.display().to_string(), &self.read);
            self.dialogue = Some(Dialogue::Layout(form));
        } else {
            self.messages.error(format!("{error:#}"));
        }
    }

    fn take_opened(&mut self, opened: Opened, notes: Vec<String>, time: f64) {
        let source = match opened.document.file() {
            Some(file) => file.display().to_string(),
            None => opened.document.session().volume.clone(),
        };
        self.preferences.remember(&source);
        self.messages.clear_errors();
        for note in notes {
            self.messages.note(note, time);
        }
        if opened.document.settings().gaze.is_some() {
            self.gaze_kind = GazeKind::Session;
        }
        self.timeline = Timeline::default();
        self.picture = None;
        self.opened = Some(opened);
    }

    fn take_shown(&mut self, context: &Context, mut shown: Shown, time: f64) {
        let size = [shown.size.width as usize, shown.size.height as usize];
        let image = ColorImage::from_rgba_premultiplied(size, &std::mem::take(&mut shown.rgba));
        if shown.progress == Progress::Moving {
            self.history.push_back(shown.timings);
            if self.history.len() > panels::HISTORY {
                self.history.pop_front();
            }
            self.arrivals.push_back(time);
        }
        self.messages.set_picture_error(None);
        match &mut self.picture {
            Some((texture, old)) => {
                texture.set(image, TextureOptions::LINEAR);
                *old = shown;
            }
            None => {
                let texture = context.load_texture("picture", image, TextureOptions::LINEAR);
                self.picture = Some((texture, shown));
            }
        }
    }

    /// Pictures a second, lately.
    fn rate(&mut self, time: f64) -> f64 {
        while self.arrivals.front().is_some_and(|&arrival| arrival < time - 1.0) {
            self.arrivals.pop_front();
        }
        self.arrivals.len() as f64
    }

    fn menu(&mut self, ui: &mut Ui) {
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

    /// Whether `command` can be done now.
    fn can(&self, command: Command) -> bool {
        let document = self.opened.as_ref().map(|opened| &opened.document);
        match command {
            Command::Open | Command::Quit | Command::ToggleTheme | Command::Help => true,
            Command::Undo => document.is_some_and(Document::can_undo),
            Command::Redo => document.is_some_and(Document::can_redo),
            Command::ExportPicture | Command::ExportVideo => document.is_some() && self.exporting.is_none(),
            _ => document.is_some(),
        }
    }

    /// Does `command`, if it can be done now.
    pub fn run(&mut self, command: Command, context: &Context) {
        if !self.can(command) {
            return;
        }
        match command {
            Command::Open => {
                self.dialogue = Some(Dialogue::File(FilePrompt::new(Purpose::Open, &self.folder())));
            }
            Command::Close => self.after_saving(context, Next::Close),
            Command::Quit => self.after_saving(context, Next::Quit),
            Command::ToggleTheme => self.preferences.dark = !self.preferences.dark,
            Command::ToggleMarks => self.preferences.marks = !self.preferences.marks,
            Command::Help => self.dialogue = Some(Dialogue::Help),
            Command::Show(look) => self.look = look,
            _ => self.run_on_document(command, context),
        }
    }

    fn run_on_document(&mut self, command: Command, context: &Context) {
        let folder = self.folder();
        let time = context.input(|input| input.time);
        let Some(opened) = &mut self.opened else { return };
        let stem = Path::new(&opened.document.name()).with_extension("");
        let named = |extension: &str| folder.join(stem.with_extension(extension));
        match command {
            Command::Save => match opened.document.file().map(Path::to_owned) {
                Some(path) => self.save(context, &path),
                None => self.run_on_document(Command::SaveAs, context),
            },
            Command::SaveAs => {
                self.dialogue = Some(Dialogue::File(FilePrompt::new(Purpose::SaveSession, &named("toml"))));
            }
            Command::ExportPicture => {
                let size = opened.document.settings().frame_size();
                self.dialogue = Some(Dialogue::Export(ExportForm::picture(size, &named("png"))));
            }
            Command::ExportVideo => {
                let (size, length) = (opened.document.settings().frame_size(), opened.path_length());
                let extension = if fovolnet::io::video::ffmpeg_installed() { "mp4" } else { "y4m" };
                self.dialogue = Some(Dialogue::Export(ExportForm::video(size, length, &named(extension))));
            }
            Command::Undo => opened.document.undo(),
            Command::Redo => opened.document.redo(),
            Command::ResetView => opened.go_to(0),
            Command::LookFrom(direction) => {
                let towards = DVec3::from_array(direction.map(f64::from));
                let camera = navigation::look_from(&opened.camera(), towards);
                opened.stand_at(&camera);
            }
            Command::PlayOrPause => self.timeline.play_or_pause(time, opened.frame()),
            Command::AddKeyframe => {
                self.timeline.pause();
                add_keyframe(opened);
            }
            _ => {}
        }
    }

    /// The folder that files are likely to be in.
    fn folder(&self) -> PathBuf {
        let opened = self.opened.as_ref().map(|opened| &opened.document);
        let known = opened.and_then(|document| {
            document.file().map(Path::to_owned).or_else(|| Some(PathBuf::from(&document.session().volume)))
        });
        let folder =
            known.and_then(|path| path.parent().map(Path::to_owned)).filter(|folder| folder.is_absolute());
        folder.or_else(|| std::env::current_dir().ok()).unwrap_or_default()
    }

    /// Does `next` when nothing is lost by it.
    fn after_saving(&mut self, context: &Context, next: Next) {
        if self.opened.as_ref().is_some_and(|opened| opened.document.is_changed()) {
            self.dialogue = Some(Dialogue::Unsaved(next));
        } else {
            self.go_on(context, next);
        }
    }

    fn go_on(&mut self, context: &Context, next: Next) {
        self.places.forget();
        match next {
            Next::Open(source) => {
                self.open(context, &source, VolumeSettings::default(), RenderSettings::default());
            }
            Next::Close => {
                self.opened = None;
                self.picture = None;
                self.timeline = Timeline::default();
            }
            Next::Quit => {
                self.may_quit = true;
                context.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    fn open(&mut self, context: &Context, source: &str, read: VolumeSettings, render: RenderSettings) {
        self.read = read;
        let source = source.to_owned();
        let name = format!("opening {}", start_page::middle_cut(&source, 50));
        self.start_opening(context, name, move || Opened::open(&source, read, render));
    }

    fn start_opening(
        &mut self,
        context: &Context,
        name: String,
        open: impl FnOnce() -> Result<(Opened, Vec<String>)> + Send + 'static,
    ) {
        let wake = context.clone();
        match Job::start(name, move || wake.request_repaint(), move |_| open()) {
            Ok(job) => self.opening = Some(job),
            Err(error) => self.messages.error(format!("cannot start a thread: {error}")),
        }
    }

    fn save(&mut self, context: &Context, path: &Path) {
        let time = context.input(|input| input.time);
        let Some(opened) = &mut self.opened else { return };
        match opened.document.save(path) {
            Ok(()) => {
                self.places.forget();
                self.preferences.remember(&path.display().to_string());
                self.messages.note(format!("{} is saved", path.display()), time);
                if let Some(next) = self.after_save.take() {
                    self.after_saving(context, next);
                }
            }
            Err(error) => {
                self.after_save = None;
                self.messages.error(error.to_string());
            }
        }
    }

    fn export(&mut self, context: &Context, export: Export) {
        let Some(opened) = &self.opened else { return };
        let (session, volume) = (opened.document.session().clone(), opened.volume.clone());
        let speed = self.speed.clone();
        let name = format!("exporting {}", start_page::middle_cut(&export.path.display().to_string(), 50));
        let wake = context.clone();
        let work = Job::start(
            name,
            move || wake.request_repaint(),
            move |handle| export.run(&session, &volume, &speed, handle),
        );
        match work {
            Ok(job) => self.exporting = Some(job),
            Err(error) => self.messages.error(format!("cannot start a thread: {error}")),
        }
    }

    /// Shows the question that is asked, and does what was answered.
    fn ask(&mut self, context: &Context) {
        let Some(answer) = self.dialogue.as_mut().and_then(|dialogue| dialogue.show(context)) else { return };
        self.dialogue = None;
        let time = context.input(|input| input.time);
        match answer {
            Answer::Cancel => self.after_save = None,
            Answer::File(purpose, path) => self.take_file(context, purpose, &path, time),
            Answer::Export(export) => self.export(context, *export),
            Answer::Save(next) => {
                self.after_save = Some(next);
                self.run_on_document(Command::Save, context);
            }
            Answer::Discard(next) => self.go_on(context, next),
            Answer::Layout(source, read) => self.open(context, &source, read, RenderSettings::default()),
            Answer::Restore(session) => {
                let open = move || Opened::of_document(Document::restored(*session));
                self.start_opening(context, "opening what was not saved".into(), open);
            }
        }
    }

    fn take_file(&mut self, context: &Context, purpose: Purpose, path: &Path, time: f64) {
        match purpose {
            Purpose::Open => self.after_saving(context, Next::Open(path.display().to_string())),
            Purpose::SaveSession => self.save(context, path),
            Purpose::ReadTransfer => match (transfer_function::read(path), &mut self.opened) {
                (Ok(transfer), Some(opened)) => opened.set_transfer(transfer),
                (Err(error), _) => self.messages.error(error.to_string()),
                (Ok(_), None) => {}
            },
            Purpose::SaveTransfer => {
                let Some(opened) = &self.opened else { return };
                match transfer_function::write(path, opened.transfer()) {
                    Ok(()) => self.messages.note(format!("{} is saved", path.display()), time),
                    Err(error) => self.messages.error(error.to_string()),
                }
            }
            // Forms ask for these.
            Purpose::SavePicture | Purpose::SaveVideo => {}
        }
    }

    fn settings(&mut self, ui: &mut Ui) {
        let time = ui.input(|input| input.time);
        let rate = self.rate(time);
        let folder = self.folder();
        let Some(opened) = &mut self.opened else { return };
        let section = |name: &str| CollapsingHeader::new(name).default_open(true);
        section("Transfer function").show(ui, |ui| {
            ui.horizontal(|ui| {
                let current = opened.document.settings().tf.clone().unwrap_or_else(|| "auto".into());
                if let Some(name) = crate::transfer_editor::presets_ui(ui, &current, &opened.volume) {
                    opened.document.settings_mut().tf = Some(name);
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
            if let Some(changed) = opened.editor.ui(ui, &transfer, &opened.histogram) {
                opened.set_transfer(changed);
            }
        });
        section("Light").show(ui, |ui| panels::scene(ui, opened.document.settings_mut()));
        CollapsingHeader::new("Clipping").show(ui, |ui| {
            panels::clipping(ui, opened.document.settings_mut(), opened.volume.volume.grid().dims());
        });
        let shown = self.picture.as_ref().map(|(_, shown)| shown);
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
    }

    fn picture(&mut self, ui: &mut Ui) {
        let time = ui.input(|input| input.time);
        let Some(opened) = &mut self.opened else { return };
        if self.timeline.is_playing() {
            self.timeline.advance(time, opened);
            ui.ctx().request_repaint();
        }
        let texture = self.picture.as_ref().map(|(texture, _)| texture.id());
        let before = opened.camera();
        let handled = picture_view::show(ui, opened, texture);
        if handled.resets {
            opened.go_to(0);
        }
        if opened.camera() != before && opened.document.settings().camera.is_some() {
            self.timeline.pause();
        }
        self.rect = handled.rect;
        let frame = opened.frame();
        let gaze = match self.gaze_kind {
            GazeKind::Pointer => self.pointer_gaze.gaze(frame, handled.pointer),
            GazeKind::Session => opened.document.settings().fovea(frame).map_or([0.5; 2], |fovea| fovea.gaze),
        };
        if self.preferences.marks
            && let Some((_, shown)) = &self.picture
        {
            let gaze = (shown.progress == Progress::Moving).then_some(gaze);
            let camera = shown.camera;
            picture_view::marks(ui, opened, &camera, gaze, handled.rect);
        }
        self.engine.want(Wanted {
            volume: opened.volume.clone(),
            settings: opened.screen_settings(pixels(handled.rect, ui.ctx().pixels_per_point())),
            camera: opened.camera(),
            gaze,
            rate: (self.preferences.rate > 0.0).then_some(self.preferences.rate),
            converges: self.preferences.converges && !self.timeline.is_playing(),
            look: self.look,
        });
        if !self.timeline.is_playing() {
            opened.document.remember(time);
        }
    }

    fn start_page(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        self.thumbnails.prepare(&context);
        match start_page::show(ui, &self.preferences.recent, &self.thumbnails) {
            Some(start_page::Choice::Browse) => self.run(Command::Open, &context),
            Some(start_page::Choice::Open(source)) => self.after_saving(&context, Next::Open(source)),
            None => {}
        }
    }

    /// What is under way, in the last line of the window.
    fn status(&mut self, ui: &mut Ui) {
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
                (Some(opened), Some((_, shown))) => {
                    let grid = opened.volume.volume.grid();
                    let [x, y, z] = grid.dims();
                    ui.weak(format!("{x}×{y}×{z} {}", opened.volume.volume.dtype()));
                    if let Progress::Converging(share) = shown.progress {
                        ui.weak(format!("measured {:.0} %", share * 100.0));
                    }
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        let explanation = self.look.explanation();
                        if self.look != Look::Picture {
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

    /// Keeps what is not saved, and tastes, where a crash does not take them.
    fn keep(&mut self, context: &Context) {
        let time = context.input(|input| input.time);
        if time < self.kept_at + KEEP_EVERY {
            return;
        }
        self.kept_at = time;
        context.request_repaint_after_secs(KEEP_EVERY as f32 + 0.1);
        if let Some(opened) = self.opened.as_ref().filter(|opened| opened.document.is_changed())
            && let Err(error) = self.places.keep(opened.document.session())
        {
            self.messages.error(format!("unsaved work cannot be kept: {error}"));
        }
        self.save_preferences();
    }

    fn save_preferences(&mut self) {
        if self.preferences != self.saved_preferences {
            self.saved_preferences = self.preferences.clone();
            if let Err(error) = self.places.set_preferences(&self.preferences) {
                self.messages.error(format!("preferences cannot be kept: {error}"));
            }
        }
    }

    /// Does not let the window close over unsaved changes.
    fn guard_close(&mut self, context: &Context) {
        if !context.input(|input| input.viewport().close_requested()) {
            return;
        }
        let is_changed = self.opened.as_ref().is_some_and(|opened| opened.document.is_changed());
        if is_changed && !self.may_quit {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.dialogue = Some(Dialogue::Unsaved(Next::Quit));
        } else {
            self.places.forget();
            self.save_preferences();
        }
    }
}

/// The size of `rect` in pixels.
fn pixels(rect: Rect, pixels_per_point: f32) -> FrameSize {
    let side = |points: f32| (points * pixels_per_point).round().clamp(1.0, LARGEST) as u32;
    FrameSize { width: side(rect.width()), height: side(rect.height()) }
}
