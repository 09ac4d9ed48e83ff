//! The machine and its operating system: devices, memory, priorities, signals.

mod device;
mod machine;
mod memory;
mod priority;
pub mod signals;

pub use device::{Device, OpenDevice};
pub use machine::Machine;
pub use memory::keep_freed_memory;
pub use priority::lower_thread_priority;
