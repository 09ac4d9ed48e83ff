//! The edge between C and Rust: no panic crosses it, and errors become codes and texts.

use crate::cancel::Running;
use crate::status::{FOVOLNET_CANCELLED, FOVOLNET_ERROR_INTERNAL, FOVOLNET_OK, Failure, FovolnetStatus};
use fovolnet::core::stop;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Text of the last failed call of this thread: one line in UTF-8 that says what is wrong and how to mend it. Empty if no call
/// has failed. The text holds until the next failed call of this thread.
#[unsafe(no_mangle)]
pub extern "C" fn fovolnet_last_error() -> *const c_char {
    // A thread that is ending has no text any more.
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or_else(|_| CStr::as_ptr(c""))
}

/// Runs `work`, and keeps the text of its failure.
pub fn call(work: impl FnOnce() -> Result<(), Failure>) -> FovolnetStatus {
    let failure = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return FOVOLNET_OK,
        Ok(Err(failure)) => failure,
        Err(cause) if stop::is_stop(&*cause) => cancelled(),
        Err(cause) => internal(&*cause),
    };
    let text = CString::new(failure.text.replace('\0', " ")).unwrap_or_default();
    // There is nowhere else to put it on a thread that is ending.
    let _ = LAST.try_with(|last| last.replace(text));
    failure.status
}

/// Runs `work` that may take long, so that `fovolnet_cancel` can end it.
pub fn long_call(work: impl FnOnce() -> Result<(), Failure>) -> FovolnetStatus {
    call(|| {
        let _running = Running::begin();
        work()
    })
}

/// Runs `work`, which changes what `undone` repairs if the work was abandoned or failed by a fault.
pub fn repaired<T, C>(
    changed: &mut C,
    work: impl FnOnce(&mut C) -> Result<T, Failure>,
    undone: impl FnOnce(&mut C),
) -> Result<T, Failure> {
    match catch_unwind(AssertUnwindSafe(|| work(changed))) {
        Ok(result) => result,
        Err(cause) => {
            undone(changed);
            std::panic::resume_unwind(cause)
        }
    }
}

fn cancelled() -> Failure {
    Failure { status: FOVOLNET_CANCELLED, text: "the call was cancelled; call again to do the work".into() }
}

fn internal(cause: &(dyn std::any::Any + Send)) -> Failure {
    let said = cause.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| cause.downcast_ref::<&str>().copied()).unwrap_or("unknown cause");
    Failure {
        status: FOVOLNET_ERROR_INTERNAL,
        text: fovolnet::printable_line(&format!("a fault of the library: {said}; please report it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> String {
        // SAFETY: the text ends in NUL and lives until the next failure of this thread.
        unsafe { CStr::from_ptr(fovolnet_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn panics_become_errors() {
        assert_eq!(last(), "");
        assert_eq!(call(|| panic!("a {} is missing", "bolt")), FOVOLNET_ERROR_INTERNAL);
        assert_eq!(last(), "a fault of the library: a bolt is missing; please report it");
        assert_eq!(call(|| Err(Failure::invalid("a\0b"))), crate::FOVOLNET_ERROR_INVALID);
        assert_eq!(last(), "a b");
        assert_eq!(call(|| Ok(())), FOVOLNET_OK);
        assert_eq!(last(), "a b");
    }

    #[test]
    fn abandoned_work_is_repaired() {
        let mut state = 1;
        let fail = |state: &mut i32| -> Result<(), Failure> {
            *state = 2;
            std::panic::resume_unwind(Box::new(stop::Stopped))
        };
        let status = call(|| repaired(&mut state, fail, |state| *state = 3));
        assert_eq!((status, state), (FOVOLNET_CANCELLED, 3));
    }
}
