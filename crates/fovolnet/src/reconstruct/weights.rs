use crate::{Error, RandomWeights, Reconstruction, RenderSettings, Result, WeightsChoice};
use fovol_net::Weights;

/// Weights that `settings` name, checked to be of the network that they reconstruct with.
///
/// # Errors
/// Weights that are missing, unreadable or of another kind of network.
pub fn weights(settings: &RenderSettings) -> Result<Weights> {
    let how = settings.reconstruction;
    let weights = match &settings.weights {
        WeightsChoice::Named(name) => Weights::named_or_read(name)?,
        WeightsChoice::Random(RandomWeights { network, seed }) => Weights::random(&network.config(), *seed)?,
        WeightsChoice::Usual => {
            let network = how.default_network();
            let network = network.ok_or_else(|| Error::Setting(format!("{how} needs no network")))?;
            Weights::shipped(network)?
        }
    };
    let other = Reconstruction::by(&weights.config);
    if other == how {
        return Ok(weights);
    }
    Err(Error::Setting(format!("these weights are of another network; use --reconstruct {other}")))
}
