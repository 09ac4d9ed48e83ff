//! Meaning of the axes of an array of numbers: time, z, y, x, component, slowest first.

use fovol_core::Contents;
use std::cmp::Reverse;

/// Axes of an array in C order, whose last axis of space is x.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayAxes {
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The axes of the array that are x, y, z; none where there is one voxel.
    pub space: [Option<usize>; 3],
    /// Time points.
    pub times: usize,
    /// The axis of the array that is time. It is slower than all others that are longer than 1.
    pub time: Option<usize>,
    /// Values per voxel: the fastest axis.
    pub components: usize,
    /// Remarks on assumptions, one line each.
    pub notes: Vec<String>,
}

/// Lengths of a last axis of four that count as components rather than voxels.
const COMPONENTS: std::ops::RangeInclusive<usize> = 2..=4;

/// A last axis of three is suspected to hold colours where the others are this many times as long.
const MUCH_LONGER: usize = 8;

impl ArrayAxes {
    /// The meaning of the axes of an array of this `shape`. Axes of length 1 are dropped where there are more than
    /// three.
    ///
    /// Two axes are one slice, three a volume. A fourth axis holds components if it is the last and has two to four
    /// values, else time points.
    ///
    /// # Errors
    /// Shapes that are no volume, as a remark that follows "its array".
    pub fn of(shape: &[usize]) -> Result<Self, String> {
        Self::arranged(shape, None)
    }

    /// The axes of an array whose first axis is known to be time.
    ///
    /// # Errors
    /// Those of [`Self::of`].
    #[cfg(any(feature = "hdf5", feature = "zarr", test))]
    pub fn after_time(shape: &[usize]) -> Result<Self, String> {
        Self::arranged(shape, Some(0))
    }

    fn arranged(shape: &[usize], known_time: Option<usize>) -> Result<Self, String> {
        if shape.contains(&0) {
            return Err(format!("of shape {} is empty", shown(shape)));
        }
        let kept = squeezed(shape, known_time.map_or(0, |time| time + 1));
        let lengths: Vec<usize> = kept.iter().map(|&axis| shape[axis]).collect();
        let (guessed_time, space, components) = match *lengths.as_slice() {
            [] | [_] => return Err(too_flat(shape)),
            [_, _] | [_, _, _] => (None, &kept[..], 1),
            [_, _, _, last] if COMPONENTS.contains(&last) => (None, &kept[..3], last),
            [_, _, _, _] => (Some(kept[0]), &kept[1..], 1),
            [_, _, _, _, last] if COMPONENTS.contains(&last) => (Some(kept[0]), &kept[1..4], last),
            _ => return Err(too_deep(shape)),
        };
        if known_time.and(guessed_time).is_some() {
            return Err(too_deep(shape));
        }
        let time = known_time.or(guessed_time);
        let [z, y, x] = std::array::from_fn(|i| (i + space.len()).checked_sub(3).map(|i| space[i]));
        let axes = Self {
            dims: [x, y, z].map(|axis| axis.map_or(1, |axis| shape[axis])),
            space: [x, y, z],
            times: time.map_or(1, |axis| shape[axis]),
            time,
            components,
            notes: Vec::new(),
        };
        Ok(axes.with_notes(shape, guessed_time.is_some()))
    }

    fn with_notes(mut self, shape: &[usize], time_is_guessed: bool) -> Self {
        let [x, y, z] = self.dims;
        if self.components == 1 && COMPONENTS.contains(&x) && y.min(z) >= MUCH_LONGER * x {
            self.notes.push(format!(
                "its last axis, taken as x, has {x} values; if they are colours, save the array with the axes z, y, x, colour"
            ));
        }
        if time_is_guessed {
            self.notes.push(format!("the first axis of its shape {} is taken as time", shown(shape)));
        }
        if self.components > 1 {
            self.notes.push(format!("the last axis of its shape {} is taken as components", shown(shape)));
        }
        self
    }

    /// Voxels of one time point; saturates.
    pub fn voxels(&self) -> usize {
        self.dims.iter().fold(1, |product, &dim| product.saturating_mul(dim))
    }

