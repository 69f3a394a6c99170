//! Colour maps named after the lichens that look so.

use super::paint::{Prothallus, UnknownColormap};
use super::{Apothecia, Areoles, ColormapError};

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
    /// The cracks that its crust has.
    pub areoles: Option<Areoles>,
    /// The fruiting bodies that it has.
    pub apothecia: Option<Apothecia>,
}

const PLAIN: NamedColormap = NamedColormap {
    name: "",
    look: "",
    stops: &[],
    prothallus: None,
    areoles: None,
    apothecia: None,
};

/// Every colour map.
pub const PALETTE: &[NamedColormap] = &[
    NamedColormap {
        name: "parmelia",
        look: "shield lichen: grey-green, paler at the tips of its lobes",
        stops: &[
            (0.10, [0xb9, 0xc1, 0xaf]),
            (0.40, [0xa6, 0xb0, 0x9c]),
            (0.60, [0x8d, 0x97, 0x84]),
            (0.80, [0x6c, 0x74, 0x63]),
        ],
        ..PLAIN
    },
    NamedColormap {
        name: "xanthoria",
        look: "sunburst lichen: yellow-orange lobes, crowded with orange discs in the middle",
        stops: &[
            (0.10, [0xf0, 0xc4, 0x3c]),
            (0.40, [0xe9, 0xac, 0x2a]),
            (0.60, [0xdc, 0x93, 0x1c]),
            (0.80, [0xc4, 0x7a, 0x14]),
        ],
        apothecia: Some(Apothecia {
            width: 11.0,
            spacing: 9.0,
            from: 6.0,
            color: [0xc8, 0x68, 0x0f],
            margin: 0.22,
        }),
        ..PLAIN
    },
    NamedColormap {
        name: "rhizocarpon",
        look: "map lichen: yellow-green, with black cracks, discs and margin",
        stops: &[
            (0.10, [0x8f, 0x92, 0x40]),
            (0.45, [0xad, 0xb0, 0x52]),
            (0.65, [0xa0, 0xa4, 0x4c]),
            (0.80, [0x7f, 0x84, 0x3e]),
        ],
        prothallus: Some(Prothallus {
            width: 4.0,
            color: [0x26, 0x27, 0x1d],
        }),
        areoles: Some(Areoles {
            width: 9.0,
            color: [0x26, 0x27, 0x1d],
        }),
        apothecia: Some(Apothecia {
            width: 7.0,
            spacing: 15.0,
            from: 8.0,
            color: [0x1c, 0x1c, 0x1a],
            margin: 0.0,
        }),
    },
    NamedColormap {
        name: "caloplaca",
        look: "firedot lichen: cracked, rust orange, brighter at the rim",
        stops: &[
            (0.10, [0xee, 0xb0, 0x40]),
            (0.45, [0xe3, 0x92, 0x2a]),
            (0.62, [0xd6, 0x80, 0x22]),
            (0.80, [0xb5, 0x64, 0x1c]),
        ],
        areoles: Some(Areoles {
            width: 10.0,
            color: [0x7a, 0x3e, 0x12],
        }),
        ..PLAIN
    },
    NamedColormap {
        name: "lecanora",
        look: "rim lichen: chalk grey and cracked, brown discs with pale rims, a blue-grey margin",
        stops: &[
            (0.10, [0xb9, 0xbb, 0xb0]),
            (0.50, [0xd0, 0xd0, 0xc2]),
            (0.75, [0xb3, 0xb1, 0x9f]),
        ],
        prothallus: Some(Prothallus {
            width: 5.0,
            color: [0x5b, 0x63, 0x68],
        }),
        areoles: Some(Areoles {
            width: 8.0,
            color: [0x5e, 0x60, 0x58],
        }),
        apothecia: Some(Apothecia {
            width: 9.0,
            spacing: 11.0,
            from: 10.0,
            color: [0x5c, 0x46, 0x36],
            margin: 0.25,
        }),
    },
    NamedColormap {
        name: "xanthoparmelia",
        look: "rock-shield lichen: pale yellow-green lobes, darker in the middle",
        stops: &[
            (0.10, [0xd7, 0xd9, 0xa8]),
            (0.40, [0xbc, 0xc1, 0x8a]),
            (0.60, [0x98, 0x9f, 0x6a]),
            (0.80, [0x6c, 0x71, 0x4a]),
        ],
        ..PLAIN
    },
    NamedColormap {
        name: "verrucaria",
        look: "wart lichen: olive black, as on wet rock",
        stops: &[
            (0.10, [0x84, 0x79, 0x55]),
            (0.50, [0x66, 0x5f, 0x43]),
            (0.80, [0x46, 0x42, 0x31]),
        ],
        areoles: Some(Areoles {
            width: 8.0,
            color: [0x14, 0x13, 0x0f],
        }),
        ..PLAIN
    },
    NamedColormap {
        name: "cladonia",
        look: "reindeer lichen: pale silver green",
        stops: &[
            (0.10, [0xe4, 0xe5, 0xd2]),
            (0.40, [0xd0, 0xd4, 0xbb]),
            (0.70, [0xaa, 0xb1, 0x95]),
        ],
        ..PLAIN
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
