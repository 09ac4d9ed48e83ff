//! Compared methods: classical fills and networks, of colours and of light ratios.

use super::data_set::DataSet;
use super::evaluation::Evaluation;
use anyhow::Result;
use fovolnet::core::{Frame, SparseFrame};
use fovolnet::guide::{compose, joint_bilateral, light_ratios};
use fovolnet::net::Fill;
use fovolnet::{
    Density, Guide, OpenVolume, Pipeline, Reconstruction, RenderSettings, RenderedFrame, SpeedSettings,
    WeightsChoice,
};

/// Method of filling frames.
#[derive(Clone, Copy)]
pub struct Method {
    /// Name in the report.
    pub name: &'static str,
    what: Filled,
    how: How,
}

/// Kind of numbers that a method fills.
#[derive(Clone, Copy, PartialEq)]
enum Filled {
    /// Colours, as in the paper: no guide, and densities that do not follow the picture.
    Colours,
    /// Light ratios: a guide at a quarter of the pixels, and as many samples where the ratio changes.
    LightRatios,
}

#[derive(Clone, Copy)]
enum How {
    Fill(Fill),
    /// Network with the weights of this name.
    Network(&'static str),
    JointBilateral,
}

use Filled::{Colours, LightRatios};

/// All methods. The same guide and samples of `ratio wnet-fast` are filled by `ratio linear` and `ratio bilateral`.
pub const METHODS: [Method; 9] = [
    Method { name: "pull-push", what: Colours, how: How::Fill(Fill::PullPush) },
    Method { name: "linear", what: Colours, how: How::Fill(Fill::Linear) },
    Method { name: "wnet-fast", what: Colours, how: How::Network("wnet-fast") },
    Method { name: "wnet-paper", what: Colours, how: How::Network("wnet-paper") },
    Method { name: "deepfovea-fvn", what: Colours, how: How::Network("deepfovea-fvn") },
    Method { name: "ratio wnet-fast", what: LightRatios, how: How::Network("wnet-fast") },
    Method { name: "ratio wnet-paper", what: LightRatios, how: How::Network("wnet-paper-ratio") },
    Method { name: "ratio linear", what: LightRatios, how: How::Fill(Fill::Linear) },
    Method { name: "ratio bilateral", what: LightRatios, how: How::JointBilateral },
];
/// Number of methods.
pub const COUNT: usize = METHODS.len();
/// Our own network with the paper's method: colours.
pub const OWN: usize = 2;
/// Our own network with the light ratio.
pub const RATIO: usize = 5;

/// Meaning of the names of [`METHODS`], for the text of a section.
pub const LEGEND: &str = "Methods that begin with `ratio` march a quarter of the pixels without shadow rays and fill the light \
    ratio; the others fill colours, as the paper does. `ratio linear` and `ratio bilateral` have no network.";

impl Method {
    /// Sets this method in `settings`. Frames of `ratio bilateral` get the guide and the samples, filled by pull-push.
    pub fn settings(self, settings: RenderSettings) -> RenderSettings {
        let (reconstruction, weights) = match self.how {
            How::Fill(fill) => (Reconstruction::Fill(fill), WeightsChoice::Usual),
            How::JointBilateral => (Reconstruction::Fill(Fill::PullPush), WeightsChoice::Usual),
            How::Network(name) => (network_kind(name), WeightsChoice::Named(name.to_owned())),
        };
        let (guide, density) = match self.what {
            Colours => (Guide::None, Density::Fixed),
            LightRatios => (Guide::Quarter, Density::Adaptive),
        };
        RenderSettings { reconstruction, weights, guide: guide.into(), density: density.into(), ..settings }
    }

    /// Whether it is a network.
    pub fn is_network(self) -> bool {
        matches!(self.how, How::Network(_))
    }

    /// Whether it is a network of the paper's size.
    pub fn is_large_network(self) -> bool {
        matches!(self.how, How::Network(name) if name != "wnet-fast")
    }

