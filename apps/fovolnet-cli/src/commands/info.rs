use crate::console::{self, JsonOutput};
use crate::outputs;
use anyhow::{Result, bail};
use fovolnet::core::{ChannelDisplay, Placement, Space, Volume, path_of_text};
#[cfg(feature = "gpu")]
use fovolnet::gpu::DeviceType;
use fovolnet::io::volume::dicom::{self, Series};
use fovolnet::render::cpu::{available_simd, best_simd};
use fovolnet::{Machine, OpenVolume, Session, VolumeSettings, open_single_volume, parse, presets};
use glam::DMat3;
use serde::Serialize;

/// Say what a volume file holds
#[derive(clap::Args)]
pub struct Info {
    /// Volume file, folder of slices, or procedural volume
    #[arg(value_parser = parse::file())]
    volume: Option<String>,
    /// Say what this machine can render with
    #[arg(long, conflicts_with = "volume")]
    devices: bool,
    /// List the transfer functions that have names
    #[arg(long, conflicts_with_all = ["volume", "devices"])]
    transfer_functions: bool,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    format: String,
    dims: [usize; 3],
    dtype: String,
    components: usize,
    spacing: [f64; 3],
    min: f64,
    max: f64,
    mean: f64,
    non_finite: u64,
    range: [f64; 2],
    histogram: Vec<u64>,
    /// Rows of the matrix whose columns are the directions of the voxel axes in LPS.
    orientation: Option<[[f64; 3]; 3]>,
    /// Centre of the first voxel in LPS.
    origin: Option<[f64; 3]>,
    /// Unit of spacing and origin.
    units: Option<String>,
    /// Names of the arrays.
    arrays: Vec<String>,
    /// Names of the channels.
    channels: Vec<String>,
    /// Number of time points.
    times: usize,
    /// Number of levels of resolution.
    levels: usize,
    /// How the file asks to show each channel; empty where it says nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    channel_displays: Vec<ChannelReport>,
    /// Series of a DICOM file or folder, in the order in which `--series` counts them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    series: Vec<SeriesReport>,
    /// Whether the file declares the components as colours.
    colours: bool,
    /// Facts about labels, if the values may be labels.
    labels: Option<Labels>,
    /// Part of the contents that the statistics cover.
    shown: Shown,
    /// Values far outside all others, which the range leaves out.
    outliers: Vec<f64>,
    /// Doubts while reading the file, one line each.
    notes: Vec<String>,
}

/// How a file asks to show a channel.
#[derive(Serialize)]
struct ChannelReport {
    /// Red, green and blue of sRGB, 0 to 255.
    colour: Option<[u8; 3]>,
    /// The values shown as darkest and brightest.
    window: Option<[f64; 2]>,
    hidden: bool,
}

impl From<&ChannelDisplay> for ChannelReport {
    fn from(display: &ChannelDisplay) -> Self {
        Self { colour: display.colour, window: display.window, hidden: display.is_hidden }
    }
}

/// Series of a DICOM file or folder.
#[derive(Serialize)]
struct SeriesReport {
    uid: String,
    description: String,
    modality: String,
    dims: [usize; 3],
    /// Number of time points.
    times: usize,
    /// Property that tells it apart from other volumes of the same series.
    #[serde(skip_serializing_if = "String::is_empty")]
    part: String,
}

impl SeriesReport {
    /// Series beside which `opened` was chosen; empty unless it is of DICOM.
    fn all(opened: &OpenVolume) -> Result<Vec<Self>> {
        if !opened.volume.format().starts_with("DICOM") {
            return Ok(Vec::new());
        }
        let all = dicom::series(&path_of_text(&opened.source))?;
        let report = |Series { uid, description, modality, dims, times, part }| Self {
            uid,
            description,
            modality,
            dims,
            times,
            part,
        };
        Ok(all.into_iter().map(report).collect())
    }

    /// Line that lists the series as number `number`.
    fn line(&self, number: usize) -> String {
        let Self { uid, description, modality, dims: [x, y, z], times, part } = self;
        let times = if *times > 1 { format!(" x {times} times") } else { String::new() };
        let words = [modality, description, part].map(String::as_str);
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        format!("{number}: {x} x {y} x {z}{times}, {}, {uid}", words.join(" "))
    }
}

/// Facts about labels: integers of few different values, or labels that the file declares.
#[derive(Serialize)]
struct Labels {
    /// Whether the file declares them.
    declared: bool,
    /// Number of different values; `None` if there are many.
    count: Option<usize>,
}

impl Labels {
    /// Facts about the labels of `volume`; `None` if it does not look like a label map.
    fn of(volume: &Volume) -> Option<Self> {
        let declared = volume.contents().are_labels;
        let may_be = declared || volume.dtype().is_integer();
        let count = volume.distinct_values(MOST_LABELS).filter(|_| may_be).map(|values| values.len());
        (declared || count.is_some_and(|count| count > 2)).then_some(Self { declared, count })
    }
}

