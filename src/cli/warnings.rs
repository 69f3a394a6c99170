//! What a mesh's report means for lichen, in words.

use std::f64::consts::{FRAC_2_PI, PI};

use thallus::run::{DEFAULT_ELEMENTS, RADIUS, Settings};
use thallus::substrate::{Substrate, SubstrateReport};

use super::facing;
use super::number::{count, elements, percent, place, plural, short};

/// Everything about a mesh that its owner should know before growing elements of this radius.
pub(crate) fn warnings(substrate: &Substrate, radius: f64) -> Vec<String> {
    let report = substrate.report();
    let diagonal = substrate.units().diagonal();
    let [of_largest, of_others] = facing::warnings(substrate);
    let found = [
        cramped(substrate, radius),
        stray(substrate, radius),
        loose(report),
        of_largest,
        of_others,
        pieces(report),
        open_edges(report),
        non_manifold_edges(substrate),
        wound_apart(report),
        dense(report, radius).or_else(|| slivers(report, radius)),
        lost(report),
        far(substrate.units().offset(), diagonal, radius),
        scale(diagonal),
    ];
    found.into_iter().flatten().collect()
}

/// Elements for which the largest piece should have room: fewer make little of a lichen.
const FEWEST: f64 = 100.0;

/// Share of a surface that discs of one size fill when lichen packs them.
const PACKED: f64 = 0.8;

/// A mesh of more pieces than this, none with more triangles than the next, is no surface.
const LOOSE_PIECES: usize = 10;
const LOOSE_TRIANGLES: usize = 4;

/// Why `thallus grow` refuses a mesh that has a surface, if nothing but the mesh is said, and what to do.
pub(crate) fn unfit(substrate: &Substrate, file: &str) -> Option<String> {
    let refused = Settings::default().resolve(substrate, file).err()?;
    let cramped =
        cramped(substrate, substrate.auto_radius()).map(|reason| format!("{file}: {reason}"));
    Some(cramped.unwrap_or_else(|| refused.to_string()))
}

fn loose(report: &SubstrateReport) -> Option<String> {
    let n = report.components.len();
    let largest = report.components.iter().map(|c| c.triangles).max()?;
    let size = plural(largest, "triangle", "triangles");
    (n > LOOSE_PIECES && largest <= LOOSE_TRIANGLES).then(|| {
        format!(
            "the triangles lie loose: {} pieces, none of more than {size}; merge vertices by \
             distance where the mesh was made (Blender: Mesh, Merge, By Distance) and export it \
             again",
            count(n as u64)
        )
    })
}

fn cramped(substrate: &Substrate, radius: f64) -> Option<String> {
    let units = substrate.units();
    let area = units.area_to_file(substrate.components().first()?.area);
    let room = PACKED * area / (PI * radius * radius);
    let finer = (PACKED * area / (PI * DEFAULT_ELEMENTS as f64)).sqrt();
    let cure = match finer > RADIUS.low * units.diagonal() {
        true => format!("give --radius {}, join the pieces, or", short(finer)),
        false => "join the pieces, or".to_owned(),
    };
    let number = elements(room as usize);
    (room < FEWEST).then(|| {
        format!(
            "the largest piece has room for about {number} of radius {}: {cure} remove what lies \
             far from the rest",
            short(radius),
        )
    })
}

/// Share of the vertices that may lie far from the rest, at either end of each axis.
const STRAY: f64 = 0.005;

/// A mesh this many times as large as all but those has vertices that flew away.
const FAR: f64 = 10.0;

/// Where a few vertices lie far off, as in scans, a radius that is proposed by the whole extent is too large.
fn stray(substrate: &Substrate, radius: f64) -> Option<String> {
    let units = substrate.units();
    let vertices = substrate.vertices();
    let apart = (STRAY * vertices.len() as f64) as usize;
    if is_spread(substrate, apart) {
        return None;
    }
    let extent = [0, 1, 2].map(|axis| {
        let mut along: Vec<f64> = vertices.iter().map(|&v| units.to_file(v)[axis]).collect();
        let last = along.len() - 1 - apart;
        let (_, low, _) = along.select_nth_unstable_by(apart, f64::total_cmp);
        let low = *low;
        *along.select_nth_unstable_by(last, f64::total_cmp).1 - low
    });
    let most = extent.iter().map(|e| e * e).sum::<f64>().sqrt();
    let diagonal = units.diagonal();
    let proposed = most * substrate.auto_radius() / diagonal;
    let is_apart = proposed > 0.0 && diagonal > FAR * most;
    let other_cure = match proposed > RADIUS.low * diagonal {
        true => format!(", or give --radius {}", short(proposed)),
        false => String::new(),
    };
    (is_apart && radius > FAR * proposed).then(|| {
        format!(
            "nearly all of it lies within {} of the {} units that it is across: a few vertices lie far off; remove \
             them{other_cure}",
            short(most),
            short(diagonal),
        )
    })
}

/// Whether in each third at either end of the longest axis there are more vertices than may lie apart: then what
/// lies between is more than a [`FAR`]th of the diagonal, and to sort nothing tells so.
fn is_spread(substrate: &Substrate, apart: usize) -> bool {
    let [low, high] = substrate.bounds();
    let axis = (high - low).max_position();
    let third = (high - low)[axis] / 3.0;
    // What was dropped with the triangles without area may lie farther off.
    if FAR * third < substrate.units().local_diagonal() {
        return false;
    }
    let ends = [low[axis] + third, high[axis] - third];
    let is_full = |is_there: fn(f64, [f64; 2]) -> bool| {
        let mut there = substrate
            .vertices()
            .iter()
            .filter(|v| is_there(v[axis], ends));
        there.nth(apart).is_some()
    };
    is_full(|x, ends| x < ends[0]) && is_full(|x, ends| x > ends[1])
}

