//! Any bytes given as STL end in triangles that are sound, or in an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use thallus::substrate::{Format, parse_soup};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(loaded) = parse_soup(bytes, Format::Stl, None) {
        let soup = loaded.soup;
        let count = soup.positions.len() as u32;
        assert!(!soup.triangles.is_empty());
        assert!(soup.triangles.iter().flatten().all(|&corner| corner < count));
        assert!(soup.positions.iter().flatten().all(|x| x.is_finite()));
    }
});
