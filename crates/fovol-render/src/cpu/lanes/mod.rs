//! Vectors of f32, i32 and truth values, written once for every instruction set.
//!
//! A kernel is generic over [`Lanes`], marked `#[inline(always)]`, and instantiated inside a function
//! that enables the instruction set; only there do the operations become single instructions.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
pub(crate) mod portable;

/// The number of lanes of the widest instruction set.
pub const MOST_LANES: usize = 16;

/// Spreads the two low bytes of every 32-bit word to 16 bits each; 0x80 makes zeros.
#[cfg(target_arch = "x86_64")]
const PICK_LOW: [u8; 16] = [0, 0x80, 1, 0x80, 4, 0x80, 5, 0x80, 8, 0x80, 9, 0x80, 12, 0x80, 13, 0x80];
/// Spreads the two high bytes of every 32-bit word to 16 bits each; 0x80 makes zeros.
#[cfg(target_arch = "x86_64")]
const PICK_HIGH: [u8; 16] = [2, 0x80, 3, 0x80, 6, 0x80, 7, 0x80, 10, 0x80, 11, 0x80, 14, 0x80, 15, 0x80];

/// The operations of one instruction set on `N` lanes.
///
/// # Safety
/// Every method may only be called where the instruction set is available. Methods that take pointers
/// or gather from memory also require every address they touch to be readable (or writable).
pub unsafe trait Lanes: Copy + 'static {
    /// The number of lanes.
    const N: usize;
    /// Lanes of f32.
    type F: Copy;
    /// Lanes of i32.
    type I: Copy;
    /// Lanes of truth values.
    type M: Copy;

    unsafe fn splat(x: f32) -> Self::F;
    unsafe fn load(from: *const f32) -> Self::F;
    unsafe fn store(v: Self::F, to: *mut f32);
    unsafe fn add(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sub(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn mul(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn div(a: Self::F, b: Self::F) -> Self::F;
    /// a·b + c, rounded once.
    unsafe fn fma(a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    unsafe fn min(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn max(a: Self::F, b: Self::F) -> Self::F;
    unsafe fn sqrt(a: Self::F) -> Self::F;
    unsafe fn ceil(a: Self::F) -> Self::F;
    unsafe fn abs(a: Self::F) -> Self::F;
    /// 0, 1, 2, …
    unsafe fn iota() -> Self::F;
    /// The sum of all lanes, in a fixed order.
    unsafe fn sum(a: Self::F) -> f32;
    /// The product of all lanes before each lane (1 in lane 0), and the product of all.
    unsafe fn products_before(a: Self::F) -> (Self::F, f32);
    /// Lane i takes lane i − 1 of `v`, lane 0 takes `first`.
    unsafe fn moved_up(v: Self::F, first: f32) -> Self::F;
    /// Lane i takes lane i ^ 1 of `v`.
    unsafe fn neighbours(v: Self::F) -> Self::F;
    /// Lane i takes lane i ^ 2 of `v`.
    unsafe fn next_neighbours(v: Self::F) -> Self::F;
    /// Packs the lanes of `v` where `m` holds and writes N lanes (packed ones first) to `to`.
    unsafe fn compress(v: Self::F, m: Self::M, to: *mut f32);

    /// Lanes where `m` holds take consecutive f32s from `from` on; the others keep `old`. N f32s must be readable.
    unsafe fn expand(old: Self::F, m: Self::M, from: *const f32) -> Self::F;

    unsafe fn truncate(a: Self::F) -> Self::I;
    unsafe fn to_f32(a: Self::I) -> Self::F;
    /// Reinterprets the bits of i32 lanes as f32.
    unsafe fn from_bits(a: Self::I) -> Self::F;
    /// Reinterprets the bits of f32 lanes as i32.
    unsafe fn to_bits(a: Self::F) -> Self::I;

    unsafe fn splat_i(x: i32) -> Self::I;
    unsafe fn add_i(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn sub_i(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn mul_i(a: Self::I, b: Self::I) -> Self::I;
    unsafe fn and_i(a: Self::I, b: Self::I) -> Self::I;
    /// Logical shift right.
    unsafe fn shr_i<const BITS: u32>(a: Self::I) -> Self::I;
    /// Logical shift right by a number known at run time.
    unsafe fn shr_by(a: Self::I, bits: u32) -> Self::I;
    /// Shift left, lane by lane; zeros for 32 and more.
    unsafe fn shift_left(a: Self::I, by: Self::I) -> Self::I;
    /// Logical shift right, lane by lane; zeros for 32 and more.
    unsafe fn shift_right(a: Self::I, by: Self::I) -> Self::I;
    /// 32-bit words at `base` + `SCALE`·offset, any alignment.
    unsafe fn gather<const SCALE: i32>(base: *const u8, offset: Self::I) -> Self::I;
    /// The words at `base` + 4·index and its successor.
    unsafe fn gather_words(base: *const u32, index: Self::I) -> (Self::I, Self::I);
    /// For every word, byte 2·`PAIR` · low half of its weight + byte 2·`PAIR` + 1 · high half.
    unsafe fn weighted_bytes<const PAIR: usize>(words: Self::I, weights: Self::I) -> Self::I;
    /// The f32 at `table`\[index\].
    unsafe fn gather_f32(table: *const f32, index: Self::I) -> Self::F;
    /// The f32 at `base` + 4·index and its successor.
    unsafe fn gather_pair(base: *const u8, index: Self::I) -> (Self::F, Self::F);

    unsafe fn lt(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn gt(a: Self::F, b: Self::F) -> Self::M;
    unsafe fn and_m(a: Self::M, b: Self::M) -> Self::M;
    /// `a` where `m` holds, else `b`.
    unsafe fn select(m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// One bit per lane, lane 0 lowest.
    unsafe fn bits(m: Self::M) -> u32;
    /// The inverse of `bits`.
    unsafe fn mask(bits: u32) -> Self::M;
}
