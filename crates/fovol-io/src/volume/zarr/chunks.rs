//! The values of a part of an array: its chunks are read, unpacked and put in place by all threads at once.

use super::codec::{Chain, Layout, Scratch, Shards};
use super::hierarchy::{Hierarchy, key};
use super::metadata::{Array, product};
use super::store::Blob;
use super::target::Target;
use super::window::{Chunks, Window};
use crate::{Error, Result};
use fovol_core::memory::{self, Estimate};
use fovol_core::stop;
use rayon::prelude::*;

/// Advice for arrays that do not fit in memory.
const ADVICE: &str = "a coarser level of resolution needs less: --level N; or save a part of it";

/// Bytes that a volume may have whatever is stored of it.
const FREE: usize = 8 << 20;

/// Bytes of a volume that one stored byte stands for at most: other chunks have the fill value.
const SPARSEST: usize = 1 << 16;

/// Chunks that are looked for before an array counts as empty, and that a volume has at most.
const MOST_LOOKED_FOR: usize = 1 << 16;
const MOST_CHUNKS: usize = 1 << 21;

/// An array at its path.
#[derive(Clone, Copy)]
pub struct Chunked<'a> {
    /// The hierarchy that it is in.
    pub hierarchy: &'a Hierarchy<'a>,
    /// Its path.
    pub path: &'a str,
    /// Its metadata.
    pub array: &'a Array,
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    packed: Vec<u8>,
    scratch: Scratch,
}

/// One chunk in memory or in a file.
struct Stored<'a> {
    chain: &'a Chain,
    shape: &'a [usize],
    window: &'a Window,
}

impl Chunked<'_> {
    /// The values in `window`, which leads to `length` bytes of memory and has no two values at one place.
    ///
    /// # Errors
    /// Damaged chunks, too little memory, more values than so few chunks can stand for.
    pub fn read(&self, window: &Window, length: usize) -> Result<Vec<u8>> {
        let chunks = window.chunks(&self.array.chunk);
        if chunks.count() > MOST_CHUNKS {
            return Err(self.malformed(&format!(
                "has {} chunks; write it with larger ones, of a million voxels for one",
                chunks.count()
            )));
        }
        let scarce = |shortage| Error::memory(self.hierarchy.source.path(), shortage);
        self.justify(&chunks, length)?;
        Estimate::new("reading it").with("its values", length as u64).check(ADVICE).map_err(scarce)?;
        let mut out = memory::zeroed(length, "reading it", ADVICE).map_err(scarce)?;
        let target = Target::new(&mut out);
        (0..chunks.count()).into_par_iter().try_for_each_init(Buffers::default, |buffers, index| {
            stop::point();
            let coordinates = chunks.coordinates(index);
            let part = window.within(&coordinates, &self.array.chunk);
            self.read_chunk(&coordinates, &part, buffers, &target)
        })?;
        Ok(out)
    }

    fn malformed(&self, problem: &str) -> Error {
        self.hierarchy.malformed(self.path, problem)
    }

    fn key(&self, coordinates: &[usize]) -> String {
        key(self.path, &self.array.key(coordinates))
    }

    /// The error for the chunk at `coordinates`.
    fn damaged(&self, coordinates: &[usize], problem: &str) -> Error {
        let key = self.key(coordinates);
        self.hierarchy.source.malformed(format!(
            "its chunk `{key}` is damaged ({problem}); copy or download it again, or delete it to see the fill value there"
        ))
    }

    /// Writes the `window` of the chunk at `coordinates`.
    fn read_chunk(
        &self,
        coordinates: &[usize],
        window: &Window,
        buffers: &mut Buffers,
        target: &Target<'_>,
    ) -> Result<()> {
        let (store, chain) = (self.hierarchy.store, &self.array.codecs);
        let stored = Stored { chain, shape: &self.array.chunk, window };
        let failed = |problem: String| self.damaged(coordinates, &problem);
        match &chain.layout {
            Layout::Shards(shards) if chain.is_plain() => {
                match store.open(&self.key(coordinates)).map_err(|e| self.hierarchy.failed(e))? {
                    Some(blob) => self.read_shards(&stored, shards, &*blob, target).map_err(failed)?,
                    None => self.fill(&stored, target),
                }
            }
            _ => {
                let Buffers { packed, scratch } = buffers;
                match store.read(&self.key(coordinates), packed).map_err(|e| self.hierarchy.failed(e))? {
                    true => self.unpack(&stored, packed, scratch, target).map_err(failed)?,
                    false => self.fill(&stored, target),
                }
            }
        }
        Ok(())
    }

    /// Writes the values of `packed`.
    fn unpack(
        &self,
        stored: &Stored<'_>,
        packed: &[u8],
        scratch: &mut Scratch,
        target: &Target<'_>,
    ) -> std::result::Result<(), String> {
        let Stored { chain, shape, window } = *stored;
        match &chain.layout {
            Layout::Bytes => {
                let size = self.array.element.size();
                let values = chain.decode(packed, length_of(shape, size)?, scratch)?;
                let shape: Vec<usize> = chain.order.iter().map(|&axis| shape[axis]).collect();
                // SAFETY: chunks of a grid share no value, and no two values of the window share a place.
                unsafe { target.write(&window.permuted(&chain.order), &shape, values, size) };
                Ok(())
            }
            Layout::Shards(shards) => {
                let shard = chain.unpacked(packed, scratch)?;
                self.read_shards(stored, shards, &shard, target)
            }
        }
    }

    /// Writes the values of chunks in the shard `blob`.
    fn read_shards(
        &self,
        stored: &Stored<'_>,
        shards: &Shards,
        blob: &dyn Blob,
        target: &Target<'_>,
    ) -> std::result::Result<(), String> {
        let places = shards.places(blob)?;
        let window = stored.window.permuted(&stored.chain.order);
        let chunks = window.chunks(&shards.chunk);
        (0..chunks.count()).into_par_iter().try_for_each_init(Buffers::default, |buffers, index| {
            stop::point();
            let coordinates = chunks.coordinates(index);
            let part = window.within(&coordinates, &shards.chunk);
            let inner = Stored { chain: &shards.inner, shape: &shards.chunk, window: &part };
            let at = coordinates.iter().zip(&shards.counts).fold(0, |at, (place, count)| at * count + place);
            let Buffers { packed, scratch } = buffers;
            match places.get(at).ok_or("its index is too short")? {
                Some(place) => {
                    let bytes = blob.part(place.clone(), packed).map_err(|e| e.to_string())?;
                    self.unpack(&inner, bytes, scratch, target)
                }
                None => {
                    self.fill(&inner, target);
                    Ok(())
                }
            }
        })
    }

    /// Writes the fill value.
    fn fill(&self, stored: &Stored<'_>, target: &Target<'_>) {
        // Memory is zero already.
        if self.array.fill.iter().any(|&byte| byte != 0) {
            // SAFETY: as in `unpack`.
            unsafe { target.write(stored.window, stored.shape, &self.array.fill, self.array.fill.len()) };
        }
    }

    /// Checks that stored chunks stand for so many bytes: a few bytes of metadata could claim any number.
    fn justify(&self, chunks: &Chunks, length: usize) -> Result<()> {
        let mut justified = FREE;
        let mut is_sound = false;
        for index in 0..chunks.count().min(MOST_LOOKED_FOR) {
            if justified >= length {
                return Ok(());
            }
            let coordinates = chunks.coordinates(index);
            if !self.hierarchy.store.has(&self.key(&coordinates)) {
                continue;
            }
            if !is_sound {
                is_sound = self.probe(&coordinates)?;
            }
            if !is_sound {
                continue;
            }
            let chunk = self.array.chunk_length().unwrap_or(usize::MAX);
            justified = justified.saturating_add(chunk.saturating_mul(SPARSEST));
        }
        match justified >= length {
            true => Ok(()),
            false => Err(self.malformed(&format!(
                "has {length} bytes of values, but hardly a chunk of them is there; copy or download it again, whole"
            ))),
        }
    }

    /// Unpacks the chunk at `coordinates`. Returns whether it holds a value: shards may be empty.
    fn probe(&self, coordinates: &[usize]) -> Result<bool> {
        let (array, key) = (self.array, self.key(coordinates));
        let blob = self.hierarchy.store.open(&key).map_err(|e| self.hierarchy.failed(e))?;
        let Some(blob) = blob else { return Ok(false) };
        let size = array.element.size();
        holds_values(&array.codecs, &array.chunk, size, &*blob)
            .map_err(|problem| self.damaged(coordinates, &problem))
    }
}

