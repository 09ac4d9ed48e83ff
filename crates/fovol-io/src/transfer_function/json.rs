//! Transfer functions in JSON: our own, and those of ParaView and vtk.js.

use super::imported::{Imported, UNKNOWN, chosen};
use super::paraview;
use super::volume_property::Lists;
use crate::{Error, Result};
use serde_json::Value;
use std::borrow::Cow;
use std::path::Path;

/// One transfer function of a file.
enum Entry<'a> {
    Map(&'a Value),
    Property(Lists),
}

/// Reads `text`: our JSON, or one object or a list of them, of which the one called `name` is taken, else the first.
pub fn parse(path: &Path, text: &str, name: Option<&str>) -> Result<Imported> {
    let json: Value = serde_json::from_str(&without_last_commas(text))
        .map_err(|e| Error::malformed(path, format!("it is damaged JSON ({e}); save it again")))?;
    if json.get("points").is_some() {
        let transfer = serde_json::from_value(json).map_err(|e| Error::malformed(path, e.to_string()))?;
        return Ok(Imported::of(transfer));
    }
    let single = std::slice::from_ref(&json);
    let objects = json.as_array().map_or(single, Vec::as_slice);
    let entries: Vec<(String, Entry<'_>)> = objects.iter().filter_map(entry).collect();
    if entries.is_empty() {
        return Err(Error::malformed(path, UNKNOWN));
    }
    let names: Vec<&str> = entries.iter().map(|(name, _)| &**name).collect();
    let (index, note) = chosen(path, &names, name)?;
    let mut imported = match &entries[index].1 {
        Entry::Map(map) => paraview::parse(path, map)?,
        Entry::Property(lists) => lists.read(path)?,
    };
    imported.notes.splice(0..0, note);
    Ok(imported)
}

fn entry(json: &Value) -> Option<(String, Entry<'_>)> {
    if paraview::is_map(json) {
        let name = json.get("Name").and_then(Value::as_str).unwrap_or("unnamed");
        return Some((name.to_owned(), Entry::Map(json)));
    }
    let lists = Lists::of_json(json)?;
    Some((lists.name.clone(), Entry::Property(lists)))
}

/// `text` without commas before closing brackets: ParaView reads and ships such files.
fn without_last_commas(text: &str) -> Cow<'_, str> {
    let (mut is_text, mut is_escaped) = (false, false);
    let mut comma = None;
    let mut commas = Vec::new();
    for (i, byte) in text.bytes().enumerate() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if is_text => is_escaped = true,
            b'"' => (is_text, comma) = (!is_text, None),
            _ if is_text || byte.is_ascii_whitespace() => {}
            b',' => comma = Some(i),
            b']' | b'}' => commas.extend(comma.take()),
            _ => comma = None,
        }
    }
    let mut rest = 0;
    let mut kept = String::new();
    for &i in &commas {
        kept.push_str(&text[rest..i]);
        rest = i + 1;
    }
    if commas.is_empty() { Cow::Borrowed(text) } else { Cow::Owned(kept + &text[rest..]) }
}
