//! `tests/reference/blosc_chunks.py` made the chunks by Blosc itself.

use super::*;

const CHUNKS: &[u8] = include_bytes!("chunks.bin");

fn smooth(count: usize) -> Vec<u8> {
    (0..count).map(|i| (i / 300 + i / 1024 * (i / 2 % 2)) as u8).collect()
}

fn repeated(count: usize) -> Vec<u8> {
    let mut state = 1u32;
    let noise: Vec<u8> = (0..8500)
        .map(|_| {
            state = state.wrapping_mul(1_103_515_245).wrapping_add(12_345) & 0x7FFF_FFFF;
            (state >> 16) as u8
        })
        .collect();
    (0..count).map(|i| noise[i % 8500]).collect()
}

/// The content of each chunk, in their order.
fn contents() -> impl Iterator<Item = Vec<u8>> {
    let lengths = (0..3 * 3 * 3).flat_map(|_| [0, 1000, 12_000]);
    lengths.map(smooth).chain([repeated(17_500), repeated(17_500)])
}

/// Bytes of the chunk that begins `chunks`.
fn whole(chunks: &[u8]) -> usize {
    u32::from_le_bytes(*chunks[12..].first_chunk().unwrap()) as usize
}

#[test]
fn chunks_of_blosc_itself() {
    let mut at = 0;
    for (index, expected) in contents().enumerate() {
        let chunk = &CHUNKS[at..];
        let found = unpacked(chunk, 1 << 20).unwrap_or_else(|problem| panic!("{index}: {problem}"));
        assert!(found == expected, "{index}: {:?}", &chunk[..16]);
        at += whole(chunk);
    }
    #[cfg(not(feature = "zarr"))]
    assert!(unpacked(&CHUNKS[at..], 1 << 20).unwrap_err().to_string().contains("feature `zarr`"));
    #[cfg(feature = "zarr")]
    assert!(unpacked(&CHUNKS[at..], 1 << 20).is_ok());
}

#[test]
fn nothing_is_longer_than_allowed() {
    let chunk = contents().take(1).fold(CHUNKS, |chunks, _| &chunks[whole(chunks)..]);
    assert!(unpacked(chunk, 999).is_err());
    assert_eq!(unpacked(chunk, 1000).unwrap().len(), 1000);
}

#[test]
fn damage_never_panics() {
    let mut at = 0;
    for _ in contents() {
        let length = whole(&CHUNKS[at..]);
        let chunk = &CHUNKS[at..at + length];
        for cut in (0..length).step_by(length / 20 + 1) {
            assert!(cut == length || unpacked(&chunk[..cut], 1 << 20).is_err());
            let mut changed = chunk.to_vec();
            changed[cut] ^= 0x55;
            drop(unpacked(&changed, 1 << 20));
        }
        at += length;
    }
}
