//! Number types in which tensors are stored.

use crate::cpu::tensor::rows::{Rows, View};
use crate::cpu::tensor::{AnyTensor, Tensor};
use bytemuck::{Pod, cast_slice};
use fovol_simd::{Bf16, SimdF32};
use std::any::TypeId;

/// Number type of stored tensors.
pub trait Element: Pod + Default + Send + Sync {
    /// Converts to f32.
    fn to_f32(self) -> f32;
    /// Rounds to the nearest value of this type.
    fn from_f32(value: f32) -> Self;
    /// Returns `numbers` unchanged if they are stored as `N`.
    #[inline(always)]
    fn as_stored<N: Element>(numbers: &[Self]) -> Option<&[N]> {
        (TypeId::of::<Self>() == TypeId::of::<N>()).then(|| cast_slice(numbers))
    }
    /// Stores a vector in the first elements of `to`.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    fn store<V: SimdF32>(vector: V, to: &mut [Self]);
    /// Wraps `map` as a stored tensor.
    fn stored(map: Tensor<Self>) -> AnyTensor;
    /// Unwraps a stored tensor, and returns an empty map for another type.
    fn loaded(stored: AnyTensor) -> Tensor<Self>;
    /// Returns the map in `stored` if it has this type.
    fn of(stored: &AnyTensor) -> Option<&Tensor<Self>>;
    /// Wraps `rows` as a view.
    fn view(rows: Rows<'_, Self>) -> View<'_>;
}

impl Element for f32 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn store<V: SimdF32>(vector: V, to: &mut [f32]) {
        vector.store(to);
    }

    fn stored(map: Tensor) -> AnyTensor {
        AnyTensor::F32(map)
    }

    fn loaded(stored: AnyTensor) -> Tensor {
        if let AnyTensor::F32(map) = stored { map } else { Tensor::default() }
    }

    fn of(stored: &AnyTensor) -> Option<&Tensor> {
        if let AnyTensor::F32(map) = stored { Some(map) } else { None }
    }

    fn view(rows: Rows<'_, Self>) -> View<'_> {
        View::F32(rows)
    }
}

impl Element for Bf16 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        Self::to_f32(self)
    }

    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        Self::from_f32(value)
    }

    #[inline(always)]
    fn store<V: SimdF32>(vector: V, to: &mut [Self]) {
        vector.store_bf16(to);
    }

    fn stored(map: Tensor<Self>) -> AnyTensor {
        AnyTensor::Bf16(map)
    }

    fn loaded(stored: AnyTensor) -> Tensor<Self> {
        if let AnyTensor::Bf16(map) = stored { map } else { Tensor::default() }
    }

    fn of(stored: &AnyTensor) -> Option<&Tensor<Self>> {
        if let AnyTensor::Bf16(map) = stored { Some(map) } else { None }
    }

    fn view(rows: Rows<'_, Self>) -> View<'_> {
        View::Bf16(rows)
    }
}
