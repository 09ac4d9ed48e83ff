use fovol_simd::Simd;

/// Instruction sets that rays can be marched with on this processor, the slowest first.
///
/// [`Simd::Scalar`] is the specification in plain code. AMX has nothing for rays.
pub fn available_simd() -> Vec<Simd> {
    let vectors = Simd::available().into_iter().filter(|simd| !matches!(simd, Simd::Amx { .. }));
    [Simd::Scalar].into_iter().chain(vectors).collect()
}

/// The one of [`available_simd`] for this process: [`Simd::best`], or the fastest if that has nothing for rays.
pub fn best_simd() -> Simd {
    let sets = available_simd();
    let fastest = sets.last().copied().unwrap_or(Simd::Scalar);
    sets.into_iter().find(|set| *set == Simd::best()).unwrap_or(fastest)
}
