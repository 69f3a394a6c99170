//! The lichen: elements in birth order, and where they are.

mod element;
mod extent;
mod index;
mod population;
mod presence;
mod sparse;

pub use element::{Element, NO_PARENT};
pub use extent::Extent;
pub use index::{ElementIndex, Look, Mark};
pub use population::Population;
pub use presence::{Ease, Presence};
pub use sparse::{Notes, SparseIndex};

/// The smallest radius that positions and indices resolve, over the diagonal of the mesh's bounding box.
pub const LEAST_RADIUS: f64 = 1e-7;

/// The append-only list of elements, in birth order.
///
/// Everything is in the substrate's local units.
#[derive(Clone, Debug)]
pub struct Cluster {
    radius: f64,
    elements: Vec<Element>,
    extent: Extent,
    /// A bit for each triangle up to the last one that holds an element's centre.
    overgrown: Vec<u64>,
}

impl Cluster {
    /// No elements yet, of this radius in the substrate's local units.
    ///
    /// # Panics
    /// When the radius is not finite and positive.
    pub fn new(radius: f64) -> Self {
        assert!(radius > 0.0 && radius.is_finite(), "radius {radius}");
        Self {
            radius,
            elements: Vec::new(),
            extent: Extent::default(),
            overgrown: Vec::new(),
        }
    }

    /// Makes room for so many elements in all, where there is any.
    pub fn expect(&mut self, elements: usize) {
        make_room(&mut self.elements, elements);
    }

    /// Radius r of every element.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The elements, oldest first.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// The elements, oldest first, to keep.
    pub fn into_elements(self) -> Vec<Element> {
        self.elements
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Centroid and effective radius.
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// Area of the elements' discs.
    pub fn covered_area(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius * self.len() as f64
    }

    /// Whether some element's centre is on a triangle.
    pub fn is_on(&self, triangle: u32) -> bool {
        is_set(&self.overgrown, triangle)
    }

    /// Adds an element as the youngest.
    pub fn push(&mut self, element: Element) {
        self.overgrow(element.at.triangle);
        self.elements.push(element);
        self.extent.add(&self.elements.as_slice().into());
    }

    fn overgrow(&mut self, triangle: u32) {
        let (word, bit) = place_of_bit(triangle);
        if word >= self.overgrown.len() {
            self.overgrown.resize(word + 1, 0);
        }
        self.overgrown[word] |= bit;
    }

    /// Leaves the first so many elements, as if no others had been added: for births that nobody was told of. To all
    /// others a cluster only grows.
    pub(crate) fn truncate(&mut self, len: usize) {
        if len >= self.len() {
            return;
        }
        let mut kept = std::mem::take(&mut self.elements);
        kept.truncate(len);
        self.extent = Extent::default();
        self.overgrown.clear();
        for (last, element) in kept.iter().enumerate() {
            self.overgrow(element.at.triangle);
            self.extent.add(&kept[..=last].into());
        }
        self.elements = kept;
    }
}

/// Adds elements as the youngest, one after the other.
impl Extend<Element> for Cluster {
    fn extend<T: IntoIterator<Item = Element>>(&mut self, elements: T) {
        elements.into_iter().for_each(|element| self.push(element));
    }
}

/// Makes room for so many in all. Room that is not used takes no memory; where it is not to be had,
/// the vector grows as others do.
fn make_room<T>(all: &mut Vec<T>, most: usize) {
    let more = most.saturating_sub(all.len());
    let _ = all.try_reserve_exact(more);
}

/// Whether the bit of a triangle is set.
fn is_set(bits: &[u64], triangle: u32) -> bool {
    let (word, bit) = place_of_bit(triangle);
    bits.get(word).is_some_and(|w| w & bit != 0)
}

fn place_of_bit(triangle: u32) -> (usize, u64) {
    (triangle as usize / 64, 1 << (triangle % 64))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::substrate::SurfacePoint;

    #[test]
    fn a_cluster_is_on_the_triangles_of_its_elements() {
        let mut cluster = Cluster::new(1.0);
        let grown = [63, 64, 3, 700, 3];
        for triangle in grown {
            cluster.push(Element {
                at: SurfacePoint::centroid(triangle),
                position: DVec3::ZERO,
                parent: NO_PARENT,
                colony: 0,
                probability: 1.0,
            });
        }
        assert!((0..1000).all(|t| cluster.is_on(t) == grown.contains(&t)));
        cluster.truncate(3);
        assert!((0..1000).all(|t| cluster.is_on(t) == [63, 64, 3].contains(&t)));
    }
}
