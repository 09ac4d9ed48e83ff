//! Tables and light columns of one step along rays.

use super::light_columns::LightColumns;
use crate::scene::{BlendTable, Bricks, ExtinctionTable, GradientTable, TransferTable};
use fovol_core::{Integration, TransferFunction};

/// Tables and light columns of one step.
#[derive(Debug)]
pub struct Prepared {
    /// The step, in voxels of the smallest spacing.
    pub step: f64,
    pub table: TransferTable,
    /// The tables of fine integration; `None` where integration is plain.
    pub extinction: Option<ExtinctionTable>,
    /// Tables of all volumes, where there are several, voxels have colours, or opacity depends on the gradient.
    pub blending: Vec<BlendTable>,
    pub light_columns: Option<LightColumns>,
    /// Rays that were marched with shadow rays since the light changed, or will be now.
    pub rays: usize,
}

/// A volume with the tables of its transfer function.
#[derive(Clone, Copy)]
pub struct ColouredVolume<'a> {
    pub bricks: &'a Bricks,
    pub transfer: &'a TransferFunction,
    pub table: &'a TransferTable,
    /// Lengths of gradients and the factors of opacity for them, where it depends on them.
    pub gradient: Option<(&'a Bricks, &'a GradientTable)>,
}

/// Tables of other steps than the scene's, kept for a return to them.
#[derive(Debug, Default)]
pub struct OtherSteps(Vec<Prepared>);

/// Other steps that are kept: as many as a planner compares with the scene's.
const MOST_STEPS: usize = 3;

impl Prepared {
    /// The tables of `transfer` for `step`; light columns are prepared when they are needed.
    pub fn new(transfer: &TransferFunction, step: f64, integration: Integration) -> Self {
        let mut prepared = Self {
            step,
            table: TransferTable::new(transfer, step),
            extinction: None,
            blending: Vec::new(),
            light_columns: None,
            rays: 0,
        };
        prepared.integrate(transfer, integration);
        prepared
    }

    /// Goes over to `integration`; shadows do not depend on it.
    pub fn integrate(&mut self, transfer: &TransferFunction, integration: Integration) {
        self.extinction = match integration {
            Integration::Plain => None,
            Integration::Fine => Some(ExtinctionTable::new(transfer, &self.table, self.step)),
        };
    }

    /// Prepares to blend volumes with the transfer functions `of_volumes`, whose gradients have at most the length
    /// `greatest`.
    pub fn blend<'t>(&mut self, of_volumes: impl IntoIterator<Item = &'t TransferFunction>, greatest: f64) {
        let table = |transfer| BlendTable::with_gradient(transfer, self.step, greatest);
        self.blending = of_volumes.into_iter().map(table).collect();
    }

    /// The integration that the tables are made for.
    pub fn integration(&self) -> Integration {
        if self.extinction.is_some() { Integration::Fine } else { Integration::Plain }
    }

    /// Drops what depends on the light.
    pub fn forget_light(&mut self) {
        (self.light_columns, self.rays) = (None, 0);
    }
}

impl OtherSteps {
    /// Takes out what `step` needs, if it is here.
    pub fn take(&mut self, step: f64) -> Option<Prepared> {
        let at = self.0.iter().position(|other| other.step == step)?;
        Some(self.0.remove(at))
    }

    /// Keeps `prepared`; what was kept longest makes room.
    pub fn keep(&mut self, prepared: Prepared) {
        self.0.push(prepared);
        if self.0.len() > MOST_STEPS {
            self.0.remove(0);
        }
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Drops what depends on the light.
    pub fn forget_light(&mut self) {
        self.0.iter_mut().for_each(Prepared::forget_light);
    }
}
