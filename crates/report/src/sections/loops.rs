//! Open and closed loop over frequency, at the measurement of each tracked output.

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part};
use crate::sections::fit::unwrap;
use crate::sections::frozen_loop::FrozenLoop;
use crate::subject::Subject;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Lowest power of ten (rad/s), and number per decade, of the frequencies.
const LOWEST: i32 = -2;
const IN_A_DECADE: i32 = 60;
/// Gain range of the Nichols charts, dB.
const SHOWN: f64 = 40.0;
/// Number of intervals on the edge of a disk.
const EDGE: u32 = 180;

/// Returns the section on the open and the closed loop over frequency, at six speeds.
///
/// # Errors
/// Errors of [`FrozenLoop::flying`].
pub fn loops(subject: &Subject) -> Result<Vec<Part>, Error> {
    let loops = subject.truth.iter().map(|l| FrozenLoop::flying(subject, &subject.controller, l));
    let loops = loops.collect::<Result<Vec<FrozenLoop>, Error>>()?;
    let mut parts = vec![Part::Text(
        "The linear loop at six frozen speeds as implemented: true linearisation, sampled controller, lags of the \
            actuators. It is opened at the measurement of one output while the others remain closed, L = 1/S - 1. In \
            the Nichols charts no curve enters the dashed disk |S - 1/2| > 1/alpha around the point -1, at 0 dB and \
            -180 deg; alpha is the smallest disk margin of the six at the plotted frequencies (P. Seiler, A. \
            Packard, P. Gahinet, 2020)."
            .into(),
    )];
    for (i, tracked) in subject.inputs.design.tracked.iter().enumerate() {
        parts.push(Part::Figure(figure(subject, &loops, i, tracked.signal.name)));
    }
    Ok(parts)
}

type Response = Vec<(f64, Complex<f64>)>;

/// Returns a response at each speed.
fn responses(loops: &[FrozenLoop], of: &dyn Fn(&FrozenLoop, f64) -> Option<Complex<f64>>) -> Vec<Response> {
    let omega = |k: i32| 10f64.powf(f64::from(LOWEST) + f64::from(k) / f64::from(IN_A_DECADE));
    let one = |l: &FrozenLoop| {
        let below = (0..).map(omega).take_while(|omega| *omega < l.highest());
        below.filter_map(|omega| Some((omega, of(l, omega)?))).collect()
    };
    loops.iter().map(one).collect()
}

fn decibels(g: Complex<f64>) -> f64 {
    20.0 * g.norm().log10()
}

/// Returns the phase (deg) over frequency without jumps.
fn unwrapped(response: &Response) -> Vec<(f64, f64)> {
    let mut points = response.iter().map(|(omega, g)| (*omega, g.arg().to_degrees())).collect::<Vec<_>>();
    unwrap(&mut points);
    points
}

/// Returns the phase (deg) over frequency without jumps, from -360 to 0 deg at the gain closest to 1.
fn phases(response: &Response) -> Vec<(f64, f64)> {
    let mut points = unwrapped(response);
    let from_one = |k: &usize| response[*k].1.norm().ln().abs();
    if let Some(crossing) = (0..points.len()).min_by(|a, b| from_one(a).total_cmp(&from_one(b))) {
        let turns = (points[crossing].1 / 360.0).ceil();
        points.iter_mut().for_each(|p| p.1 -= 360.0 * turns);
    }
    points
}

