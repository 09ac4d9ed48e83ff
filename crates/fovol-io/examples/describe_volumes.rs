//! Reads volume files and prints their metadata, for comparisons with other programs.
//!
//! ```text
//! cargo run --release -p fovol-io --example describe_volumes < ORDERS
//! ```
//!
//! Each line of standard input is an order in JSON. All keys but `path` are optional:
//!
//! ```text
//! {"path": FILE, "values": FILE, "convert": FILE, "component": N, "time": N, "channel": N, "array": NAME,
//!  "series": NAME, "level": N}
//! ```
//!
//! `values` receives the values as little-endian f64, x fastest. `convert` names an output file of any supported
//! format. One line of JSON answers each order.

use fovol_core::{Space, Volume};
use fovol_io::volume::{Overrides, read, write};
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    path: PathBuf,
    values: Option<PathBuf>,
    convert: Option<PathBuf>,
    component: Option<usize>,
    time: Option<usize>,
    channel: Option<usize>,
    array: Option<String>,
    series: Option<String>,
    level: Option<usize>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = io::stdout().lock();
    for line in io::stdin().lines() {
        let answer = answer(serde_json::from_str(&line?)?)?;
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(order: Order) -> io::Result<Value> {
    let Order { path, values, convert, component, time, channel, array, series, level } = order;
    let overrides = Overrides { component, time, channel, array, series, level, ..Overrides::default() };
    let volume = match read(&path, &overrides) {
        Ok(volume) => volume,
        Err(error) => return Ok(json!({ "error": error.to_string() })),
    };
    if let Some(path) = values {
        write_values(&volume, &path)?;
    }
    let mut answer = described(&volume);
    if let Some(path) = convert {
        answer["converted"] = match write(&volume, &path) {
            Ok(notes) => json!({ "notes": notes }),
            Err(error) => json!({ "error": error.to_string() }),
        };
    }
    Ok(answer)
}

fn described(volume: &Volume) -> Value {
    let (contents, statistics) = (volume.contents(), volume.statistics());
    let placement = volume.placement();
    json!({
        "format": volume.format(),
        "dims": volume.grid().dims(),
        "dtype": volume.dtype().to_string(),
        "spacing": volume.grid().spacing(),
        "min": statistics.min,
        "max": statistics.max,
        "mean": statistics.mean,
        "orientation": placement.map(|placement| placement.directions().transpose().to_cols_array_2d()),
        "origin": placement.map(|placement| placement.origin().to_array()),
        "is_patient": placement.is_some_and(|placement| placement.space() == Space::Patient),
        "units": volume.units(),
        "components": contents.components,
        "times": contents.times,
        "channels": contents.channels.len().max(1),
        "channel_names": contents.channels,
        "displays": contents.displays.iter().map(|display| {
            json!({ "colour": display.colour, "window": display.window, "is_hidden": display.is_hidden })
        }).collect::<Vec<_>>(),
        "levels": contents.levels,
        "level": contents.level,
        "range": volume.range(),
        "array": contents.array_name(),
        "are_colours": contents.are_colours,
        "labels": contents.are_labels.then(|| contents.labels.iter().map(|label| {
            json!({ "value": label.value, "name": label.name, "colour": label.colour })
        }).collect::<Vec<_>>()),
        "notes": volume.notes(),
    })
}

fn write_values(volume: &Volume, path: &Path) -> io::Result<()> {
    let [nx, ny, nz] = volume.grid().dims();
    let mut out = BufWriter::new(std::fs::File::create(path)?);
    for voxel in (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]) {
        out.write_all(&volume.value(voxel).to_le_bytes())?;
    }
    out.flush()
}
