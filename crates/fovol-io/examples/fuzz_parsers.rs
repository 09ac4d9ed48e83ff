//! Feeds damaged files to the parsers of volumes and transfer functions, without a nightly compiler.
//!
//! ```text
//! cargo run --release -p fovol-io --example fuzz_parsers -- [OPTION…] [PARSER…]
//!
//! --inputs N         inputs for each parser, 100000 by default
//! --seed N           other inputs for another number
//! --seeds DIR        seeds besides those made here: all files with a fitting ending
//! --keep DIR         where inputs that fail are kept, out/fuzz by default
//! --write-seeds DIR  write the seeds to DIR/PARSER, where cargo-fuzz looks for them
//! ```
//!
//! Every input is one of the seeds with one to eight changes. A parser fails when it panics, takes more memory
//! than its input justifies, takes more than a second, or complains in more than one line of plain text.

#[path = "../tests/mutation/mod.rs"]
mod mutation;

use mutation::{Random, Target, mutated, words};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// An input may take this much memory whatever its size, and this much per byte. Decoders have tables, and deflate packs so
/// much into a byte; a sparse grid has a box around its voxels.
fn memory_of(parser: &str) -> (usize, usize) {
    match parser {
        "vdb" | "nvdb" | "nvdb_tree" => (600 << 20, 10_000),
        _ => (12 << 20, 1100),
    }
}

/// An input that takes a processor longer is a failure; one that takes ten times as long ends the run.
const LONGEST: Duration = Duration::from_secs(1);

/// An input that waits so long without a processor ends the run too: it waits for itself. A busy machine lets others wait.
const LONGEST_WAIT: Duration = Duration::from_secs(300);

/// The system's allocator, which also keeps account of what the current thread holds.
struct Accounting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn account(change: isize) {
    // Both are plain numbers without destructors: they can be used at any time in a thread's life.
    let held = HELD.get() + change;
    HELD.set(held);
    PEAK.set(PEAK.get().max(held));
}

// SAFETY: everything is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Accounting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        account(layout.size() as isize);
        // SAFETY: as our caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        account(layout.size() as isize);
        // SAFETY: as our caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        account(-(layout.size() as isize));
        // SAFETY: as our caller promises.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        account(new_size as isize - layout.size() as isize);
        // SAFETY: as our caller promises.
        unsafe { System.realloc(block, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Accounting = Accounting;

struct Options {
    inputs: u64,
    seed: u64,
    seeds: Option<PathBuf>,
    keep: PathBuf,
    write_seeds: Option<PathBuf>,
    parsers: Vec<String>,
}

impl Options {
    fn from_arguments() -> Result<Self, String> {
        let mut options = Self {
            inputs: 100_000,
            seed: 1,
            seeds: None,
            keep: "out/fuzz".into(),
            write_seeds: None,
            parsers: Vec::new(),
        };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
            let number = |text: String| text.parse().map_err(|_| format!("`{text}` is no whole number"));
            match argument.as_str() {
                "--inputs" => options.inputs = number(value()?)?,
                "--seed" => options.seed = number(value()?)?,
                "--seeds" => options.seeds = Some(value()?.into()),
                "--write-seeds" => options.write_seeds = Some(value()?.into()),
                "--keep" => options.keep = value()?.into(),
                name if name.starts_with('-') => return Err(format!("{name} is no option")),
                name => options.parsers.push(name.to_owned()),
            }
        }
        Ok(options)
    }
}

/// Results of one parser over all its inputs.
#[derive(Default)]
struct Tally {
    read: u64,
    failures: u64,
    slowest: Duration,
    most_memory: usize,
}

fn main() -> Result<(), String> {
    let options = Options::from_arguments()?;
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    std::panic::set_hook(Box::new(|_| {}));
    let mut failures = 0;
    for mut target in mutation::seeds::targets(folder.path()) {
        if !options.parsers.is_empty() && !options.parsers.iter().any(|name| name == target.name) {
            continue;
        }
        if let Some(more) = &options.seeds {
            add_files(&mut target, more);
        }
        if let Some(corpus) = &options.write_seeds {
            for (number, seed) in target.seeds.iter().enumerate() {
                keep(&corpus.join(target.name), "seed", &number.to_string(), seed);
            }
        }
        let start = Instant::now();
        let tally = fuzz(&target, &options, folder.path());
        println!(
            "{:10} {} inputs, {} read, {} failures, slowest {:?}, most memory {} KiB, {:.0?}",
            target.name,
            options.inputs,
            tally.read,
            tally.failures,
            tally.slowest,
            tally.most_memory >> 10,
            start.elapsed()
        );
        failures += tally.failures;
    }
    if failures > 0 {
        Err(format!("{failures} inputs failed; see {}", options.keep.display()))
    } else {
        Ok(())
    }
}

/// Adds the files below `folder` that end as those of `target` do and are not long.
fn add_files(target: &mut Target, folder: &Path) {
    let ending = target.file.split_once('.').map_or("", |(_, ending)| ending);
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            add_files(target, &path);
        } else if path.to_string_lossy().ends_with(&format!(".{ending}"))
            && entry.metadata().is_ok_and(|metadata| metadata.len() < 1 << 15)
        {
            target.seeds.extend(std::fs::read(path));
        }
    }
}

