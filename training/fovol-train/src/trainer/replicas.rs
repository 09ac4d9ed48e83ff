//! Data parallelism within one process (Krizhevsky 2014): each thread computes a part of the batch with its own
//! replica of the network. Gradients are always summed in one order.

use super::backward::{Backward, TermValues, add};
use super::{Arrangement, TrainConfig};
use crate::lesson::LessonFrame;
use crate::loss::Losses;
use crate::network::Network;
use crate::{Error, Result};
use std::ops::Range;
use std::panic::resume_unwind;
use std::thread;
use tch::{Device, Tensor};

/// Replicas beside the network itself, which computes the first part of a batch.
pub(super) struct Replicas {
    others: Vec<Replica>,
    /// Threads of each replica.
    threads: usize,
}

struct Replica {
    network: Network,
    losses: Losses,
}

impl Replicas {
    /// Makes the replicas of `network` that `arrangement` asks for, and sets torch's thread count on this thread.
    ///
    /// # Errors
    /// Files of the loss that cannot be read.
    pub fn new(arrangement: Arrangement, network: &Network, config: &TrainConfig) -> Result<Self> {
        tch::set_num_threads(arrangement.threads as i32);
        let replica = |_| {
            let losses = Losses::new(&config.loss, network.device())?;
            Ok(Replica { network: network.replica(), losses })
        };
        let others = (1..arrangement.side_by_side).map(replica).collect::<Result<_>>()?;
        Ok(Self { others, threads: arrangement.threads })
    }

    /// Distribution that the replicas were made for.
    pub fn arrangement(&self) -> Arrangement {
        Arrangement { side_by_side: 1 + self.others.len(), threads: self.threads }
    }

    /// Adds the gradients of the batch `lesson` to those of `network`; returns the terms of its loss.
    ///
    /// # Errors
    /// Errors of the networks and the losses.
    pub fn gradients(
        &mut self,
        (network, losses): (&Network, &Losses),
        config: &TrainConfig,
        lesson: &[LessonFrame],
    ) -> Result<TermValues> {
        let batch = lesson[0].colour.size()[0];
        let parts = parts(batch, 1 + self.others.len());
        let at_once = config.at_once.map(|clips| (clips / parts.len()).max(1));
        let (threads, device) = (self.threads as i32, network.device());
        let job = |part: &Range<i64>| Job {
            lesson: lesson.iter().map(|frame| frame.clips(part.start, part.end - part.start)).collect(),
            share: (part.end - part.start) as f64 / batch as f64,
            at_once,
        };
        let found: Vec<Result<TermValues>> = thread::scope(|scope| {
            let others = self.others.iter_mut().zip(&parts[1..]).map(|(replica, part)| {
                let job = job(part);
                scope.spawn(move || {
                    // Torch's thread count is a setting of each calling thread.
                    tch::set_num_threads(threads);
                    replica.network.zero_gradients();
                    job.run((&replica.network, &replica.losses), config, device)
                })
            });
            let others: Vec<_> = others.collect();
            let first = job(&parts[0]).run((network, losses), config, device);
            let others =
                others.into_iter().map(|one| one.join().unwrap_or_else(|panic| resume_unwind(panic)));
            std::iter::once(first).chain(others).collect()
        });
        let mut sums = TermValues::new();
        for terms in found {
            add(&mut sums, terms?, 1.0);
        }
        self.others
            .iter()
            .zip(&parts[1..])
            .try_for_each(|(replica, _)| add_gradients(network, &replica.network))?;
        Ok(sums)
    }
}

/// Part of a batch.
struct Job {
    lesson: Vec<LessonFrame>,
    /// Fraction of the batch.
    share: f64,
    /// Clips computed at once.
    at_once: Option<usize>,
}

impl Job {
    fn run(
        &self,
        (network, losses): (&Network, &Losses),
        config: &TrainConfig,
        device: Device,
    ) -> Result<TermValues> {
        let (share, at_once) = (self.share, self.at_once);
        Backward { network, losses, config, device, share, at_once }.run(&self.lesson)
    }
}

/// Splits `batch` clips into at most `count` parts whose sizes differ by at most one.
fn parts(batch: i64, count: usize) -> Vec<Range<i64>> {
    let count = (count as i64).min(batch);
    (0..count).map(|i| batch * i / count..batch * (i + 1) / count).collect()
}

/// Adds the gradients of `from` to those of `to`.
fn add_gradients(to: &Network, from: &Network) -> Result<()> {
    let gradient = |(_, parameter): &(String, Tensor)| parameter.grad();
    for (to, from) in to.parameters().iter().zip(&from.parameters()) {
        let (mut sum, more) = (gradient(to), gradient(from));
        match (sum.defined(), more.defined()) {
            (true, true) => tch::no_grad(|| sum += more),
            (false, true) => return Err(Error::Input(format!("`{}` learned in a replica alone", to.0))),
            (_, false) => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_whole() {
        for (batch, count) in (1..40).flat_map(|batch| (1..20).map(move |count| (batch, count))) {
            let found = parts(batch, count);
            assert_eq!([found[0].start, found[found.len() - 1].end], [0, batch]);
            assert!(found.windows(2).all(|pair| pair[0].end == pair[1].start));
            let lengths: Vec<i64> = found.iter().map(|part| part.end - part.start).collect();
            let (least, most) = (lengths.iter().min().unwrap(), lengths.iter().max().unwrap());
            assert!(*least > 0 && most - least <= 1, "{lengths:?}");
        }
    }
}
