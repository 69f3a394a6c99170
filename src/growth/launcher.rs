//! Where walkers start and how far they may go, kept up with the cluster (Sumner 2001, 6.3).

use std::ops::Range;

use glam::DVec3;

use super::enclosed::Enclosed;
use super::far::{self, Far, outset};
use super::launch::{AreaSampler, LaunchRing};
use super::{Habitat, Parameters};
use crate::cluster::{Element, Extent};
use crate::rng::{Purpose, Stream};
use crate::substrate::{Component, Substrate};
use crate::walk::Stand;

/// R_e counts as at least this many radii: that of a single seed is 0.
const LEAST_EXTENT: f64 = 4.0;

/// The launch sphere is at least this many radii outside R_e.
const LEAST_GAP: f64 = 4.0;

/// A bound from the sphere that holds the lichen serves when it is this share of its radius.
const OUTSIDE: f64 = 0.2;

/// Farther from the centre than this many times the sphere's radius the index knows no better.
const AROUND: f64 = 2.5;

/// Where the sphere gives a bound of so many edges, a longer step saves crossings worth a look at the index.
const EDGES: f64 = 2.0;

/// Places on the arcs of each component that are looked at for whether lichen may grow there.
const PLACES: usize = 256;

/// Where walkers start at present, and how far they may go.
#[derive(Default)]
pub(super) struct Launcher {
    /// Those that carry lichen, in the order of their triangles.
    components: Vec<Range<u32>>,
    /// The arcs in which the sphere cuts each, on the surface that walkers [set out](outset) on: none where it
    /// encloses it.
    rings: Vec<LaunchRing>,
    /// Whether the arcs are those of the sphere as it is now.
    is_cut: bool,
    encloses: bool,
    pub(super) centre: DVec3,
    radius: f64,
    /// All elements are within this distance of the centre.
    pub(super) reach: f64,
    /// Squared distance from the centre beyond which that says enough of how far the lichen is.
    pub(super) outside_sq: f64,
    /// How far from the centre the index knows of better bounds, and edges are so many that these pay.
    better_by_index: Range<f64>,
    /// Walkers farther from the centre are dropped.
    pub(super) kill: f64,
    area: Option<AreaSampler>,
    /// Whether walkers start inside the sphere: where lichen may not grow everywhere, and none of the arcs seems to be
    /// where it may; or, until the next birth, because none comes in from outside.
    is_enclosed: bool,
    is_inside: bool,
    /// What the sphere encloses, once they do.
    enclosed: Option<Enclosed>,
    /// How often these were worked out anew.
    pub(super) version: u64,
}

impl Launcher {
    /// Takes in the youngest element.
    pub(super) fn update(
        &mut self,
        (substrate, parameters): (&Substrate, &Parameters),
        extent: &Extent,
        youngest: &Element,
    ) {
        let is_new = self.takes_in(substrate, youngest.at.triangle);
        if std::mem::take(&mut self.is_inside) {
            self.version += 1;
        }
        if is_new || self.is_left_behind(parameters, extent) {
            self.set_out(parameters, extent);
            self.better_by_index = self.reach + EDGES * edge(substrate)..AROUND * self.reach;
            self.change();
        }
    }

    /// Whether to take in the youngest element would change anything.
    pub(super) fn is_outdated(
        &self,
        (substrate, parameters): (&Substrate, &Parameters),
        extent: &Extent,
        youngest: &Element,
    ) -> bool {
        let component = substrate.component_of(youngest.at.triangle);
        self.is_inside
            || self.place_of(component).is_err()
            || self.is_left_behind(parameters, extent)
    }

    /// Whether the lichen has grown or moved too far for the spheres.
    fn is_left_behind(&self, parameters: &Parameters, extent: &Extent) -> bool {
        let radius = launch_radius(parameters, extent.effective_radius());
        let drift = self.centre.distance(extent.centroid()) + (radius - self.radius).abs();
        let gap = self.radius - extent.effective_radius();
        let reach = extent.effective_radius() + self.centre.distance(extent.centroid());
        drift > gap / 16.0 || reach > self.reach
    }

