//! Colour maps named after the lichens that look so.

use super::ColormapError;
use super::paint::{Prothallus, UnknownColormap};

/// A colour map with a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedColormap {
    /// A genus.
    pub name: &'static str,
    /// What it looks like.
    pub look: &'static str,
    /// Local density and sRGB colour, ascending.
    pub stops: &'static [(f32, [u8; 3])],
    /// The dark margin that such a lichen has.
    pub prothallus: Option<Prothallus>,
}

/// Every colour map.
pub const PALETTE: &[NamedColormap; 8] = &[
    NamedColormap {
        name: "parmelia",
        look: "shield lichen: grey-green, paler at the tips of its lobes",
        stops: &[
            (0.10, [0xc9, 0xd0, 0xbd]),
            (0.40, [0xb2, 0xbc, 0xa4]),
            (0.65, [0x8d, 0x9a, 0x82]),
            (0.85, [0x6f, 0x7c, 0x66]),
        ],
        prothallus: None,
    },
    NamedColormap {
        name: "xanthoria",
        look: "sunburst lichen: yellow lobes, deep orange in the middle",
        stops: &[
            (0.10, [0xf2, 0xc1, 0x3c]),
            (0.40, [0xea, 0xa0, 0x20]),
            (0.65, [0xd8, 0x7d, 0x14]),
            (0.85, [0xb4, 0x5c, 0x12]),
        ],
        prothallus: None,
    },
    NamedColormap {
        name: "rhizocarpon",
        look: "map lichen: yellow-green with a black margin",
        stops: &[
            (0.10, [0x9c, 0xa0, 0x3a]),
            (0.45, [0xc3, 0xc6, 0x4b]),
            (0.70, [0xb5, 0xbb, 0x48]),
            (0.90, [0x8f, 0x97, 0x3c]),
        ],
        prothallus: Some(Prothallus {
            width: 6.0,
            color: [0x1f, 0x20, 0x1a],
        }),
    },
    NamedColormap {
        name: "caloplaca",
        look: "firedot lichen: rust orange, brighter at the rim",
        stops: &[
            (0.10, [0xe8, 0x92, 0x2c]),
            (0.50, [0xcf, 0x66, 0x1c]),
            (0.80, [0x9d, 0x42, 0x18]),
        ],
        prothallus: None,
    },
    NamedColormap {
        name: "lecanora",
        look: "rim lichen: chalk grey with a blue-grey margin",
        stops: &[
            (0.10, [0xb9, 0xbb, 0xb0]),
            (0.50, [0xd3, 0xd4, 0xc8]),
            (0.80, [0xb6, 0xb5, 0xa3]),
        ],
        prothallus: Some(Prothallus {
            width: 5.0,
            color: [0x5b, 0x63, 0x68],
        }),
    },
    NamedColormap {
        name: "xanthoparmelia",
        look: "rock-shield lichen: pale yellow-green lobes, darker in the middle",
        stops: &[
            (0.10, [0xd9, 0xdc, 0xa6]),
            (0.40, [0xbf, 0xc6, 0x86]),
            (0.65, [0x9a, 0xa3, 0x66]),
            (0.85, [0x6f, 0x76, 0x48]),
        ],
        prothallus: None,
    },
    NamedColormap {
        name: "verrucaria",
        look: "wart lichen: olive black, as on wet rock",
        stops: &[
            (0.10, [0x5a, 0x58, 0x48]),
            (0.50, [0x3f, 0x40, 0x36]),
            (0.85, [0x27, 0x29, 0x24]),
        ],
        prothallus: None,
    },
    NamedColormap {
        name: "cladonia",
        look: "reindeer lichen: pale silver green",
        stops: &[
            (0.10, [0xe2, 0xe6, 0xd6]),
            (0.40, [0xce, 0xd6, 0xbf]),
            (0.75, [0xa9, 0xb6, 0x9b]),
        ],
        prothallus: None,
    },
];

/// The colour map of this name.
pub(super) fn find(name: &str) -> Result<&'static NamedColormap, ColormapError> {
    let unknown = || UnknownColormap(name.to_owned()).into();
    PALETTE
        .iter()
        .find(|map| map.name == name)
        .ok_or_else(unknown)
}
