//! Background thread that makes frames, so that the window never blocks.

use crate::frames::frame_producer::FrameProducer;
use crate::frames::presented::Presented;
use crate::frames::shown_point::ShownPoint;
use crate::frames::view_request::ViewRequest;
use fovolnet::SpeedSettings;
use fovolnet::gpu::Gpu;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Makes frames of the latest request on a background thread.
#[derive(Debug)]
pub struct Engine {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// State shared by the two threads.
#[derive(Debug, Default)]
struct Shared {
    desk: Mutex<Desk>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Desk {
    wanted: Option<ViewRequest>,
    /// Whether the last step for `wanted` found nothing more to do.
    is_done: bool,
    stops: bool,
    shown: Option<Presented>,
    point: Option<ShownPoint>,
    said: Vec<Said>,
}

/// Message for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Said {
    /// Information.
    Note(String),
    /// Error that prevents frames.
    Error(String),
}

impl Engine {
    /// Starts the thread. If the window lends its device as `screen`, frames are made there. `wake` is called
    /// whenever there is a result to take.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start(
        speed: SpeedSettings,
        screen: Option<Gpu>,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::<Shared>::default();
        let theirs = Arc::clone(&shared);
        let run = move || {
            // The window is drawn meanwhile, on the CPU if there is no graphics card, and needs the priority.
            fovolnet::lower_thread_priority();
            theirs.run(&|| FrameProducer::new(speed.clone(), screen.clone()), &wake);
        };
        let thread = std::thread::Builder::new().name("pictures".into()).spawn(run)?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Makes frames of `wanted` from now on.
    pub fn want(&self, wanted: ViewRequest) {
        let mut desk = self.shared.desk();
        if desk.wanted.as_ref() != Some(&wanted) {
            desk.wanted = Some(wanted);
            desk.is_done = false;
            self.shared.changed.notify_all();
        }
    }

    /// Takes the latest frame; `None` if it was taken before.
    pub fn take_shown(&self) -> Option<Presented> {
        self.shared.desk().shown.take()
    }

    /// The point that was asked for, once it is found.
    pub fn point(&self) -> Option<ShownPoint> {
        self.shared.desk().point
    }

    /// Takes the messages since the last call.
    pub fn take_said(&self) -> Vec<Said> {
        std::mem::take(&mut self.shared.desk().said)
    }

    /// Whether the current request is complete.
    pub fn is_done(&self) -> bool {
        let desk = self.shared.desk();
        desk.wanted.is_none() || (desk.is_done && desk.shown.is_none())
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.shared.desk().stops = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // Panics were caught in the thread.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, new_producer: &dyn Fn() -> FrameProducer, wake: &dyn Fn()) {
        let mut producer = new_producer();
        while let Some(wanted) = self.next() {
            let step = catch_unwind(AssertUnwindSafe(|| producer.step(&wanted)));
            let mut said: Vec<Said> = producer.take_notes().into_iter().map(Said::Note).collect();
            let shown = match step {
                Ok(Ok(shown)) => shown,
                Ok(Err(error)) => {
                    said.push(Said::Error(fovolnet::one_line(error.as_ref())));
                    None
                }
                Err(_) => {
                    producer = new_producer();
                    said.push(Said::Error(
                        "the renderer failed and begins anew; change the view to try again".into(),
                    ));
                    None
                }
            };
            if self.tell(&wanted, shown, producer.point(), said) {
                wake();
            }
        }
    }

    /// Waits for work and returns the current request; `None` if the thread should end.
    fn next(&self) -> Option<ViewRequest> {
        let idle = |desk: &mut Desk| !desk.stops && (desk.is_done || desk.wanted.is_none());
        let desk = self.changed.wait_while(self.desk(), idle).unwrap_or_else(PoisonError::into_inner);
        desk.wanted.clone().filter(|_| !desk.stops)
    }

    /// Publishes results. Returns whether there is anything new, including that the request is complete.
    fn tell(
        &self,
        wanted: &ViewRequest,
        shown: Option<Presented>,
        point: Option<ShownPoint>,
        said: Vec<Said>,
    ) -> bool {
        let mut desk = self.desk();
        desk.is_done = shown.is_none() && desk.wanted.as_ref() == Some(wanted);
        let is_news = desk.is_done || shown.is_some() || !said.is_empty() || desk.point != point;
        desk.point = point;
        desk.said.extend(said);
        if shown.is_some() {
            desk.shown = shown;
        }
        is_news
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::display_mode::DisplayMode;
    use crate::frames::presented::Progress;
    use fovolnet::core::CameraPath;
    use fovolnet::{RenderOverrides, VolumeSettings, open_volume};
    use std::time::{Duration, Instant};

    fn wanted() -> ViewRequest {
        let read = VolumeSettings { dims: Some([24; 3]), ..VolumeSettings::default() };
        ViewRequest {
            volume: open_volume("head", &read).unwrap(),
            settings: RenderOverrides { size: Some("48x32".parse().unwrap()), ..RenderOverrides::default() },
            freedom: fovolnet::Freedom::ALL,
            camera: CameraPath::Orbit.camera(0),
            gaze: [0.5; 2],
            probe: None,
            rate: None,
            converges: true,
            look: DisplayMode::Picture,
        }
    }

    fn wait(engine: &Engine) {
        let started = Instant::now();
        let mut shown = None;
        while !engine.is_done() || shown.is_none() {
            shown = engine.take_shown().or(shown);
            if !engine.shared.desk().said.is_empty() {
                return;
            }
            assert!(started.elapsed() < Duration::from_secs(60), "nothing comes");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(shown.unwrap().progress, Progress::Complete);
    }

    #[test]
    fn pictures_come_until_they_are_complete_and_after_changes_again() {
        let engine = Engine::start(SpeedSettings::default(), None, || ()).unwrap();
        assert!(engine.is_done());
        engine.want(wanted());
        wait(&engine);
        engine.want(ViewRequest { camera: CameraPath::Orbit.camera(9), ..wanted() });
        wait(&engine);
    }

    #[test]
    fn errors_are_said_once_and_do_not_end_it() {
        let engine = Engine::start(SpeedSettings::default(), None, || ()).unwrap();
        let mut bad = wanted();
        bad.settings.step = Some(-1.0);
        engine.want(bad);
        wait(&engine);
        let said = engine.take_said();
        assert!(matches!(&said[..], [Said::Error(text)] if text.contains("step")), "{said:?}");
        engine.want(wanted());
        wait(&engine);
    }
}
