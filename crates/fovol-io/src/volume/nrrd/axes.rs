//! Roles of the axes of an NRRD array: components first, then x, y, z, then volumes.

use super::header::Header;
use crate::Result;
use crate::volume::Source;
use glam::DVec3;

/// An array seen as a volume.
#[derive(Debug, PartialEq)]
pub struct Axes {
    /// Interleaved values per voxel: the size of a first axis that is not spatial.
    pub components: usize,
    /// Values per voxel that lie one volume after the other: the size of a last axis that is not spatial.
    pub planes: usize,
    /// Whether the header declares the values of a voxel as colours.
    pub are_colours: bool,
    /// The sizes of the other axes.
    pub sizes: Vec<usize>,
    /// Spacings of the axes; NaN where the file states none.
    pub spacings: Vec<f64>,
    /// The vector to the next sample along each axis, if the file states it in three dimensions.
    pub directions: Vec<Option<DVec3>>,
    /// Doubts about them, a line each.
    pub notes: Vec<String>,
}

/// One axis of the header.
struct Axis {
    size: usize,
    spacing: f64,
    direction: Option<DVec3>,
    is_spatial: bool,
    /// Whether samples along it are points of time.
    is_time: bool,
    /// Whether samples along it are the values of one voxel.
    are_values: bool,
    /// Whether its spacing follows from where it begins and ends.
    is_between_ends: bool,
}

impl Axes {
    /// The axes of `header`.
    ///
    /// # Errors
    /// Missing or contradicting fields, or an order of axes that is not read.
    pub fn of(source: &Source, header: &Header) -> Result<Self> {
        let mut axes = axes(source, header)?;
        let mut notes = Vec::new();
        if axes.len() > 3 && axes[0].is_time {
            notes.push("has its time points as the values of each voxel; --component N chooses one".into());
        }
        let components = match axes.first() {
            Some(first) if axes.len() > 1 && (!first.is_spatial || axes.len() > 3 && first.is_time) => {
                axes.remove(0).size
            }
            _ => 1,
        };
        let planes = match axes.last() {
            Some(last) if axes.len() > 3 && last.are_values => axes.pop().map_or(1, |last| last.size),
            _ => 1,
        };
        let is_between = |axis: &Axis| (!axis.is_spatial || axis.is_time) && axis.size > 1;
        if axes.len() > 3 && axes[..3].iter().any(is_between) {
            return Err(source.unsupported(
                "its axis of a list or of time lies between the spatial ones; move it to the end, with `unu permute` for one",
            ));
        }
        if axes.iter().take(3).any(|axis| axis.is_time && axis.size > 1) {
            notes.push("its axis of time is shown as an axis of space".into());
        }
        let says_centres = header.get("centers").or_else(|| header.get("centerings")).is_some();
        if !says_centres && axes.iter().any(|axis| axis.is_between_ends) {
            notes.push(
                "its spacing follows from axis mins and axis maxs, taken for the outer faces of voxels; --spacing X,Y,Z overrides it"
                    .into(),
            );
        }
        let kinds = header.get("kinds").unwrap_or_default().to_ascii_lowercase();
        let are_colours = kinds.split_whitespace().any(|kind| kind.ends_with("-color"));
        Ok(Self {
            components,
            planes,
            are_colours,
            directions: axes.iter().map(|axis| axis.direction).collect(),
            notes,
            sizes: axes.iter().map(|axis| axis.size).collect(),
            spacings: axes.iter().map(|axis| axis.spacing).collect(),
        })
    }
}

