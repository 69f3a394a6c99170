//! Masks that tests make.

/// Texels of a mask along a side.
pub(crate) const TEXELS: u32 = 256;

/// A PNG of square texels, by how bright they are at (u, v).
pub(crate) fn image(brightness: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(TEXELS);
    let row = |y: u32| (0..TEXELS).map(move |x| (x, y));
    let texel = |(x, y)| (255.0 * brightness(place(x), place(y))).round() as u8;
    let texels: Vec<u8> = (0..TEXELS).flat_map(row).map(texel).collect();
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, TEXELS, TEXELS);
    encoder.set_color(::png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&texels).expect("texels");
    writer.finish().expect("an image");
    bytes
}
