//! Memory that several threads fill, each its own places.

use super::window::Window;
use std::marker::PhantomData;

/// A buffer of which each thread writes other bytes.
pub struct Target<'a> {
    start: *mut u8,
    length: usize,
    bytes: PhantomData<&'a mut [u8]>,
}

// SAFETY: it stands for a mutable slice of bytes, which may be sent and, as `write` demands, is never written at one
// place by two threads.
unsafe impl Send for Target<'_> {}
// SAFETY: as above.
unsafe impl Sync for Target<'_> {}

impl<'a> Target<'a> {
    /// The buffer `bytes`.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { start: bytes.as_mut_ptr(), length: bytes.len(), bytes: PhantomData }
    }

    /// Writes `values` from `at` on.
    ///
    /// # Safety
    /// No other thread may use these bytes meanwhile.
    unsafe fn put(&self, at: usize, values: &[u8]) {
        assert!(at <= self.length && values.len() <= self.length - at, "a chunk leaves the volume");
        // SAFETY: the bytes are within the buffer, as was just asserted, which is borrowed as long as `self` and is not
        // `values`; our caller promises that nobody else uses them.
        unsafe { self.start.add(at).copy_from_nonoverlapping(values.as_ptr(), values.len()) };
    }

    /// Writes the values of `window` from a chunk of `values` in C order, of shape `chunk`. A single value stands for a
    /// chunk that has it everywhere.
    ///
    /// # Safety
    /// No two threads may write windows that share a place in memory at the same time.
    pub unsafe fn write(&self, window: &Window, chunk: &[usize], values: &[u8], size: usize) {
        let is_one = values.len() == size;
        let mut axes = Vec::with_capacity(chunk.len());
        let (mut from, mut step) = (0, size);
        for (axis, &length) in chunk.iter().enumerate().rev() {
            let range = &window.ranges[axis];
            let stride = if is_one { 0 } else { step };
            from += range.start * stride;
            axes.push(Axis { count: range.len(), from: stride, to: window.strides[axis] });
            step *= length;
        }
        let axes = merged(axes);
        // SAFETY: as our caller promises.
        unsafe { self.copy(&axes, values, from, window.base, size) };
    }

    /// Copies the values along `axes`, the first of which has the largest steps in memory.
    ///
    /// # Safety
    /// That of [`Self::write`].
    unsafe fn copy(&self, axes: &[Axis], values: &[u8], from: usize, to: usize, size: usize) {
        match axes {
            [] => {
                // SAFETY: as our caller promises.
                unsafe { self.put(to, &values[from..from + size]) };
            }
            [axis] if axis.to == size && axis.from == size => {
                // SAFETY: as our caller promises.
                unsafe { self.put(to, &values[from..from + axis.count * size]) };
            }
            [axis] => {
                // SAFETY: as our caller promises.
                unsafe {
                    match size {
                        1 => self.spread::<1>(axis, &values[from..], to),
                        2 => self.spread::<2>(axis, &values[from..], to),
                        4 => self.spread::<4>(axis, &values[from..], to),
                        _ => self.spread::<8>(axis, &values[from..], to),
                    }
                }
            }
            [axis, rest @ ..] => {
                for index in 0..axis.count {
                    // SAFETY: as our caller promises.
                    unsafe { self.copy(rest, values, from + index * axis.from, to + index * axis.to, size) };
                }
            }
        }
    }

    /// Copies values of `N` bytes along `axis`. Those between them may belong to others.
    ///
    /// # Safety
    /// That of [`Self::write`].
    unsafe fn spread<const N: usize>(&self, axis: &Axis, values: &[u8], to: usize) {
        let end = to + (axis.count - 1) * axis.to + N;
        assert!(end <= self.length, "a chunk leaves the volume");
        for index in 0..axis.count {
            let value: &[u8; N] =
                values[index * axis.from..].first_chunk().expect("a chunk has all its values");
            // SAFETY: the last of these places is within the buffer, as was just asserted, and our caller promises that
            // nobody else uses them.
            unsafe { self.start.add(to + index * axis.to).cast::<[u8; N]>().write_unaligned(*value) };
        }
    }
}

/// A run of values: their number, and bytes from each to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Axis {
    count: usize,
    from: usize,
    to: usize,
}

/// `axes` from the largest steps in memory to the smallest. Those that continue each other become one.
fn merged(mut axes: Vec<Axis>) -> Vec<Axis> {
    axes.retain(|axis| axis.count > 1);
    axes.sort_by_key(|axis| std::cmp::Reverse(axis.to));
    let mut merged: Vec<Axis> = Vec::with_capacity(axes.len());
    for axis in axes {
        match merged.last_mut() {
            Some(last) if last.to == axis.count * axis.to && last.from == axis.count * axis.from => {
                *last = Axis { count: last.count * axis.count, ..axis };
            }
            _ => merged.push(axis),
        }
    }
    merged
}
