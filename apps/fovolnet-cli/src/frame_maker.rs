//! Frames of a picture: as the settings say, or planned.

use anyhow::{Result, ensure};
use fovolnet::core::{Camera, Frame};
use fovolnet::{
    FramePlan, Freedom, Guide, Limit, Machine, OpenVolume, Pipeline, PlannedFrames, PlannedPipeline,
    RenderSettings, RenderedFrame, SpeedSettings, TimeClip,
};

/// Pipeline of frames, planned or not.
pub enum FrameMaker {
    /// Frames as the settings say, and the volumes of a clip over time.
    Fixed(Box<Pipeline>, Option<Box<TimeClip>>),
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
    /// Prepares `opened` for frames of `settings`; planned, if there is `planning`; of several time points, if there is a
    /// `clip`.
    pub fn new(
        opened: &OpenVolume,
        settings: &RenderSettings,
        planning: Option<&Planning<'_>>,
        clip: Option<TimeClip>,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        let Some(&Planning { freedom, limit, saved }) = planning else {
            let pipeline = Pipeline::new(opened, settings, speed)?;
            return Ok(Self::Fixed(Box::new(pipeline), clip.map(Box::new)));
        };
        ensure!(
            clip.is_none(),
            "a clip over time has no planner; leave out --budget and --quality, or choose one --time"
        );
        let mut planned = PlannedPipeline::new(opened, (settings, freedom), limit, speed)?;
        planned.follow(saved)?;
        Ok(Self::Planned(Box::new(planned)))
    }

    /// Pipeline that makes the frames.
    pub fn pipeline(&mut self) -> &mut Pipeline {
        match self {
            Self::Fixed(pipeline, _) => pipeline,
            Self::Planned(planned) => planned.pipeline(),
        }
    }

    /// Renders frame `i`; also returns how it was planned.
    pub fn render(&mut self, i: u32) -> Result<(RenderedFrame, Option<FramePlan>)> {
        Ok(match self {
            Self::Fixed(pipeline, clip) => {
                if let Some(volume) = clip.as_mut().map(|clip| clip.volume_of(i)).transpose()?.flatten() {
                    pipeline.show(&volume)?;
                }
                (pipeline.render(i)?, None)
            }
            Self::Planned(planned) => {
                let (rendered, plan) = planned.render(i)?;
                (rendered, Some(plan))
            }
        })
    }

    /// Reference of frame `i`.
    pub fn reference(&mut self, i: u32) -> Result<Frame> {
        Ok(match self {
            Self::Fixed(pipeline, _) => pipeline.reference(i)?,
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
            Self::Fixed(pipeline, _) => pipeline.guide(),
            Self::Planned(_) => settings.guide_kind(),
        }
    }

    /// Choices of the frames so far.
    pub fn plans(&self) -> &[PlannedFrames] {
        match self {
            Self::Fixed(..) => &[],
            Self::Planned(planned) => planned.plans(),
        }
    }

    /// The machine as it is used.
    pub fn machine(&mut self) -> Machine {
        self.pipeline().machine()
    }
}
