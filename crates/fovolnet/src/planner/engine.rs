use super::frame_maker::FrameMaker;
use super::freedom::Freedom;
use super::limit::Limit;
use crate::{OpenVolume, Pipeline, RenderSettings, RenderedFrame, Result, SpeedSettings, Timings};
use fovol_core::{Frame, SampleMask};
use std::sync::Arc;

/// Everything that the frames of an [`Engine`] depend on.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// The volume, and what is shown with it.
    pub volume: Arc<OpenVolume>,
    /// How it is shown.
    pub settings: RenderSettings,
    /// Device and threads.
    pub speed: SpeedSettings,
    /// Limit and freedom of a planner, if there is one.
    pub planning: Option<(Limit, Freedom)>,
    /// Whether frames have the motion of their pixels, even if no network uses it.
    pub finds_motion: bool,
}

/// Makes whatever frame is wanted next, planned or not. Its pipeline is made when it is first needed, and keeps what it can when
/// something else is wanted.
#[derive(Debug, Default)]
pub struct Engine(Option<Made>);

#[derive(Debug)]
struct Made {
    maker: FrameMaker,
    wanted: Wanted,
}

impl Made {
    fn new(wanted: Wanted) -> Result<Self> {
        let Wanted { volume, settings, speed, planning, finds_motion } = &wanted;
        let mut maker = FrameMaker::new(volume, settings, *planning, speed)?;
        if *finds_motion {
            maker.pipeline().find_motion();
        }
        Ok(Self { maker, wanted })
    }

    /// Goes on with `wanted`. Returns it if nothing can be kept.
    fn change(&mut self, wanted: Wanted) -> Result<Option<Wanted>> {
        let old = &self.wanted;
        let is_another = old.speed != wanted.speed
            || old.planning != wanted.planning
            || (old.finds_motion && !wanted.finds_motion);
        let shows_another = !Arc::ptr_eq(&old.volume, &wanted.volume);
        if is_another {
            return Ok(Some(wanted));
        }
        match &mut self.maker {
            FrameMaker::Planned(_) if shows_another => return Ok(Some(wanted)),
            FrameMaker::Planned(planned) => planned.ask(&wanted.settings),
            FrameMaker::Fixed(pipeline) => {
                // The old settings may not fit the new volume.
                if shows_another && pipeline.show(&wanted.volume).is_err() {
                    return Ok(Some(wanted));
                }
                self.wanted.volume = Arc::clone(&wanted.volume);
                pipeline.change(&wanted.settings)?;
            }
        }
        if wanted.finds_motion {
            self.maker.pipeline().find_motion();
        }
        self.wanted = wanted;
        Ok(None)
    }
}

impl Engine {
    /// Renders frame `i`.
    ///
    /// # Errors
    /// Errors of [`Pipeline::new`] and of [`Pipeline::render`].
    pub fn render(&mut self, wanted: Wanted, i: u32) -> Result<RenderedFrame> {
        Ok(self.ready(wanted)?.render(i)?.0)
    }

    /// Renders frame `i` with every pixel marched and exact shadows.
    ///
    /// # Errors
    /// Errors of [`Self::render`].
    pub fn reference(&mut self, wanted: Wanted, i: u32) -> Result<RenderedFrame> {
        Ok(every_pixel(i, self.ready(wanted)?.reference(i)?))
    }

    /// Pipeline of the frames that are `wanted`.
    ///
    /// # Errors
    /// Errors of [`Pipeline::new`].
    pub fn pipeline(&mut self, wanted: Wanted) -> Result<&mut Pipeline> {
        Ok(self.ready(wanted)?.pipeline())
    }

    /// Forgets earlier frames, as after a cut.
    pub fn reset(&mut self) {
        if let Some(made) = &mut self.0 {
            made.maker.pipeline().reset();
        }
    }

    /// Forgets everything, since work on it was abandoned.
    pub fn abandon(&mut self) {
        self.0 = None;
    }

    fn ready(&mut self, wanted: Wanted) -> Result<&mut FrameMaker> {
        let anew = match &mut self.0 {
            None => Some(wanted),
            Some(made) => match made.change(wanted) {
                Ok(anew) => anew,
                Err(error) => {
                    // A lost device leaves nothing to go on with.
                    if error.is_of_gpu() {
                        self.0 = None;
                    }
                    return Err(error);
                }
            },
        };
        if let Some(wanted) = anew {
            // The old one goes first: both may not fit into memory.
            self.0 = None;
            self.0 = Some(Made::new(wanted)?);
        }
        Ok(&mut self.0.as_mut().expect("it was just made").maker)
    }
}

/// Rendered frame `i` of a reference.
fn every_pixel(i: u32, frame: Frame) -> RenderedFrame {
    let size = frame.size();
    RenderedFrame {
        index: i,
        sparse: None,
        mask: SampleMask::full(size),
        frame,
        motion: None,
        samples: size.pixels(),
        guide_samples: 0,
        guide: None,
        lost: None,
        timings: Timings::default(),
    }
}
