//! The weights against what was achieved: sensitivities and control efforts at six speeds.

use crate::claims::{Claim, all_below};
use crate::error::Error;
use crate::page::axis::Axis;
use crate::page::chart::{Chart, Curve};
use crate::page::figure::Figure;
use crate::page::key::Key;
use crate::page::section::{Part, Table};
use crate::sections::frozen_loop::FrozenLoop;
use crate::subject::Subject;
use auv::Linearisation;
use lpv::controller::Controller;
use lpv::matrix::largest;
use lpv::weights::TrackingWeight;
use nalgebra::Complex;
use squid_design::numbers::above;

/// Frequencies, rad/s, evenly spread on a logarithmic axis from 1e-4 to 1e2.
fn axis() -> Vec<f64> {
    (0..=240).map(|i| 10f64.powf(-4.0 + f64::from(i) / 40.0)).collect()
}

/// 1/|W_e| at a frequency.
fn allowed(weight: &TrackingWeight, omega: f64) -> f64 {
    let s = Complex::new(0.0, omega);
    let (below, above) = (s / weight.peak + weight.bandwidth, s + weight.bandwidth * weight.steady_error);
    (above / below).norm()
}

/// The section on |S| and control effort over frequency against the weights, ideal and as flown.
///
/// # Errors
/// [`Error::NothingSteps`], [`ModelError::Lft`](squid_design::error::ModelError::Lft).
pub fn sensitivity(subject: &Subject) -> Result<Vec<Part>, Error> {
    let all = |make: fn(&Subject, &Controller, &Linearisation) -> Result<FrozenLoop, Error>| {
        let each = subject.truth.iter().map(|l| make(subject, &subject.controller, l));
        each.collect::<Result<Vec<FrozenLoop>, Error>>()
    };
    let (loops, ideal) = (all(FrozenLoop::flying)?, all(FrozenLoop::ideal)?);
    let gamma = subject.stored.controller.gamma.bound;
    let mut keys = subject.speed_keys();
    keys.push(Key { dash: "", ..Key::reference("asked for: 1/|W|") });
    keys.push(Key::reference("guaranteed: gamma/|W|"));
    let mut charts = Vec::new();
    for (i, tracked) in subject.inputs.design.tracked.iter().enumerate() {
        let title = format!("error of {}", tracked.signal().name);
        let limit = |omega| allowed(&tracked.weight, omega);
        charts.push(chart(title, &loops, gamma, &|l, omega| l.error(i, omega), &limit));
    }
    let weight = subject.inputs.design.control_weight;
    let title = "references to controls".to_owned();
    charts.push(chart(title, &loops, gamma, &FrozenLoop::control, &|omega| 1.0 / weight.gain(omega)));
    let figure = Figure {
        name: "weights-and-sensitivity".into(),
        caption: format!(
            "What the weights ask for and what the loop of {} achieves as it flies (true linearisations at six \
                frozen speeds, sampled, with the lags of the \
             actuators), in units of the references' scales and the actuators' limits. Dashed: what a gain \
             below {} means for the fitted model in continuous \
             time{}.",
            subject.name(),
            above(gamma),
            if subject.stored.controller.gamma.certified {
                ""
            } else {
                "; this controller is not proved to have it"
            }
        ),
        keys,
        charts,
    };
    let output = subject.output()?;
    let weight = subject.inputs.design.tracked[output].weight;
    let peaks = Both::of(&loops, &ideal, |l| l.peak(output));
    let steady = Both::of(&loops, &ideal, |l| l.error(output, 0.0));
    let name = subject.step().name;
    Ok(vec![
        Part::Figure(figure),
        Part::Table(table(subject, &peaks, &steady)),
        Part::Claim(peak_claim(name, &peaks, weight.peak)),
        Part::Claim(steady_claim(name, &steady, weight.steady_error)),
    ])
}

/// A number at each of the six speeds, of the loop as it flies and of the one in continuous time.
struct Both {
    flying: Vec<f64>,
    ideal: Vec<f64>,
}

