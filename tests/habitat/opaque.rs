//! What materials leave open is kept free by a mask.

use thallus::appearance::Appearance;
use thallus::picture::Finish;
use thallus::substrate::{Alpha, Material, SurfacePoint, Texture, Wrap};

use super::*;

/// Texels along a side of an image.
const SIDE: u32 = 64;

/// An image that is opaque to the left of this share of it.
fn leaf(opaque: f64) -> Vec<u8> {
    let texel = |x: u32| {
        let is_opaque = f64::from(x) + 0.5 < opaque * f64::from(SIDE);
        [90, 160, 60, if is_opaque { 255 } else { 0 }]
    };
    let texels: Vec<u8> = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE)).collect();
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, SIDE, SIDE);
    encoder.set_color(::png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&texels).unwrap();
    writer.finish().unwrap();
    bytes
}

/// The square, in two materials: the halves of it before and behind its diagonal, the latter of which is opaque.
fn leaves(alpha: Alpha, opacity: f32) -> (Substrate, Texturing) {
    let (substrate, mut texturing) = square(1);
    let texture = Texture {
        image: 0,
        is_in_second: false,
        strength: 1.0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        wrap: [Wrap::Repeat; 2],
    };
    let material = |alpha| Material {
        base_color_texture: Some(texture),
        alpha,
        opacity,
        ..Material::default()
    };
    texturing.materials = vec![material(alpha), material(Alpha::Opaque)];
    texturing.material_of = vec![Some(0), Some(1)];
    texturing.images = vec![leaf(0.5)];
    (substrate, texturing)
}

/// A place of the square's first triangle in the file, or of its second, at these x and z.
fn place(substrate: &Substrate, source: u32, x: f64, z: f64) -> SurfacePoint {
    let triangles = 0..substrate.triangles().len() as u32;
    let t = triangles
        .clone()
        .find(|&t| substrate.source_triangle(t) == source);
    let t = t.expect("a triangle of it");
    let corners = substrate.corners(t).map(|p| substrate.units().to_file(p));
    let [a, b, c] = corners.map(|p| [p.x, p.z]);
    let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let p = [x, z];
    let weights = [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|w| w / cross(a, b, c));
    assert!(weights.iter().all(|w| *w > 0.0), "outside: {weights:?}");
    SurfacePoint::from_weights(t, weights)
}

/// Which of the triangles holds a place: that of the file's first has corners (0, 0), (0, 1) and (1, 1).
fn source(x: f64, z: f64) -> u32 {
    u32::from(x > z)
}

#[test]
fn a_mask_and_pictures_are_open_where_the_image_is() {
    const CUT: Alpha = Alpha::Mask { cutoff: 0.5 };
    for (alpha, opacity, open) in [
        (CUT, 1.0, [false, true]),
        (CUT, 0.4, [true, true]),
        (Alpha::Mask { cutoff: 0.0 }, 1.0, [false, false]),
        (Alpha::Blend, 1.0, [false, true]),
        (Alpha::Blend, 0.4, [true, true]),
        (Alpha::Opaque, 0.0, [false, false]),
    ] {
        let (substrate, texturing) = leaves(alpha, opacity);
        let mask = Mask::opaque(&substrate, &texturing).expect("a mask");
        assert_eq!(
            mask.is_white(),
            open == [false, false],
            "{alpha:?} {opacity}"
        );
        let looks = Appearance::new(&substrate, &texturing);
        assert_eq!(looks.has_openings(), alpha != Alpha::Opaque);
        let mut seen = 0;
        for (x, z) in (0..400).map(|i| (f64::from(i % 20), f64::from(i / 20))) {
            let (x, z) = ((x + 0.3) / 20.0, (z + 0.6) / 20.0);
            if (x - 0.5).abs() < 1.0 / f64::from(SIDE) {
                continue;
            }
            let source = source(x, z);
            let is_open = source == 0 && open[usize::from(x > 0.5)];
            let at = place(&substrate, source, x, z);
            assert_eq!(mask.at(&at), f64::from(u8::from(!is_open)), "{x} {z}");
            // What is half transparent stops some of the rays.
            let weights = at.weights().map(|w| w as f32);
            assert_eq!(looks.is_open(at.triangle, weights, 0.5), is_open, "{x} {z}");
            let is_blended = alpha == Alpha::Blend && opacity == 0.4 && x < 0.5;
            let often = is_open && !is_blended;
            assert_eq!(looks.is_open(at.triangle, weights, 0.3), often, "{x} {z}");
            seen += 1;
        }
        assert!(seen > 350);
    }
}