fn axes(source: &Source, header: &Header) -> Result<Vec<Axis>> {
    let sizes = header.get("sizes").ok_or_else(|| source.malformed("its NRRD header has no sizes"))?;
    let sizes: Option<Vec<usize>> = sizes.split_whitespace().map(|size| size.parse().ok()).collect();
    let sizes = sizes
        .filter(|sizes| (1..=16).contains(&sizes.len()))
        .ok_or_else(|| source.malformed("the sizes of its NRRD header are no 1 to 16 whole numbers"))?;
    let dimension = header.get("dimension").and_then(|text| text.parse().ok());
    if dimension.is_some_and(|dimension: usize| dimension != sizes.len()) {
        return Err(source.malformed("its NRRD header has another number of sizes than its dimension"));
    }
    let count = sizes.len();
    let per_axis = |field: &str, values: Option<usize>| match values {
        Some(found) if found != count => {
            Err(source.malformed(format!("its NRRD header has {found} {field} for {count} axes")))
        }
        _ => Ok(()),
    };
    let texts = header.get("spacedirections").map(split);
    let directions: Option<Vec<Option<f64>>> =
        texts.as_ref().map(|texts| texts.iter().map(|text| length(text)).collect());
    per_axis("space directions", directions.as_ref().map(Vec::len))?;
    let spacings: Option<Vec<f64>> = header
        .get("spacings")
        .map(|text| text.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect());
    per_axis("spacings", spacings.as_ref().map(Vec::len))?;
    let ends = ends(header);
    per_axis("axis mins and maxs", ends.as_ref().map(Vec::len))?;
    let centres: Option<Vec<&str>> = header
        .get("centers")
        .or_else(|| header.get("centerings"))
        .map(|text| text.split_whitespace().collect());
    per_axis("centers", centres.as_ref().map(Vec::len))?;
    let kinds: Option<Vec<&str>> = header.get("kinds").map(|text| text.split_whitespace().collect());
    per_axis("kinds", kinds.as_ref().map(Vec::len))?;

    let axis = |i: usize| {
        let direction = directions.as_ref().map(|directions| directions[i]);
        let has_direction = direction.is_none_or(|direction| direction.is_some());
        let stated = direction.flatten().or_else(|| spacings.as_ref().map(|spacings| spacings[i]));
        let is_node = centres.as_ref().is_some_and(|centres| centres[i] == "node");
        let between = ends.as_ref().and_then(|ends| between_ends(ends[i], sizes[i], is_node));
        let is_spatial = kinds.as_ref().is_none_or(|kinds| is_spatial(kinds[i]));
        Axis {
            size: sizes[i],
            spacing: stated.or(between).unwrap_or(f64::NAN),
            direction: texts.as_ref().and_then(|texts| vector(texts[i])),
            is_spatial: is_spatial && has_direction,
            is_time: kinds.as_ref().is_some_and(|kinds| kinds[i].eq_ignore_ascii_case("time")),
            are_values: !is_spatial
                && kinds.as_ref().is_some_and(|kinds| !kinds[i].eq_ignore_ascii_case("list")),
            is_between_ends: stated.is_none() && between.is_some(),
        }
    };
    Ok((0..count).map(axis).collect())
}

/// Whether an axis of this kind counts as a domain axis, of space or time.
fn is_spatial(kind: &str) -> bool {
    matches!(kind.to_ascii_lowercase().as_str(), "domain" | "space" | "time" | "none" | "???")
}

/// Minimum and maximum of each axis; NaN where the file states none.
fn ends(header: &Header) -> Option<Vec<[f64; 2]>> {
    let numbers = |field: &str| -> Option<Vec<f64>> {
        let text = header.get(field)?;
        Some(text.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect())
    };
    let (first, last) = (numbers("axismins")?, numbers("axismaxs")?);
    (first.len() == last.len()).then(|| first.into_iter().zip(last).map(|(a, b)| [a, b]).collect())
}

/// The spacing of `size` samples between `ends`, by Teem's rule: nodes lie on the ends, cells between them.
fn between_ends([first, last]: [f64; 2], size: usize, is_node: bool) -> Option<f64> {
    let gaps = if is_node { size.saturating_sub(1) } else { size };
    let spacing = (last - first).abs() / gaps as f64;
    (spacing.is_finite() && spacing > 0.0).then_some(spacing)
}

/// The words of the space directions: vectors and `none`.
fn split(text: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = match rest.starts_with('(') {
            true => rest.find(')').map_or(rest.len(), |end| end + 1),
            false => rest.find(|c: char| c.is_whitespace() || c == '(').unwrap_or(rest.len()),
        };
        let (word, after) = rest.split_at(end);
        words.push(word);
        rest = after.trim_start();
    }
    words
}

