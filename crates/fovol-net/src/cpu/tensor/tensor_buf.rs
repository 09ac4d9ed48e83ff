//! Arrays of any number type in untyped memory, so that tensors of different types can reuse a buffer.

use crate::cpu::tensor::page_buf::PageBuf;
use bytemuck::{Pod, cast_slice, cast_slice_mut};
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

/// Growable array of `T` in untyped memory.
pub struct TensorBuf<T> {
    words: PageBuf,
    length: usize,
    kind: PhantomData<T>,
}

impl<T: Pod> TensorBuf<T> {
    const PER_WORD: usize = size_of::<u32>() / size_of::<T>();

    /// Makes an empty array in the memory `words`.
    pub fn within(words: PageBuf) -> Self {
        Self { words, length: 0, kind: PhantomData }
    }

    /// Returns the memory.
    pub fn into_words(self) -> PageBuf {
        self.words
    }

    /// Number of 32-bit words that `length` elements take.
    pub fn words(length: usize) -> usize {
        length.div_ceil(Self::PER_WORD)
    }

    /// Sets the length. Old elements are kept; new ones are undefined.
    pub fn resize(&mut self, length: usize) {
        // Memory that is long enough is kept, since writing zeros that nobody reads costs time.
        if self.words.len() < Self::words(length) {
            let mut more = PageBuf::zeros(Self::words(length));
            let known = Self::words(self.length);
            more[..known].copy_from_slice(&self.words[..known]);
            self.words = more;
        }
        self.length = length;
    }

    /// Appends `numbers`.
    pub fn extend_from_slice(&mut self, numbers: &[T]) {
        let length = self.length;
        self.resize(length + numbers.len());
        self[length..].copy_from_slice(numbers);
    }

    /// Removes all elements and keeps the memory.
    pub fn clear(&mut self) {
        self.length = 0;
    }
}

impl<T: Pod> Deref for TensorBuf<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &cast_slice(&self.words)[..self.length]
    }
}

impl<T: Pod> DerefMut for TensorBuf<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut cast_slice_mut(&mut self.words)[..self.length]
    }
}

impl<T> Default for TensorBuf<T> {
    fn default() -> Self {
        Self { words: PageBuf::default(), length: 0, kind: PhantomData }
    }
}

impl<T: Pod> FromIterator<T> for TensorBuf<T> {
    fn from_iter<I: IntoIterator<Item = T>>(numbers: I) -> Self {
        Self::from(numbers.into_iter().collect::<Vec<T>>())
    }
}

impl<T: Pod> From<Vec<T>> for TensorBuf<T> {
    fn from(numbers: Vec<T>) -> Self {
        let mut all = Self::default();
        all.extend_from_slice(&numbers);
        all
    }
}

impl<T: Pod> Clone for TensorBuf<T> {
    /// Clones the elements, not the unused memory.
    fn clone(&self) -> Self {
        let mut clone = Self::default();
        clone.extend_from_slice(self);
        clone
    }
}

impl<'a, T: Pod> IntoIterator for &'a TensorBuf<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Pod + PartialEq> PartialEq for TensorBuf<T> {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + std::fmt::Debug> std::fmt::Debug for TensorBuf<T> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self[..].fmt(formatter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_simd::Bf16;

    #[test]
    fn memory_of_one_kind_serves_another() {
        let large: TensorBuf<f32> = (0..100).map(|i| i as f32).collect();
        assert_eq!((large.len(), large[99]), (100, 99.0));
        let words = large.into_words();
        let place = words.as_ptr();
        let mut halves = TensorBuf::<Bf16>::within(words);
        assert!(halves.is_empty());
        halves.resize(199);
        halves.fill(Bf16(7));
        let words = halves.into_words();
        assert_eq!(words.as_ptr(), place);
    }

    #[test]
    fn what_is_there_stays_when_more_comes() {
        let mut numbers: TensorBuf<Bf16> = [1, 2, 3].map(Bf16).into_iter().collect();
        numbers.extend_from_slice(&[Bf16(4), Bf16(5)]);
        assert_eq!(numbers[..], [1, 2, 3, 4, 5].map(Bf16));
        numbers.clear();
        assert_eq!(numbers, TensorBuf::default());
    }
}
