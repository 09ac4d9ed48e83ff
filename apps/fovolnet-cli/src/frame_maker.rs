//! Frames of a picture: as the settings say, or planned; of one volume, or of a clip over time.

use anyhow::{Result, ensure};
use fovolnet::core::{Camera, Frame};
use fovolnet::{
    FramePlan, Freedom, Guide, Limit, Machine, OpenVolume, Pipeline, PlannedFrames, RenderSettings,
    RenderedFrame, SpeedSettings, TimeClip,
};

/// Makes the frames of a command.
pub struct FrameMaker {
    maker: fovolnet::FrameMaker,
    /// Volumes of a clip over time.
    clip: Option<TimeClip>,
}

/// Freedom and limit of a planner, and its earlier choices.
pub struct Planning<'a> {
    pub freedom: Freedom,
    pub limit: Limit,
    pub saved: &'a [PlannedFrames],
}

impl FrameMaker {
    /// Prepares `opened` for frames of `settings`; planned, if there is `planning`; of several time points, if there is a
    /// `clip`.
    pub fn new(
        opened: &OpenVolume,
        settings: &RenderSettings,
        planning: Option<&Planning<'_>>,
        clip: Option<TimeClip>,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        ensure!(
            planning.is_none() || clip.is_none(),
            "a clip over time has no planner; leave out --budget and --quality, or choose one --time"
        );
        let bounds = planning.map(|planning| (planning.limit, planning.freedom));
        let mut maker = fovolnet::FrameMaker::new(opened, settings, bounds, speed)?;
        if let (fovolnet::FrameMaker::Planned(planned), Some(planning)) = (&mut maker, planning) {
            planned.follow(planning.saved)?;
        }
        Ok(Self { maker, clip })
    }

    /// Pipeline that makes the frames.
    pub fn pipeline(&mut self) -> &mut Pipeline {
        self.maker.pipeline()
    }

    /// Renders frame `i`; also returns how it was planned.
    pub fn render(&mut self, i: u32) -> Result<(RenderedFrame, Option<FramePlan>)> {
        if let Some(volume) = self.clip.as_mut().map(|clip| clip.volume_of(i)).transpose()?.flatten() {
            self.pipeline().show(&volume)?;
        }
        Ok(self.maker.render(i)?)
    }

    /// Reference of frame `i`.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        Ok(self.maker.reference(i)?)
    }

    /// Camera of frame `i`, in the space of the volume's box.
    pub fn camera(&mut self, i: u32) -> Camera {
        let pipeline = self.pipeline();
        pipeline.world().camera(&pipeline.camera(i))
    }

    /// Guide of the frames; of planned ones, that of the settings.
    pub fn guide(&self, settings: &RenderSettings) -> Guide {
        match &self.maker {
            fovolnet::FrameMaker::Fixed(pipeline) => pipeline.guide(),
            fovolnet::FrameMaker::Planned(_) => settings.guide_kind(),
        }
    }

    /// Choices of the frames so far.
    pub fn plans(&self) -> &[PlannedFrames] {
        self.maker.plans()
    }

    /// The machine as it is used.
    pub fn machine(&mut self) -> Machine {
        self.pipeline().machine()
    }
}
