//! Sparse volume rendering: noise, mask, compaction, march and scatter.
//!
//! [`cpu`] is the specification of image formation and its fast twins.

pub mod cpu;
pub mod noise;
