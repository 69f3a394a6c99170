//! Tips, and the branches that lead to them.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::fit::line;
use super::ranked::Ranked;
use super::width::Distribution;
use crate::morphometry::{Neighbours, Sample, TIES, Tree};

/// What the tree of parents says of a lichen's branches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Branching {
    /// Number of tips. Peaks are elements with no other within 6.4 radii that is farther from its seed,
    /// along the tree in hundredths of a radius, the older of two being the farther one where they are equal; tips are
    /// peaks with no other peak that is, within the width of the branch there. None where nothing has a width, as
    /// on a closed surface that is grown over.
    pub tips: Option<usize>,
    /// Angle in degrees at which the ways to two tips part, seen from where they do over twice the
    /// width of the branch there, or to a tip that is nearer (sixteen element radii at least). None
    /// where no ways go so far: of a lichen with one tip, as a round one may have; and where there are no tips.
    pub angle: Option<Distribution>,
    /// Strahler's order of the whole tree of parents: see [`Tree::strahler`].
    pub strahler_order: u32,
    /// Branches of each Strahler order, from 1.
    pub branches_by_order: Vec<usize>,
    /// Branches of one order over those of the next (Horton's bifurcation ratio), by a straight
    /// line through the logarithms of the numbers of all orders but the highest; none of fewer than
    /// three.
    pub bifurcation_ratio: Option<f64>,
}

impl Branching {
    /// The widths are those of the branch at each element.
    pub(super) fn new(
        sample: &Sample<'_>,
        neighbours: &Neighbours,
        widths: &[Option<f64>],
    ) -> Self {
        let tree = Tree::new(sample.parents);
        let order = tree.strahler();
        let branches = branches_by_order(sample.parents, &order);
        let has_width = widths.iter().any(Option::is_some);
        let tips = has_width.then(|| tips(sample, neighbours, widths));
        let angles = tips.as_ref().map(|tips| angles(sample, tips, widths));
        Self {
            tips: tips.map(|tips| tips.len()),
            angle: angles.and_then(Distribution::of),
            strahler_order: order.iter().copied().max().unwrap_or(0),
            bifurcation_ratio: bifurcation_ratio(&branches),
            branches_by_order: branches,
        }
    }
}

/// A branch of an order starts where the parent has a higher one, or at a seed.
fn branches_by_order(parents: &[i32], order: &[u32]) -> Vec<usize> {
    let highest = order.iter().copied().max().unwrap_or(0);
    let mut branches = vec![0; highest as usize];
    for (i, &parent) in parents.iter().enumerate() {
        let starts = usize::try_from(parent).map_or(true, |p| order[p] > order[i]);
        branches[order[i] as usize - 1] += usize::from(starts);
    }
    branches
}

fn bifurcation_ratio(branches: &[usize]) -> Option<f64> {
    const FEWEST: usize = 3;
    let counted = &branches[..branches.len().saturating_sub(1)];
    let log = |(k, &n): (usize, &usize)| [k as f64, libm::log(n as f64)];
    let points: Vec<_> = counted.iter().enumerate().map(log).collect();
    let (slope, _) = (points.len() >= FEWEST).then(|| line(&points))??;
    Some(libm::exp(-slope))
}

/// Distance of each element from its seed along the tree of parents, in hundredths of a radius. Most elements stand
/// at 2 r from their parents: without this, round-off would decide which of those of one generation is farther.
fn ways(sample: &Sample<'_>) -> Vec<u64> {
    let mut ways: Vec<f64> = Vec::with_capacity(sample.parents.len());
    for (i, &parent) in sample.parents.iter().enumerate() {
        let way = usize::try_from(parent).map_or(0.0, |parent| {
            let [a, b] = [parent, i].map(|i| DVec3::from(sample.positions[i]));
            ways[parent] + a.distance(b)
        });
        ways.push(way);
    }
    let rounded = |way: f64| (100.0 * way / sample.radius).round() as u64;
    ways.into_iter().map(rounded).collect()
}

/// See [`Branching::tips`], ascending. Elements count for each other as neighbours do.
fn tips(sample: &Sample<'_>, neighbours: &Neighbours, widths: &[Option<f64>]) -> Vec<u32> {
    let ways = ways(sample);
    let farther = |a: usize, b: usize| ways[a].cmp(&ways[b]).then(b.cmp(&a)).is_gt();
    let highest = neighbours.map(|i| {
        let mut highest = true;
        neighbours.visit(i, |j, _, _| highest &= farther(i, j as usize));
        highest
    });
    let mut peaks: Vec<usize> = (0..ways.len()).filter(|&i| highest[i]).collect();
    peaks.sort_unstable_by(|&a, &b| ways[b].cmp(&ways[a]).then(a.cmp(&b)));
    let place = |i: usize| DVec3::from(sample.positions[i]);
    let normal = |i: usize| Vec3::from(sample.normals[i]);
    let ranked = Ranked::new(peaks.iter().map(|&i| (place(i), normal(i))));
    let stands = |(rank, &i): (usize, &usize)| {
        let within = TIES * widths[i].unwrap_or(0.0);
        let is_alone = !ranked.has_higher(rank, place(i), normal(i), within);
        is_alone.then_some(i as u32)
    };
    let peaks = peaks.par_iter().enumerate();
    let mut tips: Vec<u32> = peaks.filter_map(stands).collect();
    tips.sort_unstable();
    tips
}

