//! Form of the configuration in files: one level, with a field for each option.

use super::options::{
    Accumulation, COARSE, DIRECT, Direct, Feedback, Fill, Filtering, Fresh, Kernels, POINTS, Prediction,
    TAPS, WNetOptions, check_corrections,
};
use crate::plan::layers::{Normalisation, Taps};
use serde::{Deserialize, Serialize};

/// Options in the order in which files have them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct Flat {
    encoder: Vec<usize>,
    decoder: Vec<usize>,
    feedback: Feedback,
    kernels: bool,
    normalisation: Normalisation,
    fold: bool,
    mask: bool,
    prefill: bool,
    bypass: bool,
    #[serde(default)]
    history: Option<Taps>,
    reproject: bool,
    #[serde(default)]
    filled: Option<Taps>,
    #[serde(default)]
    flat: Option<Taps>,
    #[serde(default)]
    accumulate: f32,
    #[serde(default)]
    points: bool,
    #[serde(default)]
    fresh: Option<Taps>,
    #[serde(default)]
    coarse: bool,
    #[serde(default, rename = "doubt")]
    history_confidence: bool,
    #[serde(default)]
    corrections: u32,
    #[serde(default)]
    residual: bool,
    #[serde(default)]
    addition: bool,
    #[serde(default = "yes")]
    recurrent: bool,
    #[serde(default = "yes")]
    direct: bool,
}

fn yes() -> bool {
    true
}

impl From<&WNetOptions> for Flat {
    /// Options that do not apply get their usual values.
    fn from(options: &WNetOptions) -> Self {
        let (kernels, accumulation) = (options.kernels(), options.accumulation());
        let (fresh, direct) = (options.fresh(), options.direct());
        Self {
            encoder: options.encoder.clone(),
            decoder: options.decoder.clone(),
            feedback: options.feedback,
            kernels: kernels.is_some(),
            normalisation: kernels.map_or(Normalisation::Squared, |kernels| kernels.normalisation),
            fold: options.fold,
            mask: options.mask,
            prefill: options.fill.is_some(),
            bypass: options.bypass,
            history: kernels.and_then(|kernels| kernels.history),
            reproject: options.reproject,
            filled: kernels.and_then(|kernels| kernels.filled),
            flat: kernels.and_then(|kernels| match kernels.filtering {
                Filtering::Once { direct } => Some(direct.map_or(Taps::Centre, |(_, taps)| taps)),
                Filtering::EveryLevel { .. } => None,
            }),
            accumulate: accumulation.map_or(0.0, |accumulation| accumulation.weight),
            points: accumulation.is_some_and(|accumulation| accumulation.points),
            fresh: fresh.map(|fresh| fresh.taps),
            coarse: fresh.is_some_and(|fresh| fresh.coarse),
            history_confidence: fresh.is_some_and(|fresh| fresh.history_confidence),
            corrections: options.fill.map_or(0, |fill| fill.corrections),
            residual: direct.is_some_and(|direct| direct.residual),
            addition: kernels.is_some_and(|kernels| kernels.addition),
            recurrent: options.recurrent,
            direct: direct.is_some(),
        }
    }
}

impl Flat {
    /// Sorts the options by what they belong to.
    ///
    /// # Errors
    /// Options of parts that the network does not have.
    pub(super) fn options(self) -> Result<WNetOptions, String> {
        Ok(WNetOptions {
            recurrent: self.recurrent,
            fold: self.fold,
            mask: self.mask,
            bypass: self.bypass,
            reproject: self.reproject,
            feedback: self.feedback,
            prediction: self.prediction()?,
            fill: self.fill()?,
            encoder: self.encoder,
            decoder: self.decoder,
        })
    }

    fn prediction(&self) -> Result<Prediction, String> {
        let direct = self.direct.then_some(Direct { residual: self.residual });
        if direct.is_none() && self.residual {
            return Err(DIRECT.into());
        }
        if self.kernels {
            return Ok(Prediction::Kernels(Kernels {
                normalisation: self.normalisation,
                filtering: match self.flat {
                    Some(taps) => Filtering::Once { direct: direct.map(|direct| (direct, taps)) },
                    None => Filtering::EveryLevel { direct },
                },
                history: self.history,
                filled: self.filled,
                addition: self.addition,
            }));
        }
        if [self.history, self.filled, self.flat, self.fresh].iter().any(Option::is_some) {
            return Err(TAPS.into());
        }
        if self.addition {
            return Err("there is nothing of K to add to; set `kernels`, or leave out `addition`".into());
        }
        direct.map(Prediction::Direct).ok_or_else(|| DIRECT.into())
    }

    fn fill(&self) -> Result<Option<Fill>, String> {
        check_corrections(self.corrections)?;
        let fill = Fill { corrections: self.corrections, accumulation: self.accumulation()? };
        if fill.accumulation.is_some() && !self.prefill {
            return Err(
                "samples are accumulated to be filled; set `prefill`, or leave out `accumulate`".into()
            );
        }
        Ok(self.prefill.then_some(fill))
    }

    fn accumulation(&self) -> Result<Option<Accumulation>, String> {
        let fresh = self.fresh()?;
        if self.accumulate != 0.0 {
            return Ok(Some(Accumulation { weight: self.accumulate, points: self.points, fresh }));
        }
        if self.points {
            return Err(POINTS.into());
        }
        match fresh {
            None => Ok(None),
            Some(_) => Err("every filled picture is fresh; set `accumulate`, or leave out `fresh`".into()),
        }
    }

    fn fresh(&self) -> Result<Option<Fresh>, String> {
        match self.fresh {
            Some(taps) => {
                let (coarse, history_confidence) = (self.coarse, self.history_confidence);
                Ok(Some(Fresh { taps, coarse, history_confidence }))
            }
            None if self.history_confidence => {
                Err("a fresh picture is needed to doubt the others; set `fresh`, or leave out `doubt`".into())
            }
            None if self.coarse => Err(COARSE.into()),
            None => Ok(None),
        }
    }
}
