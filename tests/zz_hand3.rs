//! hand
mod reference;
use reference::*;
#[test]
fn quick() {
    let (v, t) = shapes::rock(24);
    let m = mesh::Mesh::new(&v, &t);
    let a = nearby::nearby_sets(&m, 0.02);
    for (x, y) in [(2018usize,1981usize),(98,95),(14,11)] {
      println!("{x} {y}: contains {} {}; centre-other distance {} {} q {} {}", a[x].contains(&y), a[y].contains(&x), m.triangles[y].distance(m.triangles[x].centre()), m.triangles[x].distance(m.triangles[y].centre()), m.triangles[x].reach(), m.triangles[y].reach());
      println!("ids {:?} {:?} flat {:?}", m.triangles[x].ids, m.triangles[y].ids, m.triangles[x].flat);
    }
    let run = grow(&v, &t, &Params{at: [0.,0.,1.], ..Params::new(0.01, 1)}, Stop::at_elements(300));
    let (a, b) = (&run.elements[293], &run.elements[176]);
    for e in [a, b] { let tr = &m.triangles[e.triangle]; let p = tr.project(e.position.into()); println!("{:?} inside {} dist {}", p, tr.contains(p.0), tr.distance(e.position.into())); }
    println!("{:?}", run.elements[224]);
}
