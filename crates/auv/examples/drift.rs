//! Drift.
#![allow(clippy::print_stdout, clippy::unwrap_used)]
use auv::{Plant, Speed, Vehicle, trim};
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let text = std::fs::read_to_string(format!("{}/vehicle.toml", a[0])).unwrap();
    let whole = Vehicle::parse(&text, "vehicle.toml").unwrap();
    let plane = whole.in_plane();
    let vehicle = if a[1] == "plane" { plane.clone() } else { whole };
    let speed: f64 = a[2].parse().unwrap();
    let ticks: usize = a[3].parse().unwrap();
    let level = trim(&plane, Speed::Path(speed), 500.0).unwrap();
    let mut plant = Plant::new(&vehicle).unwrap();
    let actuators = vehicle.outputs_of_plane(&plane, &level.actuators);
    plant.start(0.0, &auv::Trim { actuators: actuators.clone(), ..level.clone() }).unwrap();
    let mut seed = 7u64;
    let t = Instant::now();
    let mut out = String::new();
    let mut c = actuators.clone();
    let mut far = 0.0;
    for k in 0..ticks {
        if k % 10 == 0 {
            for (i, x) in c.iter_mut().enumerate() {
                seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let r = (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                *x = actuators[i] + 0.1 * r * vehicle.actuators[i].reach();
                plant.set_command(i, *x).unwrap();
            }
        }
        plant.advance((k + 1) as f64 * 0.02).unwrap();
        far += plant.state().motion.q;
        if k % 50 == 49 {
            let s = plant.state();
            let m = s.motion;
            out += &format!(
                "{:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e} {:e}\n",
                m.u, m.v, m.w, m.p, m.q, m.r, m.phi, m.theta, s.heading, s.depth, s.x
            );
        }
    }
    let us = 1e6 * t.elapsed().as_secs_f64() / ticks as f64;
    std::fs::write(&a[4], out).unwrap();
    println!("{us:.3} us a tick {far}");
}
