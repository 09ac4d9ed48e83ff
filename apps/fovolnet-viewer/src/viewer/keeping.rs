//! Autosave and preferences.

use super::Viewer;
use crate::ui::dialogues::{Dialogue, Next};
use eframe::egui::{Context, ViewportCommand};

/// Seconds between autosaves.
const KEEP_EVERY: f64 = 3.0;

impl Viewer {
    /// Autosaves unsaved work and preferences.
    pub(super) fn keep(&mut self, context: &Context) {
        let time = context.input(|input| input.time);
        if time < self.kept_at + KEEP_EVERY {
            return;
        }
        self.kept_at = time;
        context.request_repaint_after_secs(KEEP_EVERY as f32 + 0.1);
        let changed = self.opened.as_ref().filter(|opened| opened.document.is_changed());
        let session = changed.map(|opened| opened.document.session());
        if let Some(session) = session.filter(|&session| self.kept.as_ref() != Some(session)) {
            match self.autosaves.keep(session) {
                Ok(()) => self.kept = Some(session.clone()),
                Err(error) => self.messages.error(format!("unsaved work cannot be kept: {error}")),
            }
        }
        self.save_preferences();
    }

    /// Deletes this viewer's autosave.
    pub(super) fn forget(&mut self) {
        self.kept = None;
        self.autosaves.forget();
    }

    pub(super) fn save_preferences(&mut self) {
        if self.preferences != self.saved_preferences {
            self.saved_preferences = self.preferences.clone();
            if let Err(error) = self.places.set_preferences(&self.preferences) {
                self.messages.error(format!("preferences cannot be kept: {error}"));
            }
        }
    }

    /// Marks the window as lost, or ended by a signal: it closes without a question. Unsaved work is offered at the next start.
    pub fn give_up(&mut self) {
        self.kept_at = f64::NEG_INFINITY;
        self.is_lost = true;
    }

    /// Prevents the window from closing over unsaved work.
    pub(super) fn guard_close(&mut self, context: &Context) {
        if self.is_lost || !context.input(|input| input.viewport().close_requested()) {
            return;
        }
        let has_work = self.opened.as_ref().is_some_and(|opened| opened.document.has_unsaved_work());
        if has_work && !self.may_quit {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.dialogue = Some(Dialogue::Unsaved(Next::Quit));
        } else if !self.may_quit && self.asks_about_export() {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
        } else {
            self.forget();
            self.save_preferences();
        }
    }
}
