use super::TransferChoice;
use fovol_core::path_of_text;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A further volume on the box of the first, as the text `FILE` or `FILE@TF`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct LayerChoice {
    /// File, folder or procedural name, as for the first volume.
    pub source: String,
    /// Its transfer function.
    pub transfer_function: TransferChoice,
}

impl FromStr for LayerChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Names of files may have an @ too.
        let parts = match text.split_once("@{") {
            Some((source, json)) => Some((source, format!("{{{json}"))),
            None if path_of_text(text).exists() => None,
            None => text.rsplit_once('@').map(|(source, name)| (source, name.to_owned())),
        };
        let (source, transfer_function) = match parts {
            Some((source, name)) => (source, name.into()),
            None => (text, TransferChoice::Auto),
        };
        if source.is_empty() {
            return Err(format!("`{text}` names no file; give FILE or FILE@TF"));
        }
        Ok(Self { source: source.to_owned(), transfer_function })
    }
}

impl TryFrom<String> for LayerChoice {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for LayerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.source)?;
        match &self.transfer_function {
            TransferChoice::Auto => Ok(()),
            chosen => write!(f, "@{chosen}"),
        }
    }
}

impl From<LayerChoice> for String {
    fn from(choice: LayerChoice) -> Self {
        choice.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_read_back() {
        let json = r#"{"points":[[0,0,0,0,0],[1,1,1,1,1]]}"#;
        for (text, source, transfer) in [
            ("pet.nii", "pet.nii", TransferChoice::Auto),
            ("me@home.nii@magma", "me@home.nii", TransferChoice::Named("magma".into())),
            ("pet.nii@mine.json#PET", "pet.nii", TransferChoice::File("mine.json#PET".into())),
            (&format!("pet.nii@{json}"), "pet.nii", TransferChoice::Json(json.into())),
        ] {
            let choice: LayerChoice = text.parse().unwrap();
            assert_eq!((choice.source.as_str(), &choice.transfer_function), (source, &transfer), "{text}");
            assert_eq!(choice.to_string(), text);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("me@home.nii");
        std::fs::write(&path, "").unwrap();
        let choice: LayerChoice = path.to_str().unwrap().parse().unwrap();
        assert_eq!(choice.source, path.to_str().unwrap());
        assert!("@magma".parse::<LayerChoice>().is_err());
    }
}
