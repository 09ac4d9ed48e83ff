//! Links libtorch's CUDA half where there is one, and notes the version of libtorch.
//!
//! Nothing names a symbol of `libtorch_cuda`, which enters itself into libtorch's tables when it is loaded: without
//! being told, the linker leaves it out and no device is found.

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let folder = std::env::var("DEP_TCH_LIBTORCH_LIB").unwrap_or_default();
    let folder = Path::new(&folder);
    println!("cargo:rustc-env=FOVOLNET_LIBTORCH_VERSION={}", version(folder));
    // Found at run time without LD_LIBRARY_PATH, which still comes first.
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

/// What libtorch beside the libraries in `folder` says that it is.
fn version(folder: &Path) -> String {
    let read = |name: &str| std::fs::read_to_string(folder.join("..").join(name)).ok();
    // From a wheel: __version__ = '2.11.0+cu130'. From an archive: the number alone.
    let wheel = read("version.py").and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("__version__"))?.to_owned();
        line.split('\'').nth(1).map(str::to_owned)
    });
    let archive = || read("build-version").map(|text| text.trim().to_owned());
    wheel.or_else(archive).unwrap_or_else(|| "2.11.0, by what it was built for".into())
}
