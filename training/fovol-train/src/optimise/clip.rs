use tch::{Kind, Tensor};

/// What keeps the factor finite, as in PyTorch.
const EPSILON: f64 = 1e-6;

/// The Euclidean length of the gradients of all `parameters` together; those without one count as zero.
pub fn gradient_norm(parameters: &[(String, Tensor)]) -> f64 {
    let norms: Vec<Tensor> = gradients(parameters).iter().map(|g| g.norm().to_kind(Kind::Double)).collect();
    if norms.is_empty() {
        return 0.0;
    }
    // One number comes back from the device, not one for each parameter.
    Tensor::stack(&norms, 0).norm().double_value(&[])
}

/// Shortens the gradients of all `parameters` together to the length `most` where they are longer, and says how long
/// they were (`torch.nn.utils.clip_grad_norm_`).
///
/// Gradients that are not finite stay as they are, and so does the answer: such a step should not be taken.
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