#[test]
fn lichen_keeps_to_what_is_seen() {
    const RADIUS: f64 = 0.004;
    let (substrate, texturing) = leaves(Alpha::Mask { cutoff: 0.5 }, 1.0);
    let mask = Mask::opaque(&substrate, &texturing).expect("a mask");
    let id = MaskId {
        layers: vec!["opaque".to_owned()],
        hashes: mask.hashes().into_iter().map(str::to_owned).collect(),
    };
    let substrate = substrate.with_mask(Some(mask));
    let recipe = Recipe {
        at: vec![SeedPlace::Point([0.45, 0.0, 0.5])],
        mask: Some(id),
        ..common::recipe(RADIUS, 8000)
    };
    let growth = grow(&substrate, &recipe, &Execution::default(), &mut ()).unwrap();
    let places = growth.cluster.elements().iter();
    let places = places.map(|e| substrate.units().to_file(e.position));
    // A texel is 0.0156 wide.
    let is_open = |p: &DVec3| p.z > p.x + 0.01 && p.x > 0.51;
    let (open, all) = places.fold((0, 0), |(open, all), p| {
        (open + usize::from(is_open(&p)), all + 1)
    });
    assert!(all > 5000 && open == 0, "{open} of {all}");
    // It has gone round the opening, along the diagonal.
    let reached = |p: DVec3| p.x > 0.9;
    let mut places = growth.cluster.elements().iter();
    assert!(places.any(|e| reached(substrate.units().to_file(e.position))));
}

#[test]
fn the_hash_is_of_all_that_says_what_is_open() {
    let hash = |change: &dyn Fn(&mut Texturing)| {
        let (substrate, mut texturing) = leaves(Alpha::Mask { cutoff: 0.5 }, 1.0);
        change(&mut texturing);
        let mask = Mask::opaque(&substrate, &texturing).expect("a mask");
        mask.hashes()[0].to_owned()
    };
    let texture = |texturing: &mut Texturing, change: &dyn Fn(&mut Texture)| {
        let texture = texturing.materials[0].base_color_texture.as_mut();
        change(texture.expect("a texture"));
    };
    let same = hash(&|_| ());
    assert_eq!(same, hash(&|t| t.materials[1].roughness = 0.3));
    assert_eq!(same, hash(&|t| t.materials[1].opacity = 0.3));
    let others = [
        hash(&|t| t.images[0] = leaf(0.6)),
        hash(&|t| t.materials[0].alpha = Alpha::Mask { cutoff: 0.4 }),
        hash(&|t| t.materials[0].opacity = 0.9),
        hash(&|t| t.material_of[1] = Some(0)),
        hash(&|t| t.uvs[0] = t.uvs[1]),
        hash(&|t| texture(t, &|texture| texture.wrap = [Wrap::Clamp; 2])),
        hash(&|t| texture(t, &|texture| texture.transform[0][2] = 0.1)),
    ];
    let mut all = others.to_vec();
    all.push(same);
    all.sort();
    all.dedup();
    assert_eq!(all.len(), others.len() + 1);
}

/// An image that cannot be read says nothing of what is open; one that is of an opaque material need not.
#[test]
fn an_image_that_cannot_be_read_is_no_mask() {
    let (substrate, mut texturing) = leaves(Alpha::Blend, 1.0);
    texturing.images[0].truncate(60);
    let told = Mask::opaque(&substrate, &texturing)
        .unwrap_err()
        .to_string();
    assert!(
        told.contains("image 0 of the mesh: it is damaged"),
        "{told}"
    );
    texturing.images = vec![leaf(0.5)];
    texturing.materials[0].unread_opacity = Some("the image leaf.webp".to_owned());
    let told = Mask::opaque(&substrate, &texturing)
        .unwrap_err()
        .to_string();
    assert!(told.contains("leaf.webp says what is open"), "{told}");
    texturing.materials.remove(0);
    texturing.material_of = vec![Some(0); 2];
    assert!(
        Mask::opaque(&substrate, &texturing)
            .expect("a mask")
            .is_white()
    );
}
