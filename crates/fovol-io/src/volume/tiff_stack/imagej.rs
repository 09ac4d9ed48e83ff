//! Stacks of ImageJ: lines of `key=value` in the description of the first page.

use super::hyperstack::{Counts, Hyperstack, Resolution};

/// Parses ImageJ's description `text` of a file that has `pages` pages and room for `most` planes.
///
/// Channels vary fastest, then slices, then time. Files above 4 GiB have one page, followed by `images` planes.
pub fn hyperstack(text: &str, pages: usize, most: usize, resolution: Resolution) -> Hyperstack {
    let Resolution { pitch, unit } = resolution;
    let value = |key: &str| {
        let pair = |line: &'_ str| {
            line.split_once('=').filter(|(k, _)| k.trim() == key).map(|(_, v)| v.trim().to_owned())
        };
        text.lines().find_map(pair)
    };
    let count = |key| value(key).and_then(|n| n.parse().ok()).filter(|&n: &usize| n > 0);
    let images = count("images").unwrap_or(1);
    let mut counts = Counts {
        slices: count("slices").unwrap_or(1),
        channels: count("channels").unwrap_or(1),
        times: count("frames").unwrap_or(1),
    };
    let is_one_page = pages == 1 && images > 1;
    let planes = if is_one_page { images.min(most) } else { pages };
    let mut notes = Vec::new();
    if counts.planes() == Some(1) {
        counts.slices = planes;
    } else if counts.planes() != Some(planes) {
        let Counts { slices, channels, times } = counts;
        notes.push(format!(
            "says {slices} slices, {channels} channels and {times} time points, but has {planes} planes; all are shown as slices"
        ));
        counts = Counts::slices(planes);
    } else if counts.slices == 1 && counts.times > 1 {
        notes.push(format!("its {} time points of one slice are shown as slices", counts.times));
        counts = Counts { slices: counts.times, times: 1, ..counts };
    }
    let name = match (value("unit"), unit) {
        (Some(name), _) => Some(name),
        (None, 2.0) if pitch[0].is_some() => Some("inch".to_owned()),
        (None, 3.0) if pitch[0].is_some() => Some("cm".to_owned()),
        _ => None,
    };
    let depth = value("spacing").and_then(|s| s.parse().ok()).map(f64::abs);
    let [x, y] = pitch;
    if depth.is_none() && counts.slices > 1 && x.is_some_and(|x| (x - 1.0).abs() > 1e-9) {
        notes.push("says no distance between slices; ImageJ's 1 is taken; --spacing says others".into());
    }
    Hyperstack {
        spacing: [x, y.or(x), depth],
        units: name,
        is_one_page,
        notes,
        ..Hyperstack::ordered(counts, "CZT")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TENTH: Resolution = Resolution { pitch: [Some(0.1); 2], unit: 1.0 };
    const NONE: Resolution = Resolution { pitch: [None; 2], unit: 1.0 };

    #[test]
    fn sizes_and_spacing() {
        let text = "ImageJ=1.11a\nimages=8\nslices=8\nhyperstack=true\nspacing=0.3\nunit=um\n";
        let stack = hyperstack(text, 8, 99, TENTH);
        assert_eq!(
            (stack.counts, stack.spacing(), stack.units()),
            (Counts::slices(8), [0.1, 0.1, 0.3], Some("µm"))
        );
        assert!(!stack.is_one_page && stack.notes.is_empty());
    }

    #[test]
    fn channels_come_before_slices_and_time() {
        let stack = hyperstack("ImageJ=1\nimages=24\nchannels=2\nslices=3\nframes=4\n", 24, 99, NONE);
        assert_eq!(stack.counts, Counts { slices: 3, channels: 2, times: 4 });
        assert_eq!(stack.pages[3..6], [Some(1), Some(3), Some(5)]);
    }

    #[test]
    fn large_stacks_have_one_page() {
        let stack = hyperstack("ImageJ=1\nimages=8\n", 1, 99, NONE);
        assert!(stack.is_one_page && stack.counts == Counts::slices(8));
    }

    #[test]
    fn what_cannot_be_is_said() {
        let stack = hyperstack("ImageJ=1\nimages=8\nslices=3\nchannels=2\n", 8, 99, TENTH);
        assert!(
            stack.notes[0].contains("but has 8 planes") && stack.counts == Counts::slices(8),
            "{stack:?}"
        );
        let film = hyperstack("ImageJ=1\nimages=5\nframes=5\n", 5, 99, NONE);
        assert!(film.notes[0].contains("shown as slices") && film.counts == Counts::slices(5));
    }
}
