//! An open HDF5 file: its groups, datasets and attributes, and errors in our words.

use super::limits::{BYTES_PER_BYTE, FREE_BYTES};
use super::{lzf, packed};
use crate::volume::cf::{Attribute, Attributes};
use crate::volume::{Source, reals};
use crate::{Error, Result};
use fovol_core::VoxelBytes;
use hdf5_reader::error::Error as Problem;
use hdf5_reader::group::Group;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::{Dataset, FilterRegistry, Hdf5File, OpenOptions};
use std::collections::HashSet;

/// First bytes of an HDF5 file, after a block of the user's own whose length is 0, 512 or a greater power of two.
const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Longest block of the user's own that is passed over.
const LONGEST_USER_BLOCK: usize = 1 << 20;

/// Datasets that are listed at most, and the depth of groups in which they are looked for.
const MOST_DATASETS: usize = 1 << 12;
const DEEPEST: usize = 16;

/// Where the HDF5 file in `bytes` begins; none if it is none.
pub fn start(bytes: &[u8]) -> Option<usize> {
    let places = std::iter::once(0).chain((9..).map(|power| 1 << power));
    let mut places = places.take_while(|&at| at <= LONGEST_USER_BLOCK && at < bytes.len());
    places.find(|&at| bytes[at..].starts_with(MAGIC))
}

/// A dataset and its path.
pub type Named = (String, Dataset);

/// An open file.
pub struct File<'a> {
    /// The bytes.
    pub source: &'a Source,
    /// Where the file begins in `source`.
    pub start: usize,
    inner: Hdf5File,
}

/// Shared bytes from a place on.
struct Tail(VoxelBytes, usize);

impl AsRef<[u8]> for Tail {
    fn as_ref(&self) -> &[u8] {
        &(*self.0).as_ref()[self.1..]
    }
}

impl<'a> File<'a> {
    /// Opens the file in `source`. Nothing is copied.
    ///
    /// # Errors
    /// Damage.
    pub fn open(source: &'a Source) -> Result<Self> {
        let start = start(source.bytes())
            .ok_or_else(|| source.malformed("it does not begin like an HDF5 file; is the name right?"))?;
        let mut filters = FilterRegistry::new();
        filters.register(lzf::FILTER, Box::new(|filter, data, _| lzf::unpacked(filter, data)));
        filters.register(packed::BLOSC, Box::new(|_, data, _| packed::of_blosc(data)));
        filters.register(packed::LZ4, Box::new(|_, data, _| packed::of_lz4(data)));
        let length = source.bytes().len();
        let options = OpenOptions::default()
            .with_chunk_cache_bytes(0)
            .with_filter_registry(filters)
            .with_max_chunk_bytes(length.saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES))
            .with_max_object_header_bytes(length);
        let inner = Hdf5File::from_owner(Tail(source.shared(), start), options);
        Ok(Self { source, start, inner: inner.map_err(|problem| failed(source, problem))? })
    }

    /// The error for `problem`.
    pub fn failed(&self, problem: Problem) -> Error {
        failed(self.source, problem)
    }

    /// The group at `path`; none if there is none.
    pub fn group(&self, path: &str) -> Option<Group> {
        self.inner.group(path).ok()
    }

    /// The dataset at `path`; none if there is none.
    ///
    /// # Errors
    /// A dataset that cannot be read.
    pub fn dataset(&self, path: &str) -> Result<Option<Dataset>> {
        match self.inner.dataset(path) {
            Ok(dataset) => Ok(Some(dataset)),
            Err(problem) if is_missing(&problem) => Ok(None),
            Err(problem) => Err(self.failed(problem)),
        }
    }

    /// All datasets with their paths, as far as they can be read, and the names of links to other files.
    ///
    /// # Errors
    /// A damaged root group.
    pub fn datasets(&self) -> Result<(Vec<Named>, Vec<String>)> {
        let root = self.inner.root_group().map_err(|problem| self.failed(problem))?;
        root.member_names().map_err(|problem| self.failed(problem))?;
        let mut walk = Walk { file: self, seen: HashSet::new(), found: Vec::new(), outside: Vec::new() };
        walk.add(&root, "", 0);
        Ok((walk.found, walk.outside))
    }

    /// The messages of the object header at `address`.
    pub fn header(&self, address: u64) -> Option<std::sync::Arc<hdf5_reader::object_header::ObjectHeader>> {
        self.inner.get_or_parse_header(address).ok()
    }

    /// Bytes of a reference to an object.
    pub fn reference_size(&self) -> usize {
        usize::from(self.inner.superblock().offset_size)
    }
}

