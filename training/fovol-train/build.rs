//! Links libtorch's CUDA library where it exists, and records libtorch's version for the program.
//!
//! `libtorch_cuda` registers itself with libtorch when it is loaded; no code refers to its symbols. Without
//! `--no-as-needed` the linker would drop it, and libtorch would find no device.

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let folder = std::env::var("DEP_TCH_LIBTORCH_LIB").unwrap_or_default();
    let folder = Path::new(&folder);
    println!("cargo:rustc-env=FOVOLNET_LIBTORCH_VERSION={}", version(folder));
    // The run path finds libtorch at run time. LD_LIBRARY_PATH still takes precedence.
    println!("cargo:rustc-link-arg=-Wl,-rpath,{}", folder.display());
    if folder.join("libtorch_cuda.so").exists() {
        let flags = ["--push-state", "--no-as-needed", "-ltorch_cuda", "--pop-state"].map(|flag| {
            let is_library = flag.starts_with("-l");
            if is_library { flag.to_owned() } else { format!("-Wl,{flag}") }
        });
        println!("cargo:rustc-link-arg=-L{}", folder.display());
        flags.iter().for_each(|flag| println!("cargo:rustc-link-arg={flag}"));
    }
}

/// The version of libtorch in `folder/..`: from `version.py` of a Python wheel, or `build-version` of an archive.
fn version(folder: &Path) -> String {
    let read = |name: &str| std::fs::read_to_string(folder.join("..").join(name)).ok();
    // A wheel has: __version__ = '2.11.0+cu130'. An archive has the number alone.
    let wheel = read("version.py").and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("__version__"))?.to_owned();
        line.split('\'').nth(1).map(str::to_owned)
    });
    let archive = || read("build-version").map(|text| text.trim().to_owned());
    wheel.or_else(archive).unwrap_or_else(|| "2.11.0, by what it was built for".into())
}
