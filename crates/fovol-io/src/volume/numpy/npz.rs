//! `.npz`: zip archives of `.npy` files.

use super::header::{self, Header};
use super::{Array, remark};
use crate::Result;
use crate::volume::array_axes::{ArrayAxes, likeliest};
use crate::volume::zip::{Member, members};
use crate::volume::{Overrides, Source};
use fovol_core::{Contents, Volume};

/// Whether `bytes` begin as archives of `.npy` files do.
pub fn is_npz(bytes: &[u8]) -> bool {
    let length = bytes.get(26..28).map(|length| usize::from(u16::from_le_bytes([length[0], length[1]])));
    let name = length.and_then(|length| bytes.get(30..30 + length));
    bytes.starts_with(b"PK\x03\x04") && name.is_some_and(|name| name.ends_with(b".npy"))
}

/// Reads the chosen array of a `.npz` file, else the only one with three axes, else the largest. Stored arrays in C
/// order stay mapped.
///
/// # Errors
/// A damaged archive, no array that is a volume, and the errors of [`super::parse`].
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let found: Vec<Found> =
        members(source)?.into_iter().filter_map(|member| Found::of(source, member)).collect();
    let shown = shown(source, &found, overrides)?;
    // A chosen array that is no volume says why.
    let header = shown.header.clone().map_err(|problem| remark(source, &problem))?;
    let listed: Vec<&Found> =
        found.iter().filter(|array| array.axes.is_ok() || array.name == shown.name).collect();
    let contents = Contents {
        arrays: listed.iter().map(|array| array.name.clone()).collect(),
        array: listed.iter().position(|array| array.name == shown.name).unwrap_or_default(),
        ..Contents::default()
    };
    let (bytes, start) = shown.member.bytes(source)?;
    Array { source, header, bytes, start }.volume(overrides, contents)
}

/// An array in an archive.
struct Found {
    name: String,
    member: Member,
    header: std::result::Result<Header, String>,
    axes: std::result::Result<ArrayAxes, String>,
}

/// Bytes of a member that hold most headers.
const MOST_HEADERS: usize = 256;

impl Found {
    /// The array in `member`, if that is one.
    fn of(source: &Source, member: Member) -> Option<Self> {
        let name = member.name.strip_suffix(".npy")?.to_owned();
        let header = read_header(source, &member);
        let axes = header.as_ref().map_err(String::clone).and_then(|header| ArrayAxes::of(&header.shape));
        Some(Self { name, member, header, axes })
    }
}

fn read_header(source: &Source, member: &Member) -> std::result::Result<Header, String> {
    let begin = |count| member.beginning(source, count).map_err(|_| "cannot be unpacked".to_owned());
    let start = begin(MOST_HEADERS)?;
    let length = header::length(&start)?;
    match length > start.len() {
        true => header::parse(&begin(length)?),
        false => header::parse(&start),
    }
}

/// The array to show.
fn shown<'a>(source: &Source, found: &'a [Found], overrides: &Overrides) -> Result<&'a Found> {
    if let Some(chosen) = &overrides.array {
        let names: Vec<String> = found.iter().map(|array| array.name.clone()).collect();
        return found
            .iter()
            .find(|array| array.name == *chosen)
            .ok_or_else(|| Overrides::no_array(source, chosen, &names));
    }
    let best = likeliest(found.iter().map(|array| array.axes.as_ref().ok())).map(|index| &found[index]);
    match (best, found) {
        (Some(best), _) => Ok(best),
        (None, []) => Err(source.malformed("it holds no arrays of NumPy; save one with numpy.savez")),
        (None, [only]) => Ok(only),
        (None, _) => Err(source.malformed("none of its arrays is a volume; save one with the axes z, y, x")),
    }
}
