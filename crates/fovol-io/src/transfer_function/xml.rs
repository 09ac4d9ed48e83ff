//! Transfer functions in XML: Inviwo's `.itf` and 3D Slicer's `presets.xml`.

use super::imported::{Imported, chosen};
use super::inviwo;
use super::volume_property::Lists;
use crate::{Error, Result};
use quick_xml::Reader;
use quick_xml::events::Event;
use std::path::Path;

/// Reads `text`: the volume property called `name`, else the first one, else points of Inviwo.
pub fn parse(path: &Path, text: &str, name: Option<&str>) -> Result<Imported> {
    let mut reader = Reader::from_str(text);
    let mut properties = Vec::new();
    let mut points = inviwo::Points::default();
    loop {
        let event = reader
            .read_event()
            .map_err(|e| Error::malformed(path, format!("it is damaged XML ({e}); save it again")))?;
        match event {
            Event::Start(e) | Event::Empty(e) if e.name().as_ref() == "VolumeProperty" => {
                properties.push(Lists::of_element(&e));
            }
            Event::Start(e) | Event::Empty(e) => points.take(path, &e)?,
            Event::Eof => break,
            _ => {}
        }
    }
    if properties.is_empty() {
        return points.read(path);
    }
    let names: Vec<&str> = properties.iter().map(|property| &*property.name).collect();
    let (index, note) = chosen(path, &names, name)?;
    let mut imported = properties[index].read(path)?;
    imported.notes.splice(0..0, note);
    Ok(imported)
}
