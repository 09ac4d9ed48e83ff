//! Memory planning for tensors on a device: tensors that are never alive at the same time share a buffer.

use crate::gpu::kernel::{Kernel, Operand};
use crate::gpu::tensor::Place;
use crate::plan::TensorId;
use std::collections::{HashMap, HashSet};

/// Memory plan of a frame.
#[derive(Debug, Default)]
pub struct Memory {
    /// Size of each buffer in bytes.
    pub pieces: Vec<u64>,
    /// Index of the buffer of each tensor.
    pub piece_of: HashMap<TensorId, usize>,
}

impl Memory {
    /// Places the tensors that `kernels` write in shared buffers; `bytes` gives their sizes. Tensors in `apart`
    /// have buffers of their own and are left out. Tensors in `kept` are still needed after the frame.
    pub fn new(
        kernels: &[&Kernel],
        bytes: impl Fn(TensorId) -> u64,
        apart: &HashSet<TensorId>,
        kept: &HashSet<TensorId>,
    ) -> Self {
        let mut memory = Self::default();
        let mut free: Vec<usize> = Vec::new();
        let last = last_uses(kernels);
        for (number, kernel) in kernels.iter().enumerate() {
            for id in written(kernel).filter(|id| !apart.contains(id)) {
                if !memory.piece_of.contains_key(&id) {
                    let piece = memory.take(&mut free, bytes(id));
                    memory.piece_of.insert(id, piece);
                }
            }
            let mut done: Vec<TensorId> = tensors(kernel)
                .filter(|id| last[id] == number && !kept.contains(id) && !apart.contains(id))
                .collect();
            done.sort_unstable();
            done.dedup();
            free.extend(done.iter().filter_map(|id| memory.piece_of.get(id)));
        }
        memory
    }

    /// Takes the best free buffer for `bytes`: the smallest that is large enough, else the largest, which grows,
    /// else a new one.
    fn take(&mut self, free: &mut Vec<usize>, bytes: u64) -> usize {
        let fitting = (0..free.len()).filter(|&i| self.pieces[free[i]] >= bytes);
        let best = fitting.min_by_key(|&i| self.pieces[free[i]]);
        match best.or_else(|| (0..free.len()).max_by_key(|&i| self.pieces[free[i]])) {
            Some(i) => {
                let piece = free.swap_remove(i);
                self.pieces[piece] = self.pieces[piece].max(bytes);
                piece
            }
            None => {
                self.pieces.push(bytes);
                self.pieces.len() - 1
            }
        }
    }
}

/// Tensors that `kernel` writes.
pub fn written(kernel: &Kernel) -> impl Iterator<Item = TensorId> {
    kernel.operands.iter().filter_map(|operand| match operand {
        Operand::Write(Place::Tensor(id)) | Operand::Change(Place::Tensor(id)) => Some(*id),
        _ => None,
    })
}

/// Tensors that `kernel` reads or writes.
pub fn tensors(kernel: &Kernel) -> impl Iterator<Item = TensorId> {
    kernel.operands.iter().filter_map(|operand| match operand.place() {
        Some(Place::Tensor(id)) => Some(id),
        _ => None,
    })
}

/// For each tensor, the index of the last kernel that uses it.
fn last_uses(kernels: &[&Kernel]) -> HashMap<TensorId, usize> {
    let uses = kernels.iter().enumerate();
    uses.flat_map(|(number, kernel)| tensors(kernel).map(move |id| (id, number))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::kernel::Groups;
    use crate::gpu::kernel::shader::KEEP;

    /// A kernel that reads and writes tensors of these numbers.
    fn kernel(reads: &[usize], writes: usize) -> Kernel {
        let place = |i: usize| Place::Tensor(TensorId(i));
        let mut operands: Vec<Operand> = reads.iter().map(|&i| Operand::Read(place(i))).collect();
        operands.push(Operand::Write(place(writes)));
        Kernel { shader: KEEP, entry_point: "", constants: Vec::new(), operands, groups: Groups::Count(1) }
    }

    #[test]
    fn tensors_that_are_not_needed_at_once_share_memory() {
        // Tensor 0 is a state and 2 is kept. 1 is read until 3 is written; 4 takes its buffer, which grows.
        let kernels =
            [kernel(&[0], 1), kernel(&[1], 2), kernel(&[1, 2], 3), kernel(&[3], 4), kernel(&[4], 5)];
        let bytes = |id: TensorId| [0, 10, 20, 30, 15, 5][id.index()];
        let [apart, kept] = [0, 2].map(|i| HashSet::from([TensorId(i)]));
        let memory = Memory::new(&kernels.iter().collect::<Vec<_>>(), bytes, &apart, &kept);
        assert!(!memory.piece_of.contains_key(&TensorId(0)));
        let piece = |i: usize| memory.piece_of[&TensorId(i)];
        assert_eq!([1, 2, 3, 4, 5].map(piece), [0, 1, 2, 0, 2]);
        assert_eq!(memory.pieces, [15, 20, 30]);
    }

    #[test]
    fn what_is_written_at_the_same_time_as_it_is_read_for_the_last_time_is_elsewhere() {
        let kernels: Vec<Kernel> = (0..9).map(|i| kernel(&[i], i + 1)).collect();
        let memory =
            Memory::new(&kernels.iter().collect::<Vec<_>>(), |_| 1, &HashSet::new(), &HashSet::new());
        assert_eq!(memory.pieces.len(), 2);
        assert!((1..9).all(|i| memory.piece_of[&TensorId(i)] != memory.piece_of[&TensorId(i + 1)]));
    }
}
