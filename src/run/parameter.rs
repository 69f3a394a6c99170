//! What each parameter does to the lichen's look, and its range: one table for help, errors and
//! documentation.

/// A number that the user may set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// Its flag without the dashes, which is also its key in a recipe.
    pub name: &'static str,
    /// What it looks like.
    pub looks: &'static str,
    /// Its range in words.
    pub range: &'static str,
    /// What holds when nothing is said; empty for nothing.
    pub default: &'static str,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
}

impl ParameterInfo {
    /// Whether a value is in range; NaN never is.
    pub fn allows(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Look, range and default, as `--help` has them.
    pub fn help(&self) -> String {
        let default = match self.default {
            "" => String::new(),
            default => format!(" [default: {default}]"),
        };
        format!("{} [range: {}]{default}", self.looks, self.range)
    }
}

/// Element radius r. Its bounds are relative to the bounding box's diagonal.
pub const RADIUS: ParameterInfo = ParameterInfo {
    name: "radius",
    looks: "Grain: radius of one element. Smaller gives a finer lichen that needs more elements to \
            cover the same surface",
    range: "auto (1/2000 of the bounding box's diagonal), or a length from a millionth to half of \
            that diagonal",
    default: "auto",
    low: 1e-6,
    high: 0.5,
};

/// The curvature radius where nothing says it, in element radii.
pub const DEFAULT_CURVATURE_RADII: f64 = 10.0;

/// Curvature radius L. Its bounds are in element radii.
pub const CURVATURE_RADIUS: ParameterInfo = ParameterInfo {
    name: "curvature-radius",
    looks: "Width of the branches: the distance L over which the lichen feels its own edge. 5r \
            gives twigs, 20r broad lobes",
    range: "2r to 1000r",
    default: "10r",
    low: 2.0,
    high: 1000.0,
};

/// Sticking bias B.
pub const BIAS: ParameterInfo = ParameterInfo {
    name: "bias",
    looks: "Openness: the chance B to stick at a straight edge. 0.7 to 1 gives thin, uneven, \
            fractal branches; 0.2 to 0.35 smooth, thick, space-filling lobes",
    range: "-1 to 2",
    default: "0.5",
    low: -1.0,
    high: 2.0,
};

/// Curvature gain A.
pub const GAIN: ParameterInfo = ParameterInfo {
    name: "gain",
    looks: "How strongly hollows fill and tips are held back (A). 0 ignores shape, 1 is the \
            thesis's. Fronts are roundest and most even at some 1 for a bias of 0.3, 2 for 0.5 and 3 for \
            0.7; beyond that they get angular",
    range: "0 to 100",
    default: "1",
    low: 0.0,
    high: 100.0,
};

/// Lowest sticking probability.
pub const MIN_STICK: ParameterInfo = ParameterInfo {
    name: "min-stick",
    looks: "Stray growth: the lowest chance to stick, even at the sharpest tip. Higher lets spikes \
            and side twigs through; lower is smoother and slower. 1 sticks always: plain DLA",
    range: "0.000001 to 1",
    default: "0.01",
    low: 1e-6,
    high: 1.0,
};

/// Launch radius.
pub const LAUNCH: ParameterInfo = ParameterInfo {
    name: "launch",
    looks: "Where walkers start, in effective radii from the lichen's centroid. It does not change \
            the look, unless close to 1, where outer branches win too easily",
    range: "1.1 to 100",
    default: "1.5",
    low: 1.1,
    high: 100.0,
};

/// Kill radius.
pub const KILL: ParameterInfo = ParameterInfo {
    name: "kill",
    looks: "Where walkers are given up, in effective radii. Larger is more exact; below 3 favours \
            the longest tips",
    range: "above launch, up to 10000",
    default: "10",
    low: 1.1,
    high: 10_000.0,
};

/// The size of a run where nothing says it.
pub const DEFAULT_ELEMENTS: u64 = 20_000;

/// Number of elements.
pub const ELEMENTS: ParameterInfo = ParameterInfo {
    name: "elements",
    looks: "Size: stop at this many elements",
    range: "1 to 1000000000",
    default: "20000",
    low: 1.0,
    high: 1e9,
};

/// Effective radius to reach.
pub const REACH: ParameterInfo = ParameterInfo {
    name: "reach",
    looks: "Size: stop when the lichen extends this far from its centroid; of several colonies, when \
            one extends this far from its seed",
    range: "a length above 0",
    default: "",
    low: 0.0,
    high: f64::MAX,
};

/// Share to cover.
pub const COVER: ParameterInfo = ParameterInfo {
    name: "cover",
    looks: "Size: stop when this share is covered of the pieces of the mesh that lichen is on, as far \
            as it may grow there. Discs leave gaps: growth ends by itself at about 0.75, or 0.6 \
            where they only touch",
    range: "above 0, up to 1",
    default: "",
    low: f64::MIN_POSITIVE,
    high: 1.0,
};

/// Number of colonies.
pub const COLONIES: ParameterInfo = ParameterInfo {
    name: "colonies",
    looks: "How many lichens grow at once, each from a seed of its own, and compete for the surface. Colonies without \
            a place start at random places, uniformly by area",
    range: "1 to 10000",
    default: "",
    low: 1.0,
    high: 10_000.0,
};

/// The table, in the order in which it is shown.
pub const PARAMETERS: &[ParameterInfo] = &[
    RADIUS,
    CURVATURE_RADIUS,
    BIAS,
    GAIN,
    MIN_STICK,
    LAUNCH,
    KILL,
    ELEMENTS,
    REACH,
    COVER,
    COLONIES,
];
