//! Charts as long as the image, cut across.
//!
//! Branches and trunks come as strips. The longest decides how large all charts are, and most of the image stays empty.

use uvunwrap::{Atlas, OutputMesh};

/// For each triangle whether charts are cut along its sides.
pub(super) type Seams = Vec<[bool; 3]>;

/// Share of the image that charts fill, from which on none is cut.
const ENOUGH: f64 = 0.45;

/// How much of a square charts fill where none is long.
const USUAL: f64 = 0.6;

/// How long a chart may stay, as a share of the side of a square that would hold all.
const LONGEST: f64 = 0.4;

/// From which share of the image's side on a chart decides the scale.
const DECIDES: f64 = 0.7;

/// Share of an image with so many texels in a row that charts fill: the library counts of the rows in use.
pub(super) fn share(atlas: &Atlas, size: u32) -> f64 {
    covered(atlas) / f64::from(size).powi(2)
}

fn covered(atlas: &Atlas) -> f64 {
    f64::from(atlas.utilization) * f64::from(atlas.width) * f64::from(atlas.height)
}

/// Where to cut, which is also between the charts there are; nothing where none is as long as the image, or where they
/// fill enough of it. Corners are those of the mesh that was given.
pub(super) fn seams(atlas: &Atlas, size: u32, corners: &[u32]) -> Option<Seams> {
    let mesh = &atlas.meshes[0];
    let texels = [atlas.width, atlas.height].map(f64::from);
    let spans = spans(atlas.chart_count as usize, mesh, texels);
    let longest = spans.iter().map(|span| span.length).fold(0.0, f64::max);
    if share(atlas, size) >= ENOUGH || longest < DECIDES * f64::from(size) {
        return None;
    }
    let most = LONGEST * (covered(atlas) / USUAL).sqrt();
    let pieces = pieces(mesh, texels, &spans, most);
    Some(between(&pieces, corners))
}

/// The longer side of a chart's box, in texels.
#[derive(Clone, Copy)]
struct Span {
    axis: usize,
    from: f64,
    length: f64,
}

fn spans(charts: usize, mesh: &OutputMesh, texels: [f64; 2]) -> Vec<Span> {
    let mut boxes = vec![[[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]; charts];
    for vertex in &mesh.vertices {
        let Some(chart) = vertex.chart else { continue };
        let [low, high] = &mut boxes[chart as usize];
        for axis in 0..2 {
            let at = f64::from(vertex.uv[axis]) * texels[axis];
            low[axis] = low[axis].min(at);
            high[axis] = high[axis].max(at);
        }
    }
    let longer = |[low, high]: [[f64; 2]; 2]| {
        let [width, height] = [high[0] - low[0], high[1] - low[1]];
        let axis = usize::from(height > width);
        Span {
            axis,
            from: low[axis],
            length: width.max(height),
        }
    };
    boxes.into_iter().map(longer).collect()
}

/// For each triangle its chart and the piece of it, counted along its span, none longer than that.
fn pieces(
    mesh: &OutputMesh,
    texels: [f64; 2],
    spans: &[Span],
    most: f64,
) -> Vec<Option<(u32, u32)>> {
    let triangles = mesh.indices.as_chunks::<3>().0;
    let piece = |triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| &mesh.vertices[vertex as usize]);
        let chart = corners[0].chart?;
        let Span { axis, from, length } = spans[chart as usize];
        let at = corners.map(|corner| f64::from(corner.uv[axis]) * texels[axis]);
        let along = (at.iter().sum::<f64>() / 3.0 - from) / length;
        let all = (length / most).ceil();
        Some((chart, (along * all).clamp(0.0, all - 1.0) as u32))
    };
    triangles.iter().map(piece).collect()
}

/// The sides where triangles of different pieces meet.
fn between(pieces: &[Option<(u32, u32)>], corners: &[u32]) -> Seams {
    let mut sides = Vec::with_capacity(corners.len());
    for (t, triangle) in corners.as_chunks::<3>().0.iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
            sides.push((a.min(b), a.max(b), t, k));
        }
    }
    sides.sort_unstable();
    let mut seams = vec![[false; 3]; pieces.len()];
    for meeting in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let piece = pieces[meeting[0].2];
        let is_seam = meeting.iter().any(|side| pieces[side.2] != piece);
        for &(_, _, t, k) in meeting {
            seams[t][k] = is_seam;
        }
    }
    seams
}
