use super::saved::Saved;
use crate::Result;
use tch::Tensor;

/// Exponential moving average of weights.
///
/// Update n = 1, 2 … computes a ← d·a + (1 − d)·p with d = min(decay, (1 + n) / (10 + n)), so that the initial
/// weights are soon forgotten.
#[derive(Debug)]
pub struct Average {
    decay: f64,
    updates: i64,
    means: Vec<Mean>,
}

#[derive(Debug)]
struct Mean {
    name: String,
    parameter: Tensor,
    mean: Tensor,
}

impl Average {
    /// Starts the average of `parameters` at their current values. `decay` in 0…1 is the fraction kept in an update.
    pub fn new(parameters: &[(String, Tensor)], decay: f64) -> Self {
        let means = parameters.iter().map(|(name, parameter)| Mean {
            name: name.clone(),
            parameter: parameter.shallow_clone(),
            mean: parameter.detach().copy(),
        });
        Self { decay, updates: 0, means: means.collect() }
    }

    /// Updates the average with the current parameters.
    pub fn update(&mut self) {
        self.updates += 1;
        let n = self.updates as f64;
        let decay = self.decay.min((1.0 + n) / (10.0 + n));
        for mean in &mut self.means {
            let _ = mean.mean.lerp_(&mean.parameter.detach(), 1.0 - decay);
        }
    }

    /// Swaps parameters and average, to evaluate or write the average; a second call swaps them back.
    pub fn swap(&mut self) {
        tch::no_grad(|| {
            for Mean { parameter, mean, .. } in &mut self.means {
                let kept = parameter.detach().copy();
                parameter.copy_(mean);
                mean.copy_(&kept);
            }
        });
    }

    /// Copies of the state for [`Self::restore`]: averages under the parameters' names, and `updates`.
    pub fn state(&self) -> Vec<(String, Tensor)> {
        let means = self.means.iter().map(|mean| (mean.name.clone(), mean.mean.copy()));
        means.chain([("updates".to_owned(), Tensor::from_slice(&[self.updates]))]).collect()
    }

    /// Restores `state`.
    ///
    /// # Errors
    /// A state of other parameters; nothing changes then.
    pub fn restore(&mut self, state: &[(String, Tensor)]) -> Result<()> {
        let saved = Saved::new(state);
        let found = self.means.iter().map(|mean| saved.tensor(&mean.name, &mean.mean.size()));
        let found = found.collect::<Result<Vec<_>>>()?;
        self.updates = saved.number("updates")?;
        self.means.iter_mut().zip(found).for_each(|(mean, tensor)| mean.mean.copy_(tensor));
        Ok(())
    }
}
