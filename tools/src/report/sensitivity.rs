//! The weights against what was achieved: sensitivities and control efforts at six speeds.

use super::axis::Axis;
use super::chart::{Chart, Curve, Key};
use super::figure::Figure;
use super::frozen_loop::FrozenLoop;
use super::section::Part;
use super::subject::Subject;
use super::verdict::{Verdict, all_below};
use crate::error::Error;
use crate::output::above;
use lpv::tracking::TrackingWeight;
use nalgebra::Complex;

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

/// The section.
///
/// # Errors
/// [`Error::PitchNotTracked`], [`Error::Lft`].
pub fn sensitivity(subject: &Subject) -> Result<Vec<Part>, Error> {
    let loops: Vec<FrozenLoop> = subject
        .truth
        .iter()
        .map(|l| FrozenLoop::new(subject, &subject.controller, l))
        .collect::<Result<_, Error>>()?;
    let gamma = subject.stored.controller.gamma.bound;
    let mut keys: Vec<Key> =
        subject.speeds.iter().enumerate().map(|(i, v)| Key::nth(i, Subject::speed_name(*v))).collect();
    keys.push(Key { dash: "", ..Key::reference("asked for: 1/|W|") });
    keys.push(Key::reference("guaranteed: gamma/|W|"));
    let mut charts = Vec::new();
    for (i, tracked) in subject.inputs.design.tracked.iter().enumerate() {
        let title = format!("|S| of {}", tracked.output.name());
        let limit = |omega| allowed(&tracked.weight, omega);
        charts.push(chart(title, &loops, gamma, &|l, omega| l.sensitivity(i, omega), &limit));
    }
    let weight = subject.inputs.design.control_weight;
    let title = "references to controls".to_owned();
    charts.push(chart(title, &loops, gamma, &FrozenLoop::control, &|_| 1.0 / weight));
    let figure = Figure {
        name: "weights-and-sensitivity".into(),
        caption: format!(
            "What the weights ask for and what the loop of {} achieves at six frozen speeds (true linearisations), in units of the \
             references' scales and the actuators' limits. Dashed: what a gain below {} means for the fitted model{}.",
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
    let pitch = subject.pitch()?;
    let weight = subject.inputs.design.tracked[pitch].weight;
    let frequencies = axis();
    let peak = |l: &FrozenLoop| frequencies.iter().map(|o| l.sensitivity(pitch, *o)).fold(0.0, f64::max);
    let peaks: Vec<f64> = loops.iter().map(peak).collect();
    let steady: Vec<f64> = loops.iter().map(|l| l.sensitivity(pitch, 0.0)).collect();
    Ok(vec![
        Part::Figure(figure),
        Part::Verdict(peak_verdict(&peaks, weight.peak)),
        Part::Verdict(steady_verdict(&steady, weight.steady_error)),
    ])
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
        .map(|(key, l)| Curve { key, points: axis.iter().map(|omega| (*omega, of(l, *omega))).collect() })
        .collect();
    for (k, factor) in [1.0, gamma].into_iter().enumerate() {
        let points = axis.iter().map(|omega| (*omega, factor * limit(*omega))).collect();
        curves.push(Curve { key: loops.len() + k, points });
    }
    Chart { title, x: Axis::logarithmic("frequency (rad/s)"), y: Axis::logarithmic("magnitude"), curves }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn peak_verdict(peaks: &[f64], limit: f64) -> Verdict {
    Verdict {
        claim: "M_s = 2 in the weight gives a good robustness margin (section 3B).",
        criterion: format!("the peak of |S| of pitch below M_s = {limit} at each of the six speeds."),
        finding: all_below(peaks, limit),
        because: format!("The largest peak is {:.2}.", largest(peaks)),
    }
}

fn steady_verdict(steady: &[f64], limit: f64) -> Verdict {
    Verdict {
        claim: "epsilon = 0.01 in the weight keeps the tracking error below 1 % (section 3B).",
        criterion: format!(
            "|S| of pitch at zero frequency below {} % at each of the six speeds.",
            100.0 * limit
        ),
        finding: all_below(steady, limit),
        because: format!("The largest is {:.3} %.", 100.0 * largest(steady)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::verdict::Finding;

    #[test]
    fn the_weight_asks_for_its_three_numbers() {
        let weight = TrackingWeight { peak: 2.0, steady_error: 0.01, bandwidth: 0.46 };
        assert!((allowed(&weight, 0.0) - 0.01).abs() < 1e-12);
        assert!((allowed(&weight, 1e6) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn verdicts_follow_the_numbers() {
        assert_eq!(peak_verdict(&[1.2, 1.9], 2.0).finding, Finding::BorneOut);
        assert_eq!(peak_verdict(&[2.2, 1.9], 2.0).finding, Finding::Partly);
        assert_eq!(steady_verdict(&[0.02], 0.01).finding, Finding::NotBorneOut);
    }
}
