//! Networks under autograd.
