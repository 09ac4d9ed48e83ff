use crate::presets::{is_name, text};
use fovol_core::TransferFunction;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Transfer function of a picture. Its text is a name, JSON, or anything else for [`Self::File`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum TransferChoice {
    /// The preset of a procedural volume, else one made from the histogram.
    #[default]
    Auto,
    /// Preset or colour map, see [`crate::presets::names`]. Case is ignored.
    Named(String),
    /// File, with `#NAME` for one of several functions in it.
    File(String),
    /// Content of a file of ours.
    Json(String),
    /// Function in memory. As text it is JSON.
    Function(TransferFunction),
}

/// Name of [`TransferChoice::Auto`].
const AUTO: &str = "auto";

impl TransferChoice {
    /// Name of the function, its file, or its JSON.
    pub fn text(&self) -> Cow<'_, str> {
        match self {
            Self::Auto => AUTO.into(),
            Self::Named(text) | Self::File(text) | Self::Json(text) => text.into(),
            Self::Function(function) => text(function).into(),
        }
    }
}

impl From<TransferFunction> for TransferChoice {
    fn from(function: TransferFunction) -> Self {
        Self::Function(function)
    }
}

impl From<String> for TransferChoice {
    fn from(text: String) -> Self {
        if text == AUTO {
            Self::Auto
        } else if text.trim_start().starts_with('{') {
            Self::Json(text)
        } else if is_name(&text) {
            Self::Named(text)
        } else {
            Self::File(text)
        }
    }
}

impl From<&str> for TransferChoice {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<TransferChoice> for String {
    fn from(choice: TransferChoice) -> Self {
        choice.text().into_owned()
    }
}

impl fmt::Display for TransferChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_read_back() {
        let ramp = TransferFunction::grey_ramp(0.3);
        let json = TransferChoice::Json(text(&ramp));
        for (text, choice) in [
            ("auto", TransferChoice::Auto),
            ("Viridis", TransferChoice::Named("Viridis".into())),
            ("maps.json#Cool", TransferChoice::File("maps.json#Cool".into())),
            (&*json.text(), json.clone()),
        ] {
            assert_eq!((TransferChoice::from(text), choice.to_string()), (choice, text.to_owned()));
        }
        assert_eq!(TransferChoice::from(ramp).text(), json.text());
    }
}
