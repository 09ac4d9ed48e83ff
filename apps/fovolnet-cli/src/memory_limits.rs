//! Too little memory ends the program with one line and status 1, wherever it shows.

use fovolnet::core::memory;
use fovolnet::core::temporaries;
use std::panic::PanicHookInfo;

/// Makes the program end with one line if an allocation fails or a thread cannot start. No temporary files are left.
pub fn outlive() {
    memory::before_exit(temporaries::remove_all);
    if let Some((nth, bytes)) = refused() {
        memory::refuse_allocation(nth, bytes);
    }
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if is_of_threads(panic) {
            memory::exit_with(&[
                b"error: threads cannot be started: too little memory or too many of them; give a smaller --threads, or raise \
                  the limit (`ulimit -v`, `ulimit -u`)",
            ]);
        }
        usual(panic);
    }));
}

/// Whether `panic` means that the standard library or rayon could not start a thread, or that a thread has no room for the
/// stack of its signals.
fn is_of_threads(panic: &PanicHookInfo<'_>) -> bool {
    let said = panic.payload_as_str().unwrap_or_default();
    ["failed to spawn thread", "ThreadPoolBuildError", "alternative stack"]
        .iter()
        .any(|text| said.contains(text))
}

/// Value of `FOVOLNET_REFUSE_ALLOCATION=N:BYTES`: makes the N-th allocation of at least that many bytes fail. Tests use
/// it to let every large allocation of the shipped program fail in turn.
fn refused() -> Option<(usize, usize)> {
    let said = std::env::var("FOVOLNET_REFUSE_ALLOCATION").ok()?;
    let (nth, bytes) = said.split_once(':')?;
    Some((nth.parse().ok()?, bytes.parse().ok()?))
}
