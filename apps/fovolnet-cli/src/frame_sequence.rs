//! Numbered pictures in a folder, in numerical order.

use anyhow::{Result, bail};
use fovolnet::core::input;
use fovolnet::io::{Error, image, natural_order};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Whether `path` has the extension of a readable picture.
pub fn is_picture(path: &Path) -> bool {
    let found = path.extension().unwrap_or_default();
    image::EXTENSIONS.iter().any(|known| found.eq_ignore_ascii_case(known))
}

/// Last part of `path`, as text.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Pictures in `folder` whose names begin with `prefix`, sorted by the numbers in their names: 2 before 10.
///
/// # Errors
/// A folder that cannot be read or has no such picture; two pictures with the same number.
pub fn pictures_named(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>> {
    let files = pictures_if_any(folder, prefix)?;
    if files.is_empty() {
        bail!("{}: there are no pictures {prefix}0000.png, … in it; check the folder", folder.display());
    }
    Ok(files)
}

/// Pictures as in [`pictures_named`], possibly none. They count as inputs from now on, see [`input`].
///
/// # Errors
/// A folder that cannot be read; two pictures with the same number.
pub fn pictures_if_any(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
        if file_name(&path).starts_with(prefix) && is_picture(&path) && !path.is_dir() {
            input::add(&path);
            files.push(path);
        }
    }
    files.sort_by(|a, b| natural_order::compare(&file_name(a), &file_name(b)));
    if !prefix.is_empty() {
        by_number(&files, prefix)?;
    }
    Ok(files)
}

/// Part of the name of `path` between `prefix` and the extension. Leading zeros of a number are dropped.
pub fn number(path: &Path, prefix: &str) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let rest = stem.strip_prefix(prefix).unwrap_or(&stem);
    match rest.trim_start_matches('0') {
        "" if !rest.is_empty() => "0".into(),
        digits if digits.bytes().all(|b| b.is_ascii_digit()) => digits.into(),
        _ => rest.into(),
    }
}

/// Indexes `files` by their numbers.
///
/// # Errors
/// Two files with the same number, such as `frame_1.png` and `frame_0001.exr`.
pub fn by_number<'a>(files: &'a [PathBuf], prefix: &str) -> Result<BTreeMap<String, &'a Path>> {
    let mut found: BTreeMap<String, &Path> = BTreeMap::new();
    for path in files {
        if let Some(other) = found.insert(number(path, prefix), path) {
            bail!(
                "{} and {} are the same frame by their numbers; move one of them away",
                other.display(),
                file_name(path)
            );
        }
    }
    Ok(found)
}

/// Note on numbers that are missing in the sequence of `files`; `None` if there are none.
pub fn gaps(files: &[PathBuf], prefix: &str) -> Option<String> {
    const LISTED: usize = 4;
    let numbers: Vec<u64> = files.iter().filter_map(|path| number(path, prefix).parse().ok()).collect();
    let missing: Vec<String> = numbers
        .windows(2)
        .filter(|pair| pair[1] > pair[0] + 1)
        .map(|pair| match [pair[0] + 1, pair[1] - 1] {
            [first, last] if first == last => first.to_string(),
            [first, last] => format!("{first} to {last}"),
        })
        .collect();
    if missing.is_empty() {
        return None;
    }
    let more = if missing.len() > LISTED { ", …" } else { "" };
    let listed = missing[..missing.len().min(LISTED)].join(", ");
    Some(format!(
        "{prefix}* has gaps, frames {listed}{more} are missing; the frames around them count as consecutive"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        names.iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
        folder
    }

    #[test]
    fn numbers_order_frames_with_and_without_zeros() {
        let names = ["a_10.png", "a_2.PNG", "a_0.exr", "a_1.jpg", "b_3.png", "a_7.txt"];
        let folder = folder(&names);
        let files = pictures_named(folder.path(), "a_").unwrap();
        let found: Vec<String> = files.iter().map(|path| file_name(path)).collect();
        assert_eq!(found, ["a_0.exr", "a_1.jpg", "a_2.PNG", "a_10.png"]);
        assert_eq!(files.iter().map(|path| number(path, "a_")).collect::<Vec<_>>(), ["0", "1", "2", "10"]);
        let said = gaps(&files, "a_").unwrap();
        assert!(said.contains("frames 3 to 9 are missing"), "{said}");
        assert_eq!(gaps(&files[..3], "a_"), None);
        assert!(pictures_named(folder.path(), "c_").is_err());
    }

    #[test]
    fn one_number_is_one_frame() {
        let folder = folder(&["a_1.png", "a_0001.exr"]);
        let error = pictures_named(folder.path(), "a_").unwrap_err().to_string();
        assert!(error.contains("a_1.png") && error.contains("a_0001.exr"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn names_need_not_be_text() {
        use std::os::unix::ffi::OsStrExt;
        let inside = tempfile::tempdir().unwrap();
        let folder = inside.path().join(std::ffi::OsStr::from_bytes(b"fr\xff"));
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("a_0.png"), "").unwrap();
        assert_eq!(pictures_named(&folder, "a_").unwrap(), [folder.join("a_0.png")]);
    }
}
