//! Plain code that the compiler turns into whatever vectors the processor has.

use super::Call;

/// Pixels of a group.
pub const GROUP: usize = 4;
/// Channels of a block.
pub const WIDTH: usize = 16;

/// The kernel.
///
/// # Safety
/// The call's patch and weights must be readable, `out` writable for a whole block.
pub unsafe fn kernel(call: &Call, out: *mut f32) {
    // SAFETY: the caller's.
    unsafe {
        let bias = call.bias.cast::<[f32; WIDTH]>().read();
        let mut sums = [bias; GROUP];
        for row in 0..call.rows {
            let patch = call.patch.add(row * call.row);
            let weights = call.weights.add(row * call.run * WIDTH);
            for k in 0..call.run {
                let w = weights.add(k * WIDTH).cast::<[f32; WIDTH]>().read();
                for (p, sums) in sums.iter_mut().enumerate() {
                    let v = *patch.add(p * call.pixel + k);
                    for c in 0..WIDTH {
                        sums[c] += v * w[c];
                    }
                }
            }
        }
        out.cast::<[[f32; WIDTH]; GROUP]>().write(sums);
    }
}
