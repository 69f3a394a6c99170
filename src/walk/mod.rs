//! Walking straight over a triangle mesh.
//!
//! A walk is plane geometry: the triangles it crosses are laid flat one after the other beside the
//! one it starts in (Sumner 2001, 6.1). See [`trace()`].

mod connect;
mod plane;
mod section;
mod stand;
mod trace;

pub use connect::Connectivity;
pub use plane::TrianglePlane;
pub use section::{Ball, Place};
pub(crate) use stand::Footing;
pub use stand::{Moved, Stand};
pub use trace::{End, MOST_CROSSINGS, Trace, Visitor, trace, trace_visiting};

pub use crate::substrate::SurfacePoint;