/// The first three numbers of a vector like `(1,0,0)`.
pub fn vector(text: &str) -> Option<DVec3> {
    let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Option<Vec<f64>> = inner.split(',').map(|word| word.trim().parse().ok()).collect();
    let numbers = numbers?;
    (numbers.len() >= 3).then(|| DVec3::new(numbers[0], numbers[1], numbers[2]))
}

/// The length of a vector like `(1,0,0)`.
fn length(vector: &str) -> Option<f64> {
    let inner = vector.strip_prefix('(')?.strip_suffix(')')?;
    let squares: Option<f64> =
        inner.split(',').map(|word| word.trim().parse::<f64>().ok().map(|value| value * value)).sum();
    squares.map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn of(text: &str) -> Result<Axes> {
        let source = Source::from_bytes(Path::new("x"), format!("NRRD0004\n{text}\n\n").into_bytes());
        Axes::of(&source, &Header::parse(&source)?)
    }

    #[test]
    fn directions_give_spacings() {
        let axes = of("sizes: 4 5 6\nspace directions: (3,0,4) (0,2,0)(0,0,-1)").unwrap();
        assert_eq!(axes.spacings, [5.0, 2.0, 1.0]);
        assert_eq!(axes.components, 1);
    }

    #[test]
    fn a_first_axis_of_values_is_components() {
        for text in
            ["kinds: RGB-color domain domain domain", "space directions: none (1,0,0) (0,1,0) (0,0,1)"]
        {
            let axes = of(&format!("sizes: 3 5 6 7\n{text}")).unwrap();
            assert_eq!((axes.components, axes.sizes), (3, vec![5, 6, 7]));
        }
    }

    #[test]
    fn ends_give_spacings() {
        let axes = of("sizes: 12 10\naxis mins: 0 0\naxis maxs: 11 18\ncenters: node node").unwrap();
        assert_eq!((axes.spacings, axes.notes.len()), (vec![1.0, 2.0], 0));
        let axes = of("sizes: 12 10\naxis mins: 0 NaN\naxis maxs: 24 NaN").unwrap();
        assert!(axes.spacings[0] == 2.0 && axes.spacings[1].is_nan());
        assert!(axes.notes[0].contains("--spacing"), "{:?}", axes.notes);
        let axes = of("sizes: 12 10\nspacings: 3 4\naxis mins: 0 0\naxis maxs: 11 18").unwrap();
        assert_eq!((axes.spacings, axes.notes.len()), (vec![3.0, 4.0], 0));
    }

    #[test]
    fn list_axes_go_last_or_are_refused() {
        assert_eq!(of("sizes: 5 6 7 9\nkinds: space space space list").unwrap().sizes, [5, 6, 7, 9]);
        let error = of("sizes: 5 6 9 7\nkinds: space space list space").unwrap_err().to_string();
        assert!(error.contains("unu permute"), "{error}");
    }

    #[test]
    fn time_axes_are_no_axes_of_space() {
        let first = of("sizes: 4 5 6 7\nkinds: time domain domain domain").unwrap();
        assert_eq!((first.components, first.sizes), (4, vec![5, 6, 7]));
        assert!(first.notes[0].contains("--component"), "{:?}", first.notes);
        assert!(of("sizes: 5 6 9 7\nkinds: space space time space").is_err());
        let film = of("sizes: 5 6 9\nkinds: domain domain time").unwrap();
        assert!(film.sizes == [5, 6, 9] && film.notes[0].contains("axis of time"), "{:?}", film.notes);
        let last = of("sizes: 5 6 7 9\nkinds: domain domain domain time").unwrap();
        assert!(last.sizes == [5, 6, 7, 9] && last.notes.is_empty());
    }

    #[test]
    fn contradictions_are_errors() {
        for text in [
            "dimension: 3",
            "sizes: 1 x 3",
            "sizes:",
            "sizes: -1 2",
            "dimension: 2\nsizes: 1 2 3",
            "sizes: 1 2 3\nspacings: 1 1",
            "sizes: 1 2 3\nkinds: domain",
            "sizes: 1 2 3\nspace directions: (1,0,0)",
        ] {
            assert!(of(text).is_err(), "{text}");
        }
    }
}
