//! The maps: what each one holds, and in what form it is written.

use glam::Vec3;

use super::Baked;

/// What a map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapKind {
    /// The share of a texel that lichen covers.
    Mask,
    /// The lichen's height over the mesh.
    Height,
    /// Normals in tangent space.
    Normal,
    /// When the lichen came.
    Birth,
    /// The lichen's own colour.
    Color,
    /// The share of the sky's light that the lichen around leaves.
    Occlusion,
    /// The lichen's colour over the mesh's own.
    BaseColor,
    /// Occlusion, roughness and metal in one.
    Orm,
}

/// A map.
#[derive(Clone, Copy, Debug)]
pub struct Map {
    /// What it holds.
    pub kind: MapKind,
    /// Its name in files.
    pub name: &'static str,
    /// What it holds, in words for the user.
    pub what: &'static str,
    /// 1 for grey, 3 for red, green and blue.
    pub channels: usize,
    /// Bits a channel where it is written as PNG.
    pub png_bits: u8,
    /// Whether it is a colour to look at: sRGB in PNG, linear in EXR.
    pub is_color: bool,
    /// Whether it is written to EXR in 32 bits, and not in 16.
    pub is_exact: bool,
    pub(super) value: fn(&Baked, usize) -> [f32; 3],
}

/// Every map.
pub const MAPS: &[Map] = &[
    Map {
        kind: MapKind::Mask,
        name: "mask",
        what: "share of the texel that lichen covers",
        value: |baked, i| grey(baked.texels.get(i).map_or(0.0, |t| t.mask)),
        ..GREY
    },
    Map {
        kind: MapKind::Height,
        name: "height",
        what: "height of the lichen over the mesh, along its normal",
        png_bits: 16,
        is_exact: true,
        value: |baked, i| {
            let height = baked.texels.get(i).map_or(0.0, |t| t.height);
            grey(height / baked.highest.max(f32::MIN_POSITIVE))
        },
        ..GREY
    },
    Map {
        kind: MapKind::Normal,
        name: "normal",
        what: "normal in tangent space (MikkTSpace), lichen over the mesh's own normal map",
        channels: 3,
        png_bits: 16,
        value: |baked, i| (0.5 * baked.normal(i) + 0.5).to_array(),
        ..GREY
    },
    Map {
        kind: MapKind::Birth,
        name: "birth",
        what: "when the lichen came: 0 the first element, 1 the last; 1 where there is none near",
        png_bits: 16,
        is_exact: true,
        value: |baked, i| grey(baked.texels.get(i).map_or(1.0, |t| t.birth)),
        ..GREY
    },
    Map {
        kind: MapKind::Color,
        name: "color",
        what: "the lichen's own colour, black where there is none near",
        value: |baked, i| baked.texels.get(i).map_or([0.0; 3], |t| t.color.to_array()),
        ..COLOR
    },
    Map {
        kind: MapKind::Occlusion,
        name: "occlusion",
        what: "share of an even sky's light that the lichen around leaves",
        value: |baked, i| grey(baked.occlusion(i)),
        ..GREY
    },
    Map {
        kind: MapKind::BaseColor,
        name: "base_color",
        what: "the lichen's colour over the mesh's own",
        value: |baked, i| baked.base_color(i).to_array(),
        ..COLOR
    },
    Map {
        kind: MapKind::Orm,
        name: "orm",
        what: "red: occlusion, green: roughness, blue: metallic",
        channels: 3,
        value: |baked, i| baked.orm(i),
        ..GREY
    },
];

const GREY: Map = Map {
    kind: MapKind::Mask,
    name: "",
    what: "",
    channels: 1,
    png_bits: 8,
    is_color: false,
    is_exact: false,
    value: |_, _| [0.0; 3],
};

const COLOR: Map = Map {
    channels: 3,
    is_color: true,
    ..GREY
};

/// Roughness of lichen: chalky.
const ROUGH: f32 = 0.9;

fn grey(x: f32) -> [f32; 3] {
    [x; 3]
}

impl Map {
    /// The map of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        MAPS.iter().find(|map| map.name == name)
    }

    /// The map of this kind.
    pub(super) fn of(kind: MapKind) -> &'static Self {
        let place = MAPS.iter().position(|map| map.kind == kind);
        &MAPS[place.unwrap_or(0)]
    }
}

impl Baked<'_> {
    /// Height of the highest texel, in the mesh file's units.
    pub fn highest(&self) -> f64 {
        let units = self.shown.substrate.units();
        units.length_to_file(f64::from(self.highest))
    }

    /// A map's numbers at the texel in a column and a row, from the upper left: 0 to 1, colours in
    /// linear light, grey as three equal ones.
    ///
    /// # Panics
    /// Beyond the image.
    pub fn value(&self, map: &Map, x: usize, y: usize) -> [f32; 3] {
        assert!(x < self.size(), "column {x} of {}", self.size());
        (map.value)(self, y * self.size() + x)
    }

    fn occlusion(&self, texel: usize) -> f32 {
        self.texels.get(texel).map_or(1.0, |t| t.occlusion)
    }

    fn base_color(&self, texel: usize) -> Vec3 {
        let under = self.bare_color(texel);
        let over = self.texels.get(texel);
        over.map_or(under, |t| under.lerp(t.color, t.mask))
    }

    fn orm(&self, texel: usize) -> [f32; 3] {
        let under = self.surface(texel);
        let mask = self.texels.get(texel).map_or(0.0, |t| t.mask);
        let roughness = under.roughness + mask * (ROUGH - under.roughness);
        // Beneath lichen the stone's own hollows do not show.
        let own = 1.0 + (1.0 - mask) * (under.occlusion - 1.0);
        [
            own * self.occlusion(texel),
            roughness,
            under.metallic * (1.0 - mask),
        ]
    }
}