fn figure(subject: &Subject, loops: &[FrozenLoop], i: usize, name: &str) -> Figure {
    let open = responses(loops, &|l, omega| l.open(i, omega));
    let closed = responses(loops, &|l, omega| l.closed(i, omega));
    let curves = |all: &[Response], of: &dyn Fn(&Response) -> Vec<(f64, f64)>| -> Vec<Curve> {
        all.iter().enumerate().map(|(key, response)| Curve { key, points: of(response) }).collect()
    };
    let gains = |r: &Response| r.iter().map(|(omega, g)| (*omega, decibels(*g))).collect();
    let over = |title: &str, y: Axis, curves| Chart::over_frequency(format!("{title} of {name}"), y, curves);
    let mut nichols = curves(&open, &|r| {
        phases(r).into_iter().zip(r).map(|((_, phase), (_, g))| (phase, decibels(*g))).collect()
    });
    let far = |(_, l): &(f64, Complex<f64>)| (1.0 / (1.0 + l) - 0.5).norm();
    let alpha = 1.0 / open.iter().flatten().map(far).fold(0.0, f64::max);
    nichols.push(Curve { key: loops.len(), points: disk(alpha) });
    let mut gain_of_closed = curves(&closed, &gains);
    if let Some(model) = subject.inputs.design.tracked[i].model {
        let highest = closed.iter().flatten().map(|(omega, _)| *omega).fold(0.0, f64::max);
        let points = closed[0].iter().map(|(omega, _)| *omega).filter(|omega| *omega <= highest);
        let points = points.map(|omega| (omega, decibels(model.response(omega)))).collect();
        gain_of_closed.push(Curve { key: loops.len() + 1, points });
    }
    let mut keys = subject.speed_keys();
    keys.push(Key::reference(format!("disk with alpha = {alpha:.3}")));
    keys.push(Key { dash: "7 3", ..Key::reference("reference model") });
    Figure {
        name: format!("loop-of-{name}"),
        caption: format!(
            "The loop of {} opened at {name}: gain, phase and Nichols chart; and the closed loop from its reference \
                to {name}.",
            subject.name()
        ),
        keys,
        charts: vec![
            over("open loop", Axis::linear("gain (dB)").over(-60.0, 60.0), curves(&open, &gains)),
            over("open loop", Axis::linear("phase (deg)").over(-360.0, 0.0), curves(&open, &phases)),
            Chart {
                title: format!("Nichols, {name}"),
                x: Axis::linear("phase (deg)").over(-360.0, 0.0),
                y: Axis::linear("gain (dB)").over(-SHOWN, SHOWN),
                curves: nichols,
            },
            over("closed loop", Axis::linear("gain (dB)").over(-60.0, 10.0), gain_of_closed),
            over("closed loop", Axis::linear("phase (deg)"), curves(&closed, &unwrapped)),
        ],
    }
}

/// Returns the edge of the disk `|S - 1/2| = 1/alpha` in a Nichols chart, phase (deg) and gain (dB).
fn disk(alpha: f64) -> Vec<(f64, f64)> {
    let edge =
        (0..=EDGE).map(|k| Complex::from_polar(1.0 / alpha, TAU * f64::from(k) / f64::from(EDGE)) + 0.5);
    let points = edge.map(|s| 1.0 / s - 1.0);
    points.map(|l| ((-l).arg().to_degrees() - 180.0, decibels(l))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The disk with alpha = 2/3 has gains from (2 - alpha)/(2 + alpha) = 1/2 to 2 at a phase of -180 deg; the phase at
    /// gain 1 is within 2 atan(alpha/2) on both sides.
    #[test]
    fn disk_has_expected_gains_and_phases() {
        let alpha = 2.0 / 3.0;
        let (mut low, mut high, mut side) = (f64::INFINITY, 0f64, 0f64);
        for (phase, gain) in disk(alpha) {
            (low, high) = (low.min(gain), high.max(gain));
            if gain.abs() < 0.2 {
                side = side.max((phase + 180.0).abs());
            }
        }
        assert!((low + 20.0 * 2f64.log10()).abs() < 1e-9 && (high - 20.0 * 2f64.log10()).abs() < 1e-9);
        let expected = 2.0 * (0.5 * alpha).atan().to_degrees();
        assert!((side - expected).abs() < 0.2, "{side} {expected}");
    }

    /// The phase of -1/s^2 is plotted at -180 deg at each frequency, not 360 deg away.
    #[test]
    fn phase_branch_follows_gain_crossover() {
        let response = |k: i32| {
            let s = Complex::new(0.0, 10f64.powf(f64::from(k) / 10.0));
            (s.im, (1.0 / (s * s)) * Complex::from_polar(1.0, -0.1 * s.im))
        };
        let response: Response = (-10..=10).map(response).collect();
        for ((omega, phase), _) in phases(&response).into_iter().zip(&response) {
            assert!((phase + 180.0 + (0.1 * omega).to_degrees()).abs() < 1e-9, "{omega} {phase}");
        }
    }
}
