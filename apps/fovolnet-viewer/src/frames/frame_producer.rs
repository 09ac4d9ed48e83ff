//! Frame producer: makes the pictures on the screen, step by step.

use crate::frames::display_mode::{DisplayMode, Parts, rgba};
use crate::frames::presented::{Pixels, Presented, Progress};
use crate::frames::shown_point::ShownPoint;
use crate::frames::still::{Quality, Still};
use crate::frames::turnaround::Turnaround;
use crate::frames::view_request::ViewRequest;
use anyhow::Result;
use eframe::wgpu;
use fovolnet::core::{Fovea, FrameSize};
use fovolnet::gpu::Gpu;
use fovolnet::{
    DoneFrame, FramePlan, Freedom, Limit, Machine, MadeFrame, OpenDevice, OpenVolume, Pipeline, Planner,
    RenderSettings, RenderedFrame, Shown, SpeedSettings, Timings, Viewpoint, Way,
};
use std::sync::Arc;
use std::time::Instant;

/// Most milliseconds of a frame on the window's own device, since the window should respond within 50.
const WINDOW_MS: f64 = 40.0;

/// Frame producer with its device, pipeline and planner.
#[derive(Debug, Default)]
pub struct FrameProducer {
    speed: SpeedSettings,
    /// Device of the window, until it is lost.
    screen: Option<Gpu>,
    device: Option<OpenDevice>,
    pipeline: Option<Pipeline>,
    /// Timings of the last frame that stayed on the device.
    displayed: Timings,
    last: Option<Last>,
    planner: Planner,
    turnaround: Turnaround,
    /// Milliseconds that the last change of settings took.
    change_ms: f64,
    /// Whether it changed light, transfer function or clip.
    scene_changed: bool,
    next_frame: u32,
    /// Answer to the last question for a point, until the view changes.
    point: Option<ShownPoint>,
    notes: Vec<String>,
}

/// State after the last step.
#[derive(Debug)]
struct Last {
    wanted: ViewRequest,
    settings: RenderSettings,
    density: f64,
    timings: Timings,
    machine: Machine,
    view: View,
    plan: Option<FramePlan>,
}

#[derive(Debug)]
enum View {
    Moving(Box<RenderedFrame>, Fovea),
    /// Frame in a texture on the window's device, and the statistics of the last frame finished there.
    Displayed(wgpu::Texture, Option<DoneFrame>),
    Still(Box<Still>, Option<Quality>),
}

impl FrameProducer {
    /// Frame producer with the settings `speed`. If the window lends its device as `screen`, frames are made there.
    pub fn new(speed: SpeedSettings, screen: Option<Gpu>) -> Self {
        Self { speed, screen, ..Self::default() }
    }

    /// Takes the notes since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// The point that was asked for last, if the view has not changed since.
    pub fn point(&self) -> Option<ShownPoint> {
        self.point
    }

    /// Makes the next picture of `wanted`; `None` if the last picture is final.
    ///
    /// # Errors
    /// Invalid render settings, or a lost device.
    pub fn step(&mut self, wanted: &ViewRequest) -> Result<Option<Presented>> {
        let shown = self.next(wanted);
        if let Err(error) = &shown
            && error.downcast_ref::<fovolnet::Error>().is_some_and(fovolnet::Error::is_of_gpu)
        {
            // A lost device cannot recover; the next step opens another.
            (self.device, self.pipeline, self.screen) = (None, None, None);
        }
        shown
    }

    fn next(&mut self, wanted: &ViewRequest) -> Result<Option<Presented>> {
        let (last, is_new) = match self.last.take() {
            Some(last) if last.wanted.shows_as(wanted) => {
                let next = self.go_on(last, wanted)?;
                self.find_point(wanted, &next.0.settings)?;
                next
            }
            _ => {
                self.point = None;
                (self.move_to(wanted)?, true)
            }
        };
        let shown = is_new.then(|| self.shown(&last));
        self.last = Some(last);
        Ok(shown)
    }

