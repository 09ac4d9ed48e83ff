mod files;

use crate::settings::toml_text;
use crate::{
    Error, LayerChoice, PlannedFrames, RenderOverrides, Result, Sampling, TransferChoice, VolumeSettings,
    presets,
};
use fovol_core::{input, path_of_text};
use fovol_net::Weights;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{Read, Write};
use std::path::Path;

/// Everything that a picture depends on, as one TOML file. Rendering it again gives the same pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Session {
    /// The volume: a path as [`fovol_core::text_of_path`] writes it, relative to the session file, or a procedural
    /// name. A file that has moved is looked for beside the session file.
    pub volume: String,
    /// SHA-256 of the volume's file, if it is a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_sha256: Option<String>,
    /// SHA-256 of the files of further volumes, in order; empty where one is no file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overlay_sha256: Vec<String>,
    /// SHA-256 of the weights, if a network with known weights reconstructs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights_sha256: Option<String>,
    /// Settings for reading the volume's file, such as its dimensions.
    #[serde(default, skip_serializing_if = "is_default")]
    pub read: VolumeSettings,
    /// Settings for rendering.
    #[serde(default)]
    pub render: RenderOverrides,
    /// How a planner with a budget made the frames. Rendering them again follows this.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plan: Vec<PlannedFrames>,
}

fn is_default(settings: &VolumeSettings) -> bool {
    *settings == VolumeSettings::default()
}

impl Session {
    /// Session of the volume `source`, see [`crate::open_volume`], with the hash of its file if it is one.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub fn new(source: &str, mut read: VolumeSettings, render: RenderOverrides) -> Result<Self> {
        let path = path_of_text(source);
        // The array of a name such as `FILE:ARRAY` becomes a setting, so that the file can be found and checked.
        let (path, array) = fovol_io::volume::split_array(&path);
        let named = fovol_core::text_of_path(&path);
        let source = if array.is_some() { &named } else { source };
        if let (Some(other), Some(named)) = (&read.array, &array)
            && other != named
        {
            return Err(Error::Setting(format!(
                "the name of the volume chooses the array {named}, --array {other}; leave one of them out"
            )));
        }
        read.array = read.array.or(array);
        let volume_sha256 = if path.is_file() { Some(sha256(&path)?) } else { None };
        let is_file = path.exists() || fovol_io::volume::is_pattern(&path);
        let volume = if is_file { files::absolute(&path) } else { source.to_owned() };
        let overlay_sha256 = hashes_of_layers(&read)?;
        Ok(Self {
            volume,
            volume_sha256,
            overlay_sha256,
            weights_sha256: None,
            read,
            render,
            plan: Vec::new(),
        })
    }

    /// Reads a session file. Relative paths count from its folder. Absolute paths that no longer exist are looked for
    /// there, too.
    ///
    /// # Errors
    /// A missing file, unknown fields.
    pub fn read(path: &Path) -> Result<Self> {
        let text = input::read_to_string(path).map_err(|e| fovol_io::Error::io("read", path, e))?;
        let mut session: Self = toml::from_str(&text).map_err(|e| {
            Error::Setting(format!(
                "{}, {}{}",
                path.display(),
                toml_text::problem(&text, &e),
                advice(e.message())
            ))
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        if let Some(found) = files::found(folder, &session.volume) {
            session.volume = found;
        }
        files::find(folder, &mut session.render);
        files::find_layers(folder, &mut session.read);
        Ok(session)
    }

    /// Writes the session to `path`, with the current hash of its weights.
    ///
    /// # Errors
    /// Errors of writing the file.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = toml::to_string(&self.clone().sealed())
            .map_err(|e| Error::Setting(format!("the session cannot be written: {e}")))?;
        fovol_io::atomic::write(path, |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// Checks that the volume of the session, which was read from `file`, is there.
    ///
    /// # Errors
    /// A missing volume, unless its name may be that of a procedural one.
    pub fn check_volume(&self, file: &Path) -> Result<()> {
        let is_path = self.volume_sha256.is_some() || self.volume.contains(['.', '/', '\\']);
        let path = path_of_text(&self.volume);
        if !is_path
            || path.exists()
            || fovol_io::volume::is_remote(&path)
            || fovol_io::volume::is_pattern(&path)
        {
            return Ok(());
        }
        Err(Error::Setting(format!(
            "there is no {}, the volume of {1}; put it beside {1}, or mend `volume =` there",
            self.volume,
            file.display()
        )))
    }

    /// Checks that the volumes of the session, which was read from `file`, are as they were when it was saved.
    ///
    /// # Errors
    /// Changed files, errors of reading them.
    pub fn check_unchanged(&self, file: &Path) -> Result<()> {
        if self.volume_is_unchanged()? {
            return Ok(());
        }
        Err(Error::Setting(format!(
            "{} has changed since {} was saved; save the session again, or restore the volume",
            self.volume,
            file.display()
        )))
    }

    /// Checks the transfer function that stands in the session, which was read from `file`.
    ///
    /// # Errors
    /// Damaged JSON, wrong points.
    pub fn check_transfer_function(&self, file: &Path) -> Result<()> {
        let Some(TransferChoice::Json(text)) = &self.render.tf else { return Ok(()) };
        let of_file = |problem| Error::Setting(format!("`tf` in {} {problem}", file.display()));
        presets::of_json(text).map(drop).map_err(of_file)
    }

    /// Whether the files of the volumes still have the hashes in the session; true if there are none.
    ///
    /// # Errors
    /// Errors of reading a file.
    pub fn volume_is_unchanged(&self) -> Result<bool> {
        if !self.overlay_sha256.is_empty() && hashes_of_layers(&self.read)? != self.overlay_sha256 {
            return Ok(false);
        }
        let path = path_of_text(&self.volume);
        match &self.volume_sha256 {
            Some(expected) if path.is_file() => Ok(sha256(&path)? == *expected),
            _ => Ok(true),
        }
    }

    /// Completes the session for saving: with the current hash of its weights, and with the contents of named files in
    /// place of their names. The volume and the weights are too large for that; they get absolute paths.
    #[must_use]
    pub fn sealed(self) -> Self {
        // Missing weights do not prevent saving everything else.
        let weights_sha256 = self.hash_of_weights().ok().flatten();
        let mut sealed = Self { weights_sha256, ..self };
        files::take_in(&mut sealed.render);
        files::take_in_layers(&mut sealed.read);
        sealed
    }

    /// Whether the weights still have the hash in the session; true if there is no hash.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub fn weights_are_unchanged(&self) -> Result<bool> {
        match &self.weights_sha256 {
            Some(expected) => Ok(self.hash_of_weights()?.is_none_or(|hash| hash == *expected)),
            None => Ok(true),
        }
    }

    /// Hash of the weights, if a network reconstructs.
    fn hash_of_weights(&self) -> Result<Option<String>> {
        let render = &self.render;
        if render.sampling() == Sampling::Full {
            return Ok(None);
        }
        let Some(network) =
            render.reconstruction().default_network().filter(|_| render.random_weights.is_none())
        else {
            return Ok(None);
        };
        let name = render.weights.as_deref().unwrap_or(network.name());
        let path = path_of_text(name);
        if path.exists() {
            return Ok(Some(sha256(&path)?));
        }
        let shipped = Weights::shipped_file(name);
        Ok(shipped.map(|file| hex(&Sha256::digest(file))))
    }
}

/// SHA-256 of the files of further volumes; empty where one is no file.
fn hashes_of_layers(read: &VolumeSettings) -> Result<Vec<String>> {
    let of = |layer: &LayerChoice| {
        let path = path_of_text(&layer.source);
        if path.is_file() { sha256(&path) } else { Ok(String::new()) }
    };
    read.overlay.iter().flatten().map(of).collect()
}

/// Advice for `problem`, unless its message already lists the accepted words.
fn advice(problem: &str) -> &'static str {
    match problem.contains("expected") {
        true => "",
        false => {
            "; the words are volume, volume-sha256, weights-sha256, and tables [read] and [render] of flags without --"
        }
    }
}

