//! Training of a network on clips: from a configuration to weights, with resumption.
//!
//! Everything random in step s depends on the seed and s alone, so that a resumed run continues exactly.

mod arrangement;
mod backward;
mod checkpoint;
mod config;
mod dead_channel_reset;
mod lessons;
mod progress;
mod ranges;
mod replicas;
mod taken;
mod validation;

pub use arrangement::Arrangement;
pub use config::{ClipsConfig, NetworkChoice, TrainConfig};
pub use ranges::note_ranges;
pub use validation::{Fills, Scores};

use crate::clips::ClipSet;
use crate::lesson::LessonFrame;
use crate::loss::Losses;
use crate::network::{Network, Options, initial_weights};
use crate::optimise::{Average, Cosine, Ranger, clip_gradients};
use crate::{Error, Result};
use backward::TermValues;
use checkpoint::Checkpoint;
use dead_channel_reset::revived;
use fovol_net::Weights;
use fovolnet::io::atomic;
use lessons::Lessons;
use progress::Progress;
use replicas::Replicas;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use taken::Taken;
use tch::{Device, Tensor};
use validation::Validation;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All steps are done.
    Complete,
    /// The time limit or a request stopped the run; it can be resumed.
    Stopped,
}

/// File of the averaged weights.
const WEIGHTS: &str = "weights.safetensors";

/// A network in training.
pub struct Trainer {
    config: TrainConfig,
    folder: PathBuf,
    network: Network,
    replicas: Replicas,
    ranger: Ranger,
    average: Average,
    losses: Losses,
    schedule: Cosine,
    /// Steps done.
    step: u64,
    /// Hours of training before this start.
    hours_before: f64,
    /// Start and length of a run whose learning rate follows the clock.
    pace: Option<(Instant, Duration)>,
    /// Distribution over threads before the run was resumed, if known.
    arranged_before: Option<Arrangement>,
    device: Device,
}

impl Trainer {
    /// Prepares a run of `config` that writes to `folder`. With `resume` it continues from the checkpoint there, if
    /// there is one.
    ///
    /// # Errors
    /// Initial weights or a checkpoint that cannot be read or belong to another network.
    pub fn new(config: TrainConfig, folder: &Path, device: Device, resume: bool) -> Result<Self> {
        config.check()?;
        let weights = match &config.from {
            Some(path) => Weights::named_or_read(&fovol_core::text_of_path(path))?,
            None => initial_weights(&config.network.config(), config.spread, config.seed)?,
        };
        // A resumed run finds its own weights there.
        if !resume {
            atomic::refuse_input(&folder.join(WEIGHTS))?;
        }
        let options = Options {
            bf16: config.bf16,
            channels_last: config.channels_last,
            fake_quantised: config.fake_quantised,
        };
        let network = Network::new(&weights, options, device)?;
        let parameters = network.parameters();
        let alone = Arrangement { side_by_side: 1, threads: tch::get_num_threads().max(1) as usize };
        let mut trainer = Self {
            ranger: Ranger::new(&parameters, config.optimiser),
            average: Average::new(&parameters, config.average),
            losses: Losses::new(&config.loss, device)?,
            schedule: Cosine { first: config.rate, last: config.last_rate, epochs: config.epochs() },
            folder: folder.to_owned(),
            step: 0,
            hours_before: 0.0,
            pace: None,
            arranged_before: None,
            replicas: Replicas::new(alone, &network, &config)?,
            network,
            config,
            device,
        };
        std::fs::create_dir_all(folder).map_err(|e| Error::file("make", folder, &e))?;
        if resume && Checkpoint::path(folder).is_file() {
            trainer.restore(&Checkpoint::read(folder)?)?;
        }
        Ok(trainer)
    }

    /// Makes the learning rate follow the clock from now on, and ends training after `time`, however many steps that
    /// allows. Such a run cannot be repeated exactly.
    pub fn pace(&mut self, time: Duration) {
        self.pace = Some((Instant::now(), time));
        self.config.steps = u64::MAX;
    }