    /// Continues from `last` for an unchanged view. Also returns whether there is a new picture.
    fn go_on(&mut self, last: Last, wanted: &ViewRequest) -> Result<(Last, bool)> {
        let looks_other = last.wanted.look != wanted.look;
        let (view, is_new) = match last.view {
            View::Moving(..) | View::Displayed(..) if wanted.converges => {
                return Ok((self.stand_at(wanted)?, true));
            }
            View::Moving(..) | View::Displayed(..) if last.wanted.gaze != wanted.gaze => {
                return Ok((self.move_to(wanted)?, true));
            }
            // Other display modes need data that has stayed on the device.
            View::Displayed(..) if looks_other => return Ok((self.move_to(wanted)?, true)),
            View::Still(mut still, _) if !still.is_done() && wanted.converges => {
                still.advance(self.open(&wanted.volume, &last.settings)?)?;
                let quality = still.quality();
                (View::Still(still, quality), true)
            }
            view => (view, looks_other),
        };
        Ok((Last { view, wanted: wanted.clone(), ..last }, is_new))
    }

    /// Finds the point that `wanted` asks for, unless it is known. Views in motion have no time for it.
    fn find_point(&mut self, wanted: &ViewRequest, settings: &RenderSettings) -> Result<()> {
        let Some(at) = wanted.probe.filter(|&at| self.point.is_none_or(|known| known.at != at)) else {
            return Ok(());
        };
        let pipeline = self.open(&wanted.volume, settings)?;
        self.point = Some(ShownPoint::find(pipeline, &wanted.camera, at)?);
        Ok(())
    }

    /// Makes a frame in motion as the planner says.
    fn move_to(&mut self, wanted: &ViewRequest) -> Result<Last> {
        let asked = &wanted.settings.resolve()?;
        let is_planned = wanted.settings.quality != Some(fovolnet::Quality::Fixed);
        let Some(rate) = wanted.rate.filter(|_| is_planned) else {
            return self.move_as(wanted, asked.clone());
        };
        let most = if self.screen.is_some() { WINDOW_MS } else { f64::INFINITY };
        let left_ms = self.turnaround.begin(1e3 / rate);
        let ms = wanted.settings.budget.unwrap_or(left_ms).min(most);
        // Another volume has other costs and errors.
        self.open(&wanted.volume, asked)?;
        // Other displays show what sparse frames consist of.
        let freedom = match wanted.look {
            DisplayMode::Picture => wanted.freedom,
            _ => Freedom { size: true, ..Freedom::NOTHING },
        };
        let may_be_cached = freedom.ways(asked).contains(&Way::CachedLight);
        if self.planner.candidate().is_none() && self.screen.is_none() {
            let (index, viewpoint) = self.next_viewpoint(wanted, asked)?;
            let pipeline = self.pipeline.as_mut().expect("it is open");
            self.planner.measure((pipeline, &viewpoint, asked), index, None, may_be_cached)?;
        }
        self.planner.choose(asked, freedom, Limit::Time(ms));
        let last = self.move_as(wanted, self.planner.settings(asked))?;
        let (made_ms, probe_ms) = match &last.view {
            View::Moving(frame, fovea) => {
                let viewpoint = Viewpoint { camera: wanted.camera, fovea: *fovea };
                let probing = Instant::now();
                let shown = Some(Shown { frame: &frame.frame, on_screen: true });
                let pipeline = self.pipeline.as_mut().expect("it has made a frame");
                self.planner.measure((pipeline, &viewpoint, asked), frame.index, shown, may_be_cached)?;
                (frame.timings.total, probing.elapsed().as_secs_f64() * 1e3)
            }
            // What stays on the device is not compared.
            View::Displayed(_, Some(done)) => (done.timings.total, 0.0),
            View::Displayed(_, None) | View::Still(..) => return Ok(last),
        };
        let change_ms = self.change_ms;
        let scene_changed = self.scene_changed;
        self.planner.learn(asked, MadeFrame { ms: made_ms, change_ms, probe_ms, scene_changed });
        self.turnaround.end();
        Ok(Last { plan: self.planner.plan(asked), ..last })
    }

    /// Makes a frame in motion with `settings`. It stays on the device if that draws the window.
    fn move_as(&mut self, wanted: &ViewRequest, settings: RenderSettings) -> Result<Last> {
        match self.display(wanted, &settings)? {
            Some(last) => Ok(last),
            None => self.render(wanted, settings),
        }
    }

    /// Makes the first picture of a still view.
    fn stand_at(&mut self, wanted: &ViewRequest) -> Result<Last> {
        let last = self.render(wanted, wanted.settings.resolve()?)?;
        let view = match last.view {
            View::Moving(frame, fovea) => {
                View::Still(Box::new(Still::new(&last.settings, wanted.camera, fovea, *frame)), None)
            }
            other => other,
        };
        Ok(Last { view, ..last })
    }

