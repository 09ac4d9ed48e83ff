//! What drivers have compiled, kept for the next run of a program.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The environment variable that names the folder for what drivers have compiled; empty for none.
pub const CACHE_VARIABLE: &str = "FOVOLNET_CACHE";

/// The compiled pipelines of a device, as a file of its adapter's from one run to the next. Nothing depends on it: where
/// the file cannot be read or written, or is of another driver, everything is compiled anew.
pub(crate) struct PipelineCache {
    cache: wgpu::PipelineCache,
    file: PathBuf,
    /// What the file held.
    found: Option<Vec<u8>>,
}

impl PipelineCache {
    /// That of `device` in the folder of this user, if its interface has such a thing and there is such a folder.
    pub fn of_user(device: &wgpu::Device) -> Option<Self> {
        Self::within(&folder()?, device)
    }

    fn within(folder: &Path, device: &wgpu::Device) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let file = folder.join(wgpu::util::pipeline_cache_key(&device.adapter_info())?);
        let found = std::fs::read(&file).ok();
        let descriptor =
            wgpu::PipelineCacheDescriptor { label: None, data: found.as_deref(), fallback: true };
        // SAFETY: the file is this user's own, written by `save` alone and never in part, and says of which adapter and driver
        // it is, which is compared before a driver sees the rest.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self { cache, file, found })
    }

    pub fn get(&self) -> &wgpu::PipelineCache {
        &self.cache
    }

    /// Writes what has been compiled, if that is more than what was found. All of it or nothing.
    fn save(&self) -> std::io::Result<()> {
        let Some(data) = self.cache.get_data().filter(|data| self.found.as_ref() != Some(data)) else {
            return Ok(());
        };
        let folder = self.file.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(&data)?;
        file.persist(&self.file)?;
        Ok(())
    }
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // Then the next run compiles again: nobody loses anything.
        let _ = self.save();
    }
}

impl fmt::Debug for PipelineCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("PipelineCache").field(&self.file).finish()
    }
}

/// The folder of this user for what can be made again: [`CACHE_VARIABLE`], or what the system has for such.
fn folder() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from);
    if let Some(folder) = of(CACHE_VARIABLE) {
        return Some(folder).filter(|folder| !folder.as_os_str().is_empty());
    }
    let system = match cfg!(windows) {
        true => of("LOCALAPPDATA"),
        false => of("XDG_CACHE_HOME").or_else(|| Some(of("HOME")?.join(".cache"))),
    };
    // The standard has relative ones ignored.
    system.filter(|folder| folder.is_absolute()).map(|folder| folder.join("fovolnet"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AdapterRequest, Gpu};

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
            let (file, found) = (cache.file.clone(), cache.found.clone());
            drop(cache);
            Some((file, found))
        };
        let Some((file, nothing)) = build() else { return };
        assert_eq!(nothing, None);
        let written = std::fs::read(&file).expect("a file of what was compiled");
        assert_eq!(build().unwrap().1.as_ref(), Some(&written));
        for damaged in [&written[..written.len() / 2], b"", b"nothing of the kind"] {
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(build().unwrap().1.as_deref(), Some(damaged));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left there");
    }
}
