//! What figures compare: two ways to fill frames without a network, and networks.

use super::{DataSet, Evaluation};
use anyhow::Result;
use fovolnet::core::Frame;
use fovolnet::net::Fill;
use fovolnet::{OpenVolume, Pipeline, Reconstruction, RenderSettings, RenderedFrame, SpeedSettings};

/// A way to fill frames.
#[derive(Clone, Copy)]
pub struct Method {
    /// What the report calls it; of networks also that of their weights.
    pub name: &'static str,
    how: Reconstruction,
}

/// All of them, networks last.
pub const METHODS: [Method; 5] = [
    Method { name: "pull-push", how: Reconstruction::Fill(Fill::PullPush) },
    Method { name: "linear", how: Reconstruction::Fill(Fill::Linear) },
    Method { name: "wnet-fast", how: Reconstruction::WNet },
    Method { name: "wnet-paper", how: Reconstruction::WNet },
    Method { name: "deepfovea-fvn", how: Reconstruction::DeepFovea },
];
/// How many there are.
pub const COUNT: usize = METHODS.len();
/// How many of them need no network.
const FILLS: usize = 2;
/// Our own network among them.
pub const OWN: usize = 2;

impl Method {
    /// `settings` with this way to fill frames.
    pub fn settings(self, settings: RenderSettings) -> RenderSettings {
        let weights = (!matches!(self.how, Reconstruction::Fill(_))).then(|| self.name.to_owned());
        RenderSettings { reconstruct: Some(self.how), weights, ..settings }
    }
}

/// What [`METHODS`] are called.
pub fn names() -> [&'static str; COUNT] {
    METHODS.map(|method| method.name)
}

/// Pipelines that sample the same pixels, one for each network.
pub struct Comparison {
    networks: Vec<Pipeline>,
}

/// A frame of every method.
pub struct Compared {
    /// What was sampled.
    pub sparse: Frame,
    /// In the order of [`METHODS`].
    pub frames: [Frame; COUNT],
}

impl Comparison {
    /// Begins a clip of `opened` with `settings`, whatever they say of reconstruction.
    pub fn new(opened: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let pipeline = |method: Method| Pipeline::new(opened, &method.settings(settings.clone()), speed);
        Ok(Self { networks: METHODS.into_iter().skip(FILLS).map(pipeline).collect::<Result<_, _>>()? })
    }

    /// Makes frame `number`.
    pub fn render(&mut self, number: u32) -> Result<Compared> {
        let mut rendered = self
            .networks
            .iter_mut()
            .map(|pipeline| pipeline.render(number))
            .collect::<Result<Vec<_>, _>>()?;
        let sparse = rendered[0].sparse.clone();
        let frames = METHODS.map(|method| match method.how {
            Reconstruction::Fill(fill) => fill.reconstruct(&sparse),
            _ => rendered.remove(0).frame,
        });
        Ok(Compared { sparse, frames })
    }

    /// Frame `number` with every pixel marched.
    pub fn reference(&mut self, number: u32) -> Result<Frame> {
        Ok(self.networks[0].reference(number)?)
    }

    /// Where the eye looks in frame `number`, 0…1.
    pub fn gaze(&self, number: u32) -> [f64; 2] {
        self.networks[0].fovea(number).gaze
    }
}

/// Settings of a fly-through of `data` with our own network, sampled with (P_b, σ).
pub fn with_network(evaluation: &Evaluation, data: &DataSet, sampling: [f64; 2]) -> RenderSettings {
    METHODS[OWN].settings(evaluation.settings(data, sampling))
}

/// A pipeline that has made one frame: memory is taken and filled for the first time then.
pub fn warmed(opened: &OpenVolume, settings: &RenderSettings, evaluation: &Evaluation) -> Result<Pipeline> {
    let mut pipeline = Pipeline::new(opened, settings, &evaluation.speed)?;
    pipeline.render(0)?;
    pipeline.reset();
    Ok(pipeline)
}

/// Frame `number` of a fly-through, and what it takes there: after a cut from the `last` one, the frame before it is made first,
/// for of what is seen from elsewhere nothing is there that it could go on from.
pub fn in_flight(pipeline: &mut Pipeline, number: u32, last: Option<u32>) -> Result<RenderedFrame> {
    if let Some(before) = number.checked_sub(1).filter(|before| last != Some(*before)) {
        pipeline.render(before)?;
    }
    Ok(pipeline.render(number)?)
}
