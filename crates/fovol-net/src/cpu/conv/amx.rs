//! Convolution kernels for AMX: 32 pixels × 32 (or 16) channels. A tile has 16 rows of 64 bytes: words of 16
//! pixels, or weights of 16 words.
//!
//! The instructions are written in assembly, because Rust has no stable intrinsics for them.

use super::call::Call;
use fovol_simd::Simd;
use std::arch::asm;
use std::marker::PhantomData;

/// Number of pixels of a group: two tiles of them.
pub const GROUP: usize = 32;
/// Number of words of a window's row that are multiplied at once.
pub const RUN: usize = 16;

/// Tile configuration: 16 rows of 64 bytes for every tile.
#[repr(C, align(64))]
struct Shapes {
    palette: u8,
    start: u8,
    reserved: [u8; 14],
    bytes: [u16; 16],
    rows: [u8; 16],
}

static SHAPES: Shapes = {
    let (mut bytes, mut rows) = ([0; 16], [0; 16]);
    let mut tile = 0;
    while tile < 8 {
        (bytes[tile], rows[tile]) = (64, 16);
        tile += 1;
    }
    Shapes { palette: 1, start: 0, reserved: [0; 14], bytes, rows }
};

/// Guard for the tile registers of this thread. It must stay on its thread.
pub struct Tiles(PhantomData<*const ()>);

impl Tiles {
    /// Configures the tile registers.
    ///
    /// # Safety
    /// [`Simd::Amx`] must be available.
    pub unsafe fn new() -> Self {
        // SAFETY: palette 1 allows these shapes.
        unsafe { asm!("ldtilecfg [{0}]", in(reg) &raw const SHAPES, options(nostack, readonly)) };
        Self(PhantomData)
    }
}

impl Drop for Tiles {
    fn drop(&mut self) {
        // SAFETY: tiles are configured while the guard lives, and nothing else on this thread uses them.
        unsafe { asm!("tilerelease", options(nostack, nomem)) };
    }
}

/// Runs `$step` for every 16 words of a window, then `$end`, with the parameters of a call in registers.
///
/// `{near}` and `{far}` point to the pixels of two tiles and `{weights}` to their weights, which steps advance.
/// Rows of pixels are `{pixel}` bytes apart, rows of weights and sums `{width}`.
macro_rules! multiply {
    ($call:expr, $out:expr, $width:expr, [$($step:expr),+], [$($end:expr),+]) => {
        asm!(
            "2:",
            "mov {k}, {steps}",
            "mov {near}, {patch}",
            "lea {far}, [{patch} + {half}]",
            "3:",
            $($step,)+
            "add {near}, 64",
            "add {far}, 64",
            "dec {k}",
            "jnz 3b",
            "add {patch}, {row}",
            "dec {rows}",
            "jnz 2b",
            $($end,)+
            patch = inout(reg) $call.patch => _,
            weights = inout(reg) $call.weights => _,
            rows = inout(reg) $call.rows => _,
            row = in(reg) $call.row * 4,
            pixel = in(reg) $call.pixel * 4,
            half = in(reg) $call.pixel * 4 * 16,
            steps = in(reg) $call.run.div_ceil(RUN),
            width = in(reg) $width * 4,
            out = in(reg) $out,
            k = out(reg) _,
            near = out(reg) _,
            far = out(reg) _,
            options(nostack),
        )
    };
}

