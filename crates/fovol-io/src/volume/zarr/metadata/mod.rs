//! Metadata of arrays and groups, of versions 2 and 3 alike.

mod v2;
mod v3;

use super::codec::Chain;
use super::element::Element;
use super::json::Object;
pub use v2::{array as array_v2, group as group_v2};
pub use v3::node as node_v3;

/// Most axes of an array.
const MOST_AXES: usize = 32;

/// A group or an array.
#[derive(Debug)]
pub enum Node {
    /// A group, by its attributes.
    Group(Object),
    /// An array, or what is wrong with it.
    Array(Result<Box<Array>, String>),
}

/// Names of the files of chunks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Keys {
    /// Text before the numbers.
    pub prefix: &'static str,
    /// Character between them.
    pub separator: char,
}

/// An array in chunks of equal shape.
#[derive(Debug)]
pub struct Array {
    /// Lengths of the axes.
    pub shape: Vec<usize>,
    /// Shape of a chunk, or of a shard.
    pub chunk: Vec<usize>,
    /// The type of decoded values.
    pub element: Element,
    /// The value of chunks that are not stored, in the byte order of `element`.
    pub fill: Vec<u8>,
    /// The encoding of a chunk.
    pub codecs: Chain,
    /// Names of the files of chunks.
    pub keys: Keys,
    /// Names of the axes, where they have any.
    pub names: Vec<Option<String>>,
    /// The user's attributes.
    pub attributes: Object,
    /// Whether the fill value marks voxels without data, as xarray writes it.
    pub fill_is_missing: bool,
}

impl Array {
    /// The file of the chunk at `coordinates`, in the folder of the array.
    pub fn key(&self, coordinates: &[usize]) -> String {
        let Keys { prefix, separator } = self.keys;
        let mut key = String::from(prefix);
        for (axis, number) in coordinates.iter().enumerate() {
            if axis > 0 || !prefix.is_empty() {
                key.push(separator);
            }
            key.push_str(&number.to_string());
        }
        key
    }

    /// Bytes of a decoded chunk; none on overflow.
    pub fn chunk_length(&self) -> Option<usize> {
        product(&self.chunk)?.checked_mul(self.element.size())
    }
}

/// The product of `lengths`; none on overflow.
pub fn product(lengths: &[usize]) -> Option<usize> {
    lengths.iter().try_fold(1usize, |product, &length| product.checked_mul(length))
}

/// Checks that `shape` and `chunk` have the same axes, no more than usual, and that chunks are not empty.
fn check_shapes(shape: &[usize], chunk: &[usize]) -> Result<(), String> {
    if shape.len() != chunk.len() {
        return Err(format!("has {} axes, but its chunks have {}; write it again", shape.len(), chunk.len()));
    }
    if shape.len() > MOST_AXES {
        return Err(format!("has {} axes; no more than {MOST_AXES} are read", shape.len()));
    }
    if chunk.contains(&0) || product(chunk).is_none_or(|values| values > isize::MAX as usize / 16) {
        return Err("has chunks of an impossible shape; write it again".into());
    }
    Ok(())
}
