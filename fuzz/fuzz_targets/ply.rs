#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| crosscut_fuzz::ply(data));
