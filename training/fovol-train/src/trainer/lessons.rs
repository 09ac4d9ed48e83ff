use super::TrainConfig;
use crate::clips::{Clip, ClipSet};
use crate::lesson::{LessonFrame, TrainingBatch};
use crate::{Error, Result};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use tch::Device;

/// Queue of training batches that background threads prepare.
pub(super) struct Lessons {
    prepared: Receiver<Result<Vec<LessonFrame>>>,
}

/// Batches prepared ahead.
const AHEAD: usize = 2;

impl Lessons {
    /// Starts preparing batches of `clips` from step `step` on, for a network on `device`.
    ///
    /// # Errors
    /// Batches that cannot be made.
    pub fn start(clips: ClipSet, config: &TrainConfig, step: u64, device: Device) -> Result<Self> {
        let lesson = TrainingBatch::new(&config.lesson)?;
        let threads = threads()?;
        let (sender, prepared) = sync_channel(AHEAD);
        let config = config.clone();
        thread::spawn(move || {
            let lesson_of = |step| {
                threads.install(|| {
                    let frames = prepare(&clips, &config, &lesson, step)?;
                    Ok(frames.into_par_iter().map(|frame| frame.ready_for(device)).collect())
                })
            };
            // Ends when the receiver is dropped.
            let mut step = step;
            while sender.send(lesson_of(step)).is_ok() {
                step += 1;
            }
        });
        Ok(Self { prepared })
    }

    /// Receives the next batch.
    pub fn next(&mut self) -> Result<Vec<LessonFrame>> {
        let ended = |_| Error::Clip("the thread that prepares clips has ended".into());
        self.prepared.recv().map_err(ended)?
    }
}

/// Pool with a thread for every CPU thread. Work is split by clips, so torch uses one thread in each.
fn threads() -> Result<ThreadPool> {
    let threads = ThreadPoolBuilder::new().start_handler(|_| tch::set_num_threads(1)).build();
    threads.map_err(|e| Error::Clip(format!("no threads that prepare clips: {e}")))
}

/// Prepares the batch of step `step`.
pub(super) fn prepare(
    clips: &ClipSet,
    config: &TrainConfig,
    lesson: &TrainingBatch,
    step: u64,
) -> Result<Vec<LessonFrame>> {
    let mut random = ChaCha8Rng::seed_from_u64(config.seed);
    random.set_stream(step + 1);
    let first = step * config.batch as u64;
    let read = (0..config.batch).into_par_iter().map(|i| {
        let clip = shuffled(first + i as u64, clips.len(), config.seed);
        clips.clip(clip)
    });
    let whole: Vec<Clip> = read.collect::<Result<_>>()?;
    let parts: Vec<Clip> = whole.into_iter().map(|clip| part(clip, config.side, &mut random)).collect();
    Ok(lesson.of(&parts, config.frames, &mut random))
}

/// Index of the clip at place `number`: each of `count` clips once in every round of `count` places, shuffled anew
/// each round.
fn shuffled(number: u64, count: usize, seed: u64) -> usize {
    let (round, place) = (number / count as u64, (number % count as u64) as usize);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    random.set_stream(round);
    let mut order: Vec<usize> = (0..count).collect();
    // Fisher-Yates shuffle, as far as needed.
    for i in 0..=place {
        order.swap(i, random.random_range(i..count));
    }
    order[place]
}

/// Random square crop of `side`² pixels of `clip`.
fn part(clip: Clip, side: usize, random: &mut ChaCha8Rng) -> Clip {
    let [width, height] = [clip.scenery.part.width, clip.scenery.part.height].map(|s| s as usize);
    let side = [side.min(width), side.min(height)];
    let corner = [width - side[0], height - side[1]].map(|free| random.random_range(0..=free));
    if side == [width, height] {
        return clip;
    }
    let mut scenery = clip.scenery;
    scenery.corner = [0, 1].map(|a| scenery.corner[a] + corner[a] as u32);
    (scenery.part.width, scenery.part.height) = (side[0] as u32, side[1] as u32);
    let square = Square { corner, side, width };
    Clip {
        frames: clip.frames.iter().map(|frame| square.of(frame, 3)).collect(),
        guides: clip.guides.iter().map(|frame| square.of(frame, 4)).collect(),
        inverse_distances: clip.inverse_distances.iter().map(|frame| square.of(frame, 1)).collect(),
        scenery,
    }
}

/// Crop of frames that are `width` pixels wide.
struct Square {
    corner: [usize; 2],
    side: [usize; 2],
    width: usize,
}

impl Square {
    /// Crops `frame`, which has `numbers` values per pixel.
    fn of<T: Copy>(&self, frame: &[T], numbers: usize) -> Vec<T> {
        let [left, top] = self.corner;
        let row = |y: usize| &frame[numbers * (y * self.width + left)..][..numbers * self.side[0]];
        (top..top + self.side[1]).flat_map(row).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clip_comes_once_a_round() {
        for round in 0..3u64 {
            let mut seen: Vec<usize> = (0..10).map(|i| shuffled(round * 10 + i, 10, 7)).collect();
            assert_ne!(seen, (0..10).collect::<Vec<_>>());
            seen.sort_unstable();
            assert_eq!(seen, (0..10).collect::<Vec<_>>());
        }
        let round = |r: u64| (0..10).map(|i| shuffled(r * 10 + i, 10, 7)).collect::<Vec<_>>();
        assert_ne!(round(0), round(1));
    }
}
