//! Who watches a run. Growth neither prints nor writes: observers do.

use std::ops::ControlFlow;

use crate::cluster::Element;
use crate::growth::Counts;

/// How far a run has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Elements born.
    pub elements: u64,
    /// Effective radius R_e, file units.
    pub effective_radius: f64,
    /// What a reach is compared with, file units: the effective radius, or of several colonies how far elements are
    /// from their colonies' seeds at most.
    pub reach: f64,
    /// Share of the pieces that the lichen is on that its discs cover, by area, 0 to 1.
    pub covered: f64,
    /// What it took: together with the elements, all that going on later needs.
    pub counts: Counts,
}

/// Watches elements being born, and may stop the run.
///
/// Mind the units: an [`Element`] is in the substrate's local ones, [`Progress`] in the mesh file's. See
/// [`Units`](crate::substrate::Units), whose [`to_file`](crate::substrate::Units::to_file) converts.
///
/// It is always called from one thread at a time, but that may be another than the one that began
/// the run. On several threads walkers walk meanwhile, and up to 256 younger elements may have been born: those that it
/// is not told of when it ends the run are none.
pub trait Observer: Send {
    /// Called after each birth, the seed's included; `Break` ends the run with this element.
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()>;
}

/// Watches nothing.
impl Observer for () {
    fn born(&mut self, _: &Element, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Both watch, and either may stop the run.
impl<A: Observer, B: Observer> Observer for (A, B) {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        let first = self.0.born(element, progress);
        let second = self.1.born(element, progress);
        match first {
            ControlFlow::Break(()) => first,
            ControlFlow::Continue(()) => second,
        }
    }
}

/// An observer that is lent, and used again afterwards.
impl<O: Observer + ?Sized> Observer for &mut O {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        (**self).born(element, progress)
    }
}

/// An observer of a kind that is known only when the program runs.
impl<O: Observer + ?Sized> Observer for Box<O> {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        (**self).born(element, progress)
    }
}

/// A closure that watches, made by [`watch`].
#[derive(Clone, Copy, Debug)]
pub struct Watch<F>(F);

/// An observer of what is to be done at each birth. (Were closures observers by themselves, references and boxes could
/// not be.)
///
/// ```
/// use std::ops::ControlFlow;
/// use thallus::run::watch;
///
/// // No larger than 3 in the mesh's units.
/// let mut observer = watch(|_, progress| match progress.effective_radius > 3.0 {
///     true => ControlFlow::Break(()),
///     false => ControlFlow::Continue(()),
/// });
/// # let also: Box<dyn thallus::run::Observer> = Box::new(());
/// # let _: &mut dyn thallus::run::Observer = &mut (&mut observer, also);
/// ```
pub fn watch<F: FnMut(&Element, &Progress) -> ControlFlow<()> + Send>(born: F) -> Watch<F> {
    Watch(born)
}

impl<F: FnMut(&Element, &Progress) -> ControlFlow<()> + Send> Observer for Watch<F> {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        (self.0)(element, progress)
    }
}
