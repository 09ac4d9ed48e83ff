//! Actions of menus, keys and dialogues.

use super::Viewer;
use crate::job::Job;
use crate::session::document::Document;
use crate::session::export::Export;
use crate::session::opened::Opened;
use crate::ui::commands::Command;
use crate::ui::dialogues::export_form::ExportForm;
use crate::ui::dialogues::files::Purpose;
use crate::ui::dialogues::{Answer, Dialogue, FilePrompt, Next};
use crate::ui::timeline::{Timeline, add_keyframe};
use crate::{session::kept, ui::picture::navigation, ui::start_page};
use anyhow::Result;
use eframe::egui::{Context, ViewportCommand};
use fovolnet::core::{path_of_text, text_of_path};
use fovolnet::io::transfer_function;
use fovolnet::{RenderOverrides, VolumeSettings};
use glam::DVec3;
use std::path::{Path, PathBuf};

impl Viewer {
    /// Whether `command` is available now.
    pub(super) fn can(&self, command: Command) -> bool {
        let document = self.opened.as_ref().map(|opened| &opened.document);
        match command {
            Command::Open | Command::Quit | Command::ToggleTheme | Command::Help => true,
            Command::Undo => document.is_some_and(Document::can_undo),
            Command::Redo => document.is_some_and(Document::can_redo),
            Command::ExportPicture | Command::ExportVideo => document.is_some() && self.exporting.is_none(),
            _ => document.is_some(),
        }
    }

    /// Runs `command` if it is available.
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
            Command::ToggleSlices => self.preferences.slices = !self.preferences.slices,
            Command::ToggleRuler => self.slices.measures = !self.slices.measures,
            Command::ClearRulers => self.slices.rulers.clear(),
            Command::Help => self.dialogue = Some(Dialogue::Help),
            Command::Show(look) => self.look = look,
            _ => self.run_on_document(command, context),
        }
    }

    pub(super) fn run_on_document(&mut self, command: Command, context: &Context) {
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
                let form = ExportForm::picture(opened.document.settings(), &named("png"));
                self.dialogue = Some(Dialogue::Export(form));
            }
            Command::ExportVideo => {
                let (camera, length) = (opened.camera(), opened.path_length());
                let form = ExportForm::video(opened.document.settings(), camera, length, &named("mp4"));
                self.dialogue = Some(Dialogue::Export(form));
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

    /// Folder to suggest for files.
    pub(super) fn folder(&self) -> PathBuf {
        let opened = self.opened.as_ref().map(|opened| &opened.document);
        let known = opened.and_then(|document| {
            document
                .file()
                .map(Path::to_owned)
                .or_else(|| Some(path_of_text(&document.session().volume).into_owned()))
        });
        let folder =
            known.and_then(|path| path.parent().map(Path::to_owned)).filter(|folder| folder.is_absolute());
        folder.or_else(|| std::env::current_dir().ok()).unwrap_or_default()
    }

    /// Continues with `next`, after asking about unsaved work.
    pub(super) fn after_saving(&mut self, context: &Context, next: Next) {
        if self.opened.as_ref().is_some_and(|opened| opened.document.has_unsaved_work()) {
            self.dialogue = Some(Dialogue::Unsaved(next));
        } else {
            self.go_on(context, next);
        }
    }

    pub(super) fn go_on(&mut self, context: &Context, next: Next) {
        if next == Next::Quit && self.asks_about_export() {
            return;
        }
        self.forget();
        match next {
            Next::Open(source) => {
                self.open(context, &source, VolumeSettings::default(), RenderOverrides::default());
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

    pub(super) fn open(
        &mut self,
        context: &Context,
        source: &str,
        read: VolumeSettings,
        render: RenderOverrides,
    ) {
        self.said = (read.clone(), render.clone());
        let source = source.to_owned();
        let name = format!("opening {}", start_page::middle_cut(&source, 50));
        self.start_opening(context, name, move || Opened::open(&source, read, render));
    }

    pub(super) fn start_opening(
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

    pub(super) fn save(&mut self, context: &Context, path: &Path) {
        let time = context.input(|input| input.time);
        let Some(opened) = &mut self.opened else { return };
        match opened.document.save(path) {
            Ok(()) => {
                self.forget();
                self.preferences.remember(&text_of_path(path));
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

    pub(super) fn export(&mut self, context: &Context, export: Export) {
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

    /// Shows the current dialogue and handles its answer.
    pub(super) fn ask(&mut self, context: &Context) {
        let Some(answer) = self.dialogue.as_mut().and_then(|dialogue| dialogue.show(context)) else { return };
        let is_offer = matches!(self.dialogue, Some(Dialogue::Restore(_)));
        self.dialogue = None;
        let time = context.input(|input| input.time);
        match answer {
            Answer::Cancel => {
                self.after_save = None;
                // A cancelled offer to restore comes again at the next start.
                if is_offer {
                    self.crashed = None;
                }
            }
            Answer::File(purpose, path) => self.take_file(context, purpose, &path, time),
            Answer::Export(export) => self.export(context, *export),
            Answer::Save(next) => {
                self.after_save = Some(next);
                self.run_on_document(Command::Save, context);
            }
            Answer::Discard(next) => self.go_on(context, next),
            Answer::Layout(source, read) => self.open(context, &source, *read, self.said.1.clone()),
            Answer::Forget => {
                if let Some(crashed) = self.crashed.take() {
                    crashed.forget();
                }
            }
            Answer::Leave => self.leave_export(context),
            Answer::Restore(session) => {
                let open = move || Opened::of_document(Document::restored(*session));
                self.start_opening(context, "opening what was not saved".into(), open);
            }
        }
    }

    pub(super) fn take_file(&mut self, context: &Context, purpose: Purpose, path: &Path, time: f64) {
        match purpose {
            Purpose::Open => self.after_saving(context, Next::Open(text_of_path(path))),
            Purpose::SaveSession => self.save(context, path),
            Purpose::ReadTransfer => match (transfer_function::read(path), &mut self.opened) {
                (Ok(transfer), Some(opened)) => opened.set_transfer(&transfer),
                (Err(error), _) => self.messages.error(error.to_string()),
                (Ok(_), None) => {}
            },
            Purpose::SaveTransfer => {
                let Some(opened) = &self.opened else { return };
                let written = kept::check(path, |path| transfer_function::read(path).is_ok())
                    .and_then(|()| transfer_function::write(path, opened.transfer()));
                match written {
                    Ok(()) => self.messages.note(format!("{} is saved", path.display()), time),
                    Err(error) => self.messages.error(error.to_string()),
                }
            }
            // Exports use their own forms.
            Purpose::SavePicture | Purpose::SaveVideo => {}
        }
    }
}