fn fuzz(target: &Target, options: &Options, folder: &Path) -> Tally {
    let mut tally = Tally::default();
    let path = folder.join(target.file);
    let words = words(&target.seeds);
    let (free, per_byte) = memory_of(target.name);
    let watch = Watch::start(target.name, &options.keep);
    for number in 0..options.inputs {
        // Each input has a generator of its own, so that one failure can be made again alone.
        let mut random = Random::new(options.seed.wrapping_mul(0x1_0000_0001).wrapping_add(number));
        let input = mutated(&mut random, &target.seeds, &words);
        watch.begin(&input);
        let held = HELD.get();
        PEAK.set(held);
        let start = processor_time();
        let outcome = catch_unwind(AssertUnwindSafe(|| (target.read)(&path, &input)));
        let (taken, memory) = (processor_time() - start, (PEAK.get() - held).max(0) as usize);
        tally.slowest = tally.slowest.max(taken);
        tally.most_memory = tally.most_memory.max(memory);
        let problem = match outcome {
            Err(_) => Some("panics".to_owned()),
            Ok(Err(problem)) => Some(problem),
            Ok(Ok(_)) if memory > free + per_byte * input.len() => Some(format!("takes {memory} bytes")),
            Ok(Ok(_)) if taken > LONGEST => Some(format!("takes {taken:?}")),
            Ok(Ok(is_read)) => {
                tally.read += u64::from(is_read);
                None
            }
        };
        if let Some(problem) = problem {
            tally.failures += 1;
            println!("{}: input {number} of {} bytes {problem}", target.name, input.len());
            keep(&options.keep, target.name, &number.to_string(), &input);
        }
    }
    tally
}

fn keep(folder: &Path, parser: &str, name: &str, input: &[u8]) {
    let path = folder.join(format!("{parser}_{name}"));
    if std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, input)).is_err() {
        println!("cannot write {}; choose another folder with --keep", path.display());
    }
}

/// Time that processors have spent on this program; time by the clock where the system does not say.
fn processor_time() -> Duration {
    #[cfg(unix)]
    {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: the call writes the one time that it is given.
        unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    }
    #[cfg(not(unix))]
    {
        static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
        START.get_or_init(Instant::now).elapsed()
    }
}

/// The input that is being read, and when it began by the clock and by the processors.
struct Current {
    since: Instant,
    spent: Duration,
    input: Vec<u8>,
}

/// Ends the program when one input takes far too long: a parser that hangs cannot be stopped otherwise.
struct Watch(std::sync::Arc<std::sync::Mutex<Current>>);

impl Watch {
    fn start(parser: &'static str, folder: &Path) -> Self {
        let current = Current { since: Instant::now(), spent: processor_time(), input: Vec::new() };
        let state = std::sync::Arc::new(std::sync::Mutex::new(current));
        let (watched, folder) = (std::sync::Arc::downgrade(&state), folder.to_owned());
        std::thread::spawn(move || {
            while let Some(state) = watched.upgrade() {
                if let Ok(state) = state.lock()
                    && (processor_time() - state.spent > LONGEST * 10 || state.since.elapsed() > LONGEST_WAIT)
                {
                    println!("{parser}: an input of {} bytes hangs", state.input.len());
                    keep(&folder, parser, "hang", &state.input);
                    // Nothing else ends a thread that does not return.
                    std::process::abort();
                }
                drop(state);
                std::thread::sleep(LONGEST);
            }
        });
        Self(state)
    }

    fn begin(&self, input: &[u8]) {
        if let Ok(mut state) = self.0.lock() {
            state.since = Instant::now();
            state.spent = processor_time();
            state.input.clear();
            state.input.extend_from_slice(input);
        }
    }
}
