use super::layers::{LayerNumbers, Layers};
use crate::scene::{ExtinctionTable, TransferTable};
use fovol_core::{Integration, MOST_VOLUMES, TransferFunction};

/// Tables of transfer functions for one step, as shaders read them. Those of several volumes lie one after the other.
pub struct Tables {
    /// Opacity and colour of every entry.
    pub appearance: Vec<[u32; 2]>,
    /// α of one shadow step of every entry.
    pub shadow_alpha: Vec<f32>,
    /// With several volumes the bits of the extinction of every entry, and of factors by gradient; else the tables of shaders/fine.wgsl, if it is fine.
    pub extinction: Vec<u32>,
    /// Extinction of one step that an integer 1 in tables of fine integration stands for.
    pub extinction_unit: f32,
    /// log2 of the entries in a bin of colours.
    pub bin_bits: u32,
    /// Entries of the first volume between the display values 0 and 1.
    pub scale: f32,
    /// Entry of its largest value.
    pub last: usize,
    /// Where the tables of each volume begin, and how its values become entries.
    pub layers: [LayerNumbers; MOST_VOLUMES],
}

impl Tables {
    /// The tables of `transfer`, and of further volumes, for primary steps of `step` voxels.
    pub fn new(
        transfer: &TransferFunction,
        (step, integration): (f64, Integration),
        layers: &Layers,
    ) -> Self {
        let table = TransferTable::new(transfer, step);
        let mut tables = Self {
            scale: table.scale(),
            last: table.last(),
            // A buffer that nobody reads.
            extinction: vec![0],
            extinction_unit: 0.0,
            bin_bits: 0,
            layers: layers.numbers(&[]),
            appearance: Vec::new(),
            shadow_alpha: Vec::new(),
        };
        if layers.are_blended() {
            let all = layers.tables(transfer, step);
            tables.layers = layers.numbers(&all);
            let factors = all.iter().flat_map(|of| of.gradient.iter().flat_map(|gradient| &gradient.factors));
            let extinctions = all.iter().flat_map(|of| &of.extinction).chain(factors);
            tables.extinction = extinctions.map(|number| number.to_bits()).collect();
            tables.appearance = all.iter().flat_map(|of| of.transfer.appearance.iter().copied()).collect();
            tables.shadow_alpha =
                all.iter().flat_map(|of| of.transfer.shadow_alpha.iter().copied()).collect();
            return tables;
        }
        if integration == Integration::Fine {
            let fine = ExtinctionTable::new(transfer, &table, step);
            tables.extinction = fine.entries.iter().flatten().chain(&fine.colours).copied().collect();
            (tables.extinction_unit, tables.bin_bits) = (fine.unit, fine.bin_bits);
        }
        (tables.appearance, tables.shadow_alpha) = (table.appearance, table.shadow_alpha);
        tables
    }
}
