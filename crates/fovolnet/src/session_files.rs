//! Files that a session's settings name. Reading a session finds them; writing one embeds their contents.

use crate::{RenderSettings, presets, toml_text};
use fovol_core::{path_of_text, text_of_path};
use fovol_net::Weights;
use fovol_net::plan::Named;
use std::path::{Path, PathBuf};

/// Resolves file names in `render` for a session in `folder`.
pub fn find(folder: &Path, render: &mut RenderSettings) {
    let settings = [&mut render.path, &mut render.gaze, &mut render.weights];
    for file in settings.into_iter().flatten().filter(|name| !is_known(name)) {
        if let Some(found) = found(folder, file) {
            *file = found;
        }
    }
    if let Some(tf) = render.tf.as_mut().filter(|tf| !is_known(tf) && !tf.trim_start().starts_with('{')) {
        let (file, part) = tf.rsplit_once('#').map_or((&**tf, ""), |(file, _)| (file, &tf[file.len()..]));
        let whole = found(folder, tf);
        if let Some(found) = whole.or_else(|| Some(found(folder, file)? + part)) {
            *tf = found;
        }
    }
}

/// Replaces names of files in `render` by their contents, so that the files may change later. Weights and unreadable
/// files keep their names.
pub fn take_in(render: &mut RenderSettings) {
    let RenderSettings { tf, tf_range, path, gaze, weights, .. } = render;
    if let Some(text) = tf.as_deref().and_then(|tf| presets::text_of_file(tf, *tf_range)) {
        *tf = Some(text);
    }
    for setting in [path, gaze].into_iter().flatten().filter(|name| !is_known(name)) {
        if let Some(text) = toml_text::of_file(setting) {
            *setting = text;
        }
    }
    if let Some(file) = weights.as_mut().filter(|file| !is_known(file) && path_of_text(file).is_file()) {
        *file = absolute(&path_of_text(file));
    }
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

/// Whether `name` is a built-in one that needs no file.
fn is_known(name: &str) -> bool {
    let names = ["orbit", "flythrough", "wander"];
    let weights = Weights::SHIPPED.map(Named::name);
    names.contains(&name) || weights.contains(&name) || presets::names().contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_path;
    use crate::world_box::tests::cube;

    const PATH: &str =
        "# mine\n[[keyframe]] # the only one\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";

    fn saying(tf: String, path: String, gaze: String) -> RenderSettings {
        RenderSettings { tf: Some(tf), path: Some(path), gaze: Some(gaze), ..RenderSettings::default() }
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
        let [path, gaze] = [
            camera_path(&render, &cube()).unwrap().camera(0),
            camera_path(&render, &cube()).unwrap().camera(9),
        ];
        take_in(&mut render);
        std::fs::remove_dir_all(folder.path()).unwrap();
        assert!(render.tf.as_ref().unwrap().starts_with("{\"points\":"), "{render:?}");
        let read = camera_path(&render, &cube()).unwrap();
        assert_eq!([read.camera(0), read.camera(9)], [path, gaze]);
        assert_eq!(render.fovea(0).unwrap().gaze, [0.1, 0.2]);
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
        let mut render = RenderSettings { tf: Some("maps.json#Cool".into()), ..RenderSettings::default() };
        find(folder.path(), &mut render);
        let expected = format!("{}#Cool", folder.path().join("maps.json").display());
        assert_eq!(render.tf, Some(expected));
    }
}
