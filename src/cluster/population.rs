//! The elements that there are, while others are born.

use std::sync::OnceLock;

use super::{Cluster, Element, is_set};

/// Elements by their ages: those of a cluster, and such as were born since it was last added to.
///
/// While walkers walk on several threads others may be born: whoever asks knows of the first [`len`](Self::len), and
/// may come upon younger ones, which [`get`](Self::get) finds if they are there already.
#[derive(Clone, Copy, Debug)]
pub struct Population<'a> {
    old: &'a [Element],
    /// A bit for each triangle that holds one of these, where that is known.
    overgrown: Option<&'a [u64]>,
    young: &'a [OnceLock<Element>],
    len: usize,
}

impl<'a> Population<'a> {
    /// This population with so many elements in all, of which the younger are in these places in order.
    ///
    /// # Panics
    /// When there are fewer.
    #[must_use]
    pub fn with_young(self, young: &'a [OnceLock<Element>], len: usize) -> Self {
        let all = Self { young, len, ..self };
        assert!(len == 0 || all.at(len - 1).is_some(), "{len} elements");
        all
    }

    /// How many are known.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether none is.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The one of an age, known or not; none where it has not been born.
    #[inline(always)]
    pub fn get(&self, age: u32) -> Option<&'a Element> {
        self.at(age as usize)
    }

    #[inline(always)]
    fn at(&self, age: usize) -> Option<&'a Element> {
        match self.old.get(age) {
            None => self.young.get(age - self.old.len())?.get(),
            found => found,
        }
    }

    /// Whether the centre of one, known or not, is on some triangles: those of a list, which `is_one` tells too.
    pub fn are_on(&self, triangles: &[u32], is_one: impl Fn(u32) -> bool) -> bool {
        let is_there = |element: &Element| is_one(element.at.triangle);
        let old = match self.overgrown {
            Some(bits) => triangles.iter().any(|&t| is_set(bits, t)),
            None => self.old.iter().any(is_there),
        };
        old || self.young.iter().map_while(OnceLock::get).any(is_there)
    }

    /// The known elements from an age on.
    pub fn since(&self, age: usize) -> impl Iterator<Item = &'a Element> + Clone + use<'a> {
        let (old, young) = (self.old.len().min(self.len), self.young);
        let born = self.len - old;
        self.old[age.min(old)..old].iter().chain(
            young[age.saturating_sub(old).min(born)..born]
                .iter()
                .map_while(OnceLock::get),
        )
    }

    /// The youngest that is known, and its age.
    pub fn youngest(&self) -> Option<(u32, &'a Element)> {
        let age = self.len.checked_sub(1)?;
        Some((age as u32, self.at(age)?))
    }
}

impl<'a> From<&'a [Element]> for Population<'a> {
    fn from(elements: &'a [Element]) -> Self {
        Self {
            old: elements,
            overgrown: None,
            young: &[],
            len: elements.len(),
        }
    }
}

impl<'a> From<&'a Vec<Element>> for Population<'a> {
    fn from(elements: &'a Vec<Element>) -> Self {
        elements.as_slice().into()
    }
}

impl<'a> From<&'a Cluster> for Population<'a> {
    fn from(cluster: &'a Cluster) -> Self {
        Self {
            overgrown: Some(&cluster.overgrown),
            ..cluster.elements().into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::NO_PARENT;
    use crate::substrate::SurfacePoint;

    fn element(triangle: u32) -> Element {
        let at = SurfacePoint::centroid(triangle);
        Element {
            at,
            position: glam::DVec3::ZERO,
            parent: NO_PARENT,
            colony: 0,
            probability: 1.0,
        }
    }

    #[test]
    fn the_young_follow_the_old_whether_known_or_not() {
        let mut cluster = Cluster::new(1.0);
        cluster.extend([5, 70].map(element));
        let young: Vec<OnceLock<Element>> = (0..3).map(|_| OnceLock::new()).collect();
        let ages = |all: &Population<'_>, age| -> Vec<u32> {
            all.since(age).map(|e| e.at.triangle).collect()
        };
        for old in [Population::from(&cluster), cluster.elements().into()] {
            assert_eq!((old.len(), old.is_empty()), (2, false));
            assert!(old.are_on(&[8, 70], |t| [8, 70].contains(&t)));
            assert!(!old.are_on(&[8, 7], |t| [8, 7].contains(&t)));
        }
        young[0].get_or_init(|| element(7));
        let all = Population::from(&cluster).with_young(&young, 3);
        young[1].get_or_init(|| element(9));
        assert_eq!(ages(&all, 0), [5, 70, 7]);
        assert_eq!(ages(&all, 1), [70, 7]);
        assert_eq!(ages(&all, 2), [7]);
        assert!(ages(&all, 3).is_empty());
        let triangle = |age| all.get(age).map(|e| e.at.triangle);
        assert_eq!(
            [1, 2, 3, 4].map(triangle),
            [Some(70), Some(7), Some(9), None]
        );
        let is_on = |triangle: u32| all.are_on(&[triangle], |t| t == triangle);
        assert!([5, 7, 9, 70].into_iter().all(is_on) && !is_on(6));
        let youngest = all.youngest().map(|(age, e)| (age, e.at.triangle));
        assert_eq!(youngest, Some((2, 7)));
        assert!(Population::from([].as_slice()).youngest().is_none());
    }

    #[test]
    #[should_panic(expected = "4 elements")]
    fn there_cannot_be_more_than_there_are() {
        let elements = [1, 2, 3].map(element);
        let _ = Population::from(elements.as_slice()).with_young(&[], 4);
    }
}
