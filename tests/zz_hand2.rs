//! hand
mod reference;
use reference::*;
use std::time::Instant;
#[test]
fn quick() {
    let (v, t) = shapes::rock(24);
    let m = mesh::Mesh::new(&v, &t);
    let s = Instant::now();
    let a = nearby::nearby_sets(&m, 0.02);
    println!("sets {:?}", s.elapsed());
    let s = Instant::now();
    let b = nearby::nearby_sets(&m, 0.1);
    println!("sets {:?} {} {}", s.elapsed(), a.iter().map(Vec::len).sum::<usize>() as f64/4608., b.iter().map(Vec::len).sum::<usize>() as f64/4608.);
    let e: Vec<f64> = m.triangles.iter().flat_map(|t| t.edges.iter().map(|e| e.length)).collect();
    println!("edge mean {} max {}", e.iter().sum::<f64>()/e.len() as f64, e.iter().cloned().fold(0., f64::max));
    let all: Vec<usize> = (0..4608).collect();
    let s = Instant::now();
    for _ in 0..1000 { launch::cut(&m, &all, glam::DVec3::new(0.,0.,1.), 0.5); }
    println!("1000 cuts {:?}", s.elapsed());
    for i in [500, 1000, 2000, 3000] {
    let s = Instant::now();
    let run = grow(&v, &t, &Params{at: [0.,0.,1.], ..Params::new(0.01, 1)}, Stop::at_elements(i));
    println!("{i} {:?} {:?}", s.elapsed(), run.counters);
    let p = run.positions();
    println!("min {}", stats::smallest_distance(&p)/0.02);
    for i in 0..p.len() { for j in 0..i { let d = glam::DVec3::from(p[i]).distance(p[j].into())/0.02; if d < 0.99999 { println!("{i} {j} {d} {:?} {:?}", run.elements[i], run.elements[j]); } } }
    }
}
