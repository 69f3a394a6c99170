#[path = "../tests/common/mod.rs"]
mod common;
use thallus::growth::*;
use thallus::run::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: u64 = a[2].parse().unwrap();
    let (s, mut r) = match a[1].as_str() {
        "plane" => (common::plane(4000.0), common::recipe(1.0, n)),
        "rock" => {
            let s = common::rock(24);
            let r = common::recipe(s.auto_radius(), n);
            (s, r)
        }
        "fine" => {
            let s = common::rock(354);
            let r = common::recipe(s.auto_radius(), n);
            (s, r)
        }
        _ => panic!(),
    };
    r.bias = a[3].parse().unwrap();
    if a.get(4).map(|x| x.as_str()) == Some("touch") {
        r.join = Join::Touch;
        r.gain = 0.0;
    }
    if let Some(x) = a.get(5) {
        r.seed = x.parse().unwrap();
    }
    let t = std::time::Instant::now();
    let g = grow(&s, &r, &Execution::default(), &mut ()).unwrap();
    let e = t.elapsed().as_secs_f64();
    let c = g.cluster.extent();
    let rg = (g
        .cluster
        .elements()
        .iter()
        .map(|x| x.position.distance_squared(c.centroid()))
        .sum::<f64>()
        / g.cluster.len() as f64)
        .sqrt()
        / g.cluster.radius();
    println!(
        "{:?} {} us/el; {:?} R_e/r {} Rg/r {}",
        g.stopped,
        e * 1e6 / n as f64,
        g.counts,
        c.effective_radius() / g.cluster.radius(),
        rg
    );
    let mut min = f64::INFINITY;
    if n <= 20000 {
        let el = g.cluster.elements();
        for i in 0..el.len() {
            for j in 0..i {
                min = min.min(el[i].position.distance(el[j].position));
            }
        }
        println!("min {}", min / g.cluster.radius());
    }
}
