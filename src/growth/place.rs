//! Where a seed element goes.

use glam::DVec3;

use super::launch::AreaSampler;
use crate::rng::{Purpose, Stream};
use crate::substrate::{Component, Substrate, SurfacePoint};

/// Where the seed element of a colony goes.
#[derive(Clone, Debug, PartialEq)]
pub enum SeedPlace {
    /// On the mesh's largest piece, where a plumb line through the middle of that piece's bounding
    /// box first meets it from above; where it misses, as in a ring, where that through the nearest centroid of a
    /// triangle does that looks up; where none does, the piece's point nearest to that middle.
    Top,
    /// The point of the surface nearest to this one (file units).
    Point([f64; 3]),
    /// A triangle by its number in the file, at barycentric (u, v) or its centroid.
    Triangle {
        /// Number of the triangle in the file's order, from 0.
        triangle: u32,
        /// Weights of the second and third corner.
        uv: Option<[f64; 2]>,
    },
    /// The highest point along the file's up axis.
    Highest,
    /// The point of the surface nearest to the bounding box's centre.
    Center,
    /// Uniform by area over the whole mesh, from the recipe's seed and the colony's number; of several pieces not where
    /// one is inside another.
    Random,
}

/// Random places where chance lets something grow that are tried for a seed element, on average.
pub(super) const TRIES: usize = 1000;

/// Why a seed element has no place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceError {
    /// The triangle is not there.
    #[error(
        "at-triangle {triangle}: the mesh has no such triangle to grow on \
         (they are numbered from 0 to {last} in the file's order; dropped ones cannot be used)"
    )]
    NoTriangle {
        /// What was asked for.
        triangle: u32,
        /// The last number there is.
        last: u32,
    },
    /// The weights are not of a point in a triangle.
    #[error(
        "at-triangle {triangle},{u},{v}: U,V is outside the triangle; U and V are the weights of its \
         second and third corner: neither below 0, together at most 1"
    )]
    OutsideTriangle {
        /// The triangle.
        triangle: u32,
        /// Weight of its second corner.
        u: f64,
        /// Weight of its third.
        v: f64,
    },
    /// The point has a coordinate that is NaN or infinite.
    #[error("at {point:?}: coordinates must be finite")]
    NotFinite {
        /// What was asked for, file units.
        point: [f64; 3],
    },
    /// The point is farther from the surface than the mesh is large.
    #[error(
        "at {point:?}: the nearest surface is {} away, more than the whole mesh's \
         diagonal ({}); its bounding box runs from {:?} to {:?}",
        four_digits(*.distance), four_digits(*.diagonal), low, high
    )]
    OnNothing {
        /// What was asked for, file units.
        point: [f64; 3],
        /// Distance to the surface, file units.
        distance: f64,
        /// Diagonal of the bounding box, file units.
        diagonal: f64,
        /// Lower corner of the bounding box, file units.
        low: [f64; 3],
        /// Upper corner of the bounding box, file units.
        high: [f64; 3],
    },
    /// Two seed elements would overlap.
    #[error(
        "at: the seeds of colonies {first} and {second}, counted from 0, would overlap: they are {} apart, and an \
         element is {} across; move one of them, or leave it out",
        four_digits(*.distance), four_digits(*.diameter)
    )]
    Overlap {
        /// The older colony.
        first: usize,
        /// The younger one.
        second: usize,
        /// Between their seeds, file units.
        distance: f64,
        /// Diameter of an element, file units.
        diameter: f64,
    },
    /// Nothing may grow at a place that was asked for.
    #[error(
        "at {place}: nothing may grow there, by the mask or the slope; {}",
        nearest_text(*.nearest)
    )]
    Barren {
        /// What was asked for.
        place: String,
        /// The nearest place found where something may, file units.
        nearest: Option<[f64; 3]>,
    },
    /// Nothing may grow anywhere.
    #[error(
        "nothing may grow anywhere, by mask and slope: of a million places none was suited; is the mask black or made for \
         another layout, or another axis up?"
    )]
    NoHabitat,
    /// Chance finds no room.
    #[error(
        "colonies: no random place where lichen may grow had room for the seed of colony {colony}, counted from 0; ask for \
         fewer colonies, or for smaller elements (radius)"
    )]
    Crowded {
        /// The colony.
        colony: usize,
    },
}

impl SeedPlace {
    /// Whether these weights of the second and third corner are those of a point in a triangle; NaN never is.
    pub(crate) fn is_in_triangle([u, v]: [f64; 2]) -> bool {
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
    }

