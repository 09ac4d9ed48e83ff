//! Editor of the transfer function, and the histograms behind it.

pub(crate) mod backdrop;
pub(crate) mod boundaries;
pub(crate) mod gradient_editor;
pub(crate) mod histogram;
pub(crate) mod transfer_editor;