/// The angles at which the ways from the seeds to the tips part: where three or more part at one
/// element, that between every two that were born one after the other.
fn angles(sample: &Sample<'_>, tips: &[u32], widths: &[Option<f64>]) -> Vec<f64> {
    let leads = leading_to(sample.parents, tips);
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); leads.len()];
    for (i, &parent) in sample.parents.iter().enumerate() {
        if let (true, Ok(parent)) = (leads[i], usize::try_from(parent)) {
            children[parent].push(i as u32);
        }
    }
    let at = |fork: usize| {
        let length = sight(sample.radius, widths[fork]);
        let chords = children[fork].iter().map(|&child| {
            let seen = follow(sample, &children, fork, child, length)?;
            (seen - DVec3::from(sample.positions[fork])).try_normalize()
        });
        chords.collect::<Vec<_>>()
    };
    let forks = (0..children.len()).filter(|&i| children[i].len() > 1);
    let between = |pair: &[Option<DVec3>]| {
        let (a, b) = (pair[0]?, pair[1]?);
        Some(libm::acos(a.dot(b).clamp(-1.0, 1.0)).to_degrees())
    };
    let of_fork = |fork| at(fork).windows(2).filter_map(between).collect::<Vec<_>>();
    forks.flat_map(of_fork).collect()
}

/// How far branches are followed to see where they go: twice the width of the one that they leave.
fn sight(radius: f64, width: Option<f64>) -> f64 {
    (2.0 * width.unwrap_or(0.0)).max(LEAST_SIGHT * radius)
}

/// In element radii: what is nearer shows no direction.
const LEAST_SIGHT: f64 = 16.0;

/// Which elements have a tip among their descendants, or are one.
fn leading_to(parents: &[i32], tips: &[u32]) -> Vec<bool> {
    let mut leads = vec![false; parents.len()];
    tips.iter().for_each(|&tip| leads[tip as usize] = true);
    for i in (0..parents.len()).rev() {
        if let (true, Ok(parent)) = (leads[i], usize::try_from(parents[i])) {
            leads[parent] = true;
        }
    }
    leads
}

/// Where the way by a child of a fork first is twice the branch's width from it, or ends: a lobe as
/// wide as it is long ends before. Of later forks the eldest child is followed. None where that is
/// too near to show a direction.
fn follow(
    sample: &Sample<'_>,
    children: &[Vec<u32>],
    fork: usize,
    child: u32,
    length: f64,
) -> Option<DVec3> {
    let place = |i: usize| DVec3::from(sample.positions[i]);
    let mut at = child as usize;
    while place(at).distance(place(fork)) < length
        && let Some(&next) = children[at].first()
    {
        at = next as usize;
    }
    let is_far = place(at).distance(place(fork)) >= LEAST_SIGHT * sample.radius;
    is_far.then(|| place(at))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two arms of this many elements, at right angles.
    fn angles_of(arms: i32, width: f64) -> Vec<f64> {
        let mut positions = vec![[0.0; 3]];
        let mut parents = vec![-1];
        for arm in 0..2 {
            for i in 1..=arms {
                let mut position = [0.0; 3];
                position[arm] = 2.0 * f64::from(i);
                parents.push(if i == 1 { 0 } else { parents.len() as i32 - 1 });
                positions.push(position);
            }
        }
        let tips = [arms as u32, 2 * arms as u32];
        let sample = Sample {
            radius: 1.0,
            positions: &positions,
            normals: &vec![[0.0, 0.0, 1.0]; positions.len()],
            parents: &parents,
        };
        angles(&sample, &tips, &vec![Some(width); positions.len()])
    }

    #[test]
    fn lobes_wider_than_long_have_an_angle_too() {
        for width in [2.0, 10.0, 1000.0] {
            for arms in [8, 9, 50] {
                let found = angles_of(arms, width);
                assert!(
                    found.len() == 1 && (found[0] - 90.0).abs() < 1e-9,
                    "{found:?}"
                );
            }
            assert!(angles_of(7, width).is_empty());
        }
    }
}
