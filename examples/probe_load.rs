//! probe
use std::path::Path;
fn main() {
    let p = std::env::args().nth(1).unwrap();
    let t = std::time::Instant::now();
    let l = thallus::substrate::load_soup(Path::new(&p)).unwrap();
    let a = t.elapsed().as_secs_f64();
    let n = l.soup.triangles.len() as f64;
    let m = peak();
    let t = std::time::Instant::now();
    let s = thallus::substrate::Substrate::from_soup(l.soup).unwrap();
    let b = t.elapsed().as_secs_f64();
    println!(
        "{n} tris load {:.2} us prep {:.2} us; peak after load {:.0} B, after all {:.0} B per tri; {} pieces",
        a * 1e6 / n,
        b * 1e6 / n,
        m / n,
        peak() / n,
        s.components().len()
    );
}
fn peak() -> f64 {
    let s = std::fs::read_to_string("/proc/self/status").unwrap();
    let l = s.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    l.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() * 1024.0
}
