//! The lichen: elements in birth order, and where they are.

mod element;
mod extent;
mod index;
mod presence;
mod sparse;

pub use element::{Element, NO_PARENT};
pub use extent::Extent;
pub use index::{ElementIndex, Look, Mark};
pub use presence::{Ease, Presence};
pub use sparse::{Notes, SparseIndex};

/// The append-only list of elements, in birth order.
///
/// Everything is in the substrate's local units.
#[derive(Clone, Debug)]
pub struct Cluster {
    radius: f64,
    elements: Vec<Element>,
    extent: Extent,
}

impl Cluster {
    /// No elements yet, of this radius.
    pub fn new(radius: f64) -> Self {
        Self {
            radius,
            elements: Vec::new(),
            extent: Extent::default(),
        }
    }

    /// Radius r of every element.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The elements, oldest first.
    pub fn elements(&self) -> &[Element] {
        &self.elements
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

    /// Adds an element as the youngest.
    pub fn push(&mut self, element: Element) {
        self.elements.push(element);
        self.extent.add(&self.elements);
    }
}