/// A walk through all groups.
struct Walk<'a> {
    file: &'a File<'a>,
    /// Addresses of groups: links may go round in circles.
    seen: HashSet<u64>,
    found: Vec<Named>,
    outside: Vec<String>,
}

impl Walk<'_> {
    fn add(&mut self, group: &Group, path: &str, depth: usize) {
        if depth > DEEPEST || !self.seen.insert(group.address()) {
            return;
        }
        self.add_links(group, path);
        let Ok((groups, datasets)) = group.member_names() else { return };
        for name in datasets {
            if self.found.len() >= MOST_DATASETS {
                return;
            }
            if let Ok(dataset) = group.dataset(&name) {
                self.found.push((format!("{path}/{name}"), dataset));
            }
        }
        for name in groups {
            if self.found.len() < MOST_DATASETS
                && let Ok(inner) = group.group(&name)
            {
                self.add(&inner, &format!("{path}/{name}"), depth + 1);
            }
        }
    }

    /// Notes links to other files in `group`, which are not followed.
    fn add_links(&mut self, group: &Group, path: &str) {
        let Some(header) = self.file.header(group.address()) else { return };
        for message in &header.messages {
            if let HdfMessage::Link(link) = message
                && let hdf5_reader::messages::link::LinkTarget::External { filename, .. } = &link.target
            {
                self.outside.push(format!("{path}/{} in {filename}", link.name));
            }
        }
    }
}

fn is_missing(problem: &Problem) -> bool {
    match problem {
        Problem::Context { source, .. } => is_missing(source),
        Problem::GroupNotFound(_) | Problem::DatasetNotFound(_) => true,
        _ => false,
    }
}

/// The error for `problem` in `source`.
fn failed(source: &Source, problem: Problem) -> Error {
    match problem {
        Problem::Context { source: problem, .. } => failed(source, *problem),
        Problem::UnsupportedFilter(filter) => source.unsupported(format!(
            "it is compressed by {}, which is not read; pack it anew with `h5repack -f GZIP=5 IN OUT`",
            filter_name(&filter)
        )),
        Problem::UnsupportedEncoding(_) => {
            source.unsupported(format!("{problem}; copy the dataset with h5py or h5repack"))
        }
        Problem::ResourceLimit(_) => source.malformed(format!(
            "it promises more than so small a file can hold ({problem}); copy or download it again"
        )),
        _ => source.malformed(format!("it is damaged ({problem}); copy or download it again")),
    }
}

/// The name of the filter in a message such as "filter id 32001".
fn filter_name(filter: &str) -> String {
    let number = filter.rsplit(' ').next().and_then(|number| number.parse().ok()).unwrap_or(0u32);
    let name = match number {
        307 => "bzip2",
        32008 => "bitshuffle",
        32013 => "ZFP",
        32015 => "Zstandard",
        32017 => "SZ",
        32026 => "Blosc2",
        _ => return filter.to_owned(),
    };
    format!("{name} (filter {number})")
}

/// Attributes of a dataset or group.
pub fn attributes(attributes: &[hdf5_reader::Attribute]) -> Attributes {
    Attributes(attributes.iter().filter_map(|found| Some((found.name.clone(), value(found)?))).collect())
}

/// The numbers or the text of an attribute.
fn value(found: &hdf5_reader::Attribute) -> Option<Attribute> {
    if let Ok(element) = super::element::Element::of(&found.datatype) {
        let numbers = reals::decoded(&found.raw_data, element.dtype, element.endian);
        return Some(Attribute::Numbers(numbers));
    }
    let texts = found.read_strings().or_else(|_| found.read_string().map(|text| vec![text])).ok()?;
    // Some writers store text as an array of single characters.
    let is_characters = texts.iter().all(|text| text.chars().count() <= 1);
    let text = texts.join(if is_characters { "" } else { " " });
    Some(Attribute::Text(text.trim_end_matches('\0').to_owned()))
}
