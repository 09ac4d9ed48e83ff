//! Samples transfer functions at 1,001 values, for comparisons with other programs.
//!
//! ```text
//! cargo run --release -p fovol-io --example transfer_table -- FILE[#NAME]…
//! ```
//!
//! Prints one line of JSON per function: `{"range":[lo,hi],"rgba":[[r,g,b,a],…]}`.
//! The values run from the lower end of the range to the upper one.

use fovol_io::transfer_function::import;
use std::path::Path;

/// The last of the values, counted from 0.
const LAST: u32 = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in std::env::args().skip(1) {
        let transfer = import(Path::new(&file))?.transfer;
        let rgba: Vec<[f64; 4]> =
            (0..=LAST).map(|i| transfer.evaluate(f64::from(i) / f64::from(LAST))).collect();
        println!("{}", serde_json::json!({ "range": transfer.range(), "rgba": rgba }));
    }
    Ok(())
}
