//! Metadata of OME-Zarr. <https://ngff.openmicroscopy.org/0.5/>.

mod labels;
mod multiscale;
mod omero;

use super::json::Object;
pub use labels::{is_label, labels};
pub use multiscale::{Level, Multiscale, USUAL_AXES};
pub use omero::channels;
use serde_json::Value;

/// The metadata of OME in the attributes of a group: under `ome` from version 0.5 on, else among the others.
pub fn metadata(attributes: &Object) -> &Object {
    attributes.get("ome").and_then(Value::as_object).unwrap_or(attributes)
}

/// Whether a group with these attributes is an image.
pub fn is_image(attributes: &Object) -> bool {
    metadata(attributes).get("multiscales").and_then(Value::as_array).is_some_and(|list| !list.is_empty())
}
