use crate::{Error, Result};
use fovol_core::{input, path_of_text};
use serde::Deserialize;

/// Parses the TOML file that `text` names, or `text` itself if it is TOML. `flag` is the flag that it belongs to, and
/// `expected` describes the accepted values, for error messages.
pub fn read<T: for<'de> Deserialize<'de>>(text: &str, flag: &str, expected: &str) -> Result<T> {
    let path = path_of_text(text);
    let (what, text) = if path.exists() {
        (text, input::read_to_string(&path).map_err(|e| fovol_io::Error::io("read", &path, e))?)
    } else if text.contains('=') {
        (flag, text.to_owned())
    } else {
        return Err(Error::Setting(format!("`{text}` is no file; {flag} takes {expected}")));
    };
    toml::from_str(&text)
        .map_err(|e| Error::Setting(format!("{what}, {}; {flag} takes {expected}", problem(&text, &e))))
}

/// Formats `error` of parsing `text`, with its line number.
pub fn problem(text: &str, error: &toml::de::Error) -> String {
    let end = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text.as_bytes()[..end].iter().filter(|&&byte| byte == b'\n').count();
    format!("line {line}: {}", error.message().lines().next().unwrap_or_default())
}

/// Contents of the file `name`, if [`read`] would read it as a file.
#[cfg(feature = "files")]
pub fn of_file(name: &str) -> Option<String> {
    let path = path_of_text(name);
    if !path.is_file() {
        return None;
    }
    input::read_to_string(&path).ok().filter(|text| text.contains('='))
}
