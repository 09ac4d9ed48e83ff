//! Reads volumes three times each, and prints how long each reading took.
//!
//! ```text
//! cargo run --release -p fovol-io --example time_reading -- PATH…
//! ```

use fovol_io::volume::{Overrides, read};
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args_os().skip(1) {
        for _ in 0..3 {
            let start = Instant::now();
            let volume = read(Path::new(&path), &Overrides::default())?;
            let seconds = start.elapsed().as_secs_f64();
            println!("{} bytes in {seconds:.3} s", volume.data().len());
        }
    }
    Ok(())
}
