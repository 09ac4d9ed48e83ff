//! Main window.

mod actions;
mod keeping;
mod leaving;
mod panes;
mod pointing;
mod time_playback;

use crate::frames::display_mode::DisplayMode;
use crate::frames::engine::{Engine, Said};
use crate::frames::gaze::{GazeKind, PointerGaze};
use crate::frames::presented::{Pixels, Presented, Progress};
use crate::job::Job;
use crate::session::autosave::{Autosaves, Crashed};
use crate::session::opened::Opened;
use crate::session::places::{Places, Preferences};
use crate::ui::commands;
use crate::ui::dialogues::layout_form::LayoutForm;
use crate::ui::dialogues::{Dialogue, Next};
use crate::ui::messages::Messages;
use crate::ui::panels;
use crate::ui::slices::slices_state::Slices;
use crate::ui::thumbnails::Thumbnails;
use crate::ui::timeline::Timeline;
use crate::window::quad::{OnWindow, Painter};
use crate::window::screen::{OnScreen, Screen};
use anyhow::Result;
use eframe::egui::{
    self, CentralPanel, Color32, ColorImage, Context, Panel, Pos2, Rect, ScrollArea, Shape, TextureHandle,
    TextureId, TextureOptions, Theme, Ui, pos2, style::ScrollStyle,
};
use fovolnet::core::text_of_path;
use fovolnet::{RenderOverrides, Session, SpeedSettings, Timings, VolumeSettings};
use std::collections::VecDeque;
use std::time::Duration;
use time_playback::TimePlayback;

/// Parameters of a viewer.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// Volume or session to open.
    pub source: Option<String>,
    /// Settings for reading the volume's file.
    pub read: VolumeSettings,
    /// Render settings that are given.
    pub render: RenderOverrides,
    /// Settings of devices and performance.
    pub speed: SpeedSettings,
    /// Device shared by window and renderer, if any.
    pub screen: Option<Screen>,
    /// Renderer for pictures from the host. Without it the user interface's own renderer draws them.
    pub painter: Option<Painter>,
}

/// Displayed picture.
struct Picture {
    texture: Texture,
    /// Description of the picture, without its pixels.
    shown: Presented,
}

/// Storage of a picture's pixels.
enum Texture {
    Host(TextureHandle),
    Window(OnWindow),
    Device(OnScreen),
}

impl Texture {
    /// Shape that draws the picture in `rect`.
    fn shape(&self, rect: Rect) -> Shape {
        let of = |id: TextureId| {
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            Shape::image(id, rect, whole, Color32::WHITE)
        };
        match self {
            Self::Host(texture) => of(texture.id()),
            Self::Window(picture) => picture.shape(rect),
            Self::Device(picture) => of(picture.id()),
        }
    }
}

/// Main window with its state.
pub struct Viewer {
    speed: SpeedSettings,
    places: Places,
    autosaves: Autosaves,
    /// Session of a crashed viewer, until it is restored or discarded.
    crashed: Option<Crashed>,
    preferences: Preferences,
    saved_preferences: Preferences,
    engine: Engine,
    opened: Option<Opened>,
    /// Settings given for the file opened last.
    said: (VolumeSettings, RenderOverrides),
    opening: Option<Job<(Opened, Vec<String>)>>,
    /// Reason why the last requested file is not open.
    unopened: Option<String>,
    exporting: Option<Job<String>>,
    dialogue: Option<Dialogue>,
    /// Action that follows once the session is saved.
    after_save: Option<Next>,
    messages: Messages,
    thumbnails: Thumbnails,
    screen: Option<Screen>,
    painter: Option<Painter>,
    picture: Option<Picture>,
    look: DisplayMode,
    gaze_kind: GazeKind,
    pointer_gaze: PointerGaze,
    slices: Slices,
    /// Words on the point under the pointer.
    pointed: Option<String>,
    timeline: Timeline,
    times: TimePlayback,
    history: VecDeque<Timings>,
    arrivals: VecDeque<f64>,
    kept_at: f64,
    kept: Option<Session>,
    may_quit: bool,
    is_lost: bool,
}

