//! Where Brownian motion beside a circle first arrives.

use glam::DVec2;

/// A disc about a walker, and a circle of contact that cuts into it. Both lie in a plane.
///
/// Two circles that cross are mapped to a wedge by a Möbius transformation that sends one crossing
/// to 0 and the other to infinity, and the wedge to a half-plane by a power. Brownian paths stay
/// Brownian paths (Lévy's theorem on conformal invariance), and from a half-plane they go out
/// Cauchy-distributed.
#[derive(Clone, Copy, Debug)]
pub struct Lune {
    /// From the walker to the centre of the circle of contact.
    centre: DVec2,
    contact: f64,
    free: f64,
    /// The distance from the walker to that centre.
    distance: f64,
    /// Where the circles cross, (x, ±y), with the walker at 0 and the centre on the positive x-axis.
    crossing: DVec2,
}

/// Where a walker first meets the rim of a lune, seen from where it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// On the circle of contact.
    Contact(DVec2),
    /// On the rim of the disc about where it was.
    Free(DVec2),
}

impl Lune {
    /// With a walker outside the circle, and a disc that reaches across the circle's nearest point
    /// but not beyond its centre, and crosses it in two places. None otherwise.
    pub fn new(centre: DVec2, contact: f64, free: f64) -> Option<Self> {
        let distance = centre.length();
        let gap = distance - contact;
        let x = (gap * (distance + contact) + free * free) / (2.0 * distance);
        let y = (free * free - x * x).max(0.0).sqrt();
        // Of a disc that reaches across by round-off alone nothing is left to arrive at.
        let is_cut = gap > 0.0 && gap < free && free <= distance && y > 0.0;
        is_cut.then_some(Self {
            centre,
            contact,
            free,
            distance,
            crossing: DVec2::new(x, y),
        })
    }

    /// The first arrival at the rim of a Brownian path from the walker, from a standard Cauchy
    /// number.
    pub fn first_arrival(&self, cauchy: f64) -> Arrival {
        let Self {
            contact,
            free,
            distance,
            crossing: DVec2 { x, y },
            ..
        } = *self;
        let gap = distance - contact;
        // Half the angles of the wedge between the walker and either side.
        let to_contact = libm::atan2(y * gap, free * free - gap * x);
        let to_free = libm::atan2(y, free + x);
        let whole = to_contact + to_free;
        let (sin, cos) = libm::sincos(std::f64::consts::PI * (to_contact / whole));
        let arrives = cos + sin * cauchy;
        // Along a side of the wedge: from the crossing at (x, y) to that at (x, −y).
        let along = libm::pow(arrives.abs(), whole * std::f64::consts::FRAC_2_PI);
        let meets = arrives > 0.0;
        let nearest = if meets { gap } else { -free };
        let turned = DVec2::new(nearest - x, -y);
        let side = turned.rotate(turned) / turned.length_squared();
        let scale = 1.0 - 2.0 * along * side.x + along * along;
        let at = DVec2::new(
            x - 2.0 * y * along * side.y / scale,
            y * (1.0 - along * along) / scale,
        );
        let there = at.rotate(self.centre / distance);
        if meets {
            Arrival::Contact(there)
        } else {
            Arrival::Free(there)
        }
    }
}
