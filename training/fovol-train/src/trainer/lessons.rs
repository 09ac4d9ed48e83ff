use super::TrainConfig;
use crate::clips::{Clip, ClipSet};
use crate::lesson::{Lesson, LessonFrame};
use crate::{Error, Result};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Lessons one after the other, prepared ahead by a thread of their own.
pub(super) struct Lessons {
    prepared: Receiver<Result<Vec<LessonFrame>>>,
}

/// How many are prepared ahead.
const AHEAD: usize = 2;

impl Lessons {
    /// The lessons of `config` on `clips` from step `step` on.
    ///
    /// # Errors
    /// Lessons that cannot be made.
    pub fn start(clips: ClipSet, config: &TrainConfig, step: u64) -> Result<Self> {
        let lesson = Lesson::new(&config.lesson)?;
        let (sender, prepared) = sync_channel(AHEAD);
        let config = config.clone();
        thread::spawn(move || {
            // Ends when nobody listens any more.
            let mut step = step;
            while sender.send(prepare(&clips, &config, &lesson, step)).is_ok() {
                step += 1;
            }
        });
        Ok(Self { prepared })
    }

    /// The next one.
    pub fn next(&mut self) -> Result<Vec<LessonFrame>> {
        let ended = |_| Error::Clip("the thread that prepares clips has ended".into());
        self.prepared.recv().map_err(ended)?
    }
}

/// The lesson of step `step`.
pub(super) fn prepare(
    clips: &ClipSet,
    config: &TrainConfig,
    lesson: &Lesson,
    step: u64,
) -> Result<Vec<LessonFrame>> {
    let mut random = ChaCha8Rng::seed_from_u64(config.seed);
    random.set_stream(step + 1);
    let chosen = (0..config.batch).map(|i| {
        let number = step * config.batch as u64 + i as u64;
        let clip = clips.clip(shuffled(number, clips.len(), config.seed))?;
        Ok(part(&clip, config.side, &mut random))
    });
    let chosen: Vec<Clip> = chosen.collect::<Result<_>>()?;
    Ok(lesson.of(&chosen, config.frames, &mut random))
}

/// Which of `count` clips comes at place `number`: each once in every `count` places, in an order of its own.
fn shuffled(number: u64, count: usize, seed: u64) -> usize {
    let (round, place) = (number / count as u64, (number % count as u64) as usize);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    random.set_stream(round);
    let mut order: Vec<usize> = (0..count).collect();
    // Fisher and Yates, as far as it is needed.
    for i in 0..=place {
        order.swap(i, random.random_range(i..count));
    }
    order[place]
}

/// A random square of `side`² pixels of `clip`.
fn part(clip: &Clip, side: usize, random: &mut ChaCha8Rng) -> Clip {
    let [width, height] = [clip.scenery.part.width, clip.scenery.part.height].map(|s| s as usize);
    let side = [side.min(width), side.min(height)];
    let corner = [width - side[0], height - side[1]].map(|free| random.random_range(0..=free));
    if side == [width, height] {
        return clip.clone();
    }
    let mut out = clip.clone();
    out.scenery.corner = [0, 1].map(|a| clip.scenery.corner[a] + corner[a] as u32);
    (out.scenery.part.width, out.scenery.part.height) = (side[0] as u32, side[1] as u32);
    let rows = corner[1]..corner[1] + side[1];
    for (to, from) in out.frames.iter_mut().zip(&clip.frames) {
        *to =
            rows.clone().flat_map(|y| from[3 * (y * width + corner[0])..][..3 * side[0]].to_vec()).collect();
    }
    for (to, from) in out.inverse_distances.iter_mut().zip(&clip.inverse_distances) {
        *to = rows.clone().flat_map(|y| from[y * width + corner[0]..][..side[0]].to_vec()).collect();
    }
    out
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
