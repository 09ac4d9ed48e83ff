//! The end of the viewer while it exports.

use super::Viewer;
use crate::ui::dialogues::{Dialogue, Next};
use eframe::egui::Context;

impl Viewer {
    /// Asks whether to leave although an export is under way; false where none is.
    pub(super) fn asks_about_export(&mut self) -> bool {
        let running = self.exporting.as_ref().filter(|job| !job.is_cancelled());
        let question = running.map(|job| Dialogue::Leave(job.name().to_owned()));
        let asks = question.is_some();
        if asks {
            self.dialogue = question;
        }
        asks
    }

    /// Drops the export and ends the viewer.
    pub(super) fn leave_export(&mut self, context: &Context) {
        if let Some(job) = &self.exporting {
            job.cancel();
        }
        self.go_on(context, Next::Quit);
    }

    /// The export has ended, and with it the question whether to drop it. What became of it stands in the window: nobody leaves
    /// without having seen that.
    pub(super) fn export_ended(&mut self) {
        if matches!(self.dialogue, Some(Dialogue::Leave(_))) {
            self.dialogue = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Start;
    use crate::job::Job;
    use crate::session::places::Places;
    use eframe::egui::{ViewportCommand, ViewportEvent, ViewportId};
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, mpsc};

    type Window = Harness<'static, Option<Viewer>>;

    /// An empty window in which an export runs until the sender is dropped; whether it was cancelled.
    fn exporting() -> (Window, mpsc::Sender<()>, Arc<AtomicBool>) {
        let show = |ui: &mut eframe::egui::Ui, viewer: &mut Option<Viewer>| {
            let make = || Viewer::new(ui.ctx(), Start::default(), Places::in_folder(None)).unwrap();
            viewer.get_or_insert_with(make).show(ui);
        };
        let mut window = Harness::builder().with_size([900.0, 640.0]).build_ui_state(show, None);
        window.step();
        let (send, end) = mpsc::channel();
        let is_cancelled = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&is_cancelled);
        let work = move |handle: &crate::job::Handle| {
            let _ = end.recv();
            told.store(handle.progress(0.5).is_err(), Ordering::Relaxed);
            Ok("head.mp4 is written".to_owned())
        };
        let job = Job::start("exporting head.mp4", || (), work).unwrap();
        window.state_mut().as_mut().unwrap().exporting = Some(job);
        window.step();
        (window, send, is_cancelled)
    }

    fn viewer(window: &Window) -> &Viewer {
        window.state().as_ref().unwrap()
    }

    /// Closes the window as its frame does; whether it stays.
    fn close(window: &mut Window) -> bool {
        let root = window.input_mut().viewports.get_mut(&ViewportId::ROOT).unwrap();
        root.events.push(ViewportEvent::Close);
        window.step();
        let stays = commands(window).contains(&ViewportCommand::CancelClose);
        // A question appears with the next frames.
        (0..3).for_each(|_| window.step());
        stays
    }

    fn commands(window: &Window) -> Vec<ViewportCommand> {
        window.output().viewport_output[&ViewportId::ROOT].commands.clone()
    }

    fn click(window: &mut Window, label: &str) -> Vec<ViewportCommand> {
        window.get_by_label(label).click();
        let mut sent = Vec::new();
        for _ in 0..3 {
            window.step();
            sent.extend(commands(window));
        }
        sent
    }

    #[test]
    fn closing_asks_whether_to_drop_the_export() {
        let (mut window, end, is_cancelled) = exporting();
        assert!(close(&mut window), "the window closed");
        assert!(
            matches!(viewer(&window).dialogue(), Some(Dialogue::Leave(name)) if name == "exporting head.mp4")
        );
        assert!(!click(&mut window, "Stay").contains(&ViewportCommand::Close));
        assert!(viewer(&window).dialogue().is_none() && viewer(&window).exporting.is_some());

        assert!(close(&mut window));
        assert!(click(&mut window, "Leave and drop it").contains(&ViewportCommand::Close));
        assert!(!close(&mut window), "the window stays");
        drop(end);
        while viewer(&window).exporting.is_some() {
            window.step();
        }
        assert!(is_cancelled.load(Ordering::Relaxed));
    }

    #[test]
    fn an_export_that_ends_takes_the_question_away() {
        let (mut window, end, _) = exporting();
        assert!(close(&mut window));
        drop(end);
        while viewer(&window).exporting.is_some() {
            window.step();
        }
        window.step();
        assert!(viewer(&window).dialogue().is_none());
        assert!(!close(&mut window), "nothing is lost any more");
    }

    #[test]
    fn a_signal_asks_nothing() {
        let (mut window, _end, _) = exporting();
        window.state_mut().as_mut().unwrap().give_up();
        assert!(!close(&mut window), "the window stays");
        assert!(viewer(&window).dialogue().is_none());
    }
}
