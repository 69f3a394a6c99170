//! How long a walker goes on in narrow steps before it asks what of the lichen near it is on its own sheet.
//!
//! Below lichen on the other face of a thin plate, a walker is near elements that it can never touch. The search for
//! its own sheet gives longer steps there, and takes as long as many steps.

/// Narrow steps in a row after which a walker looks. It is looked at one step in
/// [`STEPS_PER_LOOK`](super::walker::STEPS_PER_LOOK) whether they are, and that many count as one.
const LIMIT: i32 = 16;

/// Radii of the longest step that counts as narrow.
const NARROW: f64 = 16.0;

/// Narrow steps for which one of the shortest counts.
const SHORTEST: i32 = 4;

/// Narrow steps in a row up to now, without a contact.
///
/// - Below 0 a walker waits: its last search was not worth its time, and so many steps pass before steps count again.
/// - At [`LIMIT`] it searches at every step, and goes by its own sheet as long as that is worth it. Steps are not
///   counted meanwhile.
/// - One short of that it has come out into the open from there, or was about to search: a single narrow step is enough,
///   however many wide ones come before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Patience(i32);

impl Patience {
    /// Of a walker that has come out into the open.
    pub(super) const OUT_OF_THE_NARROWS: Self = Self(LIMIT - 1);

    /// Of one that does not search again for so many counted steps.
    pub(super) fn paused(steps: i32) -> Self {
        Self(-steps)
    }

    /// Whether it is time to search.
    pub(super) fn is_over(self) -> bool {
        self.0 >= LIMIT
    }

    /// Whether a step of this bound is too long to count.
    pub(super) fn is_wide(bound: f64, radius: f64) -> bool {
        bound > NARROW * radius
    }

    /// After steps of this bound.
    pub(super) fn after(self, bound: f64, radius: f64) -> Self {
        match bound {
            _ if self.is_over()
                || (self == Self::OUT_OF_THE_NARROWS && Self::is_wide(bound, radius)) =>
            {
                self
            }
            wide if Self::is_wide(wide, radius) => self.after_contact(),
            narrow if narrow > radius => Self(self.0.saturating_add(1)),
            _ => Self(self.0.saturating_add(SHORTEST)),
        }
    }

    /// After a contact at which it was refused: what is near is on its sheet. A pause goes on.
    pub(super) fn after_contact(self) -> Self {
        Self(self.0.min(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(patience: Patience, bounds: &[f64]) -> Patience {
        bounds
            .iter()
            .fold(patience, |p, &bound| p.after(bound, 1.0))
    }

    #[test]
    fn narrow_steps_in_a_row_are_enough_and_the_shortest_sooner() {
        let start = Patience::default();
        assert!(!after(start, &[8.0; 15]).is_over() && after(start, &[8.0; 16]).is_over());
        assert!(!after(start, &[0.5; 3]).is_over() && after(start, &[0.5; 4]).is_over());
        let broken = [[8.0; 14].as_slice(), &[20.0], &[8.0; 15]].concat();
        assert!(!after(start, &broken).is_over());
        assert_eq!(after(start, &[8.0; 15]).after_contact(), start);
    }

    #[test]
    fn a_pause_outlasts_wide_steps_and_contacts() {
        let paused = Patience::paused(10);
        assert_eq!(after(paused, &[20.0]).after_contact(), paused);
        assert!(!after(paused, &[8.0; 25]).is_over() && after(paused, &[8.0; 26]).is_over());
    }

    #[test]
    fn out_in_the_open_one_narrow_step_is_enough() {
        let out = after(Patience::OUT_OF_THE_NARROWS, &[20.0; 100]);
        assert!(!out.is_over() && after(out, &[8.0]).is_over());
        assert_eq!(out.after_contact(), Patience::default());
    }

    #[test]
    fn while_it_searches_nothing_is_counted() {
        let searching = after(Patience::default(), &[0.5; 4]);
        assert_eq!(after(searching, &[20.0, 8.0, 0.5]), searching);
        assert!(after(Patience::paused(-i32::MAX), &[0.5]).is_over());
    }
}
