use bytemuck::{Pod, Zeroable};

/// Mask of the upper half of a word, where the bf16 of an f32 lies.
pub(crate) const UPPER_HALF: u32 = 0xFFFF_0000;
/// Half a unit in the last place of a bf16, as bits of an f32.
pub(crate) const HALF_ULP: u32 = 0x8000;

/// A bf16: the upper half of an f32.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Bf16(pub u16);

impl Bf16 {
    /// Converts to f32.
    #[inline(always)]
    pub fn to_f32(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }

    /// Rounds to nearest, ties to even. Loops over it are vectorised, unlike loops over the type of the `half` crate.
    /// Values that are not finite stay so.
    #[inline(always)]
    pub fn from_f32(value: f32) -> Self {
        let bits = value.to_bits();
        Self(((bits + 0x7FFF + (bits >> 16 & 1)) >> 16) as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rounding_is_that_of_the_half_crate(value in -1e30f32..1e30) {
            prop_assert_eq!(Bf16::from_f32(value).0, half::bf16::from_f32(value).to_bits());
            prop_assert_eq!(Bf16::from_f32(value).to_f32(), half::bf16::from_f32(value).to_f32());
        }
    }
}
