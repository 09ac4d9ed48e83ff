//! What this processor can do at most, to compare with.

#[cfg(target_arch = "x86_64")]
use super::conv::amx;
use super::precision::Precision;
use super::simd::Simd;
use std::time::Instant;

/// Rounds of a measurement: some milliseconds.
const ROUNDS: usize = 2_000_000;

/// Multiplications and additions (two operations each) of the numbers that `precision` has most of, which the threads of
/// the current pool do in a second, all in registers: the limit of every convolution that multiplies such numbers.
pub fn peak_flops(simd: Simd, precision: Precision) -> f64 {
    // Once to wake the processor up, then the best of three.
    let runs = (0..4).map(|_| {
        let started = Instant::now();
        let operations: usize = rayon::broadcast(|_| spin(simd, precision)).into_iter().sum();
        operations as f64 / started.elapsed().as_secs_f64()
    });
    runs.skip(1).fold(0.0, f64::max)
}

/// Works for a while and returns the number of operations.
fn spin(simd: Simd, precision: Precision) -> usize {
    match (simd, precision.on(simd)) {
        #[cfg(target_arch = "x86_64")]
        (Simd::Amx, Precision::Bf16) => amx::spin_bf16(),
        #[cfg(target_arch = "x86_64")]
        (Simd::Amx, Precision::Int8 | Precision::Mixed) => amx::spin_int8(),
        // SAFETY: instruction sets and precisions are only named where the processor has them.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512, Precision::Bf16) => unsafe { spin_avx512_bf16() },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512, Precision::Int8 | Precision::Mixed) => unsafe { spin_avx512_int8() },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx512 | Simd::Amx, _) => unsafe { spin_avx512() },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx2, Precision::Int8 | Precision::Mixed) => unsafe { spin_avx2_int8() },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        (Simd::Avx2, _) => unsafe { spin_avx2() },
        _ => spin_portable(),
    }
}

/// Chains of operations that do not wait for each other: more than a unit's latency times its width.
const CHAINS: usize = 12;

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
unsafe fn spin_avx512() -> usize {
    use std::arch::x86_64::*;
    let mut sums = [_mm512_set1_ps(1.0); CHAINS];
    let factor = std::hint::black_box(_mm512_set1_ps(0.999));
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = _mm512_fmadd_ps(*sum, factor, factor);
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 16 * 2
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
unsafe fn spin_avx512_bf16() -> usize {
    use std::arch::x86_64::*;
    let mut sums = [_mm512_set1_ps(1.0); CHAINS];
    let factor = std::hint::black_box(_mm512_set1_ps(0.5));
    // SAFETY: both are 64 bytes of any content.
    let factor = unsafe { std::mem::transmute::<__m512, __m512bh>(factor) };
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = _mm512_dpbf16_ps(*sum, factor, factor);
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 32 * 2
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vnni")]
unsafe fn spin_avx512_int8() -> usize {
    use std::arch::x86_64::*;
    let mut sums = [_mm512_setzero_si512(); CHAINS];
    let factor = std::hint::black_box(_mm512_set1_epi32(0x0101_0101));
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = _mm512_dpbusd_epi32(*sum, factor, factor);
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 64 * 2
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn spin_avx2() -> usize {
    use std::arch::x86_64::*;
    let mut sums = [_mm256_set1_ps(1.0); CHAINS];
    let factor = std::hint::black_box(_mm256_set1_ps(0.999));
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = _mm256_fmadd_ps(*sum, factor, factor);
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 8 * 2
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avxvnni")]
unsafe fn spin_avx2_int8() -> usize {
    use std::arch::x86_64::*;
    let mut sums = [_mm256_setzero_si256(); CHAINS];
    let factor = std::hint::black_box(_mm256_set1_epi32(0x0101_0101));
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = _mm256_dpbusd_avx_epi32(*sum, factor, factor);
        }
    }
    std::hint::black_box(sums);
    ROUNDS * CHAINS * 32 * 2
}

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