/// Delay of a redraw for a new picture.
const SOON: Duration = Duration::from_micros(1);

impl Viewer {
    /// Creates a window that stores persistent state in `places`.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn new(context: &Context, start: Start, places: Places) -> Result<Self> {
        let preferences = places.preferences();
        let gpu = start.screen.as_ref().map(|screen| screen.gpu().clone());
        // An immediate repaint request would draw the window twice, which takes time with software rendering.
        let window = context.clone();
        let wake = move || window.request_repaint_after(SOON);
        let engine = Engine::start(start.speed.clone(), gpu, wake)?;
        let autosaves = places.autosaves();
        let found = autosaves.find();
        let restored = found.crashed.as_ref().map(|crashed| Box::new(crashed.session().clone()));
        let mut viewer = Self {
            speed: start.speed,
            saved_preferences: preferences.clone(),
            preferences,
            engine,
            opened: None,
            said: Default::default(),
            opening: None,
            unopened: None,
            exporting: None,
            dialogue: restored.map(Dialogue::Restore),
            places,
            autosaves,
            crashed: found.crashed,
            after_save: None,
            messages: Messages::default(),
            thumbnails: Thumbnails::default(),
            screen: start.screen,
            painter: start.painter,
            picture: None,
            look: DisplayMode::default(),
            gaze_kind: if start.render.gaze.is_some() { GazeKind::Session } else { GazeKind::default() },
            pointer_gaze: PointerGaze::default(),
            slices: Slices::default(),
            pointed: None,
            timeline: Timeline::default(),
            times: TimePlayback::default(),
            history: VecDeque::new(),
            arrivals: VecDeque::new(),
            kept_at: 0.0,
            kept: None,
            may_quit: false,
            is_lost: false,
        };
        let time = context.input(|input| input.time);
        found.notes.into_iter().for_each(|note| viewer.messages.note(note, time));
        if let Some(source) = start.source {
            viewer.open(context, &source, start.read, start.render);
        }
        Ok(viewer)
    }

    /// Sets the dark or the light theme.
    pub fn set_dark(&mut self, is_dark: bool) {
        self.preferences.dark = is_dark;
    }

    /// The open volume.
    pub fn opened(&self) -> Option<&Opened> {
        self.opened.as_ref()
    }

    /// The displayed picture, without its pixels.
    pub fn shown(&self) -> Option<&Presented> {
        self.picture.as_ref().map(|picture| &picture.shown)
    }

    /// The slices beside the picture.
    pub fn slices(&self) -> &Slices {
        &self.slices
    }

    /// Words on the point under the pointer.
    pub fn pointed(&self) -> Option<&str> {
        self.pointed.as_deref()
    }

    /// Whether no work is pending and the picture is final.
    pub fn is_settled(&self) -> bool {
        self.opening.is_none()
            && self.exporting.is_none()
            && !self.timeline.is_playing()
            && !self.times.plays
            && self.engine.is_done()
            && self.opened.as_ref().is_none_or(|opened| !opened.backdrop.is_counting())
            && (self.opened.is_none() || self.picture.is_some() || self.messages.picture_error().is_some())
    }

    /// Reason why the requested volume is not shown, once no pending work could still show it.
    pub fn failure(&self) -> Option<&str> {
        if self.opening.is_some() || self.picture.is_some() || !self.engine.is_done() {
            return None;
        }
        match self.opened {
            Some(_) => self.messages.picture_error(),
            None => self.unopened.as_deref(),
        }
    }

    /// Messages for the user.
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// The open dialogue.
    pub fn dialogue(&self) -> Option<&Dialogue> {
        self.dialogue.as_ref()
    }

    /// Shows the whole window.
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
                // A permanent scroll bar shows that there is more.
                ui.spacing_mut().scroll = ScrollStyle::solid();
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

    /// Takes results of background threads.
    fn receive(&mut self, context: &Context) {
        let time = context.input(|input| input.time);
        if let Some(result) = self.opening.as_ref().and_then(Job::take) {
            self.opening = None;
            match result {
                Ok((opened, notes)) => self.take_opened(opened, notes, time),
                Err(error) => {
                    self.times.plays = false;
                    self.not_opened(&error);
                }
            }
        }
        if let Some(job) = &self.exporting
            && let Some(result) = job.take()
        {
            match result {
                Ok(done) => self.messages.note(done, time),
                Err(_) if job.is_cancelled() => self.messages.note("the export was cancelled".into(), time),
                Err(error) => self.messages.error(fovolnet::one_line(error.as_ref())),
            }
            self.exporting = None;
            self.export_ended();
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
            self.after_saving(context, Next::Open(text_of_path(&path)));
        }
    }

    /// Asks for missing settings to open a file, or reports the error.
    fn not_opened(&mut self, error: &anyhow::Error) {
        use fovolnet::Error::Io;
        use fovolnet::io::Error::UnknownLayout;
        if let Some(Io(UnknownLayout { path, .. })) = error.downcast_ref::<fovolnet::Error>() {
            let form = LayoutForm::new(&text_of_path(path), &self.said.0);
            self.dialogue = Some(Dialogue::Layout(form));
        } else {
            self.messages.error(fovolnet::one_line(error.as_ref()));
        }
        self.unopened = Some(fovolnet::one_line(error.as_ref()));
    }

    fn take_opened(&mut self, opened: Opened, notes: Vec<String>, time: f64) {
        let source = match opened.document.file() {
            Some(file) => text_of_path(file),
            None => opened.document.session().volume.clone(),
        };
        self.preferences.remember(&source);
        self.messages.clear_errors();
        self.unopened = None;
        self.times.opened();
        if self.times.plays {
            self.opened = Some(opened);
            return;
        }
        for note in notes {
            self.messages.note(note, time);
        }
        if opened.document.settings().gaze.is_some() {
            self.gaze_kind = GazeKind::Session;
        }
        if opened.document.is_restored()
            && let Some(crashed) = self.crashed.take()
        {
            self.autosaves.adopt(crashed);
        }
        self.timeline = Timeline::default();
        self.picture = None;
        self.opened = Some(opened);
    }

    fn take_shown(&mut self, context: &Context, mut shown: Presented, time: f64) {
        self.times.shown();
        if shown.progress == Progress::Moving {
            self.history.push_back(shown.timings);
            if self.history.len() > panels::HISTORY {
                self.history.pop_front();
            }
            self.arrivals.push_back(time);
        }
        self.messages.set_picture_error(None);
        let before = self.picture.take().map(|picture| picture.texture);
        let texture = match std::mem::replace(&mut shown.pixels, Pixels::Host(Vec::new())) {
            Pixels::Host(rgba) => Some(match &self.painter {
                Some(painter) => {
                    let before = before.and_then(|texture| match texture {
                        Texture::Window(shown) => Some(shown),
                        Texture::Host(_) | Texture::Device(_) => None,
                    });
                    Texture::Window(painter.show(shown.size.into(), &rgba, before))
                }
                None => Texture::Host(uploaded(context, &rgba, &shown, before)),
            }),
            Pixels::Device(picture) => self.screen.as_ref().map(|screen| {
                let before = before.and_then(|texture| match texture {
                    Texture::Device(shown) => Some(shown),
                    Texture::Host(_) | Texture::Window(_) => None,
                });
                Texture::Device(screen.show(&picture, before))
            }),
        };
        self.picture = texture.map(|texture| Picture { texture, shown });
    }
}

/// Texture with the pixels `rgba` of `shown`; reuses `before` if possible.
fn uploaded(context: &Context, rgba: &[u8], shown: &Presented, before: Option<Texture>) -> TextureHandle {
    let size = [shown.size.width as usize, shown.size.height as usize];
    let image = ColorImage::from_rgba_premultiplied(size, rgba);
    match before {
        Some(Texture::Host(mut texture)) => {
            texture.set(image, TextureOptions::LINEAR);
            texture
        }
        _ => context.load_texture("picture", image, TextureOptions::LINEAR),
    }
}