fn sha256(path: &Path) -> Result<String> {
    let failed = |e| fovol_io::Error::io("read", path, e);
    let mut file = input::open(path).map_err(failed)?;
    let mut hasher = Sha256::new();
    let mut piece = vec![0u8; 1 << 20];
    loop {
        let read = file.read(&mut piece).map_err(failed)?;
        if read == 0 {
            break;
        }
        hasher.update(&piece[..read]);
    }
    Ok(hex(&hasher.finalize()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PathChoice, Reconstruction};

    #[test]
    fn sessions_read_back_and_notice_a_changed_volume() {
        let folder = tempfile::tempdir().unwrap();
        let volume = folder.path().join("v_2x2x2_uint8.raw");
        std::fs::write(&volume, [1u8; 8]).unwrap();
        let render = RenderOverrides {
            pb: Some(0.07),
            noise: Some("blue".parse().unwrap()),
            reconstruct: Some("linear".parse().unwrap()),
            size: Some("64x48".parse().unwrap()),
            ..RenderOverrides::default()
        };
        let session = Session::new(volume.to_str().unwrap(), VolumeSettings::default(), render).unwrap();
        let path = folder.path().join("session.toml");
        session.write(&path).unwrap();
        assert_eq!(Session::read(&path).unwrap(), session);
        assert!(session.volume_is_unchanged().unwrap());
        std::fs::write(&volume, [2u8; 8]).unwrap();
        assert!(!session.volume_is_unchanged().unwrap());
    }

    #[test]
    fn other_weights_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let weights = folder.path().join("w.safetensors");
        std::fs::write(&weights, "of one kind").unwrap();
        let mut render = RenderOverrides { reconstruct: Some(Reconstruction::WNet), ..Default::default() };
        let path = folder.path().join("session.toml");
        let saved = |render: &RenderOverrides| {
            Session::new("head", VolumeSettings::default(), render.clone()).unwrap().write(&path).unwrap();
            Session::read(&path).unwrap()
        };
        let shipped = saved(&render);
        assert!(shipped.weights_sha256.is_some() && shipped.weights_are_unchanged().unwrap());
        render.weights = Some(weights.display().to_string());
        let own = saved(&render);
        assert_ne!(own.weights_sha256, shipped.weights_sha256);
        std::fs::write(&weights, "of another").unwrap();
        assert!(!own.weights_are_unchanged().unwrap());
        (render.reconstruct, render.weights) = (None, None);
        assert_eq!(saved(&render).weights_sha256, None);
    }

    #[test]
    fn files_are_found_from_anywhere() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mine.json"), r#"{"points":[[0,0,0,0,0],[1,1,1,1,1]]}"#).unwrap();
        let path = folder.path().join("session.toml");
        std::fs::write(&path, "volume = \"head\"\n[render]\ntf = \"mine.json\"\npath = \"orbit\"\n").unwrap();
        let read = Session::read(&path).unwrap();
        let expected = folder.path().join("mine.json").display().to_string();
        assert_eq!(read.render.tf, Some(TransferChoice::File(expected)));
        assert_eq!(read.render.path, Some(PathChoice::Orbit));
    }

    #[test]
    fn volumes_that_moved_with_their_session_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let name = "v_2x2x2_uint8.raw";
        for part in ["old/data", "new/data"] {
            std::fs::create_dir_all(at(part)).unwrap();
        }
        let volume = at("old/data").join(name);
        std::fs::write(&volume, [1u8; 8]).unwrap();
        let source = volume.display().to_string();
        let session = Session::new(&source, VolumeSettings::default(), RenderOverrides::default()).unwrap();
        session.write(&at("old/session.toml")).unwrap();
        assert_eq!(Session::read(&at("old/session.toml")).unwrap().volume, source);
        std::fs::copy(&volume, at("new/data").join(name)).unwrap();
        std::fs::copy(at("old/session.toml"), at("new/session.toml")).unwrap();
        std::fs::remove_dir_all(at("old")).unwrap();
        let moved = Session::read(&at("new/session.toml")).unwrap();
        assert_eq!(moved.volume, at("new/data").join(name).display().to_string());
        assert!(moved.volume_is_unchanged().unwrap());
        moved.check_volume(&at("new/session.toml")).unwrap();
        std::fs::copy(at("new/data").join(name), at("new").join(name)).unwrap();
        let beside = Session::read(&at("new/session.toml")).unwrap();
        assert_eq!(beside.volume, at("new").join(name).display().to_string());
        std::fs::write(at("new/v_2x2x2_uint8.raw"), [2u8; 8]).unwrap();
        assert!(!beside.volume_is_unchanged().unwrap());
        std::fs::remove_dir_all(at("new/data")).unwrap();
        std::fs::remove_file(at("new").join(name)).unwrap();
        let path = at("new/session.toml");
        let gone = Session::read(&path).unwrap().check_volume(&path).unwrap_err().to_string();
        assert!(
            gone.contains(&source) && gone.contains(&format!("put it beside {}", path.display())),
            "{gone}"
        );
    }

    #[test]
    fn transfer_functions_are_blamed_on_their_session() {
        let checked = |tf: &str| {
            let render = RenderOverrides { tf: Some(tf.into()), ..Default::default() };
            let session = Session::new("head", VolumeSettings::default(), render).unwrap();
            session.check_transfer_function(Path::new("s.toml"))
        };
        checked("viridis").unwrap();
        checked(r#"{"points":[[0,0,0,0,0],[1,1,1,1,1]]}"#).unwrap();
        let said = checked(r#"{"points":[[0,0,0,0,2]]}"#).unwrap_err().to_string();
        assert!(said.starts_with("`tf` in s.toml cannot be read: ") && !said.contains("--tf"), "{said}");
    }

    #[test]
    fn an_unknown_word_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session.toml");
        std::fs::write(&path, "volume = \"head\"\n\n[render]\npb = 0.1\nsgima = 3\n").unwrap();
        let error = Session::read(&path).unwrap_err().to_string();
        assert!(error.contains("line 5") && error.contains("sgima"), "{error}");
        assert!(error.contains("`sigma`") && !error.contains("README"), "{error}");
        std::fs::write(&path, "[render]\npb = 0.1\n").unwrap();
        let error = Session::read(&path).unwrap_err().to_string();
        assert!(error.contains("missing field `volume`") && error.contains("weights-sha256"), "{error}");
    }
}
