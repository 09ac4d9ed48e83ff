use super::frame_plan::{FramePlan, PlannedFrames};
use super::freedom::Freedom;
use super::limit::Limit;
use super::planned_pipeline::PlannedPipeline;
use crate::{OpenVolume, Pipeline, RenderSettings, RenderedFrame, Result, SpeedSettings};
use fovol_core::Frame;

/// Makes frames: as the settings say, or planned.
#[derive(Debug)]
pub enum FrameMaker {
    /// Frames as the settings say.
    Fixed(Box<Pipeline>),
    /// Frames as a planner says.
    Planned(Box<PlannedPipeline>),
}

impl FrameMaker {
    /// Prepares `volume` for frames of `settings`; planned, if there are a limit and a freedom.
    ///
    /// # Errors
    /// Errors of [`Pipeline::new`] and [`PlannedPipeline::new`].
    pub fn new(
        volume: &OpenVolume,
        settings: &RenderSettings,
        planning: Option<(Limit, Freedom)>,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        Ok(match planning {
            None => Self::Fixed(Box::new(Pipeline::new(volume, settings, speed)?)),
            Some((limit, freedom)) => {
                let planned = PlannedPipeline::new(volume, (settings, freedom), limit, speed)?;
                Self::Planned(Box::new(planned))
            }
        })
    }

    /// Pipeline that makes the frames.
    pub fn pipeline(&mut self) -> &mut Pipeline {
        match self {
            Self::Fixed(pipeline) => pipeline,
            Self::Planned(planned) => planned.pipeline(),
        }
    }

    /// Renders frame `i`; also returns how it was planned.
    ///
    /// # Errors
    /// Errors of the network, a lost device.
    pub fn render(&mut self, i: u32) -> Result<(RenderedFrame, Option<FramePlan>)> {
        match self {
            Self::Fixed(pipeline) => Ok((pipeline.render(i)?, None)),
            Self::Planned(planned) => {
                let (rendered, plan) = planned.render(i)?;
                Ok((rendered, Some(plan)))
            }
        }
    }

    /// Reference of frame `i`: every pixel marched, with exact shadows.
    ///
    /// # Errors
    /// Too little memory, a lost device.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        match self {
            Self::Fixed(pipeline) => pipeline.reference(i),
            Self::Planned(planned) => planned.reference(i),
        }
    }

    /// Choices of the frames so far.
    pub fn plans(&self) -> &[PlannedFrames] {
        match self {
            Self::Fixed(_) => &[],
            Self::Planned(planned) => planned.plans(),
        }
    }
}