/// Defines the kernels of one type of arithmetic, for 32 and for 16 channels.
///
/// Each step multiplies 16 words of a window's row: pixels in tiles 4 and 5, weights in 6 and 7, sums in 0 to 3.
/// Weights are padded with zeros to whole runs, so words after the end of a window's row do not count.
macro_rules! kernels {
    ($module:ident, $multiply:literal, $begin:expr, $doc:literal) => {
        #[doc = $doc]
        pub mod $module {
            use super::*;

            /// Kernel for 32 channels.
            ///
            /// # Safety
            /// This thread must have [`Tiles`]; the call's patch must be readable for a whole run after the last
            /// window's, weights for whole runs, `out` writable for a whole block.
            pub unsafe fn thirty_two(call: &Call, out: *mut f32) {
                // SAFETY: required of the caller; nothing else uses this thread's tiles.
                unsafe {
                    $begin(call.bias, 32);
                    multiply!(
                        call,
                        out,
                        32_usize,
                        [
                            "tileloadd tmm4, [{near} + {pixel}]",
                            "tileloadd tmm6, [{weights} + {width}]",
                            concat!($multiply, " tmm0, tmm4, tmm6"),
                            "tileloadd tmm5, [{far} + {pixel}]",
                            concat!($multiply, " tmm2, tmm5, tmm6"),
                            "tileloadd tmm7, [{weights} + {width} + 64]",
                            concat!($multiply, " tmm1, tmm4, tmm7"),
                            concat!($multiply, " tmm3, tmm5, tmm7"),
                            "add {weights}, 2048"
                        ],
                        [
                            "tilestored [{out} + {width}], tmm0",
                            "tilestored [{out} + {width} + 64], tmm1",
                            "tilestored [{out} + {width} + 2048], tmm2",
                            "tilestored [{out} + {width} + 2112], tmm3"
                        ]
                    );
                }
            }

            /// Kernel for 16 channels.
            ///
            /// # Safety
            /// The conditions of [`thirty_two`].
            pub unsafe fn sixteen(call: &Call, out: *mut f32) {
                // SAFETY: required of the caller; nothing else uses this thread's tiles.
                unsafe {
                    $begin(call.bias, 16);
                    multiply!(
                        call,
                        out,
                        16_usize,
                        [
                            "tileloadd tmm4, [{near} + {pixel}]",
                            "tileloadd tmm6, [{weights} + {width}]",
                            concat!($multiply, " tmm0, tmm4, tmm6"),
                            "tileloadd tmm5, [{far} + {pixel}]",
                            concat!($multiply, " tmm2, tmm5, tmm6"),
                            "add {weights}, 1024"
                        ],
                        ["tilestored [{out} + {width}], tmm0", "tilestored [{out} + {width} + 1024], tmm2"]
                    );
                }
            }
        }
    };
}

/// Rounds of [`spin_bf16`] and [`spin_int8`], which take a few milliseconds.
const ROUNDS: usize = 200_000;

/// Defines a benchmark that multiplies tiles, with four independent sums, and returns the number of operations.
macro_rules! spin {
    ($name:ident, $multiply:literal, $per_word:literal, $doc:literal) => {
        #[doc = $doc]
        pub fn $name() -> usize {
            if !matches!(Simd::best(), Simd::Amx { .. }) {
                return 0;
            }
            // SAFETY: tiles are granted, and nothing else uses those of this thread.
            unsafe {
                let _tiles = Tiles::new();
                asm!(
                    "tilezero tmm4",
                    "tilezero tmm5",
                    "2:",
                    concat!($multiply, " tmm0, tmm4, tmm5"),
                    concat!($multiply, " tmm1, tmm4, tmm5"),
                    concat!($multiply, " tmm2, tmm4, tmm5"),
                    concat!($multiply, " tmm3, tmm4, tmm5"),
                    "dec {rounds}",
                    "jnz 2b",
                    rounds = inout(reg) ROUNDS => _,
                    options(nostack, nomem),
                );
            }
            ROUNDS * 4 * (16 * 16 * 16 * $per_word) * 2
        }
    };
}

spin!(
    spin_bf16,
    "tdpbf16ps",
    2,
    "Multiplies tiles of bf16 for a few milliseconds; returns the number of multiplications and additions."
);
spin!(
    spin_int8,
    "tdpbusd",
    4,
    "Multiplies tiles of bytes for a few milliseconds; returns the number of multiplications and additions."
);

kernels!(bf16, "tdpbf16ps", from_bias, "Kernels for bf16, two in each word.");
kernels!(int8, "tdpbusd", from_zero, "Kernels for bytes, four in each word.");

/// Initialises sums with the bias of their channel: every row of a tile gets the 16 biases.
unsafe fn from_bias(bias: *const f32, width: usize) {
    // SAFETY: the caller has tiles, and a bias for each of `width` channels.
    unsafe {
        asm!(
            "tileloadd tmm0, [{bias} + {same}]",
            "tileloadd tmm1, [{second} + {same}]",
            "tileloadd tmm2, [{bias} + {same}]",
            "tileloadd tmm3, [{second} + {same}]",
            bias = in(reg) bias,
            second = in(reg) bias.add(width - 16),
            same = in(reg) 0usize,
            options(nostack, readonly),
        );
    }
}

/// Initialises sums of int8 products with zero.
unsafe fn from_zero(_: *const f32, _: usize) {
    // SAFETY: the caller has tiles.
    unsafe {
        asm!("tilezero tmm0", "tilezero tmm1", "tilezero tmm2", "tilezero tmm3", options(nostack, nomem));
    };
}
