//! Reads the zip archive around a state dict: `NAME/data.pkl`, `NAME/data/0`, `NAME/data/1`, …, `NAME/byteorder`.

use super::advice::SAVE;
use super::one_line;
use super::tensor::{ByteOrder, Storage};
use std::io::{Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

/// Signature of a zip archive.
pub const ZIP: &[u8] = b"PK\x03\x04";

/// Name of the pickle within its folder.
const PICKLE: &[u8] = b"data.pkl";

/// Advice for a damaged archive.
const AGAIN: &str = "copy or download it again";

/// An open archive. Opening reads only the directory.
#[derive(Debug)]
pub struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Folder that contains all entries, with its slash. PyTorch names it after the file.
    folder: Vec<u8>,
    byte_order: ByteOrder,
    length: usize,
}

impl<'a> Archive<'a> {
    /// Opens the archive in `bytes`.
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        if !bytes.starts_with(ZIP) {
            return Err(format!("it is no zip archive, as torch.save writes; {SAVE}"));
        }
        let damaged = |e| format!("its zip archive is damaged ({}); {AGAIN}", one_line(&e));
        let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
        // Overlapping entries could unpack to far more than the size of the file (zip bombs).
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

    /// Byte order of the numbers in storages.
    pub fn byte_order(&self) -> ByteOrder {
        self.byte_order
    }

    /// Unpacks the pickle, a program that builds the dict.
    pub fn pickle(&self) -> Result<Vec<u8>, String> {
        // Each tensor takes more bytes in the directory than in the pickle. A larger pickle is an attack.
        self.read("data.pkl", 2 * self.length)
    }

    /// Unpacks the bytes of a storage.
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

    /// Index of `name` in the directory. The folder's name may be in any encoding.
    fn index(&self, name: &str) -> Option<usize> {
        self.zip.index_for_name_raw(&[&self.folder, name.as_bytes()].concat())
    }

    fn find_byte_order(&self) -> Result<ByteOrder, String> {
        // PyTorch before 2.1 did not write the byte order. Such files come from little-endian machines.
        if self.index("byteorder").is_none() {
            return Ok(ByteOrder::Little);
        }
        match self.read("byteorder", 16)?.trim_ascii() {
            b"little" => Ok(ByteOrder::Little),
            b"big" => Ok(ByteOrder::Big),
            _ => Err(format!("its `byteorder` is neither little nor big; {AGAIN}")),
        }
    }

    /// Unpacks `name`, at most `most` bytes. Memory grows with the unpacked bytes, not with the size that the file
    /// claims.
    pub fn read(&self, name: &str, most: usize) -> Result<Vec<u8>, String> {
        let failed = |e: ZipError| format!("its `{name}` cannot be unpacked ({}); {AGAIN}", one_line(&e));
        let index = self.index(name).ok_or_else(|| failed(ZipError::FileNotFound))?;
        let mut zip = self.zip.clone();
        let entry = zip.by_index(index).map_err(failed)?;
        let mut bytes = Vec::new();
        // One byte more than allowed, so that the end is reached and the checksum verified.
        entry.take((most as u64).saturating_add(1)).read_to_end(&mut bytes).map_err(|e| failed(e.into()))?;
        if bytes.len() > most {
            return Err(format!("its `{name}` has more than {most} bytes; {AGAIN}"));
        }
        Ok(bytes)
    }
}

/// Finds the folder of the pickle, with its slash.
fn folder(zip: &ZipArchive<Cursor<&[u8]>>) -> Option<Vec<u8>> {
    zip.file_names_raw().find_map(|name| {
        let folder = name.strip_suffix(PICKLE)?;
        let is_one_folder = folder.iter().position(|&byte| byte == b'/') == folder.len().checked_sub(1);
        (is_one_folder && !folder.is_empty()).then(|| folder.to_vec())
    })
}
