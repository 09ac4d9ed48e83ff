//! The noise that the program carries is what its generator makes.

use fovol_render::noise::{NoiseSize, STBN_SEED, encode_ranks, ranks};

#[test]
fn the_asset_is_remade_byte_for_byte() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/noise/stbn_128x128x64.ranks");
    let stored = std::fs::read(path).unwrap();
    assert!(encode_ranks(&ranks(NoiseSize::STBN, STBN_SEED)) == stored, "regenerate the asset: see its card");
}
