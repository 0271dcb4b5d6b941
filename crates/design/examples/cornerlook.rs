//! Looks at corners.
#![allow(clippy::print_stdout, clippy::unwrap_used)]
use scheduled::{ControllerDesign, Manoeuvre};
use squid_design::inputs::Inputs;
use squid_design::uncertain::gradients::perturbed;
use squid_design::uncertain::trim::{blocks, random_corners};
use squid_design::uncertain::vehicle::gains;
use squid_flight::flight::{Variations, fly_varied};
fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let inputs = Inputs::read(a[0].as_ref(), &a[1]).unwrap();
    let controller = ControllerDesign::from_json(&base::files::read(a[2].as_ref()).unwrap()).unwrap();
    let speed: f64 = a[3].parse().unwrap();
    let l = inputs.axis().at(speed).unwrap();
    let un = blocks(&inputs, &l.trim, &[]).unwrap();
    println!("{:?}", un.iter().map(|b| &b.name).collect::<Vec<_>>());
    let m = Manoeuvre {
        speed_from: speed,
        speed_to: speed,
        step_time: 1.0,
        step_end: f64::MAX,
        ramp_start: 1.0,
        ramp_duration: 1e-6,
        duration: 61.0,
        ..inputs.design.manoeuvre.without_steps()
    };
    let out = inputs.design.stepped();
    let name = inputs.design.interface.signals[out].name;
    let m = m.with_step(name, inputs.design.manoeuvre.step(name));
    let n = un.len();
    let mut corners = vec![vec![0.0; n], vec![-1.0; n], vec![1.0; n]];
    corners.extend(random_corners(n, 10, 4));
    for c in corners {
        let v = perturbed(&inputs.vehicle, &un, &c);
        let g = gains(v.actuators.len(), &un, &c);
        let va = Variations { gains: &g, ..Variations::default() };
        match fly_varied(&v, &controller, inputs.design.level(), &m, &va) {
            Err(e) => println!("{c:?} {e}"),
            Ok(f) => {
                let last = f.rows.last().unwrap();
                println!(
                    "{:?} t {:.1} pitch0 {:.2} ref {:.2} used {:.2} is {:.2} speed {:.3} commands {:?} surf {:?}",
                    c.iter().map(|d| *d as i32).collect::<Vec<_>>(),
                    last.time,
                    f.rows[0].measured(out).to_degrees(),
                    last.reference(out).to_degrees(),
                    last.used[out].to_degrees(),
                    last.measured(out).to_degrees(),
                    last.measured(1),
                    last.commands,
                    f.surfacing.is_some()
                );
            }
        }
    }
}
