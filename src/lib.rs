//! Thallus grows lichen on imported triangle meshes.
//!
//! It follows R. W. Sumner, *Pattern Formation in Lichen* (MIT master's thesis, 2001): walkers
//! diffuse over the surface and stick to the lichen, the more readily the more lichen is around
//! them. `docs/architecture.md` says which file holds which section.
//!
//! # A tour
//!
//! A **mesh file** (OBJ, glTF, STL, PLY) becomes a [`Substrate`](substrate::Substrate): welded by
//! position, cleaned, with neighbours across every edge, and never changed again. A place on it is
//! a [`SurfacePoint`](substrate::SurfacePoint): a triangle and weights of its corners.
//!
//! A **recipe** ([`run::Recipe`]) holds everything that changes the result: the element radius r,
//! the curvature radius L, the bias B, the seed. [`run::Settings`] make one from what a user said.
//! An [`Execution`](run::Execution) holds what changes nothing: threads, and a flag to stop.
//!
//! [`run::grow`] puts down the seed **element**, a disc of radius r (or several, each of a **colony** of its own:
//! [`Recipe::at`](run::Recipe::at)), and then for each next one
//! lets **walkers** go, one after the other, until one sticks. A walker is launched on a circle
//! about the lichen, steps in random directions ([`walk::trace()`] unfolds the triangles under it),
//! and in contact with an element sticks with a probability that depends on how many others are
//! within L ([`growth::Stickiness`]).
//!
//! The elements, in birth order, are the [`Cluster`](cluster::Cluster). An
//! [`Observer`](run::Observer) sees each one being born, and may stop the run: growth itself
//! neither prints nor writes. One of them is the [`log`]'s: a [`Run`](run::Run) goes on from what it
//! wrote as if it had never stopped. [`export::Elements`] makes the cluster a table for files,
//! [`morphometry`] measures each of its elements and [`analysis`] the whole of it, an
//! [`export::Scene`] holds table and measures for another program, [`skin`](mod@skin) makes a
//! triangle mesh of the cluster, [`bake`](mod@bake) textures for the substrate, [`picture`] draws
//! it, and [`animate`] says when each element comes in an animation of its growth.
//!
//! ```
//! use thallus::growth::SeedPlace;
//! use thallus::run::{Execution, Settings, StopSetting, grow};
//! use thallus::substrate::{Soup, Substrate};
//!
//! let soup = Soup {
//!     positions: vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]],
//!     triangles: vec![[0, 2, 1], [0, 3, 2]],
//!     notes: Vec::new(),
//! };
//! let substrate = Substrate::from_soup(soup)?;
//! let settings = Settings {
//!     at: Some(vec![SeedPlace::Center]),
//!     stop: Some(StopSetting::Elements(200)),
//!     ..Settings::default()
//! };
//! let recipe = settings.resolve(&substrate, "a square")?;
//! let growth = grow(&substrate, &recipe, &Execution::default(), &mut ())?;
//! assert_eq!(growth.cluster.len(), 200);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Nothing needs a file: [`substrate::parse_soup`] and [`substrate::Soup::from_buffers`] take meshes from memory,
//! [`log::Log::parse`] logs, and skins, textures and pictures are values (`examples/in_memory.rs`). What is not growth
//! works on all threads of the present rayon pool: `rayon::ThreadPool::install` says on which.
//!
//! # What is promised
//!
//! The same mesh and recipe give the same elements, to the bit, on any number of threads and any
//! IEEE machine. With [`Join::Pack`](growth::Join::Pack) no two centres of one sheet are nearer
//! than 2r(1 − 1e-6).
//!
//! A substrate, a cluster and its elements are in local units; recipes, settings, progress, and what is made for files
//! or reports are in the mesh file's. [`Units`](substrate::Units) has the list, and converts.
//!
//! The text of an error has all of it, the system's reason and what to do about it too; so no error has that again as
//! its [`source`](std::error::Error::source).

#![warn(missing_debug_implementations)]

mod ahead;
pub mod analysis;
pub mod animate;
pub mod appearance;
pub mod bake;
pub mod cluster;
mod color;
pub mod export;
pub mod growth;
mod image;
pub mod input;
pub mod log;
pub mod morphometry;
pub mod picture;
mod ply;
pub mod rng;
pub mod run;
pub mod skin;
pub mod substrate;
pub mod sweep;
pub mod walk;

/// Vectors of the interface are of this crate: use them from here, and the versions agree.
pub use glam;
