//! Test meshes: welded, manifold, consistently wound.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Vertices and triangles.
pub(crate) type Shape = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// The square |x|, |y| ≤ `half` in the plane z = 0, as two triangles.
pub(crate) fn plane(half: f64) -> Shape {
    let vertices = vec![
        [-half, -half, 0.0],
        [half, -half, 0.0],
        [half, half, 0.0],
        [-half, half, 0.0],
    ];
    (vertices, vec![[0, 1, 2], [0, 2, 3]])
}

/// The same square as 2n² triangles of uneven shape, every third one wound the other way.
pub(crate) fn uneven_plane(half: f64, n: u32) -> Shape {
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let inner = |k: u32| if k == 0 || k == n { 0.0 } else { 0.3 };
            let (x, y) = (f64::from(i), f64::from(j));
            let x = x + inner(i) * (12.9 * x + 78.2 * y).sin();
            let y = y + inner(j) * (39.3 * x + 11.1 * y).sin();
            let step = 2.0 * half / f64::from(n);
            vertices.push([x * step - half, y * step - half, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles.iter_mut().step_by(3).for_each(|t| t.swap(1, 2));
    (vertices, triangles)
}

/// The lateral surface of a prism with `around` sides inscribed in a cylinder about z, −`height`/2 ≤ z ≤ `height`/2.
pub(crate) fn cylinder(radius: f64, height: f64, around: u32, along: u32) -> Shape {
    let mut vertices = Vec::new();
    for j in 0..=along {
        for i in 0..around {
            let angle = TAU * f64::from(i) / f64::from(around);
            let z = height * (f64::from(j) / f64::from(along) - 0.5);
            vertices.push([radius * angle.cos(), radius * angle.sin(), z]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..along {
        for i in 0..around {
            let (a, b) = (j * around + i, j * around + (i + 1) % around);
            triangles.push([a, b, b + around]);
            triangles.push([a, b + around, a + around]);
        }
    }
    (vertices, triangles)
}

/// A sphere: an octahedron with every face cut into `n`² triangles and pushed out.
pub(crate) fn sphere(radius: f64, n: i32) -> Shape {
    octahedron(n, |p| p.map(|x| x * radius))
}

/// A bumpy rock of mean radius about 1 and 8n² triangles; n = 24 gives the thesis's 4,608 triangles, 2,306 vertices.
pub(crate) fn rock(n: i32) -> Shape {
    octahedron(n, |[x, y, z]| {
        let waves = 0.12 * (2.1 * x + 1.3 * y).sin()
            + 0.09 * (3.7 * y - 1.9 * z + 0.4).sin()
            + 0.05 * (6.1 * z + 4.3 * x + 1.1).sin()
            + 0.03 * (9.0 * x - 7.0 * y + 8.0 * z).sin();
        let out = 1.0 + waves;
        [1.2 * out * x, out * y, 0.85 * out * z]
    })
}

/// The integer points with |i| + |j| + |k| = n, put on the unit sphere and moved by `displace`.
fn octahedron(n: i32, displace: impl Fn([f64; 3]) -> [f64; 3]) -> Shape {
    let mut ids = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for corner in faces(n) {
        let triangle = corner.map(|point: [i32; 3]| {
            *ids.entry(point).or_insert_with(|| {
                let length = f64::from(point.iter().map(|x| x * x).sum::<i32>()).sqrt();
                vertices.push(displace(point.map(|x| f64::from(x) / length)));
                vertices.len() as u32 - 1
            })
        });
        triangles.push(triangle);
    }
    (vertices, triangles)
}

/// Corners of all small triangles on the octahedron's integer points, wound outwards.
fn faces(n: i32) -> Vec<[[i32; 3]; 3]> {
    let mut small = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            let k = n - i - j;
            small.push([[i, j, k], [i + 1, j, k - 1], [i, j + 1, k - 1]]);
            if k > 1 {
                small.push([[i + 1, j, k - 1], [i + 1, j + 1, k - 2], [i, j + 1, k - 1]]);
            }
        }
    }
    let octants = (0..8).map(|bits| [0, 1, 2].map(|axis| 1 - 2 * (bits >> axis & 1)));
    octants
        .flat_map(|signs| small.iter().map(move |face| reflect(*face, signs)))
        .collect()
}

fn reflect(face: [[i32; 3]; 3], signs: [i32; 3]) -> [[i32; 3]; 3] {
    let [a, b, c] = face.map(|p| [0, 1, 2].map(|axis| p[axis] * signs[axis]));
    if signs.iter().product::<i32>() < 0 {
        [a, c, b]
    } else {
        [a, b, c]
    }
}