    /// The place on a substrate, for the seed element of a colony, wherever lichen may grow.
    ///
    /// # Errors
    /// When there is no such triangle, the weights lie outside it, or the point is nowhere near the mesh or
    /// not finite.
    pub fn locate(
        &self,
        substrate: &Substrate,
        seed: u64,
        colony: u64,
    ) -> Result<SurfacePoint, PlaceError> {
        match self {
            Self::Top => Ok(top(substrate, &substrate.components()[0])),
            Self::Point(p) => nearest_to(substrate, *p),
            Self::Triangle { triangle, uv } => in_triangle(substrate, *triangle, *uv),
            Self::Highest => Ok(highest(substrate)),
            Self::Center => Ok(substrate.nearest(DVec3::ZERO).0),
            Self::Random => {
                let mut stream = Stream::new(seed, Purpose::SeedPlace, colony);
                Ok(AreaSampler::of_all(substrate).sample(&mut stream))
            }
        }
    }
}

/// A measured number with the digits that a reader needs.
pub(crate) fn four_digits(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// Where to put it instead.
fn nearest_text(nearest: Option<[f64; 3]>) -> String {
    match nearest {
        Some(p) => {
            let [x, y, z] = p.map(|x| format!("{x:.7e}").parse().unwrap_or(x));
            format!("something may at {x:?},{y:?},{z:?}")
        }
        None => "nor anywhere else".to_owned(),
    }
}

fn nearest_to(substrate: &Substrate, point: [f64; 3]) -> Result<SurfacePoint, PlaceError> {
    if !point.iter().all(|x| x.is_finite()) {
        return Err(PlaceError::NotFinite { point });
    }
    let units = substrate.units();
    let (at, distance) = substrate.nearest(units.to_local(point));
    let (distance, diagonal) = (units.length_to_file(distance), units.diagonal());
    let [low, high] = units.bounding_box().map(|p| p.to_array());
    if distance <= diagonal {
        return Ok(at);
    }
    Err(PlaceError::OnNothing {
        point,
        distance,
        diagonal,
        low,
        high,
    })
}

fn in_triangle(
    substrate: &Substrate,
    triangle: u32,
    uv: Option<[f64; 2]>,
) -> Result<SurfacePoint, PlaceError> {
    if let Some([u, v]) = uv.filter(|&uv| !SeedPlace::is_in_triangle(uv)) {
        return Err(PlaceError::OutsideTriangle { triangle, u, v });
    }
    let last = substrate.report().triangles_read as u32 - 1;
    let weights = uv.map_or([1.0; 3], |[u, v]| [1.0 - u - v, u, v]);
    let place = substrate.place_of_source(triangle, weights);
    place.ok_or(PlaceError::NoTriangle { triangle, last })
}

fn highest(substrate: &Substrate) -> SurfacePoint {
    let up = substrate.up();
    let height = |t: u32, k: usize| substrate.corners(t)[k].dot(up);
    let mut best = (f64::NEG_INFINITY, 0, 0);
    for t in 0..substrate.triangles().len() as u32 {
        for k in 0..3 {
            if height(t, k) > best.0 {
                best = (height(t, k), t, k);
            }
        }
    }
    let mut weights = [0.0; 3];
    weights[best.2] = 1.0;
    SurfacePoint::from_weights(best.1, weights)
}

/// Where a plumb line through the middle of a piece first meets it from above, or what is nearest to that.
pub(super) fn top(substrate: &Substrate, piece: &Component) -> SurfacePoint {
    let middle = (piece.bounds[0] + piece.bounds[1]) * 0.5;
    let up = substrate.up();
    let above = |place: DVec3| {
        let below = substrate.triangles_near_line(place, up, &piece.triangles);
        let hits = below
            .into_iter()
            .filter_map(|t| substrate.plumb(t, place, up));
        let higher = |a: (f64, SurfacePoint), b: (f64, SurfacePoint)| if b.0 > a.0 { b } else { a };
        hits.reduce(higher).map(|(_, at)| at)
    };
    above(middle)
        .or_else(|| above(nearest_that_looks_up(substrate, piece, middle)?))
        .unwrap_or_else(|| substrate.nearest_among(middle, &piece.triangles))
}

/// Of the triangles of a piece that look up, the centroid nearest to a plumb line.
fn nearest_that_looks_up(substrate: &Substrate, piece: &Component, line: DVec3) -> Option<DVec3> {
    /// Within 45° of straight up.
    const STEEPEST: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let up = substrate.up();
    let upper = piece
        .triangles
        .clone()
        .filter(|&t| substrate.normal(t).dot(up) > STEEPEST);
    let centroids = upper.map(|t| substrate.corners(t).iter().sum::<DVec3>() / 3.0);
    let aside = |place: &DVec3| (*place - line).cross(up).length_squared();
    centroids.min_by(|a, b| aside(a).total_cmp(&aside(b)))
}
