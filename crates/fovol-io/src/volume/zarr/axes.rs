//! Which axes of an array are x, y, z, time, channels and components.

use crate::volume::array_axes::ArrayAxes;
use crate::volume::array_axes::shown;
use crate::volume::cf::Described;

/// The meaning of the axes of an array, by their numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Axes {
    /// The axes x, y, z.
    pub space: [Option<usize>; 3],
    /// The axis of time points.
    pub time: Option<usize>,
    /// The axis of channels.
    pub channel: Option<usize>,
    /// The axis of values of one voxel.
    pub component: Option<usize>,
    /// Remarks on assumptions, one line each.
    pub notes: Vec<String>,
}

/// Names of axes, by their meaning.
const X: [&str; 4] = ["x", "lon", "longitude", "easting"];
const Y: [&str; 4] = ["y", "lat", "latitude", "northing"];
const Z: [&str; 10] =
    ["z", "depth", "lev", "level", "plane", "slice", "height", "altitude", "pressure", "plev"];
const TIME: [&str; 4] = ["t", "time", "times", "frame"];
const CHANNEL: [&str; 4] = ["c", "channel", "channels", "band"];

/// Most channels of an image.
const MOST_CHANNELS: usize = 1 << 16;

impl Axes {
    /// The axes of an array of this `shape` by their `names`, one for each, as far as these are known. Others must have
    /// one value.
    ///
    /// # Errors
    /// An axis that has no place in a volume.
    pub fn named(names: &[Option<String>], shape: &[usize]) -> Result<Self, String> {
        let lower: Vec<String> =
            names.iter().map(|name| name.as_deref().unwrap_or_default().to_lowercase()).collect();
        let axes = Self {
            space: [&X[..], &Y, &Z].map(|known| find(&lower, known)),
            time: find(&lower, &TIME),
            channel: find(&lower, &CHANNEL),
            ..Self::default()
        };
        axes.check(names, shape)?;
        Ok(axes)
    }

    /// The axes of an array of this `shape`, whose `names` may say nothing. `units` are those of the first axis.
    ///
    /// # Errors
    /// A shape that is no volume.
    pub fn guessed(names: &[Option<String>], shape: &[usize], units: Option<String>) -> Result<Self, String> {
        // Names that do not fit the axes say nothing.
        let names = if names.len() == shape.len() { names } else { &[] };
        if let Ok(named) = Self::named(names, shape)
            && named.space[0].is_some()
            && named.space[1].is_some()
        {
            return Ok(named);
        }
        let described = Described { shape: shape.to_vec(), names: names.to_vec(), first_units: units };
        let ArrayAxes { space, time, components, notes, .. } = described.axes()?;
        let component = (components > 1).then(|| shape.iter().rposition(|&length| length > 1)).flatten();
        Ok(Self { space, time, channel: None, component, notes })
    }

    /// Checks that there is a row of voxels, and that axes without a meaning have one value.
    fn check(&self, names: &[Option<String>], shape: &[usize]) -> Result<(), String> {
        if shape.contains(&0) {
            return Err(format!("of shape {} is empty", shown(shape)));
        }
        if let Some(count) = self.channel.map(|axis| shape[axis]).filter(|&count| count > MOST_CHANNELS) {
            return Err(format!("has {count} channels, more than {MOST_CHANNELS}; save a part of them"));
        }
        if self.space[0].is_none() {
            return Err("has no axis x; name its axes t, c, z, y, x".into());
        }
        let of_space = self.space.iter().flatten();
        let known: Vec<usize> = of_space.chain(&self.time).chain(&self.channel).copied().collect();
        let stranger = (0..shape.len()).find(|axis| shape[*axis] > 1 && !known.contains(axis));
        stranger.map_or(Ok(()), |axis| {
            let name = names.get(axis).and_then(Option::as_deref).unwrap_or_default();
            Err(format!(
                "has {} values along the axis `{name}`, which is no t, c, z, y or x; save a part of it",
                shape[axis]
            ))
        })
    }

    /// The lengths of x, y, z.
    pub fn dims(&self, shape: &[usize]) -> [usize; 3] {
        self.space.map(|axis| length(axis, shape))
    }

    /// The number of time points, channels and components.
    pub fn counts(&self, shape: &[usize]) -> [usize; 3] {
        [self.time, self.channel, self.component].map(|axis| length(axis, shape))
    }
}

/// The length of an axis; 1 where there is none.
fn length(axis: Option<usize>, shape: &[usize]) -> usize {
    axis.map_or(1, |axis| shape[axis])
}

fn find(names: &[String], known: &[&str]) -> Option<usize> {
    names.iter().position(|name| known.contains(&name.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<Option<String>> {
        text.split(' ').map(|name| Some(name.to_owned())).collect()
    }

    #[test]
    fn names_count_in_any_order() {
        let axes = Axes::named(&names("X c Z t y"), &[5, 2, 7, 3, 6]).unwrap();
        assert_eq!(axes.dims(&[5, 2, 7, 3, 6]), [5, 6, 7]);
        assert_eq!(axes.counts(&[5, 2, 7, 3, 6]), [3, 2, 1]);
        assert!(Axes::named(&names("lambda y x"), &[4, 5, 6]).unwrap_err().contains("`lambda`"));
        assert!(Axes::named(&names("lambda y x"), &[1, 5, 6]).is_ok());
        assert!(Axes::named(&names("z y"), &[4, 5]).is_err());
        assert!(Axes::named(&names("c y x"), &[1 << 40, 5, 6]).unwrap_err().contains("channels"));
    }

    #[test]
    fn axes_without_names_are_guessed() {
        let axes = Axes::guessed(&[], &[7, 6, 5, 3], None).unwrap();
        assert_eq!((axes.space, axes.component), ([Some(2), Some(1), Some(0)], Some(3)));
        let axes = Axes::guessed(&names("time dim_0 dim_1"), &[7, 6, 5], None).unwrap();
        assert_eq!((axes.space, axes.time), ([Some(2), Some(1), None], Some(0)));
        let axes = Axes::guessed(&names("time z y x"), &[6, 5], None).unwrap();
        assert_eq!(axes.space, [Some(1), Some(0), None]);
        assert!(Axes::guessed(&[], &[4], None).is_err());
    }
}
