/// Lets this thread, and those that it starts from now on, give way to all others that have work to do: an interface answers
/// while frames are made on every core. On systems other than Linux nothing changes.
///
/// These threads have what others of the same session leave: where those keep every core busy, frames wait. There is no way
/// back without rights that programs seldom have.
pub fn give_way() {
    #[cfg(target_os = "linux")]
    {
        /// A tenth of the processor where another thread wants it too.
        const NICE: libc::c_int = 10;
        // SAFETY: it takes numbers alone. On Linux 0 is the calling thread, which may always become less important.
        unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, NICE) };
        // What is to be drawn and answered goes through several threads one after the other. Each of them would wait for a slice
        // of time of such a thread to end, 1.4 ms on two cores, but for this policy, which lets others go on at once.
        let none = libc::sched_param { sched_priority: 0 };
        // SAFETY: the kernel reads `none` alone. Where it refuses, the thread goes on as above.
        unsafe { libc::sched_setscheduler(0, libc::SCHED_IDLE, &raw const none) };
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn threads_give_way_with_those_that_they_start_and_no_others() {
        // SAFETY: these take numbers alone.
        let way = || unsafe { (libc::getpriority(libc::PRIO_PROCESS, 0), libc::sched_getscheduler(0)) };
        let before = way();
        let inside = std::thread::spawn(move || {
            super::give_way();
            (way(), std::thread::spawn(way).join().unwrap())
        });
        let (own, of_started) = inside.join().unwrap();
        assert!(own.0 >= before.0 && own.0 >= 10 && of_started == own, "{before:?} {own:?} {of_started:?}");
        assert_eq!(own.1, libc::SCHED_IDLE);
        assert_eq!(way(), before);
    }
}
