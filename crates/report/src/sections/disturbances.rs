//! Effect of a current and of sensor noise on the loop; [`sea`] contains the effect of the sea of a file.

pub(crate) mod sea;
pub(crate) mod working_sea;

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Part, capital};
use crate::sections::steps;
use crate::subject::{SHOWN, STEP_TIME, Subject};
use nalgebra::Complex;
use squid_auv::Current;
use squid_auv::readable;
use squid_design::axis::Linearisation;
use squid_design::check::flown::GUST;
use squid_design::check::sampled::trapezoidal;
use squid_flight::flight::{Disturbance, Flight, TemporaryDisturbance, Variations, fly_varied};
use squid_lpv::matrix::largest_complex_singular_value;
use squid_lpv::state_space::StateSpace;
use squid_scheduled::Manoeuvre;
use squid_signals::Signal;
use std::f64::consts::PI;

/// Start of the horizontal current (s).
const FORWARD_TIME: f64 = 16.0;
/// Lowest power of ten (rad/s), and number per decade, of the frequencies of the responses to noise.
const LOWEST: i32 = -2;
const IN_A_DECADE: i32 = 40;

/// Returns the section on a step of the current, and on noise.
///
/// # Errors
/// Errors of [`fly_varied`], and of freezing and sampling the controller.
pub fn disturbances(subject: &Subject) -> Result<Vec<Part>, Error> {
    let flown =
        subject.speeds.iter().map(|v| in_current(subject, *v)).collect::<Result<Vec<Flight>, Error>>()?;
    let text = format!(
        "A uniform downward current of {GUST} m/s starts as a step at {STEP_TIME:.0} s, and a forward current of the \
             same size at {FORWARD_TIME:.0} s. The speed is relative to the water. Nonlinear and sampled simulation, \
             as above."
    );
    let current = Figure {
        name: "current".into(),
        caption: format!("{} in steps of current, at six speeds.", capital(&subject.name())),
        ..steps::figure(subject, subject.speed_keys(), &flown, SHOWN)
    };
    Ok(vec![Part::Text(text), Part::Figure(current), Part::Figure(noise(subject)?)])
}

fn in_current(subject: &Subject, speed: f64) -> Result<Flight, Error> {
    let begins = |current: Current, at: f64| {
        TemporaryDisturbance::lasting(Disturbance { current, ..Disturbance::default() }, at)
    };
    let down = begins(Current { vertical: GUST, ..Current::default() }, STEP_TIME);
    let forward = begins(Current { horizontal: GUST, ..Current::default() }, FORWARD_TIME);
    let variations = Variations { disturbances: &[down, forward], ..Variations::default() };
    let (inputs, manoeuvre) = (subject.inputs, &subject.stored.manoeuvre);
    let level =
        Manoeuvre { speed_from: speed, speed_to: speed, duration: SHOWN, ..manoeuvre.without_steps() };
    let (vehicle, controller) = (&inputs.vehicle, &subject.stored.controller);
    Ok(fly_varied(vehicle, controller, inputs.design.level(), &level, &variations)?)
}

/// Plots the gain from the noise of each sensor to the commands, relative to their reach, over frequency.
fn noise(subject: &Subject) -> Result<Figure, Error> {
    let design = &subject.inputs.design;
    let sensors = design.fed_back();
    let systems = subject.truth.iter().map(|l| noisy(subject, l, sensors.len()));
    let systems = systems.collect::<Result<Vec<StateSpace>, Error>>()?;
    let tick = design.sample_time;
    let omega = |k: i32| 10f64.powf(f64::from(LOWEST) + f64::from(k) / f64::from(IN_A_DECADE));
    let axis: Vec<f64> = (0..).map(omega).take_while(|omega| *omega < PI / tick).collect();
    let chart = |(j, (signal, scale)): (usize, &(&Signal, f64))| {
        let (factor, unit) = readable(signal.unit);
        let (factor, unit) =
            if signal.unit == "rad/s" { (1f64.to_degrees(), "deg/s") } else { (factor, unit) };
        let curve = |(key, system): (usize, &StateSpace)| {
            let one = system.parts(0..system.c.nrows(), j..j + 1);
            let at = |omega: f64| {
                let g = one.response(Complex::new(0.0, omega * tick).exp())?;
                Some((omega, 100.0 * largest_complex_singular_value(&g) / (factor * scale)))
            };
            Curve { key, points: axis.iter().filter_map(|omega| at(*omega)).collect() }
        };
        let y = Axis::logarithmic(format!("commands (% of reach per {unit})"));
        let curves = systems.iter().enumerate().map(curve).collect();
        Chart::over_frequency(format!("noise of {}", signal.name), y, curves)
    };
    Ok(Figure {
        name: "noise".into(),
        caption: format!(
            "Gain from the noise of each measurement to all commands of {}, at six frozen speeds, for the sampled \
                 loop with lags.",
            subject.name()
        ),
        keys: subject.speed_keys(),
        charts: sensors.iter().enumerate().map(chart).collect(),
    })
}

/// Returns the system from the sensor noise, the last inputs of the controller, to the commands.
fn noisy(subject: &Subject, l: &Linearisation, sensors: usize) -> Result<StateSpace, Error> {
    let sampling = subject.sampling();
    let k = trapezoidal(&subject.frozen(&subject.controller, l)?, sampling.sample_time)?;
    let closed = sampling.held(l).injected(&k);
    let (inputs, outputs, m) = (closed.b.ncols(), closed.c.nrows(), sampling.actuators.len());
    Ok(closed.parts(outputs - m..outputs, inputs - m - sensors..inputs - m))
}
