//! Compute passes whose commands are counted.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Numbers of commands that were recorded on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Commands {
    /// Compute passes.
    pub passes: u64,
    /// Dispatches of a number of workgroups that the host knows.
    pub dispatches: u64,
    /// Dispatches of a number of workgroups that lies on the device.
    pub indirect: u64,
}

impl Commands {
    /// Commands since `earlier` ones of the same device.
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self {
            passes: self.passes - earlier.passes,
            dispatches: self.dispatches - earlier.dispatches,
            indirect: self.indirect - earlier.indirect,
        }
    }
}

/// Counters of a device, shared by all clones of its [`Gpu`](crate::Gpu).
#[derive(Debug, Default)]
pub(crate) struct Counters {
    passes: AtomicU64,
    dispatches: AtomicU64,
    indirect: AtomicU64,
}

impl Counters {
    pub fn commands(&self) -> Commands {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Commands {
            passes: count(&self.passes),
            dispatches: count(&self.dispatches),
            indirect: count(&self.indirect),
        }
    }
}

/// Compute pass that counts its dispatches. Everything else is done by [`wgpu::ComputePass`].
#[derive(Debug)]
pub struct Pass<'a> {
    pass: wgpu::ComputePass<'a>,
    counters: Arc<Counters>,
}

impl<'a> Pass<'a> {
    /// Begins the pass of `descriptor` in `encoder`.
    pub(crate) fn begin(
        counters: &Arc<Counters>,
        encoder: &'a mut wgpu::CommandEncoder,
        descriptor: &wgpu::ComputePassDescriptor<'_>,
    ) -> Self {
        counters.passes.fetch_add(1, Ordering::Relaxed);
        Self { pass: encoder.begin_compute_pass(descriptor), counters: Arc::clone(counters) }
    }

    /// Dispatches `x`·`y`·`z` workgroups.
    pub fn dispatch_workgroups(&mut self, x: u32, y: u32, z: u32) {
        self.counters.dispatches.fetch_add(1, Ordering::Relaxed);
        self.pass.dispatch_workgroups(x, y, z);
    }

    /// Dispatches as many workgroups as three numbers in `buffer` say, which lie at byte `offset`.
    pub fn dispatch_workgroups_indirect(&mut self, buffer: &wgpu::Buffer, offset: u64) {
        self.counters.indirect.fetch_add(1, Ordering::Relaxed);
        self.pass.dispatch_workgroups_indirect(buffer, offset);
    }
}

impl<'a> Deref for Pass<'a> {
    type Target = wgpu::ComputePass<'a>;

    fn deref(&self) -> &Self::Target {
        &self.pass
    }
}

impl DerefMut for Pass<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_counted_from_any_moment_on() {
        let counters = Counters::default();
        counters.passes.store(5, Ordering::Relaxed);
        counters.dispatches.store(7, Ordering::Relaxed);
        let earlier = counters.commands();
        counters.dispatches.fetch_add(3, Ordering::Relaxed);
        counters.indirect.fetch_add(1, Ordering::Relaxed);
        let since = counters.commands().since(earlier);
        assert_eq!(since, Commands { passes: 0, dispatches: 3, indirect: 1 });
    }
}
