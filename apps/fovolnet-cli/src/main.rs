//! The `fovolnet` command.
fn main() {}
