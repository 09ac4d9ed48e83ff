use std::sync::atomic::{AtomicBool, Ordering};

/// Stage of a download.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Bytes come over the network.
    Download,
    /// The hash of the file is computed.
    Verify,
}

/// Progress of a download.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The current stage.
    pub stage: Stage,
    /// Bytes done, those of an earlier run included.
    pub done: u64,
    /// Bytes in all.
    pub total: u64,
}

/// The listener of one job: hears of progress, and may call it off.
pub(super) struct Watch<'a> {
    pub listener: &'a mut dyn FnMut(Progress),
    pub cancel: &'a AtomicBool,
}

impl Watch<'_> {
    /// Tells how far it has come; false when the job is called off.
    #[must_use]
    pub fn goes_on(&mut self, stage: Stage, done: u64, total: u64) -> bool {
        (self.listener)(Progress { stage, done, total });
        !self.cancel.load(Ordering::Relaxed)
    }
}
