#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fovol_net_fuzz::pickle(bytes));
