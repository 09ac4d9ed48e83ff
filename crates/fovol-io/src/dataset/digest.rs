use super::progress::{Stage, Watch};
use crate::{Error, Result, atomic};
use fovol_core::input;
use sha2::{Digest, Sha512};
use std::fmt::Write;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// The SHA-512 of the file in lower-case hexadecimal digits, or `None` when called off.
pub(super) fn sha512_of(path: &Path, watch: &mut Watch<'_>) -> Result<Option<String>> {
    let failed = |source| Error::io("read", path, source);
    let mut file = input::open(path).map_err(failed)?;
    let total = file.metadata().map_err(failed)?.len();
    let mut buffer = vec![0; 1 << 18];
    let (mut hasher, mut done) = (Sha512::new(), 0);
    loop {
        if !watch.goes_on(Stage::Verify, done, total) {
            return Ok(None);
        }
        let count = file.read(&mut buffer).map_err(failed)?;
        if count == 0 {
            return Ok(Some(hexadecimal(&hasher.finalize())));
        }
        hasher.update(&buffer[..count]);
        done += count as u64;
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("a string takes all that is written to it");
        text
    })
}

/// The hash that an earlier download left in `record`, if there is one.
pub(super) fn recorded(record: &Path) -> Result<Option<String>> {
    let text = match fs::read_to_string(record) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(Error::io("read", record, e)),
    };
    let hash = text.split_whitespace().next().unwrap_or_default().to_ascii_lowercase();
    if hash.len() != 128 || !hash.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(Error::malformed(
            record,
            "it holds no SHA-512; delete it and run the same command again",
        ));
    }
    Ok(Some(hash))
}

/// Records `hash` of the file `name` as `sha512sum` writes it, so that `sha512sum -c` checks it.
pub(super) fn record_hash(record: &Path, hash: &str, name: &str) -> Result<()> {
    atomic::write_bytes(record, format!("{hash}  {name}\n").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_of_abc_is_that_of_the_standard() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        fs::write(&path, "abc").unwrap();
        let cancel = false.into();
        let hash = sha512_of(&path, &mut Watch { listener: &mut |_| (), cancel: &cancel }).unwrap().unwrap();
        assert!(hash.starts_with("ddaf35a193617abacc417349ae204131") && hash.ends_with("a54ca49f"), "{hash}");
        let record = folder.path().join("abc.sha512");
        assert!(recorded(&record).unwrap().is_none());
        record_hash(&record, &hash, "abc").unwrap();
        assert_eq!(recorded(&record).unwrap(), Some(hash));
        fs::write(&record, "nonsense").unwrap();
        assert!(recorded(&record).is_err());
    }
}
