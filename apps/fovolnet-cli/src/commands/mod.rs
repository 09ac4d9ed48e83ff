pub mod data;
pub mod demo;
pub mod info;
pub mod mask;
pub mod metrics;
pub mod noise;
pub mod reconstruct;
pub mod render;