impl Both {
    fn of(flying: &[FrozenLoop], ideal: &[FrozenLoop], of: impl Fn(&FrozenLoop) -> f64) -> Self {
        Self { flying: flying.iter().map(&of).collect(), ideal: ideal.iter().map(of).collect() }
    }
}

fn table(subject: &Subject, peaks: &Both, steady: &Both) -> Table {
    let mut table = Table::new([
        "speed (m/s)",
        &format!("peak of |S| of {}, as it flies", subject.step().name),
        "in continuous time",
        "error at zero frequency, %, as it flies",
        "in continuous time",
    ]);
    for (i, speed) in subject.speeds.iter().enumerate() {
        let mut row = vec![format!("{speed:.2}")];
        row.extend([&peaks.flying, &peaks.ideal].map(|v| format!("{:.3}", v[i])));
        row.extend([&steady.flying, &steady.ideal].map(|v| format!("{:.4}", 100.0 * v[i])));
        table.rows.push(row);
    }
    table
}

fn chart(
    title: String,
    loops: &[FrozenLoop],
    gamma: f64,
    of: &dyn Fn(&FrozenLoop, f64) -> f64,
    limit: &dyn Fn(f64) -> f64,
) -> Chart {
    let axis = axis();
    let mut curves: Vec<Curve> = loops
        .iter()
        .enumerate()
        .map(|(key, l)| {
            let shown = axis.iter().filter(|omega| **omega < l.highest());
            Curve { key, points: shown.map(|omega| (*omega, of(l, *omega))).collect() }
        })
        .collect();
    for (k, factor) in [1.0, gamma].into_iter().enumerate() {
        let points = axis.iter().map(|omega| (*omega, factor * limit(*omega))).collect();
        curves.push(Curve { key: loops.len() + k, points });
    }
    Chart::over_frequency(title, Axis::logarithmic("magnitude (-)"), curves)
}

fn peak_claim(name: &str, peaks: &Both, limit: f64) -> Claim {
    Claim {
        claim: "M_s = 2 in the weight gives a good robustness margin (section 3B).",
        criterion: format!(
            "the peak of |S| of {name} below M_s = {limit} at each of the six speeds, of the loop as it flies: \
                sampled, with the lags of the actuators."
        ),
        finding: all_below(&peaks.flying, limit),
        because: format!(
            "The largest peak is {:.2} as it flies, and {:.2} in continuous time.",
            largest(0.0, peaks.flying.iter().copied()),
            largest(0.0, peaks.ideal.iter().copied())
        ),
    }
}

fn steady_claim(name: &str, steady: &Both, limit: f64) -> Claim {
    let percent = |v: &[f64]| 100.0 * largest(0.0, v.iter().copied());
    Claim {
        claim: "epsilon = 0.01 in the weight keeps the tracking error below 1 % (section 3B).",
        criterion: format!(
            "the error of {name} at zero frequency below {} %, which is epsilon of this design, at each of the six \
                speeds, of the loop as it flies.",
            100.0 * limit
        ),
        finding: all_below(&steady.flying, limit),
        because: format!(
            "The largest is {:.3} % as it flies, and {:.3} % in continuous time.",
            percent(&steady.flying),
            percent(&steady.ideal)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Finding;

    #[test]
    fn the_weight_asks_for_its_three_numbers() {
        let weight = TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 };
        assert!((allowed(&weight, 0.0) - 0.01).abs() < 1e-12);
        assert!((allowed(&weight, 1e6) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn claims_follow_the_numbers() {
        let both = |flying: &[f64], ideal: &[f64]| Both { flying: flying.into(), ideal: ideal.into() };
        assert_eq!(peak_claim("pitch", &both(&[1.2, 1.9], &[1.1, 1.8]), 2.0).finding, Finding::Confirmed);
        assert_eq!(steady_claim("pitch", &both(&[0.02], &[0.001]), 0.01).finding, Finding::NotConfirmed);
        // What flies counts, and both are reported.
        let found = peak_claim("pitch", &both(&[2.5, 1.9], &[1.7, 1.2]), 2.0);
        assert_eq!(found.finding, Finding::Partly);
        assert!(found.because.contains("2.50 as it flies, and 1.70 in continuous time"), "{}", found.because);
    }
}