    /// Whether the component of a triangle is new.
    fn takes_in(&mut self, substrate: &Substrate, triangle: u32) -> bool {
        let component = substrate.component_of(triangle);
        let place = self.place_of(component);
        if let Err(place) = place {
            self.components.insert(place, component.triangles.clone());
            self.area = None;
        }
        place.is_err()
    }

    /// Where a component is, or belongs.
    fn place_of(&self, component: &Component) -> Result<usize, usize> {
        let first = component.triangles.start;
        self.components.binary_search_by_key(&first, |c| c.start)
    }

    /// Whether walkers start inside the sphere until the next birth.
    pub(super) fn is_inside(&self) -> bool {
        self.is_inside
    }

    /// Walkers start inside the sphere until the next birth.
    pub(super) fn launch_inside(&mut self) {
        if !std::mem::replace(&mut self.is_inside, true) {
            self.version += 1;
        }
    }

    /// Walkers start elsewhere from now on.
    pub(super) fn change(&mut self) {
        self.version += 1;
        self.is_cut = false;
    }

    /// Cuts the surface with the sphere, or the copy that walkers then set out on, if that has not been done. Before
    /// a walker starts, not at each birth: a run that goes on takes in many before.
    fn cut(&mut self, habitat: &Habitat<'_>, far: Option<&Far>) {
        let substrate = habitat.substrate;
        if self.is_cut {
            return;
        }
        self.is_cut = true;
        let (level, surface) = outset(far, substrate);
        let components = match far.filter(|_| level > 0) {
            Some(far) => self
                .components
                .iter()
                .map(|triangles| far.component_of_copy(triangles))
                .collect(),
            None => self.components.clone(),
        };
        self.rings = LaunchRing::of_each(surface, &components, self.centre, self.radius);
        self.encloses = self.rings.iter().all(|ring| ring.length() == 0.0);
        if self.goes_by_area() && self.area.is_none() {
            let triangles = self.components.iter().flat_map(Clone::clone);
            self.area = Some(AreaSampler::new(substrate, triangles));
        }
        self.is_enclosed = !habitat.is_everywhere() && !self.cuts_habitat(habitat, far);
        self.enclosed = None;
    }

    /// Makes ready for the next walkers: [cuts](Self::cut), and finds what the sphere encloses if they start there.
    pub(super) fn make_ready(&mut self, habitat: &Habitat<'_>, far: Option<&Far>) {
        self.cut(habitat, far);
        if self.launches_inside() && self.enclosed.is_none() {
            let within = habitat.substrate.triangles_within(self.centre, self.radius);
            let is_on = |t: &u32| self.components.iter().any(|c| c.contains(t));
            let within = within.into_iter().filter(is_on);
            let sphere = (self.centre, self.radius);
            self.enclosed = Some(Enclosed::new(habitat.substrate, sphere, within));
        }
    }

    fn launches_inside(&self) -> bool {
        self.is_enclosed || self.is_inside
    }

    fn goes_by_area(&self) -> bool {
        self.encloses || self.components.len() > 1
    }

    /// Chooses among all that carries lichen: where the sphere encloses that, or between several components.
    pub(super) fn by_area(&self) -> Option<&AreaSampler> {
        self.area.as_ref().filter(|_| self.goes_by_area())
    }

    /// Chooses among what the sphere encloses, where that is all the habitat there is about the lichen.
    pub(super) fn enclosed(&self) -> Option<&Enclosed> {
        self.enclosed.as_ref().filter(|_| self.launches_inside())
    }

