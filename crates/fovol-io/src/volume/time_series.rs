//! Time series of files: a folder of volumes, or a pattern such as `run_*.vti`.

use super::array_path::is_remote;
use super::{Overrides, Source, format};
use crate::{Error, Result, natural_order};
use fovol_core::{Contents, Volume};
use std::path::{Path, PathBuf};

/// Whether `path` is a pattern of files: it does not exist, and its last part has a `*` or `?`.
pub fn is_pattern(path: &Path) -> bool {
    let has_wildcard = path.file_name().is_some_and(|name| name.to_string_lossy().contains(['*', '?']));
    has_wildcard && !is_remote(path) && !path.exists()
}

/// Files of the pattern `path` in the natural order of their names.
///
/// # Errors
/// A folder that cannot be read; no file with such a name.
pub fn files_of_pattern(path: &Path) -> Result<Vec<PathBuf>> {
    let pattern = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = files_in(folder, |name| matches(&pattern, name))?;
    if files.is_empty() {
        return Err(Error::unsupported(path, "no file has such a name; check the folder and the pattern"));
    }
    Ok(files)
}

/// Volume files of the folder `path` in the natural order of their names: those with the most frequent ending, or raw files
/// if fewer than two have headers. Empty where there are fewer than two.
///
/// # Errors
/// A folder that cannot be read.
pub fn files_in_folder(path: &Path) -> Result<Vec<PathBuf>> {
    let with_headers = alike(files_in(path, format::is_name_with_header)?);
    let files = if with_headers.len() < 2 { alike(files_in(path, is_raw_name)?) } else { with_headers };
    Ok(if files.len() < 2 { Vec::new() } else { files })
}

/// The one of `files`, one file a time point, that `overrides` choose, and its number. `path` names all of them.
///
/// # Errors
/// A time point that is not there.
pub fn chosen<'f>(path: &Path, files: &'f [PathBuf], overrides: &Overrides) -> Result<(usize, &'f Path)> {
    let time = overrides.time_of(&Source::from_bytes(path, Vec::new()), files.len())?;
    Ok((time, &files[time]))
}

/// `volume`, read from `file`, as time point `time` of `times`.
///
/// # Errors
/// A volume that has time points of its own.
pub fn placed(volume: Volume, file: &Path, [time, times]: [usize; 2]) -> Result<Volume> {
    let own = volume.contents().times;
    if own > 1 {
        return Err(Error::malformed(
            file,
            format!("it has {own} time points of its own; name it alone, not in a series"),
        ));
    }
    let contents = Contents { times, time, ..volume.contents().clone() };
    Ok(volume.with_contents(contents))
}

/// Picks the files of the most frequent ending.
fn alike(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let ending = |file: &PathBuf| file.extension().map(|ending| ending.to_ascii_lowercase());
    let count = |file: &PathBuf| files.iter().filter(|other| ending(other) == ending(file)).count();
    let Some(usual) = files.iter().max_by_key(|file| count(file)).map(ending) else { return files };
    files.into_iter().filter(|file| ending(file) == usual).collect()
}

fn is_raw_name(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    [".raw", ".raw.gz", ".raw.bz2"].iter().any(|ending| name.ends_with(ending))
}

fn files_in(folder: &Path, is_wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>> {
    let failed = |source| Error::io("read", folder, source);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.starts_with('.') && is_wanted(&name) && file.is_file() {
            files.push((name, file));
        }
    }
    files.sort_by(|(a, _), (b, _)| natural_order::compare(a, b));
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

/// Whether `name` fits `pattern`, in which `*` stands for any text and `?` for one character.
fn matches(pattern: &str, name: &str) -> bool {
    let [pattern, name]: [Vec<char>; 2] = [pattern, name].map(|text| text.chars().collect());
    // The place after the last star, and the part of the name that it stands for, in case more must go to it.
    let (mut p, mut n, mut star) = (0, 0, None);
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p + 1, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => (p, n) = (p + 1, n + 1),
            _ => {
                let Some((after, taken)) = star else { return false };
                star = Some((after, taken + 1));
                (p, n) = (after, taken + 1);
            }
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_text() {
        for (pattern, name, fits) in [
            ("a*.raw", "a12.raw", true),
            ("a*.raw", "a.raw", true),
            ("a*.raw", "b.raw", false),
            ("*b*b", "abbab", true),
            ("a?c", "abc", true),
            ("a?c", "ac", false),
            ("*", "", true),
            ("a*b", "ab.raw", false),
        ] {
            assert_eq!(matches(pattern, name), fits, "{pattern} {name}");
        }
    }

    fn series(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (number, name) in names.iter().enumerate() {
            std::fs::write(folder.path().join(name), [number as u8; 8]).unwrap();
        }
        folder
    }

    #[test]
    fn files_follow_each_other_by_their_numbers() {
        let folder = series(&["r9_2x2x2_uint8.raw", "r10_2x2x2_uint8.raw", "other_2x2x2_uint8.raw"]);
        let read = |name: &str, time: usize| {
            super::super::read(
                &folder.path().join(name),
                &Overrides { time: Some(time), ..Default::default() },
            )
        };
        let first = read("r*_2x2x2_uint8.raw", 0).unwrap();
        assert_eq!((first.value([0; 3]), first.contents().times, first.contents().time), (0.0, 2, 0));
        assert_eq!(read("r*_2x2x2_uint8.raw", 1).unwrap().value([0; 3]), 1.0);
        assert!(read("r*_2x2x2_uint8.raw", 2).unwrap_err().to_string().contains("--time"));
        assert!(read("s*.raw", 0).unwrap_err().to_string().contains("no file has such a name"));
        let all = read("", 2).unwrap();
        assert_eq!((all.value([0; 3]), all.contents().times), (1.0, 3));
    }

    #[test]
    fn folders_of_one_volume_or_none_are_no_series() {
        assert!(files_in_folder(series(&["a_2x2x2_uint8.raw"]).path()).unwrap().is_empty());
        assert!(files_in_folder(series(&["notes.txt", "more.txt"]).path()).unwrap().is_empty());
        let mixed = series(&["a_2x2x2_uint8.raw", "b_2x2x2_uint8.raw", "mask.nrrd"]);
        assert_eq!(files_in_folder(mixed.path()).unwrap().len(), 2);
    }
}