    /// Makes the next frame with `settings`.
    fn render(&mut self, wanted: &ViewRequest, settings: RenderSettings) -> Result<Last> {
        let (index, viewpoint) = self.next_viewpoint(wanted, &settings)?;
        let pipeline = self.changed(&wanted.volume, &settings)?;
        let frame = pipeline.render_from(index, &viewpoint)?;
        let machine = pipeline.machine();
        self.next_frame = index.wrapping_add(1);
        Ok(Last {
            wanted: wanted.clone(),
            settings,
            density: frame.mask.density(),
            timings: frame.timings,
            machine,
            view: View::Moving(Box::new(frame), viewpoint.fovea),
            plan: None,
        })
    }

    /// Makes the next frame on the window's device; `None` if there is no shared device or the frame cannot stay
    /// there.
    fn display(&mut self, wanted: &ViewRequest, settings: &RenderSettings) -> Result<Option<Last>> {
        if self.screen.is_none() || wanted.look != DisplayMode::Picture {
            return Ok(None);
        }
        let (index, viewpoint) = self.next_viewpoint(wanted, settings)?;
        let pipeline = self.changed(&wanted.volume, settings)?;
        let Some(frame) = pipeline.display_from(index, &viewpoint)? else { return Ok(None) };
        let (machine, size) = (pipeline.machine(), pipeline.size());
        self.next_frame = index.wrapping_add(1);
        if let Some(done) = frame.done {
            self.displayed = done.timings;
        }
        let share = |done: DoneFrame| done.samples as f64 / size.pixels() as f64;
        Ok(Some(Last {
            wanted: wanted.clone(),
            settings: settings.clone(),
            density: frame.done.map_or_else(|| viewpoint.fovea.expected_density(size), share),
            timings: self.displayed,
            machine,
            view: View::Displayed(frame.picture, frame.done),
            plan: None,
        }))
    }

    /// Number and viewpoint of the next frame.
    fn next_viewpoint(&self, wanted: &ViewRequest, settings: &RenderSettings) -> Result<(u32, Viewpoint)> {
        let fovea = Fovea { gaze: wanted.gaze, ..settings.fovea(self.next_frame)? };
        Ok((self.next_frame, Viewpoint { camera: wanted.camera, fovea }))
    }

    /// The pipeline of `volume` with `settings`. What the change takes is kept.
    fn changed(&mut self, volume: &OpenVolume, settings: &RenderSettings) -> Result<&mut Pipeline> {
        let started = Instant::now();
        self.scene_changed = self.open(volume, settings)?.change_scene(settings)?;
        self.change_ms = started.elapsed().as_secs_f64() * 1e3;
        self.open(volume, settings)
    }

    /// Returns the pipeline of `volume`; opens it with `settings` if necessary.
    fn open(&mut self, volume: &OpenVolume, settings: &RenderSettings) -> Result<&mut Pipeline> {
        let is_open = |pipeline: &Pipeline| Arc::ptr_eq(&pipeline.volume().volume, &volume.volume);
        let pipeline = match self.pipeline.take().filter(is_open) {
            Some(open) => open,
            None => {
                self.planner = Planner::new();
                let device = match self.device.take() {
                    Some(open) => open,
                    None => match &self.screen {
                        Some(gpu) => OpenDevice::Gpu(gpu.clone()),
                        None => self.speed.device().open()?,
                    },
                };
                let device = self.device.insert(device).clone();
                let pipeline = Pipeline::on(device, volume, settings, &self.speed)?;
                self.notes.extend(pipeline.notes().iter().cloned());
                pipeline
            }
        };
        Ok(self.pipeline.insert(pipeline))
    }