    /// Whether lichen may grow at one of some places on the arcs.
    fn cuts_habitat(&self, habitat: &Habitat<'_>, far: Option<&Far>) -> bool {
        let (level, surface) = outset(far, habitat.substrate);
        let mut stream = Stream::new(0, Purpose::Habitat, 1);
        let mut is_habitat = |ring: &LaunchRing| {
            let at = ring.sample(surface, &mut stream);
            let there = at.map(|at| Stand::new(surface, &at));
            let on_mesh =
                there.and_then(|there| far::on_mesh(far, habitat.substrate, level, &there));
            on_mesh.is_some_and(|on_mesh| habitat.at(&on_mesh) > 0.0)
        };
        self.rings()
            .any(|ring| (0..PLACES).any(|_| is_habitat(ring)))
    }

    /// The arcs on the component that a triangle is in; none where the sphere encloses it.
    pub(super) fn ring_of(&self, triangle: u32) -> Option<&LaunchRing> {
        let component = self.components.partition_point(|c| c.end <= triangle);
        let ring = self.rings.get(component);
        ring.filter(|ring| ring.length() > 0.0)
    }

    /// All arcs, component by component.
    pub(super) fn rings(&self) -> impl Iterator<Item = &LaunchRing> {
        self.rings.iter().filter(|ring| ring.length() > 0.0)
    }

    /// Takes the spheres from the cluster as it is now.
    fn set_out(&mut self, parameters: &Parameters, extent: &Extent) {
        let effective = extent.effective_radius();
        self.centre = extent.centroid();
        self.radius = launch_radius(parameters, effective);
        self.reach = effective + (self.radius - effective) / 8.0;
        let outside = self.reach + (OUTSIDE * self.reach).max(2.0 * parameters.radius);
        let kill = parameters.kill * floored_extent(parameters, effective);
        self.kill = kill.max(self.radius + LEAST_GAP * parameters.radius);
        let outside = outside.min(self.kill);
        self.outside_sq = outside * outside;
    }

    /// Whether a walker outside the sphere that holds the lichen had better ask the index too. On a curved
    /// surface the lichen fills little of the sphere, and is up to twice as far as that.
    pub(super) fn asks_index(&self, from_centre: f64) -> bool {
        self.better_by_index.contains(&from_centre)
    }

    /// Whether all habitat about the lichen seems to be inside the sphere.
    pub(super) fn encloses_habitat(&self) -> bool {
        self.is_enclosed
    }

    /// Whether the launch sphere encloses all that carries lichen.
    pub(super) fn encloses(&self) -> bool {
        self.encloses
    }
}

/// About how long a mesh's edges are: those of as many triangles in a square as wide as the mesh.
fn edge(substrate: &Substrate) -> f64 {
    substrate.units().local_diagonal() / (substrate.triangles().len() as f64).sqrt()
}

fn floored_extent(parameters: &Parameters, effective_radius: f64) -> f64 {
    effective_radius.max(LEAST_EXTENT * parameters.radius)
}

fn launch_radius(parameters: &Parameters, effective_radius: f64) -> f64 {
    let scaled = parameters.launch * floored_extent(parameters, effective_radius);
    scaled.max(effective_radius + LEAST_GAP * parameters.radius)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::stick::tests::{parameters, scattered};
    use super::*;

    /// Walkers may walk on while elements are born only as long as nothing here changes.
    #[test]
    fn it_tells_beforehand_whether_an_element_changes_it() {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 250.0);
        let (all, _) = scattered(&substrate, &parameters, 4000);
        let mut cluster = crate::cluster::Cluster::new(parameters.radius);
        let (mut launcher, mut changes) = (Launcher::default(), 0);
        let surface = (&substrate, &parameters);
        for (age, element) in all.elements().iter().enumerate() {
            cluster.push(*element);
            if age % 500 == 499 {
                launcher.launch_inside();
            }
            let before = launcher.version;
            let is_outdated = launcher.is_outdated(surface, cluster.extent(), element);
            launcher.update(surface, cluster.extent(), element);
            assert_eq!(is_outdated, launcher.version != before, "element {age}");
            assert!(!launcher.is_outdated(surface, cluster.extent(), element));
            changes += usize::from(is_outdated);
        }
        assert!((10..2000).contains(&changes), "{changes} changes");
    }
}