/// Most different values of a label map that the file does not declare.
const MOST_LABELS: usize = 32;

/// Indices of the shown part of a file, from 0 on.
#[derive(Serialize)]
struct Shown {
    array: Option<String>,
    channel: usize,
    time: usize,
    component: usize,
    level: usize,
}

#[derive(Serialize)]
struct Devices {
    machine: Machine,
    simd: Vec<String>,
    gpus: Vec<GpuReport>,
}

/// GPU of this machine.
#[derive(Serialize)]
struct GpuReport {
    name: String,
    /// Kind: discrete, integrated, or a software implementation.
    kind: String,
    /// Graphics API.
    interface: String,
    driver: String,
    /// Cooperative matrices that multiply networks in f16, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrices: Option<String>,
    /// Whether `--device auto` chooses this GPU.
    automatic: bool,
}

impl GpuReport {
    /// All GPUs of this machine.
    #[cfg(feature = "gpu")]
    fn all() -> Vec<Self> {
        use fovolnet::gpu::{AdapterRequest, adapters};
        let (infos, matrices): (Vec<_>, Vec<_>) = adapters().into_iter().unzip();
        let chosen = AdapterRequest::Hardware.or_environment().best(&infos);
        (0..)
            .zip(infos)
            .zip(matrices)
            .map(|((i, info), matrices)| Self {
                name: info.name,
                kind: match info.device_type {
                    DeviceType::DiscreteGpu => "a card",
                    DeviceType::IntegratedGpu => "a part of the processor",
                    DeviceType::VirtualGpu => "virtual",
                    DeviceType::Cpu => "a program on the processor, for tests",
                    DeviceType::Other => "unknown",
                }
                .into(),
                interface: info.backend.to_string(),
                driver: [info.driver, info.driver_info].join(" ").trim().into(),
                matrices: matrices.map(|matrices| matrices.to_string()),
                automatic: chosen == Some(i),
            })
            .collect()
    }

    #[cfg(not(feature = "gpu"))]
    fn all() -> Vec<Self> {
        Vec::new()
    }
}

const BINS: usize = 64;

/// Line for machines without a GPU.
const NO_GPU: &str = if cfg!(feature = "gpu") {
    "gpu    none found; where there is one, install its Vulkan driver"
} else {
    "gpu    not known: this program was built without the feature `gpu`"
};

/// Refuses a session, which is no volume but names one.
fn refuse_session(name: &str) -> Result<()> {
    let path = path_of_text(name);
    if path.extension().is_some_and(|extension| extension == "toml")
        && let Ok(session) = Session::read(&path)
    {
        bail!(
            "{name} is a session; `fovolnet render {name} -o DIR` renders it, and `fovolnet info {}` describes its volume",
            session.volume
        );
    }
    Ok(())
}

impl Info {
    pub fn run(self) -> Result<()> {
        if self.devices {
            return self.devices();
        }
        if self.transfer_functions {
            return self.transfer_functions();
        }
        let Some(name) = &self.volume else {
            bail!("no volume is named; give a file, --devices, or --transfer-functions")
        };
        refuse_session(name)?;
        let opened = open_single_volume(name, &self.read)?;
        outputs::check(self.json.file())?;
        opened.notes().iter().for_each(console::note);
        let volume = &opened.volume;
        let statistics = volume.statistics();
        let contents = volume.contents();
        let report = Report {
            format: volume.format().to_owned(),
            dims: volume.grid().dims(),
            dtype: volume.dtype().to_string(),
            components: contents.components,
            spacing: volume.grid().spacing(),
            min: statistics.min,
            max: statistics.max,
            mean: statistics.mean,
            non_finite: statistics.non_finite,
            range: volume.range(),
            histogram: volume.histogram(BINS, volume.range()),
            orientation: volume.placement().map(|placement| rows(placement.directions())),
            origin: volume.placement().map(|placement| placement.origin().to_array()),
            units: volume.units().map(str::to_owned),
            arrays: contents.arrays.clone(),
            channels: contents.channels.clone(),
            times: contents.times,
            levels: contents.levels,
            channel_displays: contents.displays.iter().map(ChannelReport::from).collect(),
            series: SeriesReport::all(&opened)?,
            colours: contents.are_colours,
            labels: Labels::of(volume),
            shown: Shown {
                array: contents.array_name().map(str::to_owned),
                channel: contents.channel,
                time: contents.time,
                component: contents.component,
                level: contents.level,
            },
            outliers: statistics.outliers.iter().map(|outlier| outlier.value).collect(),
            notes: opened.notes(),
        };
        self.describe(&opened, &report)?;
        self.json.write(&report)
    }

