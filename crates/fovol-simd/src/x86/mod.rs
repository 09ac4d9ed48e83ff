//! Vectors of x86 processors.
//!
//! Each operation is one instruction, or a few. They are unsafe for the compiler only because a processor may lack
//! them; the first vector of a type is made where the instructions are known to exist, and all others derive from it.

mod avx2;
mod avx512;
pub(crate) mod features;
mod gathers;

pub(crate) use avx2::Avx2;
pub(crate) use avx512::Avx512;

/// Spreads the two low bytes of every 32-bit word to 16 bits each; 0x80 makes zeros.
const PICK_LOW: [u8; 16] = [0, 0x80, 1, 0x80, 4, 0x80, 5, 0x80, 8, 0x80, 9, 0x80, 12, 0x80, 13, 0x80];
/// Spreads the two high bytes of every 32-bit word to 16 bits each; 0x80 makes zeros.
const PICK_HIGH: [u8; 16] = [2, 0x80, 3, 0x80, 6, 0x80, 7, 0x80, 10, 0x80, 11, 0x80, 14, 0x80, 15, 0x80];

/// Defines methods whose bodies use instructions that the vectors in hand prove to exist. Loads and stores in them take
/// slices that they have shortened to the length of a vector.
macro_rules! instructions {
    ($(
        $(#[$attribute:meta])*
        fn $name:ident $(<const $constant:ident: $kind:ty>)? ($($arguments:tt)*) $(-> $output:ty)? $body:block
    )*) => {$(
        $(#[$attribute])*
        #[inline(always)]
        fn $name $(<const $constant: $kind>)? ($($arguments)*) $(-> $output)? {
            // SAFETY: a vector of this type exists only where its instructions do.
            unsafe { $body }
        }
    )*};
}
use instructions;

/// Implements operators of a vector by one instruction each.
macro_rules! operators {
    ($vector:ident: $($operator:ident::$method:ident = $instruction:ident),*) => {
        $(impl $operator for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: a vector of this type exists only where its instructions do.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        })*
    };
}
use operators;
