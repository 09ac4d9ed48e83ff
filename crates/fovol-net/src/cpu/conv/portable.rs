//! Convolution kernels in plain code, which the compiler vectorises for any processor.

use super::call::Call;
use fovol_simd::Bf16;

/// Number of pixels of a group.
pub const GROUP: usize = 4;
/// Number of channels of a block.
pub const WIDTH: usize = 16;

/// Kernel for f32.
///
/// # Safety
/// The call's patch and weights must be readable, `out` writable for a whole block.
pub unsafe fn f32(call: &Call, out: *mut f32) {
    // SAFETY: required of the caller.
    unsafe {
        let bias = call.bias.cast::<[f32; WIDTH]>().read();
        kernel(call, out, bias, |sum, v, w| *sum += f32::from_bits(v) * f32::from_bits(w));
    }
}

/// Kernel for pairs of bf16.
///
/// # Safety
/// The call's patch and weights must be readable, `out` writable for a whole block.
pub unsafe fn bf16(call: &Call, out: *mut f32) {
    let half = |word: u32, shift: u32| Bf16((word >> shift) as u16).to_f32();
    // SAFETY: required of the caller.
    unsafe {
        let bias = call.bias.cast::<[f32; WIDTH]>().read();
        kernel(call, out, bias, |sum, v, w| {
            *sum += half(v, 0) * half(w, 0);
            *sum += half(v, 16) * half(w, 16);
        });
    }
}

/// Kernel for quadruples of bytes.
///
/// # Safety
/// The call's patch and weights must be readable, `out` writable for a whole block.
pub unsafe fn int8(call: &Call, out: *mut f32) {
    let product = |v: u32, w: u32| -> i32 {
        let (v, w) = (v.to_le_bytes(), w.to_le_bytes());
        (0..4).map(|i| i32::from(v[i]) * i32::from(w[i] as i8)).sum()
    };
    // SAFETY: required of the caller; i32 sums have the size of f32.
    unsafe {
        let mut sums = [[0i32; WIDTH]; GROUP];
        each(call, |p, c, v, w| sums[p][c] += product(v, w));
        out.cast::<[[i32; WIDTH]; GROUP]>().write(sums);
    }
}

#[inline(always)]
unsafe fn kernel(call: &Call, out: *mut f32, bias: [f32; WIDTH], add: impl Fn(&mut f32, u32, u32)) {
    let mut sums = [bias; GROUP];
    // SAFETY: required of the caller.
    unsafe {
        each(call, |p, c, v, w| add(&mut sums[p][c], v, w));
        out.cast::<[[f32; WIDTH]; GROUP]>().write(sums);
    }
}

/// Calls `add` for every pixel, channel of the block and pair of words to be multiplied.
#[inline(always)]
unsafe fn each(call: &Call, mut add: impl FnMut(usize, usize, u32, u32)) {
    // SAFETY: required of the caller.
    unsafe {
        for row in 0..call.rows {
            let patch = call.patch.add(row * call.row);
            let weights = call.weights.add(row * call.run * WIDTH);
            for k in 0..call.run {
                let w = weights.add(k * WIDTH).cast::<[u32; WIDTH]>().read();
                for p in 0..GROUP {
                    let v = *patch.add(p * call.pixel + k);
                    for c in 0..WIDTH {
                        add(p, c, v, w[c]);
                    }
                }
            }
        }
    }
}
