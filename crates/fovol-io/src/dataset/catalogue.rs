use super::{Error, Result};
use fovol_core::Dtype;
use std::sync::LazyLock;

/// A published volume: raw little-endian voxels at a URL.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its name, as in `aneurism`.
    pub name: String,
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The type of a voxel.
    pub dtype: Dtype,
    /// The distance between voxels along x, y, z, in the unit of the data set.
    pub spacing: [f64; 3],
    /// Where it is.
    pub url: String,
    /// The published SHA-512 of the file in lower-case hexadecimal digits, if there is one.
    pub sha512: Option<String>,
}

impl Entry {
    /// The size of the file in bytes.
    pub fn bytes(&self) -> u64 {
        self.dims.iter().map(|&side| side as u64).product::<u64>() * self.dtype.size() as u64
    }

    /// A file name that says size and type, as in `aneurism_256x256x256_uint8.raw`, so that the file can
    /// be read without being told.
    pub fn file_name(&self) -> String {
        let [x, y, z] = self.dims;
        format!("{}_{x}x{y}x{z}_{}.raw", self.name, long_name(self.dtype))
    }

    /// Reads a line of tab-separated fields: name, dims, dtype, spacing, url, sha512.
    fn parse(line: &str) -> Option<Self> {
        let fields: [&str; 6] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
        let [name, dims, dtype, spacing, url, sha512] = fields;
        Some(Self {
            name: name.into(),
            dims: three(dims, 'x')?,
            dtype: dtype.parse().ok()?,
            spacing: three(spacing, ',')?,
            url: url.into(),
            sha512: (!sha512.is_empty()).then(|| sha512.to_ascii_lowercase()),
        })
    }
}

fn three<T: std::str::FromStr>(text: &str, separator: char) -> Option<[T; 3]> {
    let values: Option<Vec<T>> = text.split(separator).map(|word| word.parse().ok()).collect();
    values?.try_into().ok()
}

fn long_name(dtype: Dtype) -> String {
    let short = dtype.name();
    let kind = match &short[..1] {
        "u" => "uint",
        "i" => "int",
        _ => "float",
    };
    format!("{kind}{}", &short[1..])
}

/// The Open Scientific Visualization Datasets (<https://klacansky.com/open-scivis-datasets/>), by name.
pub fn catalogue() -> &'static [Entry] {
    static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
        let table = include_str!("../../assets/datasets/open-scivis.tsv");
        // The first line names the fields. That every line can be read is tested.
        table.lines().skip(1).filter_map(Entry::parse).collect()
    });
    &ENTRIES
}

/// The entry called `name`, in any case and with `-` or `_`.
///
/// # Errors
/// [`Error::UnknownName`] with names that come near.
pub fn find(name: &str) -> Result<&'static Entry> {
    let wanted = canonical(name);
    let entries = catalogue();
    entries
        .iter()
        .find(|entry| entry.name == wanted)
        .ok_or_else(|| Error::UnknownName { name: name.into(), near: near_misses(&wanted) })
}

fn canonical(name: &str) -> String {
    name.trim().to_ascii_lowercase().replace([' ', '-'], "_")
}

/// Up to four names: those that contain or are contained in what was written, and those a few
/// keystrokes away; nearest first.
fn near_misses(wanted: &str) -> Vec<&'static str> {
    let mut near: Vec<(usize, &str)> = catalogue()
        .iter()
        .map(|entry| entry.name.as_str())
        .filter_map(|name| {
            let contained = wanted.len() >= 3 && (name.contains(wanted) || wanted.contains(name));
            let keystrokes = edit_distance(wanted, name);
            let allowed = 1 + name.len().min(wanted.len()) / 4;
            if contained { Some((0, name)) } else { (keystrokes <= allowed).then_some((keystrokes, name)) }
        })
        .collect();
    near.sort();
    near.into_iter().take(4).map(|(_, name)| name).collect()
}

/// Insertions, deletions and replacements between two words (Levenshtein 1966).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_is_an_entry() {
        let lines = include_str!("../../assets/datasets/open-scivis.tsv").lines().count() - 1;
        assert_eq!(catalogue().len(), lines);
        for entry in catalogue() {
            assert!(entry.url.ends_with(&entry.file_name()), "{}", entry.url);
            assert!(entry.bytes() > 0 && entry.spacing.iter().all(|s| *s > 0.0), "{}", entry.name);
            let is_hash = |hash: &String| hash.len() == 128 && hash.bytes().all(|b| b.is_ascii_hexdigit());
            assert!(entry.sha512.as_ref().is_none_or(is_hash), "{}", entry.name);
        }
        assert!(catalogue().windows(2).all(|pair| pair[0].name < pair[1].name));
    }

    #[test]
    fn names_are_found_as_people_write_them() {
        assert_eq!(find("Marschner-Lobb").unwrap().dims, [41, 41, 41]);
        assert_eq!(find("bonsai").unwrap().bytes(), 1 << 24);
    }

    #[test]
    fn near_misses_are_suggested() {
        for (wrong, right) in [("aneurysm", "aneurism"), ("skul", "skull"), ("turbulence", "tacc_turbulence")]
        {
            let message = find(wrong).unwrap_err().to_string();
            assert!(message.contains(right), "{message}");
        }
        let message = find("qqqqqqqq").unwrap_err().to_string();
        assert!(message.contains("data list") && !message.contains("mean"), "{message}");
    }

    #[test]
    fn edit_distances_are_known_ones() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("same", "same"), 0);
    }
}
