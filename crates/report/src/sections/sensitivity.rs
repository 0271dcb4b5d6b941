//! Comparison of the weights with the achieved sensitivities and control efforts at six speeds.

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part, Table};
use crate::sections::frozen_loop::FrozenLoop;
use crate::subject::Subject;
use nalgebra::Complex;
use squid_base::numbers::above;
use squid_design::axis::Linearisation;
use squid_lpv::controller::Controller;
use squid_lpv::weights::TrackingWeight;

/// Returns 1/|W_e| at a frequency.
fn allowed(weight: &TrackingWeight, omega: f64) -> f64 {
    let s = Complex::new(0.0, omega);
    let (below, above) = (s / weight.peak + weight.bandwidth, s + weight.bandwidth * weight.steady_error);
    (above / below).norm()
}

/// Returns the section on |S| and control effort over frequency against the weights, ideal and as flown.
///
/// # Errors
/// [`Error::NothingSteps`], [`ModelError::System`](squid_design::error::ModelError::System).
pub fn sensitivity(subject: &Subject) -> Result<Vec<Part>, Error> {
    let loops = all(subject, FrozenLoop::flying)?;
    let gamma = subject.stored.controller.gamma.bound;
    let mut keys = subject.speed_keys();
    keys.push(Key { dash: "", ..Key::reference("required: 1/|W|") });
    keys.push(Key::reference("guaranteed: gamma/|W|"));
    let mut charts = Vec::new();
    for (i, tracked) in subject.inputs.design.tracked.iter().enumerate() {
        let title = format!("error of {}", tracked.signal.name);
        let limit = |omega| allowed(&tracked.weight, omega);
        charts.push(chart(title, &loops, gamma, &|l, omega| l.error(i, omega), &limit));
    }
    let (actuators, design) = (&subject.inputs.vehicle.actuators, &subject.inputs.design);
    let relative: Vec<f64> = actuators.iter().map(|one| design.relative_weight(&one.name)).collect();
    let weighted =
        if design.relative_weights.is_empty() { "" } else { ", and each control times its relative weight" };
    let title = "references to controls".to_owned();
    let control = |l: &FrozenLoop, omega| l.control(&relative, omega);
    charts.push(chart(title, &loops, gamma, &control, &|omega| 1.0 / design.control_weight.gain(omega)));
    let figure = Figure {
        name: "weights-and-sensitivity".into(),
        caption: format!(
            "Required by the weights, and achieved by the loop of {} as implemented (true linearisations at six \
             frozen speeds, sampled, with the lags of the actuators), in units of the scales of the references and \
             the limits of the actuators{weighted}. Dashed: implied by a gain below {} for the fitted model in \
             continuous time{}.",
            subject.name(),
            above(gamma),
            if subject.stored.controller.gamma.certified {
                ""
            } else {
                "; this gain is not proved for this controller"
            }
        ),
        keys,
        charts,
    };
    Ok(vec![Part::Figure(figure), Part::Table(table(subject, &Achieved::of(subject)?))])
}

/// Returns the loop at each of the six speeds.
fn all(
    subject: &Subject,
    make: fn(&Subject, &Controller, &Linearisation) -> Result<FrozenLoop, Error>,
) -> Result<Vec<FrozenLoop>, Error> {
    subject.truth.iter().map(|l| make(subject, &subject.controller, l)).collect()
}

/// Values at each of the six speeds, for both loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Both {
    /// Values for the loop as flown.
    pub flying: Vec<f64>,
    /// Values for the loop in continuous time.
    pub ideal: Vec<f64>,
}

/// Performance of the loop for the stepped output.
#[derive(Debug, Clone, PartialEq)]
pub struct Achieved {
    /// Peaks of |S|.
    pub peaks: Both,
    /// Errors at zero frequency.
    pub steady: Both,
}

impl Achieved {
    /// Computes the performance of the stored controller.
    ///
    /// # Errors
    /// Errors of [`sensitivity`].
    pub fn of(subject: &Subject) -> Result<Self, Error> {
        let output = subject.output()?;
        let (flying, ideal) = (all(subject, FrozenLoop::flying)?, all(subject, FrozenLoop::ideal)?);
        let both = |of: &dyn Fn(&FrozenLoop) -> f64| Both {
            flying: flying.iter().map(of).collect(),
            ideal: ideal.iter().map(of).collect(),
        };
        Ok(Self { peaks: both(&|l| l.peak(output)), steady: both(&|l| l.error(output, 0.0)) })
    }
}

fn table(subject: &Subject, Achieved { peaks, steady }: &Achieved) -> Table {
    let mut table = Table::new([
        "speed (m/s)",
        &format!("peak of |S| of {}, as implemented", subject.step().name),
        "in continuous time",
        "error at zero frequency, %, as implemented",
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
    let axis: Vec<f64> = (0..=240).map(|i| 10f64.powf(-4.0 + f64::from(i) / 40.0)).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_has_steady_error_and_peak() {
        let weight = TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 };
        assert!((allowed(&weight, 0.0) - 0.01).abs() < 1e-12);
        assert!((allowed(&weight, 1e6) - 2.0).abs() < 1e-6);
    }
}
