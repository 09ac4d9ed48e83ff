//! The zip archive around a state dict: `NAME/data.pkl`, `NAME/data/0`, `NAME/data/1`, …, `NAME/byteorder`.

use super::tensor::{ByteOrder, Storage};
use super::{SAVE, ZIP, one_line};
use std::io::{Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

/// The pickle of the archive, below its folder.
const PICKLE: &[u8] = b"data.pkl";

/// What a damaged archive is mended by.
const AGAIN: &str = "copy or download it again";

/// An open archive; nothing but its directory has been read.
#[derive(Debug)]
pub struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// The name of the folder that all is in, with its slash. PyTorch takes it from the name of the file.
    folder: Vec<u8>,
    byte_order: ByteOrder,
    length: usize,
}

impl<'a> Archive<'a> {
    /// The archive that `bytes` are.
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        if !bytes.starts_with(ZIP) {
            return Err(format!("it is no zip archive, as torch.save writes; {SAVE}"));
        }
        let damaged = |e| format!("its zip archive is damaged ({}); {AGAIN}", one_line(&e));
        let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
        // Entries that share their bytes unpack to far more than the file could hold.
        if zip.has_duplicate_names() || zip.has_overlapping_files().map_err(damaged)? {
            return Err(format!("its zip archive is damaged (two entries are one); {AGAIN}"));
        }
        let folder = folder(&zip)
            .ok_or_else(|| format!("it is a zip archive, but none that torch.save wrote; {SAVE}"))?;
        let archive = Self { zip, folder, byte_order: ByteOrder::Little, length: bytes.len() };
        if archive.index("constants.pkl").is_some() {
            return Err(format!("it is a TorchScript program, not a state dict; {SAVE}"));
        }
        let byte_order = archive.find_byte_order()?;
        Ok(Self { byte_order, ..archive })
    }

    /// How numbers of more than one byte lie in storages.
    pub fn byte_order(&self) -> ByteOrder {
        self.byte_order
    }

    /// The program that builds the dict.
    pub fn pickle(&self) -> Result<Vec<u8>, String> {
        // Each tensor it names takes more room in the directory than in the pickle: a larger one is a trap.
        self.read("data.pkl", 2 * self.length)
    }

    /// The bytes of a storage, as many as its numbers have.
    pub fn storage(&self, storage: &Storage) -> Result<Vec<u8>, String> {
        let name = format!("data/{}", storage.key);
        let expected =
            storage.bytes().ok_or_else(|| format!("its `{name}` is too large for any computer"))?;
        let bytes = self.read(&name, expected)?;
        if bytes.len() < expected {
            let found = bytes.len();
            return Err(format!("its `{name}` has {found} bytes instead of {expected}; {AGAIN}"));
        }
        Ok(bytes)
    }

    /// Where `name` is in the directory. The name of the folder may be in any encoding.
    fn index(&self, name: &str) -> Option<usize> {
        self.zip.index_for_name_raw(&[&self.folder, name.as_bytes()].concat())
    }

    fn find_byte_order(&self) -> Result<ByteOrder, String> {
        // PyTorch before 2.1 did not say it, and such files come from small-endian machines.
        if self.index("byteorder").is_none() {
            return Ok(ByteOrder::Little);
        }
        match self.read("byteorder", 16)?.trim_ascii() {
            b"little" => Ok(ByteOrder::Little),
            b"big" => Ok(ByteOrder::Big),
            _ => Err(format!("its `byteorder` is neither little nor big; {AGAIN}")),
        }
    }

    /// Unpacks `name`, which has `most` bytes at most. Memory grows with what really comes out.
    pub fn read(&self, name: &str, most: usize) -> Result<Vec<u8>, String> {
        let failed = |e: ZipError| format!("its `{name}` cannot be unpacked ({}); {AGAIN}", one_line(&e));
        let index = self.index(name).ok_or_else(|| failed(ZipError::FileNotFound))?;
        let mut zip = self.zip.clone();
        let entry = zip.by_index(index).map_err(failed)?;
        let mut bytes = Vec::new();
        // One more than is allowed, so that the checksum is looked at when there is no more.
        entry.take((most as u64).saturating_add(1)).read_to_end(&mut bytes).map_err(|e| failed(e.into()))?;
        if bytes.len() > most {
            return Err(format!("its `{name}` has more than {most} bytes; {AGAIN}"));
        }
        Ok(bytes)
    }
}

/// The folder of the pickle, with its slash.
fn folder(zip: &ZipArchive<Cursor<&[u8]>>) -> Option<Vec<u8>> {
    zip.file_names_raw().find_map(|name| {
        let folder = name.strip_suffix(PICKLE)?;
        let is_one_folder = folder.iter().position(|&byte| byte == b'/') == folder.len().checked_sub(1);
        (is_one_folder && !folder.is_empty()).then(|| folder.to_vec())
    })
}
