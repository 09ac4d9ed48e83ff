use fovol_simd::Simd;

/// Instruction sets that rays can be marched with on this processor, the slowest first.
///
/// [`Simd::Scalar`] is the specification in plain code. AMX has nothing for rays.
pub fn available_simd() -> Vec<Simd> {
    let vectors = Simd::available().into_iter().filter(|simd| !matches!(simd, Simd::Amx { .. }));
    [Simd::Scalar].into_iter().chain(vectors).collect()
}

/// The fastest of [`available_simd`].
pub fn best_simd() -> Simd {
    available_simd().pop().unwrap_or(Simd::Scalar)
}

/// Finds one of [`available_simd`] by its name, or [`best_simd`] by `auto`.
///
/// # Errors
/// Another name: a message that lists the names.
pub fn parse_simd(text: &str) -> Result<Simd, String> {
    if text == "auto" { Ok(best_simd()) } else { Simd::named(text, &available_simd()) }
}