    /// Number of axes of space that are longer than one voxel.
    pub fn rank(&self) -> usize {
        self.dims.iter().filter(|&&dim| dim > 1).count()
    }

    /// The contents of a file of this one array, at `time`.
    pub fn contents(&self, time: usize) -> Contents {
        Contents { times: self.times, time, components: self.components, ..Contents::default() }
    }
}

fn too_flat(shape: &[usize]) -> String {
    format!("of shape {} has no more than one axis; a volume has three: z, y, x", shown(shape))
}

fn too_deep(shape: &[usize]) -> String {
    format!("of shape {} has too many axes; save a part of it with the axes z, y, x", shown(shape))
}

/// The axes of `shape` from `first` on, without axes of length 1 as long as more than three are left.
fn squeezed(shape: &[usize], first: usize) -> Vec<usize> {
    let mut kept: Vec<usize> = (first..shape.len()).collect();
    while kept.len() > 3
        && let Some(at) = kept.iter().position(|&axis| shape[axis] == 1)
    {
        kept.remove(at);
    }
    kept
}

/// Index of the array that is most likely the volume of a file: the one with most axes longer than 1, of those the
/// largest, of those the one with fewest components, of those the first.
pub fn likeliest<'a>(arrays: impl Iterator<Item = Option<&'a ArrayAxes>>) -> Option<usize> {
    let ranked = arrays.enumerate().filter_map(|(index, axes)| {
        let axes = axes?;
        Some((axes.rank(), axes.voxels(), Reverse(axes.components), Reverse(index)))
    });
    ranked.max().map(|(.., Reverse(index))| index)
}

/// `shape` for people.
pub fn shown(shape: &[usize]) -> String {
    match shape {
        [] => "()".into(),
        _ => shape.iter().map(usize::to_string).collect::<Vec<_>>().join("x"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_told_apart() {
        for (shape, dims, times, components) in [
            (&[5, 4][..], [4, 5, 1], 1, 1),
            (&[6, 5, 4], [4, 5, 6], 1, 1),
            (&[1, 5, 4], [4, 5, 1], 1, 1),
            (&[6, 5, 4, 3], [4, 5, 6], 1, 3),
            (&[7, 6, 5, 9], [9, 5, 6], 7, 1),
            (&[7, 6, 5, 4, 2], [4, 5, 6], 7, 2),
            (&[1, 6, 5, 4], [4, 5, 6], 1, 1),
            (&[1, 1, 6, 5, 9], [9, 5, 6], 1, 1),
            (&[6, 5, 4, 1], [4, 5, 6], 1, 1),
        ] {
            let axes = ArrayAxes::of(shape).unwrap();
            assert_eq!((axes.dims, axes.times, axes.components), (dims, times, components), "{shape:?}");
        }
    }

    #[test]
    fn shapes_that_are_no_volume_are_errors() {
        for shape in [&[][..], &[9], &[3, 0, 3], &[9, 9, 9, 9, 9]] {
            assert!(ArrayAxes::of(shape).is_err(), "{shape:?}");
        }
        assert!(ArrayAxes::after_time(&[9, 9, 9, 9, 9]).is_err());
    }

    #[test]
    fn time_may_stand_before_a_slice() {
        let axes = ArrayAxes::after_time(&[7, 5, 4]).unwrap();
        assert_eq!((axes.dims, axes.times), ([4, 5, 1], 7));
        assert_eq!((axes.time, axes.space), (Some(0), [Some(2), Some(1), None]));
        assert!(axes.notes.is_empty());
        let axes = ArrayAxes::of(&[1, 7, 6, 5, 9]).unwrap();
        assert_eq!((axes.time, axes.space), (Some(1), [Some(4), Some(3), Some(2)]));
    }

    #[test]
    fn thin_volumes_that_look_like_colours_are_noted() {
        assert!(ArrayAxes::of(&[64, 64, 3]).unwrap().notes[0].contains("colour"));
        assert!(ArrayAxes::of(&[4, 3, 2]).unwrap().notes.is_empty());
    }
}
