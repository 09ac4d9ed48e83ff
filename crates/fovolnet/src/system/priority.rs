/// Lowers the priority of this thread, and of threads that it starts later, below the program's other threads. An
/// interface then stays responsive while frames are rendered on all cores. Does nothing on systems other than Linux.
///
/// The priority falls only a little, so that background programs with a higher niceness do not hold up rendering.
/// Raising it again needs rights that programs seldom have.
pub fn lower_thread_priority() {
    #[cfg(target_os = "linux")]
    linux::lower_thread_priority();
}

#[cfg(target_os = "linux")]
mod linux {
    /// Increase of niceness: leaves a quarter of the CPU when an interface thread competes, and 22 times the share of a
    /// program with niceness 19.
    const STEPS: libc::c_int = 5;
    /// Largest niceness.
    const LAST: libc::c_int = 19;
    /// Time slice in nanoseconds; interface threads have a few milliseconds. Since Linux 6.12 a waking thread with a
    /// shorter slice preempts one with a longer slice at once, instead of waiting for its end. Drawing and answering
    /// pass through several threads, each of which would wait. Older kernels ignore the value.
    const TURN: u64 = 20_000_000;

    pub fn lower_thread_priority() {
        let own = SchedulingAttributes::own();
        // Keep another scheduling policy: whoever started the program chose it.
        let usual = own.filter(|own| own.policy == libc::SCHED_OTHER as u32);
        if !usual.is_some_and(SchedulingAttributes::lower_thread_priority) {
            // SAFETY: `getpriority` takes numbers only; on Linux 0 is the calling thread.
            let niceness = unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
            // SAFETY: `setpriority` takes numbers only. Lowering the priority is always allowed.
            unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, (niceness + STEPS).min(LAST)) };
        }
    }

    /// First version of Linux's `struct sched_attr`.
    #[derive(Default)]
    #[repr(C)]
    pub struct SchedulingAttributes {
        pub size: u32,
        pub policy: u32,
        pub flags: u64,
        pub niceness: i32,
        pub priority: u32,
        pub runtime: u64,
        pub deadline: u64,
        pub period: u64,
    }

    impl SchedulingAttributes {
        /// Attributes of the calling thread; `None` if the kernel does not return them.
        pub fn own() -> Option<Self> {
            let (mut own, size) = (Self::default(), size_of::<Self>() as u32);
            // SAFETY: the kernel writes at most `size` bytes.
            let result = unsafe { libc::syscall(libc::SYS_sched_getattr, 0, &raw mut own, size, 0) };
            (result == 0).then_some(own)
        }

        /// Gives the calling thread, whose attributes these are, a higher niceness and a longer slice. Returns whether
        /// the kernel accepts.
        fn lower_thread_priority(self) -> bool {
            let niceness = (self.niceness + STEPS).min(LAST);
            let wanted = Self { niceness, runtime: TURN, ..self };
            // SAFETY: the kernel reads as many bytes of `wanted` as its size field says.
            unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const wanted, 0) == 0 }
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::linux::SchedulingAttributes;

    /// Policy, niceness and time slice of this thread.
    fn way() -> (u32, i32, u64) {
        let found = SchedulingAttributes::own().unwrap();
        (found.policy, found.niceness, found.runtime)
    }

    #[test]
    fn threads_give_way_with_those_that_they_start_and_no_others() {
        let before = way();
        let inside = std::thread::spawn(move || {
            super::lower_thread_priority();
            (way(), std::thread::spawn(way).join().unwrap())
        });
        let (own, of_started) = inside.join().unwrap();
        assert_eq!(own.1, (before.1 + 5).min(19));
        assert_eq!(of_started, own);
        // Policies for idle threads would give way to background work, too.
        assert_eq!(own.0, libc::SCHED_OTHER as u32);
        // Kernels before 6.12 report no slice, or a constant one.
        assert!(own.2 >= before.2, "{own:?} {before:?}");
        assert_eq!(way(), before);
    }
}