    /// Chooses the fastest distribution of steps on `clips` over at most `processors` threads, by timing steps
    /// without learning.
    ///
    /// A resumed run keeps its previous distribution if the machine has enough threads, so that results stay
    /// identical. Returns the distribution, or `None` if training runs on a GPU or there are no clips.
    ///
    /// # Errors
    /// Clips that cannot be read.
    pub fn arrange(&mut self, clips: &ClipSet, processors: usize) -> Result<Option<Arrangement>> {
        if self.device != Device::Cpu || clips.is_empty() {
            return Ok(None);
        }
        let at_once = self.config.at_once.unwrap_or(self.config.batch);
        let candidates = match self.arranged_before.filter(|before| before.fits(processors)) {
            Some(before) => vec![before],
            None => Arrangement::candidates(processors, at_once.min(self.config.batch)),
        };
        let arrangement = match candidates[..] {
            [only] => only,
            _ => {
                // Batches are prepared meanwhile, as in real steps.
                let mut lessons = Lessons::start(clips.clone(), &self.config, self.step, self.device)?;
                Arrangement::quickest(&candidates, |tried| {
                    self.take(tried)?;
                    self.gradients(&lessons.next()?).map(|_| ())
                })?
            }
        };
        self.take(arrangement)?;
        Ok(Some(arrangement))
    }

    /// Distributes steps over threads in this way from now on.
    ///
    /// # Errors
    /// Files of the loss that cannot be read.
    pub fn take(&mut self, arrangement: Arrangement) -> Result<()> {
        if self.replicas.arrangement() != arrangement {
            self.replicas = Replicas::new(arrangement, &self.network, &self.config)?;
        }
        Ok(())
    }

    /// Number of steps done.
    pub fn steps_done(&self) -> u64 {
        self.step
    }

