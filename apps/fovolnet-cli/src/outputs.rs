//! Checks of a command's output files: they must not overwrite its inputs or each other.

use anyhow::{Result, bail, ensure};
use fovolnet::Error;
use fovolnet::io::atomic;
use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

/// Checks the outputs before anything is written. Call it after all inputs are open, see [`fovolnet::core::input`].
///
/// # Errors
/// An output that is a folder or an input; two outputs in one file.
pub fn check<'a>(files: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    let mut places = HashSet::new();
    for file in files {
        ensure!(!file.is_dir(), "{} is a folder; name a file in it", file.display());
        atomic::refuse_input(file)?;
        atomic::refuse_input(&without_returns(file))?;
        // Pipes and devices accept several outputs one after another.
        if (file.is_file() || !file.exists()) && !places.insert(place(file)) {
            let problem =
                format!("two outputs would be written to {}; give each a name of its own", file.display());
            return Err(Error::Contradiction(problem).into());
        }
    }
    Ok(())
}

/// Checks that the folders of `files` exist, before hours of work are lost. Call it after the command has made its own
/// folder.
///
/// # Errors
/// A folder that does not exist.
pub fn have_folders<'a>(files: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    for file in files {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.exists()) {
            bail!("{}: there is no folder {}; make it first", file.display(), folder.display());
        }
    }
    Ok(())
}

/// Location of `file`, existing or not, in a form that can be compared.
fn place(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || Some(folder.canonicalize().ok()?.join(file.file_name()?));
    let place = file.canonicalize().ok().or_else(beside);
    place.or_else(|| std::path::absolute(without_returns(file)).ok()).unwrap_or_else(|| file.to_owned())
}

/// Removes `x/..` from `file`, since `x` may be a folder that is still to be made.
fn without_returns(file: &Path) -> PathBuf {
    let mut way = PathBuf::new();
    for part in file.components() {
        match (part, way.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => {
                way.pop();
            }
            _ => way.push(part),
        }
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::input;

    #[test]
    fn folders_of_outputs_must_exist() {
        let folder = tempfile::tempdir().unwrap();
        have_folders([&*folder.path().join("a"), Path::new("a"), Path::new("-"), Path::new("/dev/null")])
            .unwrap();
        let refused = have_folders([&*folder.path().join("gone/a")]).unwrap_err().to_string();
        assert!(refused.contains("there is no folder"), "{refused}");
    }

    #[test]
    fn each_output_is_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("folder")).unwrap();
        std::fs::write(at("in"), "").unwrap();
        input::open(&at("in")).unwrap();
        let refused = |files: &[PathBuf]| check(files.iter().map(PathBuf::as_path)).unwrap_err().to_string();
        check([&*at("a"), &at("b"), &at("folder/a")]).unwrap();
        assert!(refused(&[at("a"), at("folder")]).contains("is a folder"));
        assert!(refused(&[at("a"), at("folder/../a")]).contains("two outputs"));
        assert!(refused(&[at("gone/a"), at("gone/b/../a")]).contains("two outputs"));
        assert!(refused(&[at("gone/../in")]).contains("another name"));
        assert!(refused(&[at("a"), at("in")]).contains("another name"));
        #[cfg(unix)]
        {
            check([Path::new("/dev/null"); 2]).unwrap();
            std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
            std::fs::write(at("a"), "").unwrap();
            assert!(refused(&[at("a"), at("link")]).contains("two outputs"));
        }
    }
}
