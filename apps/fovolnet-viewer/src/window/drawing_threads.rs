//! CPU affinity of Mesa's software rasteriser threads.

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, Pid, sched_getaffinity, sched_setaffinity};

/// Prefix of the names of Mesa's llvmpipe threads; a number follows.
#[cfg(target_os = "linux")]
const NAME: &str = "llvmpipe-";

/// Binds each llvmpipe thread of this process to its own CPU, among those this thread may use. Does nothing on
/// systems other than Linux.
///
/// Every llvmpipe thread draws a part of each frame. Low-priority threads ([`fovolnet::lower_thread_priority`]) keep all CPUs
/// busy, so Linux sees no idle one. It may leave two drawing threads on one CPU for whole frames, which then take
/// twice as long.
#[cfg(target_os = "linux")]
pub fn spread() {
    let Ok(allowed) = sched_getaffinity(None) else { return };
    let allowed: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&processor| allowed.is_set(processor)).collect();
    for (thread, number) in drawing() {
        let mut own = CpuSet::new();
        own.set(allowed[number % allowed.len()]);
        // Fails if the thread has ended or affinity is not permitted; then it runs where it did.
        let _ = sched_setaffinity(Some(thread), &own);
    }
}

/// Does nothing on this system.
#[cfg(not(target_os = "linux"))]
pub fn spread() {}

/// The llvmpipe threads of this process, with their numbers.
#[cfg(target_os = "linux")]
fn drawing() -> Vec<(Pid, usize)> {
    let named = |task: std::fs::DirEntry| {
        let thread = task.file_name().to_str()?.parse().ok().and_then(Pid::from_raw)?;
        let name = std::fs::read_to_string(task.path().join("comm")).ok()?;
        Some((thread, name.trim_end().strip_prefix(NAME)?.parse().ok()?))
    };
    std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten().filter_map(named).collect()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use rustix::thread::gettid;
    use std::sync::mpsc::{Sender, channel};
    use std::thread::{Builder, JoinHandle};

    /// Thread with the given name, its id, and a sender whose drop ends it.
    fn thread(name: &str) -> (JoinHandle<()>, Pid, Sender<()>) {
        let ((end, ended), (tell, told)) = (channel(), channel());
        let run = move || {
            tell.send(gettid()).unwrap();
            // The thread ends when the sender is dropped.
            let _ = ended.recv();
        };
        (Builder::new().name(name.into()).spawn(run).unwrap(), told.recv().unwrap(), end)
    }

    fn processors(thread: Pid) -> Vec<usize> {
        let set = sched_getaffinity(Some(thread)).unwrap();
        (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect()
    }

    #[test]
    fn threads_that_draw_have_processors_of_their_own_and_others_all() {
        let names = ["llvmpipe-0", "llvmpipe-1", "llvmpipe-x", "pictures"];
        let threads = names.map(thread);
        let [first, second, odd, other] = [0, 1, 2, 3].map(|i| threads[i].1);
        spread();
        let all = processors(gettid());
        assert_eq!(processors(first), [all[0]]);
        assert_eq!(processors(second), [all[1 % all.len()]]);
        assert_eq!((processors(odd), processors(other)), (all.clone(), all));
        for (thread, _, end) in threads {
            drop(end);
            thread.join().unwrap();
        }
    }
}