    fn shown(&self, last: &Last) -> Presented {
        let look = |parts: &Parts<'_>| Pixels::Host(rgba(last.wanted.look, parts));
        let (size, pixels, progress, quality) = match &last.view {
            View::Displayed(picture, _) => {
                let size = FrameSize { width: picture.width(), height: picture.height() };
                (size, Pixels::Device(picture.clone()), Progress::Moving, None)
            }
            View::Moving(frame, fovea) => {
                let picture = &frame.frame;
                let parts = Parts { picture, measured: &frame.mask, reconstructed: picture, fovea };
                (picture.size(), look(&parts), Progress::Moving, None)
            }
            View::Still(still, quality) => {
                let parts = Parts {
                    picture: still.picture(),
                    measured: still.measured(),
                    reconstructed: still.reconstructed(),
                    fovea: still.fovea(),
                };
                let progress = match still.is_complete() {
                    true => Progress::Complete,
                    false => Progress::Converging(still.share()),
                };
                (parts.picture.size(), look(&parts), progress, *quality)
            }
        };
        Presented {
            size,
            pixels,
            camera: last.wanted.camera,
            progress,
            settings: last.settings.clone(),
            density: last.density,
            timings: last.timings,
            quality,
            plan: last.plan.clone(),
            machine: last.machine.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::CameraPath;
    use fovolnet::{Device, Reconstruction, RenderOverrides, VolumeSettings, open_volume};

    fn producer() -> FrameProducer {
        FrameProducer::new(SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() }, None)
    }

    fn wanted() -> ViewRequest {
        let read = VolumeSettings { dims: Some([32; 3]), ..VolumeSettings::default() };
        let settings = RenderOverrides {
            size: Some("64x48".parse().unwrap()),
            reconstruct: Some(Reconstruction::WNet),
            ..RenderOverrides::default()
        };
        ViewRequest {
            volume: open_volume("head", &read).unwrap(),
            settings,
            freedom: Freedom::ALL,
            camera: CameraPath::Orbit.camera(0),
            gaze: [0.5; 2],
            probe: None,
            rate: None,
            converges: true,
            look: DisplayMode::Picture,
        }
    }

    /// All pictures until nothing new comes.
    fn all(producer: &mut FrameProducer, wanted: &ViewRequest) -> Vec<Presented> {
        std::iter::from_fn(|| producer.step(wanted).unwrap()).take(10_000).collect()
    }

    #[test]
    fn a_still_view_becomes_the_full_frame() {
        let wanted = wanted();
        let shown = all(&mut producer(), &wanted);
        assert_eq!(shown[0].progress, Progress::Moving);
        let last = shown.last().unwrap();
        assert_eq!(last.progress, Progress::Complete);
        assert!(last.quality.unwrap().psnr > 15.0);
        let settings = RenderSettings { camera: wanted.camera.into(), ..wanted.settings.resolve().unwrap() };
        let mut pipeline = Pipeline::new(&wanted.volume, &settings, &SpeedSettings::default()).unwrap();
        let full = pipeline.reference(0).unwrap();
        assert_eq!(last.pixels, Pixels::Host(full.to_rgba8()));
        assert_ne!(shown[0].pixels, last.pixels);
    }

    #[test]
    fn a_move_begins_anew_and_a_look_does_not() {
        let mut producer = producer();
        let first = wanted();
        let complete = all(&mut producer, &first).pop().unwrap();
        let looked = ViewRequest { look: DisplayMode::Samples, ..first.clone() };
        let shown = all(&mut producer, &looked);
        assert_eq!(shown.len(), 1);
        assert_eq!(shown[0].pixels, complete.pixels, "all of it is measured");
        let gazed = ViewRequest { gaze: [0.1, 0.2], look: DisplayMode::Samples, ..first.clone() };
        assert!(all(&mut producer, &gazed).is_empty());
        let moved = ViewRequest { camera: CameraPath::Orbit.camera(20), ..first };
        let shown = producer.step(&moved).unwrap().unwrap();
        assert_eq!(shown.progress, Progress::Moving);
        assert_ne!(shown.pixels, complete.pixels);
    }

    #[test]
    fn a_budget_makes_smaller_frames_and_still_views_whole_ones() {
        let mut producer = producer();
        let mut wanted = ViewRequest { rate: Some(1e5), ..wanted() };
        for i in 0..5 {
            wanted.camera = CameraPath::Orbit.camera(i);
            producer.step(&wanted).unwrap();
        }
        wanted.camera = CameraPath::Orbit.camera(9);
        let moving = producer.step(&wanted).unwrap().unwrap();
        // The chosen level depends on the measured times.
        assert!(moving.size.width < 32 && moving.size.height < 24, "{}", moving.size);
        assert_eq!(moving.plan.unwrap().size, moving.size);
        let last = all(&mut producer, &wanted).pop().unwrap();
        assert_eq!((last.size.to_string().as_str(), last.progress), ("64x48", Progress::Complete));
    }

    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn frames_in_motion_stay_on_the_device_that_draws_the_window() {
        let gpu = Gpu::open(&fovolnet::gpu::AdapterRequest::Any.or_environment()).unwrap();
        let mut producer = FrameProducer::new(SpeedSettings::default(), Some(gpu.clone()));
        let still = ViewRequest { converges: false, ..wanted() };
        let mut timings = Vec::new();
        for i in 0..4 {
            let moved = ViewRequest { camera: CameraPath::Orbit.camera(i), ..still.clone() };
            let shown = producer.step(&moved).unwrap().unwrap();
            let Pixels::Device(picture) = &shown.pixels else { panic!("frame {i} went through the host") };
            let pixels = fovolnet::gpu::read_picture(&gpu, picture).unwrap();
            assert_eq!((shown.size, shown.progress), (still.settings.size.unwrap(), Progress::Moving));
            assert!(pixels.iter().any(|pixel| pixel[..3] != pixels[0][..3]), "frame {i} shows nothing");
            timings.push(shown.timings.total);
        }
        assert!(timings[0] == 0.0 && timings[3] > 0.0, "{timings:?}");
        let last = ViewRequest { camera: CameraPath::Orbit.camera(3), ..still.clone() };
        assert!(producer.step(&last).unwrap().is_none(), "nothing changed");
        // Other display modes and still views need pixels on the host.
        let samples = ViewRequest { look: DisplayMode::Samples, ..last.clone() };
        assert!(matches!(producer.step(&samples).unwrap().unwrap().pixels, Pixels::Host(_)));
        let complete = all(&mut producer, &ViewRequest { converges: true, ..last }).pop().unwrap();
        assert_eq!(complete.progress, Progress::Complete);
        let budget = ViewRequest { rate: Some(1e5), camera: CameraPath::Orbit.camera(9), ..still };
        for i in 0..8 {
            let moved = ViewRequest { camera: CameraPath::Orbit.camera(10 + i), ..budget.clone() };
            let shown = producer.step(&moved).unwrap().unwrap();
            assert!(matches!(shown.pixels, Pixels::Device(_)));
            assert!(i < 7 || shown.size.width < 32, "{:?}", shown.plan);
        }
    }

    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn another_volume_and_size_take_over_while_frames_are_under_way() {
        let gpu = Gpu::open(&fovolnet::gpu::AdapterRequest::Any.or_environment()).unwrap();
        let mut producer = FrameProducer::new(SpeedSettings::default(), Some(gpu.clone()));
        let read = VolumeSettings { dims: Some([24; 3]), ..VolumeSettings::default() };
        let volumes = ["head", "vortices"].map(|name| open_volume(name, &read).unwrap());
        let mut first: [Option<Vec<[u8; 4]>>; 4] = Default::default();
        for i in 0..24u32 {
            // Each kind lasts for three frames; two of them are in flight when the next kind comes.
            let kind = (i / 3 % 4) as usize;
            let mut wanted = ViewRequest { converges: false, volume: volumes[kind % 2].clone(), ..wanted() };
            wanted.settings.size = Some(["64x48", "40x56"][kind / 2].parse().unwrap());
            wanted.settings.pb = Some(0.8);
            wanted.camera = CameraPath::Orbit.camera(i % 3);
            let shown = producer.step(&wanted).unwrap().unwrap();
            assert_eq!(shown.size, wanted.settings.size.unwrap());
            let Pixels::Device(picture) = &shown.pixels else { panic!("frame {i} went through the host") };
            if i % 3 == 0 {
                let pixels = fovolnet::gpu::read_picture(&gpu, picture).unwrap();
                let before = first[kind].get_or_insert_with(|| pixels.clone());
                let pairs = before.iter().flatten().zip(pixels.iter().flatten());
                let differences: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
                // The samples differ, but the volume is equal.
                let mean = differences as f32 / pixels.len() as f32;
                assert!(mean < 20.0, "frame {i} remembers what was shown before it: {mean}");
            }
        }
    }

    #[test]
    fn what_cannot_be_rendered_is_said_and_forgotten() {
        let mut producer = producer();
        let good = wanted();
        let mut bad = good.clone();
        bad.settings.ambient = Some(7.0);
        assert!(producer.step(&bad).unwrap_err().to_string().contains("ambient"));
        assert!(producer.step(&good).unwrap().is_some());
    }
}
