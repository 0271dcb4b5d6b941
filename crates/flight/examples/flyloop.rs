//! Times flights.
#![allow(clippy::print_stdout, clippy::unwrap_used)]
use auv::Pitch;
use scheduled::{ControllerDesign, Manoeuvre};
use squid_flight::flight::fly;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let text = std::fs::read_to_string(format!("{}/vehicle.toml", a[0])).unwrap();
    let vehicle = auv::Vehicle::parse(&text, "vehicle.toml").unwrap().in_plane();
    let controller = ControllerDesign::from_json(&base::files::read(a[1].as_ref()).unwrap()).unwrap();
    let m = Manoeuvre::from_json(&base::files::read(a[2].as_ref()).unwrap()).unwrap();
    let n: usize = a[3].parse().unwrap();
    let t = Instant::now();
    let mut rows = 0;
    for _ in 0..n {
        rows += fly(&vehicle, &controller, (50.0, &Pitch::Free), &m).unwrap().rows.len();
    }
    println!("{:.3} ms a flight of {} ticks", 1e3 * t.elapsed().as_secs_f64() / n as f64, rows / n);
}
