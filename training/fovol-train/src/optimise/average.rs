use super::saved::Saved;
use crate::Result;
use tch::Tensor;

/// A running mean of weights over steps of training: a ← d a + (1 − d) p with d = min(decay, (1 + n) / (10 + n)) in
/// update n = 1, 2 …, so that the weights that training began with are soon forgotten.
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
    /// The average of `parameters`, which begins with what they are now; `decay` in 0…1 is how much of it stays in an
    /// update.
    pub fn new(parameters: &[(String, Tensor)], decay: f64) -> Self {
        let means = parameters.iter().map(|(name, parameter)| Mean {
            name: name.clone(),
            parameter: parameter.shallow_clone(),
            mean: parameter.detach().copy(),
        });
        Self { decay, updates: 0, means: means.collect() }
    }

    /// Takes in the parameters as they are now.
    pub fn update(&mut self) {
        self.updates += 1;
        let n = self.updates as f64;
        let decay = self.decay.min((1.0 + n) / (10.0 + n));
        for mean in &mut self.means {
            let _ = mean.mean.lerp_(&mean.parameter.detach(), 1.0 - decay);
        }
    }

    /// Exchanges the parameters for the average, as to judge or write it; a second time exchanges them back.
    pub fn swap(&mut self) {
        tch::no_grad(|| {
            for Mean { parameter, mean, .. } in &mut self.means {
                let kept = parameter.detach().copy();
                parameter.copy_(mean);
                mean.copy_(&kept);
            }
        });
    }

    /// What [`Self::restore`] needs to go on from here: copies, named as the parameters, and `updates`.
    pub fn state(&self) -> Vec<(String, Tensor)> {
        let means = self.means.iter().map(|mean| (mean.name.clone(), mean.mean.copy()));
        means.chain([("updates".to_owned(), Tensor::from_slice(&[self.updates]))]).collect()
    }

    /// Goes on from `state`.
    ///
    /// # Errors
    /// A state of other parameters. Nothing has changed then.
    pub fn restore(&mut self, state: &[(String, Tensor)]) -> Result<()> {
        let saved = Saved::new(state);
        let found = self.means.iter().map(|mean| saved.tensor(&mean.name, &mean.mean.size()));
        let found = found.collect::<Result<Vec<_>>>()?;
        self.updates = saved.number("updates")?;
        self.means.iter_mut().zip(found).for_each(|(mean, tensor)| mean.mean.copy_(tensor));
        Ok(())
    }
}
