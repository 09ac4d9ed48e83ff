//! The images and arrays of a hierarchy.

use super::hierarchy::{Hierarchy, joined};
use super::json::Object;
use super::metadata::{Array, Node};
use super::ome;
use crate::Result;
use serde_json::Value;

/// Entries that are listed at most, and the depth of groups in which they are looked for.
const MOST: usize = 1 << 12;
const DEEPEST: usize = 12;

/// An image of OME, or an array.
#[derive(Debug)]
pub struct Entry {
    /// Its path.
    pub path: String,
    /// Its metadata.
    pub content: Content,
}

/// The metadata of an entry.
#[derive(Debug)]
pub enum Content {
    /// A group with levels of resolution, by its attributes.
    Image(Object),
    /// An array alone, or what is wrong with it.
    Array(std::result::Result<Box<Array>, String>),
}

impl Entry {
    /// The name for people: the root has a slash.
    pub fn name(&self) -> &str {
        if self.path.is_empty() { "/" } else { &self.path }
    }

    /// Whether it is a label map.
    pub fn is_label(&self) -> bool {
        matches!(&self.content, Content::Image(attributes) if ome::is_label(ome::metadata(attributes), &self.path))
    }
}

/// All images and arrays in and below the group or array at `path`.
///
/// # Errors
/// No group or array there; metadata that cannot be read.
pub fn entries(hierarchy: &Hierarchy<'_>) -> Result<Vec<Entry>> {
    let mut found = Vec::new();
    add(hierarchy, "", 0, &mut found)?;
    Ok(found)
}

fn add(hierarchy: &Hierarchy<'_>, path: &str, depth: usize, found: &mut Vec<Entry>) -> Result<()> {
    if found.len() >= MOST || depth > DEEPEST {
        return Ok(());
    }
    let path = path.to_owned();
    match hierarchy.node(&path)? {
        None => Ok(()),
        Some(Node::Array(array)) => {
            found.push(Entry { path, content: Content::Array(array) });
            Ok(())
        }
        Some(Node::Group(attributes)) => {
            let children = children(hierarchy, &path, &attributes)?;
            if ome::is_image(&attributes) {
                found.push(Entry { path: path.clone(), content: Content::Image(attributes) });
            }
            for child in children.iter().filter_map(|child| joined(&path, child)) {
                add(hierarchy, &child, depth + 1, found)?;
            }
            Ok(())
        }
    }
}

/// Paths of the groups and arrays of interest in a group, from it on.
fn children(hierarchy: &Hierarchy<'_>, path: &str, attributes: &Object) -> Result<Vec<String>> {
    let metadata = ome::metadata(attributes);
    if ome::is_image(attributes) {
        // Its arrays are levels.
        return Ok(vec!["labels".into()]);
    }
    if let Some(names) = texts(metadata.get("labels")) {
        return Ok(names);
    }
    if let Some(plate) = metadata.get("plate") {
        return Ok(paths(plate.get("wells")));
    }
    if let Some(well) = metadata.get("well") {
        return Ok(paths(well.get("images")));
    }
    if metadata.contains_key("bioformats2raw.layout")
        && let Some(Node::Group(of_series)) = hierarchy.node(&joined(path, "OME").unwrap_or_default())?
        && let Some(names) = texts(ome::metadata(&of_series).get("series"))
    {
        return Ok(names);
    }
    Ok(hierarchy.store.folders(path))
}

/// A list of texts.
fn texts(value: Option<&Value>) -> Option<Vec<String>> {
    value?.as_array()?.iter().map(|text| text.as_str().map(str::to_owned)).collect()
}

/// The `path` of each object in a list.
fn paths(value: Option<&Value>) -> Vec<String> {
    let path = |entry: &Value| Some(entry.get("path")?.as_str()?.to_owned());
    value.and_then(Value::as_array).into_iter().flatten().filter_map(path).collect()
}

/// The entry at `path`, and the level of its image if `path` leads to the array of a level; none if there is none.
///
/// # Errors
/// Metadata that cannot be read.
pub fn entry_at(hierarchy: &Hierarchy<'_>, path: &str) -> Result<Option<(Entry, Option<usize>)>> {
    let Some(path) = joined("", path) else { return Ok(None) };
    match hierarchy.node(&path)? {
        Some(Node::Group(attributes)) if ome::is_image(&attributes) => {
            Ok(Some((Entry { path, content: Content::Image(attributes) }, None)))
        }
        Some(Node::Array(array)) => match image_of(hierarchy, &path)? {
            Some((entry, level)) => Ok(Some((entry, Some(level)))),
            None => Ok(Some((Entry { path, content: Content::Array(array) }, None))),
        },
        _ => Ok(None),
    }
}

/// The image that has the array at `path` as a level, and the number of that.
fn image_of(hierarchy: &Hierarchy<'_>, path: &str) -> Result<Option<(Entry, usize)>> {
    let parents = path.match_indices('/').map(|(at, _)| &path[..at]).rev().chain([""]);
    for parent in parents.filter(|parent| *parent != path) {
        let Some(Node::Group(attributes)) = hierarchy.node(parent)? else { continue };
        let Ok(image) = ome::Multiscale::of(ome::metadata(&attributes)) else { continue };
        let is_it = |level: &ome::Level| joined(parent, &level.path).as_deref() == Some(path);
        if let Some(level) = image.levels.iter().position(is_it) {
            return Ok(Some((Entry { path: parent.to_owned(), content: Content::Image(attributes) }, level)));
        }
    }
    Ok(None)
}