/// Unpacks the first chunk of `shape` in `blob`. Returns whether there is one.
fn holds_values(
    chain: &Chain,
    shape: &[usize],
    size: usize,
    blob: &dyn Blob,
) -> std::result::Result<bool, String> {
    let (mut buffer, mut scratch) = (Vec::new(), Scratch::default());
    if let (Layout::Shards(shards), true) = (&chain.layout, chain.is_plain()) {
        return holds_values_in_shards(shards, size, blob);
    }
    let packed = blob.part(0..blob.length(), &mut buffer).map_err(|e| e.to_string())?;
    match &chain.layout {
        Layout::Bytes => {
            chain.decode(packed, length_of(shape, size)?, &mut scratch)?;
            Ok(true)
        }
        Layout::Shards(shards) => {
            holds_values_in_shards(shards, size, &chain.unpacked(packed, &mut scratch)?)
        }
    }
}

fn holds_values_in_shards(
    shards: &Shards,
    size: usize,
    blob: &dyn Blob,
) -> std::result::Result<bool, String> {
    let Some(place) = shards.places(blob)?.into_iter().flatten().next() else { return Ok(false) };
    let mut buffer = Vec::new();
    let bytes = blob.part(place, &mut buffer).map_err(|e| e.to_string())?;
    holds_values(&shards.inner, &shards.chunk, size, &bytes)
}

/// Bytes of a chunk of `shape`.
fn length_of(shape: &[usize], size: usize) -> std::result::Result<usize, String> {
    let length = product(shape).and_then(|values| values.checked_mul(size));
    length.ok_or_else(|| "it is too large".into())
}