fn pieces(report: &SubstrateReport) -> Option<String> {
    let n = report.components.len();
    let largest = report.components.first()?.area / report.area;
    let share = percent(largest);
    (n > 1).then(|| {
        format!(
            "{n} separate pieces: lichen cannot cross between them (the largest has {share} of the \
             area; join them if they should be one)"
        )
    })
}

fn open_edges(report: &SubstrateReport) -> Option<String> {
    let edges = plural(report.boundary_edges, "open edge", "open edges");
    let places = places(&report.boundary_places);
    (report.boundary_edges > 0).then(|| {
        format!(
            "{edges}: lichen stops there ({places}); fill holes that should not be there, and where there seem to \
             be none, merge vertices by distance"
        )
    })
}

/// How many surfaces there are for walkers, where they are more than the pieces.
fn divided(substrate: &Substrate) -> String {
    let surfaces = substrate.components();
    let pieces = substrate.report().components.len();
    let area: f64 = surfaces.iter().map(|surface| surface.area).sum();
    match surfaces.len() > pieces {
        false => String::new(),
        true => format!(
            ": for them it is {} in {}, the largest with {} of the area, and a lichen covers one of these",
            plural(surfaces.len(), "surface", "surfaces"),
            plural(pieces, "piece", "pieces"),
            percent(surfaces[0].area / area)
        ),
    }
}

fn non_manifold_edges(substrate: &Substrate) -> Option<String> {
    let report = substrate.report();
    let n = report.non_manifold_edges;
    let edges = plural(n, "edge", "edges");
    let places = places(&report.non_manifold_places);
    (n > 0).then(|| {
        format!(
            "{edges} with more than two triangles ({places}): walkers cross there in a fixed way, \
             if at all{}; separate the surfaces if it shows",
            divided(substrate)
        )
    })
}

fn wound_apart(report: &SubstrateReport) -> Option<String> {
    let n = report.winding_conflicts;
    let edges = plural(n, "edge", "edges");
    let places = places(&report.winding_conflict_places);
    (n > 0).then(|| {
        format!(
            "{edges} between triangles that are wound differently ({places}): lichen stands on one side of each piece \
             all the same, outside where it is closed; elsewhere faces may look dark or be missing: turn them (in \
             Blender: Edit Mode, Mesh, Normals, Recalculate Outside)"
        )
    })
}

fn dense(report: &SubstrateReport, radius: f64) -> Option<String> {
    let median = report.edge_length[1] / radius;
    let edges = short(median);
    (median < 0.1).then(|| {
        format!(
            "the median edge is {edges} r: consider simplifying; triangles so much smaller than an \
             element (r = {}) cost time and change nothing",
            short(radius)
        )
    })
}

/// Edges on a way of one radius, from which on they cost time: about as many as where all sides are a tenth of that long.
const MANY_EDGES: f64 = 20.0;

/// A straight way meets 2/π edges for each unit of their length on a unit of area (Crofton); each triangle has half of
/// its three.
fn slivers(report: &SubstrateReport, radius: f64) -> Option<String> {
    let of_edges = 1.5 * report.edge_length[1] * report.triangles as f64;
    let crossed = FRAC_2_PI * of_edges / report.area * radius;
    let edges = count(crossed as u64);
    (crossed > MANY_EDGES).then(|| {
        format!(
            "triangles are so long and thin that a way of one radius crosses about {edges} edges: growing, skins and \
             pictures take long; remesh it to sides alike"
        )
    })
}

/// Share of the triangles that may be dropped without a word.
const LOST: f64 = 0.2;

fn lost(report: &SubstrateReport) -> Option<String> {
    let share = |dropped: usize| dropped as f64 / report.triangles_read.max(1) as f64;
    let [flat, twice] = [report.degenerate_triangles, report.duplicate_triangles].map(share);
    let cause = match flat >= twice {
        true => {
            "most as they have no area: if that is unexpected, coordinates may have been rounded at export; move \
             the mesh to its origin and export it again"
        }
        false => {
            "most as the same are there already: if that is unexpected, look for a second copy of the object or of \
             its faces"
        }
    };
    let dropped = percent(flat + twice);
    (flat + twice > LOST).then(|| format!("{dropped} of the triangles were dropped, {cause}"))
}

/// Positions are written as 32-bit floats, which round at 2⁻²⁴ of their size.
fn far(offset: f64, diagonal: f64, radius: f64) -> Option<String> {
    let rounding = offset / f64::from(1 << 24);
    let times = short(offset / diagonal);
    let (distance, error) = (short(offset), short(rounding));
    (rounding > 0.05 * radius).then(|| {
        format!(
            "it lies {distance} from its origin, {times} times its own size: growing is exact, but \
             positions in 32-bit files round to about {error}; move it to its origin"
        )
    })
}

fn scale(diagonal: f64) -> Option<String> {
    let size = short(diagonal);
    (!(1e-4..1e5).contains(&diagonal)).then(|| {
        format!(
            "it is {size} units across: growing is exact at any scale, but check its units, and \
             give lengths in percent (0.05%) rather than in mesh units"
        )
    })
}

fn places(places: &[[f64; 3]]) -> String {
    let listed: Vec<_> = places.iter().copied().map(place).collect();
    format!("near {}", listed.join(", "))
}
