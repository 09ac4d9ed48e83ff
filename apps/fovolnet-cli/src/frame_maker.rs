//! Frames of a picture: as the settings say, or planned.

use anyhow::Result;
use fovolnet::core::{Camera, Frame};
use fovolnet::{
    FramePlan, Freedom, Guide, Limit, Machine, OpenVolume, Pipeline, PlannedFrames, PlannedPipeline,
    RenderSettings, RenderedFrame, SpeedSettings,
};

/// Pipeline of frames, planned or not.
pub enum FrameMaker {
    /// Frames as the settings say.
    Fixed(Box<Pipeline>),
    /// Frames as a planner says.
    Planned(Box<PlannedPipeline>),
}

/// Freedom and limit of a planner, and its earlier choices.
pub struct Planning<'a> {
    pub freedom: Freedom,
    pub limit: Limit,
    pub saved: &'a [PlannedFrames],
}

impl FrameMaker {
    /// Prepares `opened` for frames of `settings`; planned, if there is `planning`.
    pub fn new(
        opened: &OpenVolume,
        settings: &RenderSettings,
        planning: Option<&Planning<'_>>,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        let Some(&Planning { freedom, limit, saved }) = planning else {
            return Ok(Self::Fixed(Box::new(Pipeline::new(opened, settings, speed)?)));
        };
        let mut planned = PlannedPipeline::new(opened, (settings, freedom), limit, speed)?;
        planned.follow(saved)?;
        Ok(Self::Planned(Box::new(planned)))
    }

    /// Pipeline that makes the frames.
    pub fn pipeline(&mut self) -> &mut Pipeline {
        match self {
            Self::Fixed(pipeline) => pipeline,
            Self::Planned(planned) => planned.pipeline(),
        }
    }

    /// Renders frame `i`; also returns how it was planned.
    pub fn render(&mut self, i: u32) -> Result<(RenderedFrame, Option<FramePlan>)> {
        Ok(match self {
            Self::Fixed(pipeline) => (pipeline.render(i)?, None),
            Self::Planned(planned) => {
                let (rendered, plan) = planned.render(i)?;
                (rendered, Some(plan))
            }
        })
    }

    /// Reference of frame `i`.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        Ok(match self {
            Self::Fixed(pipeline) => pipeline.reference(i)?,
            Self::Planned(planned) => planned.reference(i)?,
        })
    }

    /// Camera of frame `i`, in the space of the volume's box.
    pub fn camera(&mut self, i: u32) -> Camera {
        let pipeline = self.pipeline();
        pipeline.world().camera(&pipeline.camera(i))
    }

    /// Guide of the frames; of planned ones, that of the settings.
    pub fn guide(&self, settings: &RenderSettings) -> Guide {
        match self {
            Self::Fixed(pipeline) => pipeline.guide(),
            Self::Planned(_) => settings.guide_kind(),
        }
    }

    /// Choices of the frames so far.
    pub fn plans(&self) -> &[PlannedFrames] {
        match self {
            Self::Fixed(_) => &[],
            Self::Planned(planned) => planned.plans(),
        }
    }

    /// The machine as it is used.
    pub fn machine(&mut self) -> Machine {
        self.pipeline().machine()
    }
}