    /// Trains on `clips` until all steps are done, `limit` has passed or `stop` returns true. Validates on `held_out`
    /// every few steps.
    ///
    /// Writes `checkpoint.safetensors`, `weights.safetensors` (the averaged weights), `log.jsonl`, `loss.svg` and
    /// `preview.png` to its folder.
    ///
    /// # Errors
    /// Clips that cannot be read, files that cannot be written, or a loss that is not finite three times in a row.
    pub fn run(
        &mut self,
        clips: &ClipSet,
        held_out: &ClipSet,
        limit: Option<Duration>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Ended> {
        if clips.is_empty() {
            return Err(Error::Config("there are no clips to train on; make some first".into()));
        }
        let started = Instant::now();
        let mut validation = Validation::new(held_out, &self.config.lesson)?;
        let end = self.pace.map(|(began, time)| began + time);
        let mut progress = Progress::new(&self.folder, self.step, self.config.steps, end)?;
        let mut lessons = Lessons::start(clips.clone(), &self.config, self.step, self.device)?;
        let mut saved = Instant::now();
        let mut failures = 0;
        while self.step < self.config.steps && !self.is_out_of_time() {
            if self.is_to_revive() {
                let count = self.revive(clips)?;
                progress.revived(self.step, count)?;
            }
            let lesson = lessons.next()?;
            let rate = self.rate();
            match self.learn(&lesson, rate)? {
                Some(taken) => {
                    failures = 0;
                    progress.step(self.step, rate, &taken)?;
                }
                None => {
                    failures += 1;
                    progress.skipped(self.step)?;
                }
            }
            if failures == 3 {
                return Err(self.diverged());
            }
            self.step += 1;
            if self.step.is_multiple_of(self.config.validate_every) || self.step == self.config.steps {
                self.judge(&mut validation, &mut progress)?;
            }
            let out_of_time = limit.is_some_and(|limit| started.elapsed() >= limit);
            let stops = out_of_time || stop();
            if stops || saved.elapsed().as_secs_f64() > 60.0 * self.config.checkpoint_minutes {
                // Calibrating activation ranges takes a while; it is done only when the run ends and weights may be
                // used.
                self.save(started, stops.then_some(clips))?;
                saved = Instant::now();
            }
            if stops {
                return Ok(Ended::Stopped);
            }
        }
        if self.pace.is_some() {
            self.judge(&mut validation, &mut progress)?;
        }
        self.save(started, Some(clips))?;
        Ok(Ended::Complete)
    }

    fn is_out_of_time(&self) -> bool {
        self.pace.is_some_and(|(began, time)| began.elapsed() >= time)
    }

    /// Whether dead channels are reset before this step. In the second half, new channels would have too little time
    /// to learn.
    fn is_to_revive(&self) -> bool {
        let every = self.config.revive_every;
        every > 0 && self.step.is_multiple_of(every) && self.share_done() < 0.5
    }

    /// Fraction of the run that is done, 0…1.
    fn share_done(&self) -> f64 {
        match self.pace {
            Some((began, time)) => began.elapsed().as_secs_f64() / time.as_secs_f64(),
            None => self.step as f64 / self.config.steps as f64,
        }
    }

    /// Resets channels that stay inactive on `clips`; returns their number.
    fn revive(&mut self, clips: &ClipSet) -> Result<usize> {
        let mut weights = self.network.weights();
        note_ranges(&mut weights, clips, &self.config)?;
        let (weights, count) =
            revived(&weights, self.config.spread, self.config.seed.wrapping_add(self.step))?;
        self.network.load(&weights)?;
        self.ranger.set_out();
        Ok(count)
    }

    /// Learning rate of the next step.
    fn rate(&self) -> f64 {
        if self.pace.is_some() {
            return self.schedule.at(self.share_done());
        }
        self.schedule.rate((self.step / self.config.steps_per_epoch) as u32)
    }

    /// Takes one step. Returns `None` and leaves the weights unchanged if gradients or loss are not finite.
    fn learn(&mut self, lesson: &[LessonFrame], rate: f64) -> Result<Option<Taken>> {
        let terms = self.gradients(lesson)?;
        let norm = clip_gradients(&self.network.parameters(), self.config.clip_gradients);
        if !norm.is_finite() || !terms[0].1.is_finite() {
            return Ok(None);
        }
        self.ranger.step(rate);
        self.average.update();
        Ok(Some(Taken { terms, norm }))
    }

    /// Computes the gradients of the batch `lesson`; returns the terms of its loss.
    fn gradients(&mut self, lesson: &[LessonFrame]) -> Result<TermValues> {
        self.ranger.zero_gradients();
        self.replicas.gradients((&self.network, &self.losses), &self.config, lesson)
    }

    /// Validates the averaged weights on the validation clips.
    fn judge(&mut self, validation: &mut Validation, progress: &mut Progress) -> Result<()> {
        self.average.swap();
        let judged = validation.judge(&self.network, &self.folder.join("preview.png"));
        self.average.swap();
        progress.judged(self.step, &judged?)
    }

    /// Writes a checkpoint and the current averaged weights. If `clips` is given, the weights include activation
    /// ranges on them.
    fn save(&mut self, started: Instant, clips: Option<&ClipSet>) -> Result<()> {
        let hours = self.hours_before + started.elapsed().as_secs_f64() / 3600.0;
        let mut tensors = Vec::new();
        let parts = [
            ("network", self.network.parameters()),
            ("ranger", self.ranger.state()),
            ("average", self.average.state()),
        ];
        for (part, named) in parts {
            tensors.extend(named.into_iter().map(|(name, tensor)| (format!("{part}/{name}"), tensor)));
        }
        let arrangement = Some(self.replicas.arrangement());
        Checkpoint { step: self.step, hours, arrangement, tensors }.write(&self.folder)?;
        self.average.swap();
        let mut weights = self.network.weights();
        self.average.swap();
        weights.facts.insert("steps".into(), self.step.to_string());
        weights.facts.insert("hours".into(), format!("{hours:.2}"));
        weights.facts.insert("seed".into(), self.config.seed.to_string());
        if let Some(clips) = clips {
            note_ranges(&mut weights, clips, &self.config)?;
        }
        let bytes = weights.to_bytes(fovol_net::weights::Storage::F32)?;
        Ok(atomic::write_bytes(&self.folder.join(WEIGHTS), &bytes)?)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let of = |part: &str| -> Vec<(String, Tensor)> {
            let named = checkpoint.tensors.iter();
            named
                .filter_map(|(name, tensor)| {
                    Some((name.strip_prefix(part)?.to_owned(), tensor.shallow_clone()))
                })
                .collect()
        };
        let saved = of("network/");
        for (name, parameter) in self.network.parameters() {
            let found =
                saved.iter().find(|(other, tensor)| *other == name && tensor.size() == parameter.size());
            let (_, tensor) =
                found.ok_or_else(|| Error::Saved(format!("`{name}` is missing or of another shape")))?;
            tch::no_grad(|| parameter.shallow_clone().copy_(&tensor.to_device(self.device)));
        }
        let there = |named: Vec<(String, Tensor)>| -> Vec<(String, Tensor)> {
            named.into_iter().map(|(name, tensor)| (name, tensor.to_device(self.device))).collect()
        };
        self.ranger.restore(&there(of("ranger/")))?;
        self.average.restore(&there(of("average/")))?;
        (self.step, self.hours_before) = (checkpoint.step, checkpoint.hours);
        self.arranged_before = checkpoint.arrangement;
        Ok(())
    }

    fn diverged(&self) -> Error {
        Error::Diverged(format!(
            "the loss is no number in three steps before step {}; the last good checkpoint is {}, go on from it with a \
             smaller `rate` or `clip-gradients`",
            self.step,
            Checkpoint::path(&self.folder).display()
        ))
    }
}
