use super::candidate::Candidate;
use super::frame_plan::{FramePlan, PlannedFrames};
use super::freedom::Freedom;
use super::limit::Limit;
use super::planning::{MadeFrame, Planner};
use super::probes::Shown;
use super::way::Way;
use crate::{
    Error, OpenDevice, OpenVolume, Pipeline, RenderSettings, RenderedFrame, Result, Sampling, SpeedSettings,
    Viewpoint,
};
use fovol_core::{Frame, ShadowMode};
use fovol_io::image;
use std::time::Instant;

/// Pipeline whose frames a [`Planner`] plans.
#[derive(Debug)]
pub struct PlannedPipeline {
    pipeline: Pipeline,
    planner: Planner,
    asked: RenderSettings,
    freedom: Freedom,
    limit: Limit,
    /// Choices that were made before.
    saved: Vec<PlannedFrames>,
    /// Choices of the frames so far.
    made: Vec<PlannedFrames>,
    /// Milliseconds before the first frame that are not counted yet.
    waiting_ms: f64,
    /// Another pipeline on the same device, for references.
    exact: Option<Box<Pipeline>>,
    speed: SpeedSettings,
    device: OpenDevice,
}

impl PlannedPipeline {
    /// Prepares `volume` for frames of the settings `asked`, of which the planner may change what `freedom` says.
    ///
    /// # Errors
    /// Errors of [`Pipeline::new`]; a transparent background.
    pub fn new(
        volume: &OpenVolume,
        (asked, freedom): (&RenderSettings, Freedom),
        limit: Limit,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        if asked.transparent {
            return Err(Error::Setting(
                "frames with a transparent background are not planned; leave out --transparent, or --quality and --budget"
                    .into(),
            ));
        }
        let device = speed.device().open()?;
        let pipeline = Pipeline::on(device.clone(), volume, &opening(asked, freedom), speed)?;
        Ok(Self {
            pipeline,
            planner: Planner::new(),
            asked: asked.clone(),
            freedom,
            limit,
            saved: Vec::new(),
            made: Vec::new(),
            waiting_ms: 0.0,
            exact: None,
            speed: speed.clone(),
            device,
        })
    }

    /// Makes frames as `saved` says, where it says something.
    ///
    /// # Errors
    /// Sizes, steps or densities that frames cannot have.
    pub fn follow(&mut self, saved: &[PlannedFrames]) -> Result<()> {
        if let Some(bad) = saved.iter().find(|part| !part.is_valid()) {
            return Err(Error::Setting(format!(
                "the plan of frame {} cannot be followed: scale and density are above 0 and at most 1, a step is 1 to 100",
                bad.first_frame
            )));
        }
        self.saved = saved.to_vec();
        Ok(())
    }

    /// Takes other settings for the next frames, such as another light. What the planner may change stays.
    pub fn ask(&mut self, asked: &RenderSettings) {
        self.asked = asked.clone();
    }

    /// Pipeline that makes the frames. Its settings are those of the last one.
    pub fn pipeline(&mut self) -> &mut Pipeline {
        &mut self.pipeline
    }

    /// Choices of all frames so far.
    pub fn plans(&self) -> &[PlannedFrames] {
        &self.made
    }

    /// Renders frame `i` as planned, at the asked size. Networks treat it as the successor of the last frame.
    ///
    /// # Errors
    /// Errors of the network, a lost device.
    pub fn render(&mut self, i: u32) -> Result<(RenderedFrame, FramePlan)> {
        self.choose(i)?;
        let Self { pipeline, planner, asked, .. } = self;
        let started = Instant::now();
        let settings = planner.settings(asked);
        let scene_changed = pipeline.change_scene(&settings)?;
        let change_ms = ms(started);
        let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
        let mut rendered = pipeline.render_from(i, &viewpoint)?;
        let probing = Instant::now();
        let shown = Shown { frame: &rendered.frame, on_screen: false };
        let may_be_cached = self.freedom.ways(asked).contains(&Way::CachedLight);
        planner.measure((pipeline, &viewpoint, asked), i, Some(shown), may_be_cached)?;
        let probe_ms = ms(probing);
        let enlarging = Instant::now();
        if rendered.frame.size() != asked.size {
            rendered.frame = image::resized(&rendered.frame, asked.size);
        }
        let enlarging_ms = ms(enlarging);
        let timings = &mut rendered.timings;
        let frame_ms = timings.total + enlarging_ms;
        planner.learn(asked, MadeFrame { ms: frame_ms, change_ms, probe_ms, scene_changed });
        timings.march += change_ms;
        timings.reconstruct += enlarging_ms;
        timings.plan = probe_ms + std::mem::take(&mut self.waiting_ms);
        timings.total += change_ms + enlarging_ms + timings.plan;
        let plan = planner.plan(asked).expect("a frame was chosen");
        if let Some(candidate) = planner.candidate() {
            PlannedFrames::push(&mut self.made, i, candidate);
        }
        Ok((rendered, plan))
    }

    /// Chooses how frame `i` is made.
    fn choose(&mut self, i: u32) -> Result<()> {
        let Self { pipeline, planner, asked, freedom, limit, saved, .. } = self;
        if let Some(candidate) = saved.iter().find_map(|part| part.candidate(i)) {
            planner.follow(candidate);
            return Ok(());
        }
        if planner.candidate().is_none() {
            let started = Instant::now();
            let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
            let may_be_cached = freedom.ways(asked).contains(&Way::CachedLight);
            planner.measure((pipeline, &viewpoint, asked), i, None, may_be_cached)?;
            self.waiting_ms += ms(started);
        }
        planner.choose(asked, *freedom, *limit);
        Ok(())
    }

    /// Reference of frame `i`: every pixel marched at the asked size and step, with exact shadows.
    ///
    /// # Errors
    /// Too little memory, a lost device.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        // The frames' own pipeline would lose what a network remembers.
        let exact = match self.exact.take() {
            Some(exact) => exact,
            None => {
                let volume = self.pipeline.volume().clone();
                let settings = RenderSettings { sampling: Sampling::Full, ..self.asked.clone() };
                Box::new(Pipeline::on(self.device.clone(), &volume, &settings, &self.speed)?)
            }
        };
        let exact = self.exact.insert(exact);
        let shadows = if self.asked.shadows == ShadowMode::Off { ShadowMode::Off } else { ShadowMode::On };
        exact.change(&RenderSettings { sampling: Sampling::Full, shadows, ..self.asked.clone() })?;
        exact.reference(i)
    }
}

/// Settings that a pipeline is opened with: without a network, if it may do without.
fn opening(asked: &RenderSettings, freedom: Freedom) -> RenderSettings {
    let way = freedom.ways(asked)[0];
    Candidate { way, scale: 1.0, step: 1.0, density: 1.0 }.settings(asked)
}

fn ms(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
