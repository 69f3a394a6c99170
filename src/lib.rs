//! Thallus grows lichen on imported triangle meshes.

pub mod cluster;
pub mod export;
pub mod growth;
pub mod picture;
pub mod rng;
pub mod run;
pub mod substrate;
pub mod walk;
