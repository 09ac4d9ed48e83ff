//! Tests of whole hierarchies in memory.
