/// Lets this thread, and those that it starts from now on, give way to all others that have work to do: an interface answers
/// while frames are made on every core. On systems other than Linux nothing changes.
pub fn give_way() {
    #[cfg(target_os = "linux")]
    {
        /// A tenth of the processor where another thread wants it too.
        const NICE: libc::c_int = 10;
        // SAFETY: it takes numbers alone. On Linux 0 is the calling thread, which may always become less important.
        unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, NICE) };
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn threads_give_way_with_those_that_they_start_and_no_others() {
        // SAFETY: it takes numbers alone.
        let nice = || unsafe { libc::getpriority(libc::PRIO_PROCESS, 0) };
        let before = nice();
        let inside = std::thread::spawn(move || {
            super::give_way();
            (nice(), std::thread::spawn(nice).join().unwrap())
        });
        let (own, of_started) = inside.join().unwrap();
        assert!(own >= before && own >= 10 && of_started == own, "{before} {own} {of_started}");
        assert_eq!(nice(), before);
    }
}
