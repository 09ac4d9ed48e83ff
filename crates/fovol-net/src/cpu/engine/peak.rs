//! Measures the peak arithmetic throughput of this processor, as a reference for speed.

#[cfg(target_arch = "x86_64")]
use crate::cpu::conv::amx;
use crate::cpu::engine::precision::Precision;
use fovol_simd::Simd;
use std::time::Instant;

/// Rounds of a measurement, which take a few milliseconds.
const ROUNDS: usize = 2_000_000;

/// Measures operations per second of the numbers that dominate at `precision`; a multiply-add counts as two. All
/// threads of the current pool work in registers, so this bounds the speed of every convolution.
pub fn peak_flops(simd: Simd, precision: Precision) -> f64 {
    // The first run wakes the processor up; the best of three more counts.
    let runs = (0..4).map(|_| {
        let started = Instant::now();
        let operations: usize = rayon::broadcast(|_| spin(simd, precision)).into_iter().sum();
        operations as f64 / started.elapsed().as_secs_f64()
    });
    runs.skip(1).fold(0.0, f64::max)
}

/// Works for some milliseconds and returns the number of operations.
fn spin(simd: Simd, precision: Precision) -> usize {
    match (simd, precision.on(simd)) {
        #[cfg(target_arch = "x86_64")]
        (Simd::Amx { .. }, Precision::Bf16) => amx::spin_bf16(),
        #[cfg(target_arch = "x86_64")]
        (Simd::Amx { .. }, Precision::Int8 | Precision::Mixed) => amx::spin_int8(),
        // SAFETY: instruction sets and precisions are only chosen where the processor has them.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512 { .. }, Precision::Bf16) => unsafe { spin_avx512_bf16() },
        // SAFETY: see above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512 { .. }, Precision::Int8 | Precision::Mixed) => unsafe { spin_avx512_int8() },
        // SAFETY: see above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512 { .. } | Simd::Amx { .. }, _) => unsafe { spin_avx512() },
        // SAFETY: see above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx2 { .. }, Precision::Int8 | Precision::Mixed) => unsafe { spin_avx2_int8() },
        // SAFETY: see above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx2 { .. }, _) => unsafe { spin_avx2() },
        _ => spin_portable(),
    }
}

/// Number of independent chains of operations: more than latency times throughput of an execution unit.
const CHAINS: usize = 12;

/// Defines a benchmark of one instruction, given the initial value of chains, a factor, the step, and the
/// operations of a step.
#[cfg(target_arch = "x86_64")]
macro_rules! spin {
    ($name:ident, $features:literal, $start:expr, $factor:expr, $step:expr, $operations:literal) => {
        #[target_feature(enable = $features)]
        unsafe fn $name() -> usize {
            use std::arch::x86_64::*;
            let mut sums = [$start; CHAINS];
            let factor = std::hint::black_box($factor);
            for _ in 0..ROUNDS {
                for sum in &mut sums {
                    *sum = $step(*sum, factor, factor);
                }
            }
            std::hint::black_box(sums);
            ROUNDS * CHAINS * $operations
        }
    };
}
#[cfg(target_arch = "x86_64")]
spin!(spin_avx512, "avx512f", _mm512_set1_ps(1.0), _mm512_set1_ps(0.999), _mm512_fmadd_ps, 32);
#[cfg(target_arch = "x86_64")]
spin!(
    spin_avx512_bf16,
    "avx512f,avx512bf16",
    _mm512_set1_ps(1.0),
    // SAFETY: both types are 64 bytes without invalid values.
    unsafe { std::mem::transmute::<__m512, __m512bh>(_mm512_set1_ps(0.5)) },
    _mm512_dpbf16_ps,
    64
);
#[cfg(target_arch = "x86_64")]
spin!(
    spin_avx512_int8,
    "avx512f,avx512vnni",
    _mm512_setzero_si512(),
    _mm512_set1_epi32(0x0101_0101),
    _mm512_dpbusd_epi32,
    128
);
#[cfg(target_arch = "x86_64")]
spin!(spin_avx2, "avx2,fma", _mm256_set1_ps(1.0), _mm256_set1_ps(0.999), _mm256_fmadd_ps, 16);
#[cfg(target_arch = "x86_64")]
spin!(
    spin_avx2_int8,
    "avx2,avxvnni",
    _mm256_setzero_si256(),
    _mm256_set1_epi32(0x0101_0101),
    _mm256_dpbusd_avx_epi32,
    64
);

fn spin_portable() -> usize {
    let mut sums = [[1.0f32; 4]; CHAINS];
    let factor = std::hint::black_box(0.999f32);
    for _ in 0..ROUNDS {
        for sum in sums.iter_mut().flatten() {
            *sum = *sum * factor + factor;
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 4 * 2
}
