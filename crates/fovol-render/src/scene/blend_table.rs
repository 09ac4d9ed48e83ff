use super::blend::extinction;
use super::gradient_table::GradientTable;
use super::transfer_table::TransferTable;
use fovol_core::TransferFunction;

/// Tables of the transfer function of one of several volumes.
#[derive(Debug, Clone)]
pub struct BlendTable {
    /// Opacity and colour.
    pub transfer: TransferTable,
    /// Extinction per reference length of every entry: the weight of its colour.
    pub extinction: Vec<f32>,
    /// Opacity by gradient, where it changes anything.
    pub gradient: Option<GradientTable>,
    /// Primary step in voxels.
    pub step: f32,
}

impl BlendTable {
    /// The tables of `transfer` for primary steps of `step` voxels, whatever the gradient is.
    pub fn new(transfer: &TransferFunction, step: f64) -> Self {
        let table = TransferTable::new(transfer, step);
        let extinction = table.opacities(transfer).map(|opacity| extinction(opacity) as f32).collect();
        Self { transfer: table, extinction, gradient: None, step: step as f32 }
    }

    /// [`Self::new`] with the factors for gradients up to the length `greatest`.
    pub fn with_gradient(transfer: &TransferFunction, step: f64, greatest: f64) -> Self {
        let gradient = transfer.gradient_opacity().map(|curve| GradientTable::new(curve, greatest));
        Self { gradient, ..Self::new(transfer, step) }
    }
}
