//! Keeps the pipelines that a driver has compiled on disk, for the next run of a program.

use sha2::{Digest, Sha256};
use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Magic number of a cache file. The SHA-256 of the rest follows it.
const MARK: &[u8; 8] = b"FOVOLPC1";

/// Length of a SHA-256 digest in bytes.
const DIGEST: usize = 32;

/// Environment variable that names the cache folder. An empty value switches the cache off.
pub const CACHE_VARIABLE: &str = "FOVOLNET_CACHE";

/// Compiled pipelines of a device, stored in one file per adapter.
///
/// The cache only saves time. If the file cannot be read or written, or belongs to another driver, all pipelines
/// are compiled anew.
pub(crate) struct PipelineCache {
    cache: wgpu::PipelineCache,
    file: PathBuf,
    /// Contents of the file, if its digest was right.
    found: Option<Vec<u8>>,
    /// Message for the user, if the file was damaged.
    note: Option<String>,
}

impl PipelineCache {
    /// Opens the cache of `device` in this user's cache folder. `None` if the device has no pipeline cache or the
    /// user no such folder.
    pub fn of_user(device: &wgpu::Device) -> Option<Self> {
        Self::within(&folder()?, device)
    }

    fn within(folder: &Path, device: &wgpu::Device) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let file = folder.join(wgpu::util::pipeline_cache_key(&device.adapter_info())?);
        let (found, note) = match std::fs::read(&file).map(|bytes| contents(&bytes)) {
            Ok(Some(sound)) => (Some(sound), None),
            Ok(None) => (None, Some(damaged(&file))),
            Err(_) => (None, None),
        };
        let descriptor =
            wgpu::PipelineCacheDescriptor { label: None, data: found.as_deref(), fallback: true };
        // SAFETY: the file is this user's own, and its digest shows that `save` wrote all of it. The data names its
        // adapter and driver; wgpu compares these before the driver sees the rest.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self { cache, file, found, note })
    }

    pub fn get(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Message for the user about a damaged cache file, if there was one.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Writes the compiled pipelines if they differ from the file that was read. The file is replaced atomically.
    fn save(&self) -> std::io::Result<()> {
        let Some(data) = self.cache.get_data().filter(|data| self.found.as_ref() != Some(data)) else {
            return Ok(());
        };
        let folder = self.file.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut unfinished = unfinished();
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        let temporary = file.path().to_owned();
        unfinished.push(temporary.clone());
        drop(unfinished);
        let written = file
            .write_all(MARK)
            .and_then(|()| file.write_all(&Sha256::digest(&data)))
            .and_then(|()| file.write_all(&data))
            .and_then(|()| file.as_file().sync_all());
        let mut unfinished = self::unfinished();
        unfinished.retain(|other| *other != temporary);
        written?;
        file.persist(&self.file)?;
        Ok(())
    }
}

/// The temporary files of caches that are being written. Held while one is made and while it is renamed.
fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes temporary files of pipeline caches, for a process that ends whatever its threads do. While the returned guard
/// lives, no thread makes or renames another.
#[must_use]
pub fn abandon_cache() -> impl Sized {
    let unfinished = unfinished();
    for file in unfinished.iter() {
        // If removal fails, nobody is left to try again.
        let _ = std::fs::remove_file(file);
    }
    unfinished
}

/// Returns the pipeline data of a cache file, or `None` if any byte of it has changed.
fn contents(bytes: &[u8]) -> Option<Vec<u8>> {
    let (digest, data) = bytes.strip_prefix(MARK)?.split_at_checked(DIGEST)?;
    (Sha256::digest(data).as_slice() == digest).then(|| data.to_vec())
}

/// Message for the user about the damaged cache file `file`.
fn damaged(file: &Path) -> String {
    format!(
        "{}: the compiled pipelines in it are damaged or of an earlier version; they are made anew",
        file.display()
    )
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // An error only means that the next run compiles again.
        let _ = self.save();
    }
}

impl fmt::Debug for PipelineCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("PipelineCache").field(&self.file).finish()
    }
}

/// Cache folder of this user: [`CACHE_VARIABLE`], or else the system's cache folder.
pub(crate) fn folder() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from);
    if let Some(folder) = of(CACHE_VARIABLE) {
        return Some(folder).filter(|folder| !folder.as_os_str().is_empty());
    }
    let system = match cfg!(windows) {
        true => of("LOCALAPPDATA"),
        false => of("XDG_CACHE_HOME").or_else(|| Some(of("HOME")?.join(".cache"))),
    };
    // The XDG base directory specification says that relative paths are ignored.
    system.filter(|folder| folder.is_absolute()).map(|folder| folder.join("fovolnet"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AdapterRequest, Gpu};

    #[test]
    fn every_damaged_byte_is_found() {
        let whole = [&MARK[..], &Sha256::digest(b"pipelines"), b"pipelines"].concat();
        assert_eq!(contents(&whole).as_deref(), Some(&b"pipelines"[..]));
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x10;
            assert_eq!(contents(&damaged), None, "{at}");
            assert_eq!(contents(&whole[..at]), None, "{at}");
        }
    }

    #[test]
    #[ignore = "needs a graphics processor, or Mesa's software one"]
    fn what_was_compiled_is_found_again_and_what_is_damaged_does_no_harm() {
        let gpu = Gpu::open(&AdapterRequest::Any.or_environment()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let build = || {
            let cache = PipelineCache::within(folder.path(), gpu.device())?;
            let source = wgpu::ShaderSource::Wgsl("@compute @workgroup_size(1) fn main() {}".into());
            let module =
                gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
            let descriptor = wgpu::ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                cache: Some(cache.get()),
            };
            gpu.guarded("compiling", || drop(gpu.device().create_compute_pipeline(&descriptor))).unwrap();
            let (file, found, note) = (cache.file.clone(), cache.found.clone(), cache.note.clone());
            drop(cache);
            Some((file, found, note))
        };
        let Some((file, nothing, _)) = build() else { return };
        assert_eq!(nothing, None);
        let written = std::fs::read(&file).expect("a file of what was compiled");
        let again = build().unwrap();
        assert_eq!((again.1, again.2), (contents(&written), None));
        let mut changed = written.clone();
        changed[64..72].fill(0xFF);
        for damaged in [&written[..written.len() / 2], b"", b"nothing of the kind", &changed] {
            std::fs::write(&file, damaged).unwrap();
            let (_, found, note) = build().unwrap();
            assert!(found.is_none() && note.unwrap().contains("made anew"));
            assert_eq!(contents(&std::fs::read(&file).unwrap()), contents(&written), "the file is mended");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left there");
    }
}
