use crate::console::{self, JsonOutput, Progress};
use crate::outputs;
use crate::second_file::SecondFile;
use anyhow::Result;
use clap::Subcommand;
use fovolnet::core::stop;
use fovolnet::io::dataset::{self, Stage};
use fovolnet::io::procedural::{self, Procedural};
use fovolnet::io::{atomic, volume};
use fovolnet::parse;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// List, make and download volumes
#[derive(clap::Args)]
pub struct Data {
    #[command(subcommand)]
    command: DataCommand,
}

#[derive(Subcommand)]
enum DataCommand {
    /// List procedural and published volumes
    List {
        #[command(flatten)]
        json: JsonOutput,
    },
    /// Make a procedural volume
    Make {
        /// Its name
        name: Procedural,
        /// File to write; its ending says the format
        output: PathBuf,
        #[command(flatten)]
        second: SecondFile,
        /// Voxels along x, y, z
        #[arg(long, value_name = "X,Y,Z", value_parser = parse::whole_numbers::<3>, default_value = "256,256,256")]
        dims: [usize; 3],
        /// Seed
        #[arg(long, value_name = "N", default_value_t = 0)]
        seed: u64,
    },
    /// Download a published volume and check it
    Get {
        /// Its name
        name: String,
        /// Folder to put it into
        #[arg(short, long, value_name = "DIR", default_value = ".")]
        output: PathBuf,
    },
}

#[derive(Serialize)]
struct Listing {
    procedural: Vec<Made>,
    published: Vec<Published>,
}

#[derive(Serialize)]
struct Made {
    name: &'static str,
    description: &'static str,
}

#[derive(Serialize)]
struct Published {
    name: &'static str,
    dims: [usize; 3],
    dtype: String,
    bytes: u64,
    url: &'static str,
    checked: bool,
}

impl Data {
    pub fn run(self) -> Result<()> {
        match self.command {
            DataCommand::List { json } => list(&json),
            DataCommand::Make { name, output, second, dims, seed } => {
                outputs::check([&*output])?;
                let made = procedural::make(name, dims, seed)?;
                console::notes_of(&output, &volume::write_with(&made, &output, second.beside())?);
                console::say(format!("wrote {}", output.display()))
            }
            DataCommand::Get { name, output } => get(&name, &output),
        }
    }
}

fn list(json: &JsonOutput) -> Result<()> {
    let procedural: Vec<Made> = Procedural::ALL
        .iter()
        .map(|kind| Made { name: kind.name(), description: kind.description() })
        .collect();
    let published: Vec<Published> = dataset::catalogue()
        .iter()
        .map(|entry| Published {
            name: &entry.name,
            dims: entry.dims,
            dtype: entry.dtype.to_string(),
            bytes: entry.bytes(),
            url: &entry.url,
            checked: entry.sha512.is_some(),
        })
        .collect();
    json.say("procedural volumes (fovolnet data make NAME OUT, or NAME wherever a volume is meant):")?;
    for made in &procedural {
        json.say(format!("  {:<16} {}", made.name, made.description))?;
    }
    json.say("published volumes (fovolnet data get NAME):")?;
    for p in &published {
        let [x, y, z] = p.dims;
        let note = if p.checked { "" } else { "  (no published hash)" };
        json.say(format!(
            "  {:<36} {:>16} {:<4} {:>10.1} MB{note}",
            p.name,
            format!("{x}x{y}x{z}"),
            p.dtype,
            p.bytes as f64 / 1e6
        ))?;
    }
    json.write(&Listing { procedural, published })
}

fn get(name: &str, folder: &Path) -> Result<()> {
    let entry = dataset::find(name)?;
    atomic::make_folder(folder)?;
    let mut download = Progress::new("MB downloaded", entry.bytes() >> 20);
    let mut verify = None;
    let mut listener = |p: dataset::Progress| match p.stage {
        Stage::Download => download.to(p.done >> 20),
        Stage::Verify => {
            verify.get_or_insert_with(|| Progress::new("MB verified", p.total >> 20)).to(p.done >> 20);
        }
    };
    let outcome = dataset::get(entry, folder, &mut listener, stop::flag())?;
    drop(verify);
    drop(download);
    console::say(outcome.to_string())
}
