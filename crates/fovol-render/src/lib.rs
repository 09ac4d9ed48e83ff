//! Sparse volume rendering: noise, mask, compaction, march and scatter.
