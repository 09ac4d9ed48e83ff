use crate::memory::{self, SMALLER_VOLUME};
use crate::{Dtype, Result, Volume, VoxelColours, stop};
use rayon::prelude::*;
use std::sync::Arc;

/// Weights of red, green and blue in luminance (BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

impl Volume {
    /// Whether voxels can be shown as colours: they have three or four components.
    pub fn may_be_colours(&self) -> bool {
        matches!(self.components(), 3 | 4)
    }

    /// Red, green and blue of voxels whose components are colours, and the volume that decides their opacity: the fourth
    /// component, or else luminance.
    ///
    /// Bytes are shown over 0…255, other components over the range of all three together, unless a range was chosen. The opacity of a
    /// fourth component is shown likewise.
    ///
    /// # Errors
    /// Other than three or four components, too little memory.
    pub fn colours(&self) -> Result<(VoxelColours, Self)> {
        let component = |index: usize| self.separate(index);
        let colours = [component(0)?, component(1)?, component(2)?];
        let [lo, hi] = if self.dtype() == Dtype::U8 || self.range_is_chosen() {
            self.range()
        } else {
            let ranges = colours.each_ref().map(|channel| channel.statistics().shown);
            ranges.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], [low, high]| {
                [f64::min(lo, *low), f64::max(hi, *high)]
            })
        };
        let colours = {
            let [r, g, b] = colours.map(|channel| channel.with_range([lo, hi]));
            [Arc::new(r?), Arc::new(g?), Arc::new(b?)]
        };
        let opacity = match self.components() {
            4 => component(3)?,
            _ => self.luminance(&colours)?,
        };
        Ok((colours, opacity))
    }

    /// Component `index` as a volume of its own.
    fn separate(&self, index: usize) -> Result<Self> {
        self.clone().with_component(index)
    }

    /// Luminance of `colours`, the colours of these voxels, as bytes.
    fn luminance(&self, colours: &VoxelColours) -> Result<Self> {
        let [nx, ny, _] = self.grid().dims();
        let mut values = memory::zeroed::<u8>(self.grid().voxels(), "the luminance", SMALLER_VOLUME)?;
        values.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
            stop::point();
            for (x, out) in line.iter_mut().enumerate() {
                let voxel = [x, row % ny, row / ny];
                let of =
                    |(channel, weight): (&Arc<Self>, f64)| weight * channel.normalised(channel.value(voxel));
                let luminance: f64 = colours.iter().zip(LUMINANCE).map(of).sum();
                *out = (255.0 * luminance).round() as u8;
            }
        });
        let made = Self::from_values(*self.grid(), values)?.with_notes_of(self);
        let made = self.placement().map_or(made.clone(), |placement| made.with_placement(*placement));
        Ok(made.with_format(self.format()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Endian, Grid};

    fn coloured(components: usize, bytes: Vec<u8>) -> Volume {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        Volume::with_layout(grid, Dtype::U8, Endian::Little, components, Arc::new(bytes), 0).unwrap()
    }

    #[test]
    fn luminance_or_the_fourth_component_decides_opacity() {
        let (colours, opacity) = coloured(3, vec![255, 0, 0, 10, 20, 30]).colours().unwrap();
        let at = |x: usize| colours.each_ref().map(|channel| channel.value([x, 0, 0]));
        assert_eq!([at(0), at(1)], [[255.0, 0.0, 0.0], [10.0, 20.0, 30.0]]);
        assert_eq!([opacity.value([0, 0, 0]), opacity.value([1, 0, 0])], [54.0, 19.0]);
        let (_, opacity) = coloured(4, vec![255, 0, 0, 77, 10, 20, 30, 0]).colours().unwrap();
        assert_eq!([opacity.value([0, 0, 0]), opacity.value([1, 0, 0])], [77.0, 0.0]);
        assert!(coloured(2, vec![0; 4]).colours().is_err());
    }
}