    /// Whether it needs [`bilateral`] after the frame was rendered.
    pub fn is_bilateral(self) -> bool {
        matches!(self.how, How::JointBilateral)
    }
}

/// Method of the network `name`.
pub fn network_kind(name: &str) -> Reconstruction {
    if name.starts_with("deepfovea") { Reconstruction::DeepFovea } else { Reconstruction::WNet }
}

/// Names of [`METHODS`].
pub fn names() -> [&'static str; COUNT] {
    METHODS.map(|method| method.name)
}

/// The frame of `rendered`, whose guide was kept, with light ratios filled from its samples by `fill`.
fn refilled(
    rendered: &RenderedFrame,
    background: [f32; 3],
    fill: impl FnOnce(&SparseFrame, &fovolnet::guide::UpsampledGuide) -> Frame,
) -> Frame {
    let (Some(sparse), Some(kept)) = (&rendered.sparse, &rendered.guide) else {
        return rendered.frame.clone();
    };
    let ratios = light_ratios(sparse, &kept.guide, background);
    let mut frame = fill(&ratios, &kept.guide);
    compose(&mut frame, &kept.guide, sparse, background);
    frame
}

/// The frame of `rendered`, whose guide was kept, filled by the joint bilateral filter.
pub fn bilateral(rendered: &RenderedFrame, background: [f32; 3]) -> Frame {
    refilled(rendered, background, joint_bilateral)
}

/// Pipelines of one clip, one for each network.
pub struct Comparison {
    networks: Vec<Pipeline>,
    background: [f32; 3],
}

/// One frame, filled by every method.
pub struct Compared {
    /// Picture of the samples of the methods that fill colours.
    pub sparse: Frame,
    /// Full frames in the order of [`METHODS`].
    pub frames: [Frame; COUNT],
}

impl Comparison {
    /// Begins a clip of `opened` with `settings`; their reconstruction is ignored.
    pub fn new(opened: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let pipeline = |method: Method| -> Result<Pipeline> {
            let mut pipeline = Pipeline::new(opened, &method.settings(settings.clone()), speed)?;
            pipeline.keep_guide();
            Ok(pipeline)
        };
        let networks = METHODS.into_iter().filter(|method| method.is_network()).map(pipeline);
        Ok(Self {
            networks: networks.collect::<Result<_>>()?,
            background: settings.background.map(|value| value as f32),
        })
    }

    /// Renders frame `number` with every method.
    pub fn render(&mut self, number: u32) -> Result<Compared> {
        let mut rendered = Vec::with_capacity(COUNT);
        let mut networks = self.networks.iter_mut();
        for method in METHODS {
            let pipeline = if method.is_network() { networks.next() } else { None };
            rendered.push(pipeline.map(|pipeline| pipeline.render(number)).transpose()?);
        }
        let of = |method: usize| rendered[method].as_ref().expect("our own networks are rendered");
        let (colours, ratios) = (of(OWN), of(RATIO));
        let sparse = colours.samples_picture();
        let samples = SparseFrame::from(&sparse);
        let frames = std::array::from_fn(|at| match (&rendered[at], METHODS[at].what, METHODS[at].how) {
            (Some(rendered), ..) => rendered.frame.clone(),
            (None, Colours, How::Fill(fill)) => fill.reconstruct(&samples),
            (None, LightRatios, How::Fill(fill)) => {
                refilled(ratios, self.background, |ratios, _| fill.reconstruct(ratios))
            }
            _ => bilateral(ratios, self.background),
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

/// Settings of a fly-through of `data` with our own network, filling colours as the paper does, and the sampling (P_b, σ).
pub fn with_network(evaluation: &Evaluation, data: &DataSet, sampling: [f64; 2]) -> RenderSettings {
    METHODS[OWN].settings(evaluation.settings(data, sampling))
}

/// Settings of a fly-through of `data` with our own network, filling light ratios, and the sampling (P_b, σ).
pub fn with_light_ratio(evaluation: &Evaluation, data: &DataSet, sampling: [f64; 2]) -> RenderSettings {
    METHODS[RATIO].settings(evaluation.settings(data, sampling))
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
