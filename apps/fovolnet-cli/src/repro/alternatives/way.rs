//! Ways to make frames cheaper.

use super::super::data_set::DataSet;
use super::super::evaluation::{Evaluation, SPARSE};
use super::super::methods::{self, METHODS, Method};
use anyhow::Result;
use fovolnet::core::{FrameSize, ShadowMode};
use fovolnet::{Guide, RenderSettings, Sampling, ShadowRays};
use std::num::NonZero;

/// One way to make frames cheaper.
pub struct Way {
    pub family: &'static str,
    pub name: String,
    pub settings: RenderSettings,
    pub finish: Finish,
    /// Whether light moves from frame to frame.
    pub moves: bool,
}

/// Last step of a way, after a frame was rendered.
#[derive(Clone, Copy)]
pub enum Finish {
    Nothing,
    /// It was rendered smaller.
    Enlarge,
    /// Its light ratios are filled by the joint bilateral filter instead.
    Bilateral,
    /// A planner makes it within this number of milliseconds.
    Planned(f64),
}

/// Sampling densities P_b, each with a width σ of the fovea.
const SAMPLINGS: [[f64; 2]; 5] = [[0.01, 0.02], [0.03, 0.02], [0.07, 0.06], [0.15, 0.06], [0.30, 0.06]];
/// Marching steps in voxels; the full frame has ½.
const STEPS: [f64; 5] = [0.75, 1.0, 2.0, 4.0, 8.0];
/// Factors by which frames are smaller along each axis before they are enlarged.
const SMALLER: [[u32; 2]; 5] = [[3, 4], [1, 2], [1, 3], [1, 4], [1, 6]];
/// Parts of the size along each axis that frames with cached shadows have, and their steps.
const CACHED: [[u32; 2]; 5] = [[1, 1], [3, 4], [1, 2], [1, 3], [1, 4]];
const CACHED_STEPS: [(&str, f64); 3] =
    [("cached shadows", 0.5), ("cached shadows, step 1", 1.0), ("cached shadows, step 2", 2.0)];
/// Numbers of shadow rays of a pixel.
const SHADOW_RAYS: [u32; 5] = [2, 4, 8, 16, 32];
/// Budgets of the planner, as parts of the time of an exact full frame.
const BUDGETS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];

/// Name of the planner's frames.
pub const PLANNER: &str = "planner";

/// All ways but the planner's, where light rests or `moves`. The paper's networks, whose cost and quality do not depend on
/// that, are left out where it moves.
pub fn ways(evaluation: &Evaluation, data: &DataSet, moves: bool) -> Result<Vec<Way>> {
    let mut ways = sparse(evaluation, data, moves);
    let full = full_settings(evaluation, data);
    let mut add = |family, name: String, settings| {
        ways.push(Way { family, name, settings, finish: Finish::Enlarge, moves });
    };
    for part in SMALLER {
        let size = part_of(evaluation.size, part)?;
        add("smaller frames", fraction(part), RenderSettings { size, ..full.clone() });
    }
    for step in STEPS {
        add("longer steps", format!("step {step}"), RenderSettings { step, ..full.clone() });
    }
    for (family, step) in CACHED_STEPS {
        for part in CACHED {
            let size = part_of(evaluation.size, part)?;
            let shadows = ShadowMode::Cached;
            add(family, fraction(part), RenderSettings { size, shadows, step, ..full.clone() });
        }
    }
    Ok(ways)
}

/// Ways that march some of the pixels.
fn sparse(evaluation: &Evaluation, data: &DataSet, moves: bool) -> Vec<Way> {
    let mut ways = Vec::new();
    for method in METHODS.into_iter().filter(|method| !moves || !method.is_large_network()) {
        for sampling in SAMPLINGS {
            let settings = method.settings(evaluation.settings(data, sampling));
            let (family, finish) = (method.name, Finish::of(method));
            ways.push(Way { family, name: named(sampling), settings, finish, moves });
        }
    }
    let ratio = |sampling| METHODS[methods::RATIO].settings(evaluation.settings(data, sampling));
    let mut add = |family, name, settings| {
        ways.push(Way { family, name, settings, finish: Finish::Nothing, moves });
    };
    for sampling in SAMPLINGS {
        let settings = RenderSettings { guide: Guide::Cached.into(), ..ratio(sampling) };
        add("ratio wnet-fast, cached guide", named(sampling), settings);
    }
    for count in SHADOW_RAYS {
        let few = NonZero::new(count).expect("numbers of rays are above 0");
        let settings = RenderSettings { shadow_rays: ShadowRays::Few(few), ..ratio(SPARSE) };
        add("ratio wnet-fast, few shadow rays", format!("{count} rays"), settings);
    }
    ways
}

/// The planner's ways; an exact full frame takes `full_ms`.
pub fn planned(
    evaluation: &Evaluation,
    data: &DataSet,
    moves: bool,
    full_ms: f64,
) -> impl Iterator<Item = Way> {
    let settings = METHODS[methods::RATIO].settings(evaluation.settings(data, SPARSE));
    BUDGETS.into_iter().map(move |part| {
        let budget = full_ms * part;
        let settings = settings.clone();
        Way {
            family: PLANNER,
            name: format!("{budget:.0} ms"),
            settings,
            finish: Finish::Planned(budget),
            moves,
        }
    })
}

/// Exact full frames.
pub fn exact(evaluation: &Evaluation, data: &DataSet, moves: bool) -> Way {
    let settings = full_settings(evaluation, data);
    Way { family: "full frames", name: "step 0.5".into(), settings, finish: Finish::Nothing, moves }
}

fn full_settings(evaluation: &Evaluation, data: &DataSet) -> RenderSettings {
    RenderSettings { sampling: Sampling::Full, ..evaluation.settings(data, SPARSE) }
}

fn part_of(size: FrameSize, [part, of]: [u32; 2]) -> Result<FrameSize> {
    let side = |side: u32| (side * part / of).max(1);
    Ok(FrameSize::new(side(size.width), side(size.height))?)
}

fn fraction([part, of]: [u32; 2]) -> String {
    format!("{part}/{of}")
}

fn named([pb, sigma]: [f64; 2]) -> String {
    format!("({pb}, {sigma})")
}

impl Finish {
    fn of(method: Method) -> Self {
        if method.is_bilateral() { Self::Bilateral } else { Self::Nothing }
    }
}
