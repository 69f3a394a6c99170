//! hand
mod reference;
use reference::*;
use std::time::Instant;
fn report(name: &str, run: &Run, r: f64, t: Instant) {
    let p = run.positions();
    println!("{name}: n {} Re {:.1} Rg {:.2} D {:.3} contacts {:.3} min {:.9} {:?} {:.2}s", p.len(), stats::effective_radius(&p)/r, stats::radius_of_gyration(&p)/r,
      stats::gyration_dimension(&p), if p.len()<6000 {stats::mean_contacts(&p, r, 1e-6)} else {0.0}, if p.len()<6000 {stats::smallest_distance(&p)/(2.0*r)} else {0.0}, run.counters, t.elapsed().as_secs_f64());
}
#[test]
fn quick() {
    let (v, t) = shapes::plane(1e5);
    for search in [Search::Lists, Search::Cells] {
        for p in [Params::plain_dla(1.0, 1), Params::new(1.0, 1)] {
            let p = Params{search, ..p};
            let s = Instant::now();
            report(&format!("{search:?}"), &grow(&v, &t, &p, Stop::at_elements(4000)), 1.0, s);
        }
    }
    let (v, t) = shapes::rock(24);
    for search in [Search::Lists, Search::Cells] {
        let p = Params{search, at: [0.,0.,1.], ..Params::new(0.01, 1)};
        let s = Instant::now();
        report(&format!("rock {search:?}"), &grow(&v, &t, &p, Stop::at_elements(4000)), 0.01, s);
    }
}
