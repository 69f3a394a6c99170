//! Any bytes given as glTF or GLB end in triangles that are sound, or in an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use thallus::substrate::{Format, parse_soup};

fuzz_target!(|bytes: &[u8]| {
    let format = if bytes.starts_with(b"glTF") { Format::Glb } else { Format::Gltf };
    if let Ok(loaded) = parse_soup(bytes, format, None) {
        let soup = loaded.soup;
        let count = soup.positions.len() as u32;
        assert!(!soup.triangles.is_empty());
        assert!(soup.triangles.iter().flatten().all(|&corner| corner < count));
        assert!(soup.positions.iter().flatten().all(|x| x.is_finite()));
    }
});
