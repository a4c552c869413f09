//! What identifies inputs, independent of names.

use std::fs::File;
use std::hash::Hasher as _;
use std::io::{self, Read as _};
use std::path::Path;

use siphasher::sip128::{Hasher128 as _, SipHasher13};

/// A hash of these texts.
pub(crate) fn hash(texts: &[&str]) -> String {
    let mut hasher = SipHasher13::new();
    for text in texts {
        hasher.write_usize(text.len());
        hasher.write(text.as_bytes());
    }
    format!("{:032x}", hasher.finish128().as_u128())
}

/// A hash of what is in a file.
pub(crate) fn hash_of_file(path: &Path) -> io::Result<String> {
    let (mut file, mut hasher, mut part) = (File::open(path)?, SipHasher13::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut part)? {
            0 => return Ok(format!("{:032x}", hasher.finish128().as_u128())),
            bytes => hasher.write(&part[..bytes]),
        }
    }
}
