//! Compared methods: two classical fills, and networks.

use super::data_set::DataSet;
use super::evaluation::Evaluation;
use anyhow::Result;
use fovolnet::core::{Frame, SparseFrame};
use fovolnet::net::Fill;
use fovolnet::{
    OpenVolume, Pipeline, Reconstruction, RenderSettings, RenderedFrame, SpeedSettings, WeightsChoice,
};

/// Method of filling frames.
#[derive(Clone, Copy)]
pub struct Method {
    /// Name in the report; for networks also the name of their weights.
    pub name: &'static str,
    how: Reconstruction,
}

/// All methods, networks last.
pub const METHODS: [Method; 5] = [
    Method { name: "pull-push", how: Reconstruction::Fill(Fill::PullPush) },
    Method { name: "linear", how: Reconstruction::Fill(Fill::Linear) },
    Method { name: "wnet-fast", how: Reconstruction::WNet },
    Method { name: "wnet-paper", how: Reconstruction::WNet },
    Method { name: "deepfovea-fvn", how: Reconstruction::DeepFovea },
];
/// Number of methods.
pub const COUNT: usize = METHODS.len();
/// Number of classical fills, which come first.
const FILLS: usize = 2;
/// Index of our own network.
pub const OWN: usize = 2;

impl Method {
    /// Sets this method in `settings`.
    pub fn settings(self, settings: RenderSettings) -> RenderSettings {
        let weights = match self.how {
            Reconstruction::Fill(_) => WeightsChoice::Usual,
            _ => WeightsChoice::Named(self.name.to_owned()),
        };
        RenderSettings { reconstruction: self.how, weights, ..settings }
    }
}

/// Names of [`METHODS`].
pub fn names() -> [&'static str; COUNT] {
    METHODS.map(|method| method.name)
}

/// Pipelines that sample the same pixels, one for each network.
pub struct Comparison {
    networks: Vec<Pipeline>,
}

/// One frame, filled by every method.
pub struct Compared {
    /// Picture of the samples.
    pub sparse: Frame,
    /// Full frames in the order of [`METHODS`].
    pub frames: [Frame; COUNT],
}

impl Comparison {
    /// Begins a clip of `opened` with `settings`; their reconstruction is ignored.
    pub fn new(opened: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let pipeline = |method: Method| Pipeline::new(opened, &method.settings(settings.clone()), speed);
        Ok(Self { networks: METHODS.into_iter().skip(FILLS).map(pipeline).collect::<Result<_, _>>()? })
    }

    /// Renders frame `number` with every method.
    pub fn render(&mut self, number: u32) -> Result<Compared> {
        let mut rendered = self
            .networks
            .iter_mut()
            .map(|pipeline| pipeline.render(number))
            .collect::<Result<Vec<_>, _>>()?;
        let sparse = rendered[0].samples_picture();
        let samples = SparseFrame::from(&sparse);
        let frames = METHODS.map(|method| match method.how {
            Reconstruction::Fill(fill) => fill.reconstruct(&samples),
            _ => rendered.remove(0).frame,
        });
        Ok(Compared { sparse, frames })
    }

    /// Renders frame `number` with every pixel marched.
    pub fn reference(&mut self, number: u32) -> Result<Frame> {
        Ok(self.networks[0].reference(number)?)
    }

    /// Gaze in frame `number`, as fractions of the frame.
    pub fn gaze(&self, number: u32) -> [f64; 2] {
        self.networks[0].fovea(number).gaze
    }
}

/// Settings of a fly-through of `data` with our own network and the sampling (P_b, σ).
pub fn with_network(evaluation: &Evaluation, data: &DataSet, sampling: [f64; 2]) -> RenderSettings {
    METHODS[OWN].settings(evaluation.settings(data, sampling))
}

/// Pipeline that has rendered one frame, so that its memory has been allocated and touched.
pub fn warmed(opened: &OpenVolume, settings: &RenderSettings, evaluation: &Evaluation) -> Result<Pipeline> {
    let mut pipeline = Pipeline::new(opened, settings, &evaluation.speed)?;
    pipeline.render(0)?;
    pipeline.reset();
    Ok(pipeline)
}

/// Renders frame `number` of a fly-through. If it does not follow the `last` rendered frame, its predecessor is
/// rendered first, so that the network has the right history.
pub fn in_flight(pipeline: &mut Pipeline, number: u32, last: Option<u32>) -> Result<RenderedFrame> {
    if let Some(before) = number.checked_sub(1).filter(|before| last != Some(*before)) {
        pipeline.render(before)?;
    }
    Ok(pipeline.render(number)?)
}
