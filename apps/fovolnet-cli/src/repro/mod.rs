//! The paper's evaluation with this program: every table and figure as CSV, JSON and pictures, bound into one report.

mod ablations;
mod alternatives;
mod busy;
mod compression;
mod data_set;
mod data_sets;
mod evaluation;
mod frame_times;
mod jod;
mod masks;
mod methods;
mod noise;
mod over_time;
mod plot;
mod precision;
mod quality;
mod report;
mod scaling;
mod section;
mod speedups;
mod video;
mod vtk;

use crate::console::JsonOutput;
use crate::{interrupt, outputs};
use anyhow::{Result, ensure};
use busy::Watch;
use clap::ValueEnum;
use data_set::DataSet;
use evaluation::{Evaluation, FLY_THROUGH};
use fovolnet::core::{FrameSize, input};
use fovolnet::io::atomic;
use fovolnet::{SpeedSettings, parse};
use section::Section;
use std::path::PathBuf;

/// Make tables and figures of the paper's evaluation
#[derive(clap::Args)]
pub struct Repro {
    /// Tables and figures to make; others that the folder already holds stay in its report
    #[arg(value_name = "TABLE_OR_FIGURE", required = true)]
    items: Vec<Item>,
    /// Volume to evaluate, may be given several times: file, folder of slices, or procedural NAME or NAME:SIDE; @ and a
    /// transfer function may follow [default: all procedural ones]
    #[arg(long = "volume", value_name = "VOLUME[@TF]", value_parser = parse::file())]
    volumes: Vec<String>,
    /// Frames of each fly-through, spread over the paper's 500 [default: 500, with --quick 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=500))]
    frames: Option<u32>,
    /// Frame size in pixels [default: 1280x720, with --quick 640x360]
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Few and small frames, and three small volumes: minutes instead of hours
    #[arg(long)]
    quick: bool,
    /// File vtk_march.json of benchmarks/peers/vtk_march.py: adds a comparison of full frames with VTK's to the
    /// speed-ups
    #[arg(long, value_name = "FILE")]
    vtk: Option<PathBuf>,
    /// File ablations.csv of benchmarks/ablations.py
    #[arg(long, value_name = "FILE")]
    ablations: Option<PathBuf>,
    /// Folder for report.html and its figures
    #[arg(short, long, value_name = "DIR", default_value = "fovolnet-repro")]
    output: PathBuf,
    #[command(flatten)]
    speed: SpeedSettings,
    #[command(flatten)]
    json: JsonOutput,
}

/// Table or figure, or several that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Item {
    /// Everything below
    All,
    /// Table: the volumes
    DataSets,
    /// Figure: noise patterns, their means over frames, and their spectra
    Noise,
    /// Figure: sampling masks
    Masks,
    /// Figure: times of the parts of each frame
    FrameTimes,
    /// Figure and table: average frame times and speed-ups
    Speedups,
    /// Figure: pictures of every method beside the full one
    Quality,
    /// Figures: PSNR, SSIM and tPSNR over time
    OverTime,
    /// Table: just-objectionable differences
    Jod,
    /// Figure: model precision
    Precision,
    /// Figure: effective compression
    Compression,
    /// Table: effect of each part of the method, from --ablations
    Ablations,
    /// Figure beyond the paper: quality against frame time, for every way to make frames cheaper
    Alternatives,
    /// Figures beyond the paper: cost against resolution and against volume size
    Scaling,
    /// The supplemental video: fly-throughs side by side; as .mp4 where ffmpeg is installed
    Video,
}

impl Item {
    /// All items except `all`, in the order of the report.
    fn each() -> impl Iterator<Item = Self> {
        Self::value_variants().iter().copied().filter(|&item| item != Self::All)
    }

    /// Name on the command line.
    fn name(self) -> String {
        self.to_possible_value().expect("every item can be named").get_name().to_owned()
    }

    fn make(self, evaluation: &Evaluation) -> Result<Section> {
        match self {
            Self::All => unreachable!("it stands for the others"),
            Self::DataSets => data_sets::section(evaluation),
            Self::Noise => noise::section(),
            Self::Masks => masks::section(evaluation),
            Self::FrameTimes => frame_times::section(evaluation),
            Self::Speedups => speedups::section(evaluation),
            Self::Quality => quality::section(evaluation),
            Self::OverTime => over_time::section(evaluation),
            Self::Jod => jod::section(evaluation),
            Self::Precision => precision::section(evaluation),
            Self::Compression => compression::section(evaluation),
            Self::Ablations => ablations::section(evaluation),
            Self::Alternatives => alternatives::section(evaluation),
            Self::Scaling => scaling::section(evaluation),
            Self::Video => video::section(evaluation),
        }
    }
}

impl Repro {
    pub fn run(self) -> Result<()> {
        let evaluation = self.evaluation()?;
        self.keep_tables()?;
        atomic::make_folder(&self.output)?;
        let all = self.items.contains(&Item::All);
        let names: Vec<String> = Item::each().map(Item::name).collect();
        for item in Item::each().filter(|item| all || self.items.contains(item)) {
            interrupt::check(&format!("what was made before is in {}", self.output.display()))?;
            self.json.say(format!("{} …", item.name()))?;
            let watch = Watch::start();
            let mut section = item.make(&evaluation)?;
            section.name = item.name();
            section.seconds = watch.seconds();
            section.text.extend(watch.note());
            section.machine = serde_json::to_value(&evaluation.machine)?;
            section.write(&self.output)?;
            report::write(&self.output, &names)?;
            for line in section.lines() {
                self.json.say(line)?;
            }
        }
        self.json.say(format!("{}", self.output.join("report.html").display()))?;
        self.json.write(&report::sections(&self.output, &names)?)
    }

    /// Protects the tables of other programs: refuses to write sections over them.
    fn keep_tables(&self) -> Result<()> {
        let tables: Vec<&PathBuf> = [&self.vtk, &self.ablations].into_iter().flatten().collect();
        tables.iter().for_each(|table| input::add(table));
        outputs::check(self.json.file())?;
        for table in tables {
            let parts = Item::each().map(|item| self.output.join(item.name()).canonicalize());
            let table = table.canonicalize();
            let is_inside = |part: PathBuf| table.as_ref().is_ok_and(|table| table.starts_with(part));
            if parts.flatten().any(is_inside) {
                atomic::refuse_input(table.as_ref().unwrap_or(&self.output))?;
            }
        }
        Ok(())
    }

    fn evaluation(&self) -> Result<Evaluation> {
        let data_sets = match (&self.volumes[..], self.quick) {
            ([], true) => data_set::few(),
            ([], false) => data_set::procedural(),
            (given, _) => given.iter().map(|text| DataSet::parse(text)).collect::<Result<_>>()?,
        };
        let mut names: Vec<&str> = data_sets.iter().map(|data| data.name.as_str()).collect();
        names.sort_unstable();
        ensure!(
            names.windows(2).all(|pair| pair[0] != pair[1]),
            "two volumes have the same name; give each of them once"
        );
        let [frames, width, height] = if self.quick { [20, 640, 360] } else { [FLY_THROUGH, 1280, 720] };
        Ok(Evaluation {
            data_sets,
            frames: self.frames.unwrap_or(frames),
            size: self.size.map_or_else(|| FrameSize::new(width, height), Ok)?,
            machine: self.speed.machine()?,
            speed: self.speed.clone(),
            output: self.output.clone(),
            vtk: self.vtk.clone(),
            ablations: self.ablations.clone(),
        })
    }
}