    fn describe(&self, opened: &OpenVolume, r: &Report) -> Result<()> {
        let say = |line: String| self.json.say(line);
        let [x, y, z] = r.dims;
        say(opened.source.clone())?;
        say(format!("  format      {}", r.format))?;
        say(format!("  dims        {x} x {y} x {z}"))?;
        say(format!("  type        {}", r.dtype))?;
        if !r.arrays.is_empty() {
            say(format!("  arrays      {}", r.arrays.join(", ")))?;
        }
        if !r.channels.is_empty() {
            say(format!("  channels    {}", numbered(&r.channels)))?;
        }
        for (number, series) in (1..).zip(&r.series) {
            say(format!("  series      {}", series.line(number)))?;
        }
        if r.times > 1 {
            say(format!("  times       {}", r.times))?;
        }
        if r.levels > 1 {
            say(format!("  levels      {}, shown is {}", r.levels, r.shown.level))?;
        }
        if r.components > 1 {
            let colours = if r.colours { ", colours" } else { "" };
            say(format!("  components  {}{colours}", r.components))?;
        }
        if let Some(Labels { declared, count }) = &r.labels {
            let count = count.map_or(String::new(), |count| format!("{count} different values"));
            let declared = if *declared { "the file says so" } else { "" };
            let known: Vec<&str> = [declared, &count].into_iter().filter(|part| !part.is_empty()).collect();
            say(format!("  labels      {}", known.join(", ")))?;
        }
        let units = r.units.as_deref().map(|units| format!(" {units}")).unwrap_or_default();
        say(format!("  spacing     {} x {} x {}{units}", r.spacing[0], r.spacing[1], r.spacing[2]))?;
        say(format!("  values      {} to {}, mean {:.6}", r.min, r.max, r.mean))?;
        say(format!("  shown as    {} (0) to {} (1)", r.range[0], r.range[1]))?;
        if r.non_finite > 0 {
            let nan = opened.volume.statistics().nan;
            let infinite = r.non_finite - nan;
            say(format!(
                "  not finite  {nan} NaN, transparent (--nan); {infinite} infinite, shown as the lowest"
            ))?;
        }
        if let Some(placement) = opened.volume.placement() {
            say(format!("  orientation {}", axes_in_words(placement)))?;
            let [x, y, z] = placement.origin().to_array();
            say(format!("  origin      {x} {y} {z} (LPS)"))?;
        }
        say(format!("  histogram   {}", sparkline(&r.histogram)))
    }

    fn transfer_functions(&self) -> Result<()> {
        for kind in presets::kinds() {
            self.json.say(format!("{}:", kind.description))?;
            self.json.say(format!("  {}", kind.names.join(" ")))?;
        }
        self.json.write(&presets::names())
    }

    fn devices(&self) -> Result<()> {
        let available = available_simd();
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let devices = Devices {
            machine: Machine::this(threads, best_simd()),
            simd: available.iter().map(ToString::to_string).collect(),
            gpus: GpuReport::all(),
        };
        self.json.say(format!(
            "cpu    {} ({threads} threads), instruction sets: {}",
            devices.machine.cpu,
            devices.simd.join(" ")
        ))?;
        for gpu in &devices.gpus {
            let automatic = if gpu.automatic { "; --device auto takes it" } else { "" };
            let matrices = gpu.matrices.as_ref().map(|kind| format!(", matrices of {kind}"));
            self.json.say(format!(
                "gpu    {} ({}, {}, {}{}){automatic}",
                gpu.name,
                gpu.kind,
                gpu.interface,
                gpu.driver,
                matrices.unwrap_or_default()
            ))?;
        }
        if devices.gpus.is_empty() {
            self.json.say(NO_GPU)?;
        }
        self.json.write(&devices)
    }
}

/// Joins names with their indices, from 0 on.
fn numbered(names: &[String]) -> String {
    let shown = |(i, name): (usize, &String)| format!("{i} {name}").trim_end().to_owned();
    names.iter().enumerate().map(shown).collect::<Vec<_>>().join(", ")
}

/// Rows of `matrix`.
fn rows(matrix: DMat3) -> [[f64; 3]; 3] {
    matrix.transpose().to_cols_array_2d()
}

/// Describes the directions of the voxel axes in words.
fn axes_in_words(placement: &Placement) -> String {
    let word = |letter| match letter {
        'L' => "left",
        'R' => "right",
        'P' => "posterior",
        'A' => "anterior",
        'S' => "superior",
        _ => "inferior",
    };
    let letters = placement.letters();
    let ends: Vec<&str> = letters.chars().map(word).collect();
    let space = if placement.space() == Space::Patient { "" } else { ", if its space is LPS" };
    let shear = match placement.shear() {
        0.0 => String::new(),
        degrees => format!(", sheared by {degrees:.1} degrees"),
    };
    format!("{letters}: x to {}, y to {}, z to {}{space}{shear}", ends[0], ends[1], ends[2])
}

/// Draws counts as a line of bars, on a logarithmic scale.
fn sparkline(counts: &[u64]) -> String {
    const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let height = |count: u64| (count as f64 + 1.0).ln();
    let most = counts.iter().map(|&c| height(c)).fold(1e-9, f64::max);
    counts.iter().map(|&c| BARS[(height(c) / most * 8.0).ceil() as usize]).collect()
}
