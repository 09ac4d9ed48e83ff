//! Lists the DICOM series of a file, folder or DICOMDIR.
//!
//! ```text
//! cargo run --release -p fovol-io --example list_series -- PATH
//! ```

use fovol_io::volume::dicom;
use std::path::PathBuf;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path: PathBuf = std::env::args_os().nth(1).ok_or("give a path")?.into();
    let start = Instant::now();
    for (number, series) in (1..).zip(dicom::series(&path)?) {
        println!("{number}: {} {series}", series.uid);
    }
    println!("{:.2?}", start.elapsed());
    Ok(())
}
