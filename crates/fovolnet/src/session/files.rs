//! Files that a session's settings name. Reading a session finds them; writing one embeds their contents.

use crate::settings::toml_text;
use crate::{GazeChoice, PathChoice, RenderOverrides, TransferChoice, VolumeSettings, presets};
use fovol_core::{path_of_text, text_of_path};
use fovol_net::Weights;
use std::path::{Path, PathBuf};

/// Resolves file names in `render` for a session in `folder`.
pub fn find(folder: &Path, render: &mut RenderOverrides) {
    let search = |file: &mut String| {
        if let Some(found) = found(folder, file) {
            *file = found;
        }
    };
    toml_files(render).into_iter().for_each(search);
    weights_file(render).into_iter().for_each(search);
    if let Some(transfer) = &mut render.tf {
        find_transfer(folder, transfer);
    }
}

/// Resolves the file of `choice`, if it names one, for a session in `folder`.
fn find_transfer(folder: &Path, choice: &mut TransferChoice) {
    if let TransferChoice::File(tf) = choice {
        let (file, part) = tf.rsplit_once('#').map_or((&**tf, ""), |(file, _)| (file, &tf[file.len()..]));
        let whole = found(folder, tf);
        if let Some(found) = whole.or_else(|| Some(found(folder, file)? + part)) {
            *tf = found;
        }
    }
}

/// Resolves file names of further volumes in `read` for a session in `folder`.
pub fn find_layers(folder: &Path, read: &mut VolumeSettings) {
    for layer in read.overlay.iter_mut().flatten() {
        if let Some(found) = found(folder, &layer.source) {
            layer.source = found;
        }
        find_transfer(folder, &mut layer.transfer_function);
    }
}

/// Makes file names of further volumes in `read` absolute, and replaces transfer functions in files by their contents.
pub fn take_in_layers(read: &mut VolumeSettings) {
    for layer in read.overlay.iter_mut().flatten() {
        let path = path_of_text(&layer.source).into_owned();
        if path.exists() {
            layer.source = absolute(&path);
        }
        if let Some(json) = presets::json_of_file(&layer.transfer_function, None) {
            layer.transfer_function = json;
        }
    }
}

/// Replaces names of files in `render` by their contents, so that the files may change later. Weights and unreadable
/// files keep their names.
pub fn take_in(render: &mut RenderOverrides) {
    let json = render.tf.as_ref().and_then(|tf| presets::json_of_file(tf, render.tf_range));
    render.tf = json.or(render.tf.take());
    for setting in toml_files(render) {
        if let Some(text) = toml_text::of_file(setting) {
            *setting = text;
        }
    }
    if let Some(file) = weights_file(render).filter(|file| path_of_text(file).is_file()) {
        *file = absolute(&path_of_text(file));
    }
}

/// Names of TOML files in `render`, or texts in their place.
fn toml_files(render: &mut RenderOverrides) -> Vec<&mut String> {
    let path = match &mut render.path {
        Some(PathChoice::Toml(file)) => Some(file),
        _ => None,
    };
    let gaze = match &mut render.gaze {
        Some(GazeChoice::Toml(file)) => Some(file),
        _ => None,
    };
    path.into_iter().chain(gaze).collect()
}

/// File of weights in `render`, if they are not built in.
fn weights_file(render: &mut RenderOverrides) -> Option<&mut String> {
    render.weights.as_mut().filter(|name| Weights::shipped_file(name).is_none())
}

/// Resolves the file or folder `name` for a session in `folder`. An absolute path that no longer exists is looked for
/// below `folder`, by the shortest end of the path that exists there. `None` for an absolute path that exists, and if
/// nothing is found.
pub fn found(folder: &Path, name: &str) -> Option<String> {
    let path: &Path = &path_of_text(name);
    let ends: Vec<&Path> = match path.is_absolute() {
        false => vec![path],
        true if path.exists() => return None,
        true => path.ancestors().filter_map(|above| path.strip_prefix(above).ok()).collect(),
    };
    let places = ends.into_iter().filter(|end| !end.as_os_str().is_empty()).map(|end| folder.join(end));
    places.into_iter().find(|place| place.exists()).map(|place| text_of_path(&place))
}

/// Absolute form of `path`, as text.
pub fn absolute(path: &Path) -> String {
    text_of_path(&std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_path;
    use crate::volume::cube;
    use fovol_core::Camera;

    const PATH: &str =
        "# mine\n[[keyframe]] # the only one\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";

    fn saying(tf: String, path: String, gaze: String) -> RenderOverrides {
        let (tf, path, gaze) = (Some(tf.into()), Some(path.into()), Some(gaze.into()));
        RenderOverrides { tf, path, gaze, ..RenderOverrides::default() }
    }

    /// Cameras of frames 0 and 9.
    fn cameras(render: &RenderOverrides) -> [Camera; 2] {
        let path = camera_path(&render.resolve().unwrap(), &cube()).unwrap();
        [0, 9].map(|frame| path.camera(frame))
    }

    #[test]
    fn files_are_taken_in() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            folder.path().join(name).display().to_string()
        };
        let mut render = saying(
            file("tf.json", r#"{"points":[[0,0,0,0,0],[1,1,1,1,0.1]]}"#),
            file("path.toml", PATH),
            file("gaze.toml", "stops = [[0, 0.1, 0.2]]\n"),
        );
        let before = cameras(&render);
        take_in(&mut render);
        std::fs::remove_dir_all(folder.path()).unwrap();
        assert!(matches!(render.tf, Some(TransferChoice::Json(_))), "{render:?}");
        assert_eq!(cameras(&render), before);
        assert_eq!(render.resolve().unwrap().gaze.gaze(0), [0.1, 0.2]);
        // Embedded text is not looked up as a file.
        let taken = render.clone();
        find(Path::new("/"), &mut render);
        take_in(&mut render);
        assert_eq!(render, taken);
    }

    #[test]
    fn names_and_what_cannot_be_read_stay() {
        let mut render = saying("viridis".into(), "orbit".into(), "0.3,0.4".into());
        let named = render.clone();
        take_in(&mut render);
        find(Path::new("/"), &mut render);
        assert_eq!(render, named);
        let mut render = saying("gone.json#part".into(), "gone.toml".into(), "wander".into());
        let named = render.clone();
        take_in(&mut render);
        assert_eq!(render, named);
    }

    #[test]
    fn parts_of_files_beside_a_session_are_found() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("maps.json"), "[]").unwrap();
        let mut render = RenderOverrides { tf: Some("maps.json#Cool".into()), ..RenderOverrides::default() };
        find(folder.path(), &mut render);
        let expected = format!("{}#Cool", folder.path().join("maps.json").display());
        assert_eq!(render.tf, Some(TransferChoice::File(expected)));
    }
}
