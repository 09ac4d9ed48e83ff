//! Values of any type as 64-bit floats, and back. Readers share it, so that only this file is compiled for every type.

use fovol_core::{Dtype, Endian, Voxel, with_voxel_type};

/// Values that are converted at once.
const PIECE: usize = 512;

/// The values in `bytes`.
pub fn decoded(bytes: &[u8], dtype: Dtype, endian: Endian) -> Vec<f64> {
    let mut values = vec![0.0; bytes.len() / dtype.size()];
    decode(bytes, dtype, endian, &mut values);
    values
}

/// Calls `visit` with each value in `bytes`.
pub fn for_each(bytes: &[u8], dtype: Dtype, endian: Endian, mut visit: impl FnMut(f64)) {
    let mut values = [0.0; PIECE];
    for piece in bytes.chunks(PIECE * dtype.size()) {
        let values = &mut values[..piece.len() / dtype.size()];
        decode(piece, dtype, endian, values);
        values.iter().for_each(|&value| visit(value));
    }
}

fn decode(bytes: &[u8], dtype: Dtype, endian: Endian, values: &mut [f64]) {
    with_voxel_type!(dtype, T => {
        for (value, raw) in values.iter_mut().zip(bytes.chunks_exact(size_of::<T>())) {
            *value = T::decode(raw, endian).to_f64();
        }
    });
}

/// Writes the nearest values of type `dtype` to `out`, little-endian.
pub fn encode(values: &[f64], dtype: Dtype, out: &mut [u8]) {
    with_voxel_type!(dtype, T => {
        for (place, value) in out.chunks_exact_mut(size_of::<T>()).zip(values) {
            place.copy_from_slice(&T::from_f64(*value).to_le_bytes());
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_every_type_come_back() {
        let values: Vec<f64> = (0..2 * PIECE + 7).map(|index| (index % 100) as f64).collect();
        for dtype in Dtype::ALL {
            let mut bytes = vec![0; values.len() * dtype.size()];
            encode(&values, dtype, &mut bytes);
            assert_eq!(decoded(&bytes, dtype, Endian::Little), values, "{dtype}");
            bytes.chunks_exact_mut(dtype.size()).for_each(<[u8]>::reverse);
            let mut visited = Vec::new();
            for_each(&bytes, dtype, Endian::Big, |value| visited.push(value));
            assert_eq!(visited, values, "{dtype}");
        }
    }

    #[test]
    fn values_beyond_a_type_become_its_nearest() {
        let mut bytes = [0; 2];
        encode(&[-3.0, 300.4], Dtype::U8, &mut bytes);
        assert_eq!(bytes, [0, 255]);
    }
}
