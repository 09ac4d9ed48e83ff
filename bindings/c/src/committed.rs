use crate::status::Failure;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Parameters of an object: pending ones, which calls set, and those that frames use since the last commit.
#[derive(Debug)]
pub struct Committed<P, C = P>(Mutex<Both<P, C>>);

#[derive(Debug)]
struct Both<P, C> {
    pending: P,
    committed: Option<C>,
}

impl<P: Default, C> Default for Committed<P, C> {
    fn default() -> Self {
        Self(Mutex::new(Both { pending: P::default(), committed: None }))
    }
}

impl<P: Clone, C: Clone> Committed<P, C> {
    /// Changes the pending parameters.
    pub fn set(&self, change: impl FnOnce(&mut P) -> Result<(), Failure>) -> Result<(), Failure> {
        change(&mut self.lock().pending)
    }

    /// Pending parameters.
    pub fn pending(&self) -> P {
        self.lock().pending.clone()
    }

    /// Puts `made`, from pending parameters, in the place of the committed ones.
    pub fn commit(&self, made: C) {
        self.lock().committed = Some(made);
    }

    /// Committed parameters of the object `name`.
    pub fn committed(&self, name: &str) -> Result<C, Failure> {
        self.lock().committed.clone().ok_or_else(|| {
            Failure::invalid(format!("the {name} was never committed; call fovolnet_{name}_commit first"))
        })
    }

    fn lock(&self) -> MutexGuard<'_, Both<P, C>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
