//! Detection of label maps.

use crate::Volume;

/// Most labels of a label map; with more values it cannot be told from a scan.
const MOST: usize = 32;
/// Fewest labels; two values are a mask.
const LEAST: usize = 3;

impl Volume {
    /// The labels, smallest first, if the values look like labels.
    ///
    /// Labels are 3 to 32 different integers, and somewhere two voxels touch whose labels are not next to each other in
    /// order. Labels jump, while the values of a scan pass through all values between.
    ///
    /// They are looked for once.
    pub fn label_values(&self) -> Option<&[f64]> {
        self.found.labels.get_or_init(|| self.looked_up_labels()).as_deref()
    }

    /// Whether the values are labels: the file says so, or they look like labels.
    pub fn is_label_map(&self) -> bool {
        self.dtype().is_integer() && (self.contents().are_labels || self.label_values().is_some())
    }

    fn looked_up_labels(&self) -> Option<Vec<f64>> {
        if !self.dtype().is_integer() {
            return None;
        }
        let values = self.distinct_values(MOST).filter(|values| values.len() >= LEAST)?;
        self.jumps(&values).then_some(values)
    }

    /// Whether two voxels share a face whose places in `values` are more than one apart.
    fn jumps(&self, values: &[f64]) -> bool {
        let [nx, ny, nz] = self.grid().dims();
        let place = |voxel| values.partition_point(|value| *value < self.value(voxel));
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let here = place([x, y, z]);
                    let next = [[x + 1, y, z], [x, y + 1, z], [x, y, z + 1]];
                    let inside = |[x, y, z]: &[usize; 3]| *x < nx && *y < ny && *z < nz;
                    if next.into_iter().filter(inside).any(|voxel| place(voxel).abs_diff(here) > 1) {
                        return true;
                    }
                }
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use crate::{Grid, Volume};

    fn volume(values: Vec<i16>) -> Volume {
        Volume::from_values(Grid::new([values.len() / 2, 2, 1], [1.0; 3]).unwrap(), values).unwrap()
    }

    #[test]
    fn labels_jump() {
        assert_eq!(volume(vec![0, 0, 3, 3, 0, 1, 1, 3]).label_values(), Some(&[0.0, 1.0, 3.0][..]));
        // Neighbours along y alone.
        assert_eq!(volume(vec![0, 0, 0, 1, 7, 7, 0, 0]).label_values().map(|v| v.len()), Some(3));
    }

    #[test]
    fn ramps_masks_and_scans_are_none() {
        assert_eq!(volume(vec![0, 1, 2, 3, 0, 1, 2, 3]).label_values(), None);
        assert_eq!(volume(vec![0, 9, 0, 9, 9, 9, 0, 0]).label_values(), None);
        assert_eq!(volume((0..80).map(|i| i * 7 % 80).collect()).label_values(), None);
    }

    #[test]
    fn fractions_are_none() {
        let grid = Grid::new([4, 1, 1], [1.0; 3]).unwrap();
        assert_eq!(Volume::from_values(grid, vec![0.0f32, 5.0, 0.0, 1.0]).unwrap().label_values(), None);
    }
}
