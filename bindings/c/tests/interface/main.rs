//! The C interface, called as C calls it.

#![expect(
    clippy::undocumented_unsafe_blocks,
    reason = "one promise holds for all calls: pointers are null, or point to what the header asks for"
)]

mod calls;
mod frames;
mod header;
mod mistakes;
mod pictures;
mod reconstructing;
