use tch::{Kind, Tensor};

/// Keeps the factor finite, as in PyTorch.
const EPSILON: f64 = 1e-6;

/// Euclidean norm of the gradients of all `parameters` together; missing gradients count as zero.
pub fn gradient_norm(parameters: &[(String, Tensor)]) -> f64 {
    let norms: Vec<Tensor> = gradients(parameters).iter().map(|g| g.norm().to_kind(Kind::Double)).collect();
    if norms.is_empty() {
        return 0.0;
    }
    // One value comes back from the device, not one for each parameter.
    Tensor::stack(&norms, 0).norm().double_value(&[])
}

/// Scales the gradients of all `parameters` to a joint norm of at most `most` (`torch.nn.utils.clip_grad_norm_`).
/// Returns the norm before.
///
/// Non-finite gradients stay unchanged and make the norm non-finite; the caller should skip such a step.
pub fn clip_gradients(parameters: &[(String, Tensor)], most: f64) -> f64 {
    let norm = gradient_norm(parameters);
    let factor = most / (norm + EPSILON);
    if norm.is_finite() && factor < 1.0 {
        tch::no_grad(|| gradients(parameters).iter_mut().for_each(|gradient| *gradient *= factor));
    }
    norm
}

fn gradients(parameters: &[(String, Tensor)]) -> Vec<Tensor> {
    parameters.iter().map(|(_, parameter)| parameter.grad()).filter(Tensor::defined).collect()
}
