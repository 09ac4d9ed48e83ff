/// Lets this thread, and those that it starts from now on, give way to the other threads of this program that have work to do: an
/// interface answers while frames are made on every core. On systems other than Linux nothing changes.
///
/// They give way by as little as that takes, so that programs which run in the background, at a higher niceness, do not keep
/// frames from being made. There is no way back without rights that programs seldom have.
pub fn lower_thread_priority() {
    #[cfg(target_os = "linux")]
    linux::lower_thread_priority();
}

#[cfg(target_os = "linux")]
mod linux {
    /// A quarter of the processor where a thread of the interface wants it too, 22 times as much as a program of niceness 19.
    const STEPS: libc::c_int = 5;
    /// The greatest niceness there is.
    const LAST: libc::c_int = 19;
    /// Nanoseconds that a thread may run for before others get their turn; the interface's have a few milliseconds. Since 6.12
    /// Linux lets a thread that wakes up take the place of one with a longer turn at once, where it would wait for the end
    /// of it otherwise. What is drawn and answered goes through several threads one after the other, each of which would wait.
    /// Older kernels take no notice.
    const TURN: u64 = 20_000_000;

    pub fn lower_thread_priority() {
        let own = SchedulingAttributes::own();
        // Whoever started the program with another policy means it.
        let usual = own.filter(|own| own.policy == libc::SCHED_OTHER as u32);
        if !usual.is_some_and(SchedulingAttributes::lower_thread_priority) {
            // SAFETY: it takes numbers alone. On Linux 0 is the calling thread.
            let niceness = unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
            // SAFETY: as above; a thread may always become less important.
            unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, (niceness + STEPS).min(LAST)) };
        }
    }

    /// `struct sched_attr` of Linux in its first version.
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
        /// Those of the calling thread; none where the kernel does not tell.
        pub fn own() -> Option<Self> {
            let (mut own, size) = (Self::default(), size_of::<Self>() as u32);
            // SAFETY: the kernel writes at most `size` bytes.
            let result = unsafe { libc::syscall(libc::SYS_sched_getattr, 0, &raw mut own, size, 0) };
            (result == 0).then_some(own)
        }

        /// Gives the calling thread, whose these are, a higher niceness and longer turns; whether the kernel does so.
        fn lower_thread_priority(self) -> bool {
            let niceness = (self.niceness + STEPS).min(LAST);
            let wanted = Self { niceness, runtime: TURN, ..self };
            // SAFETY: the kernel reads as many bytes of `wanted` as its size says.
            unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const wanted, 0) == 0 }
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::linux::SchedulingAttributes;

    /// Policy, niceness and turn of this thread.
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
        // Whatever is idle gives way to background work too.
        assert_eq!(own.0, libc::SCHED_OTHER as u32);
        // Kernels before 6.12 say nothing, or always the same.
        assert!(own.2 >= before.2, "{own:?} {before:?}");
        assert_eq!(way(), before);
    }
}
