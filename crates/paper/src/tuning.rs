//! Pitch responses of the paper's Fig. 5, at six speeds for three bandwidths of W_e.

use crate::claims::{
    Claim, Found, LEAST_DAMPING, all_below, best, equivalent_damping, least, well_damped, worst,
};
use squid_auv::longitudinal::PITCH;
use squid_base::numbers::above;
use squid_design::augment::augment;
use squid_design::certify::lft_matrices;
use squid_design::inputs::Inputs;
use squid_design::synthesise::options;
use squid_flight::flight::Row;
use squid_flight::metrics::StepFigures;
use squid_lpv::matrix::largest;
use squid_lpv::synthesis::synthesise;
use squid_report::error::Error;
use squid_report::page::{Chart, Curve, Figure, Part, Table, known};
use squid_report::sections::frozen_loop::FrozenLoop;
use squid_report::subject::{FLOWN, SHOWN, STEP_TIME, Subject};
use squid_report::threads::in_parallel;
use squid_scheduled::ControllerDesign;

/// Bandwidths of Fig. 5 a, b and c (rad/s), and the one that the paper prefers.
const TRIED: [(f64, &str); 3] = [(0.46, "a"), (0.1, "b"), (0.23, "c")];
const PREFERRED: f64 = 0.23;
/// Upper limit of the closed-loop bandwidth claimed by the paper (rad/s).
const CLAIMED_BANDWIDTH: f64 = 1.0;

/// Linear figures of a frozen loop.
struct Linear {
    impulse: Vec<(f64, f64)>,
    bandwidth: f64,
    /// Damping ratios: the least of its modes, and that of its impulse response.
    mode_damping: f64,
    impulse_damping: f64,
}

impl Linear {
    fn of(frozen: &FrozenLoop, pitch: usize) -> Self {
        let impulse = frozen.impulse(pitch, FLOWN);
        let impulse_damping = equivalent_damping(&impulse.iter().map(|p| p.1).collect::<Vec<_>>());
        Self {
            impulse,
            bandwidth: frozen.bandwidth(pitch),
            mode_damping: frozen.least_damping().0,
            impulse_damping,
        }
    }
}

/// Response for one bandwidth at one speed.
struct Response {
    /// Sampled loop as flown, and loop in continuous time.
    flying: Linear,
    ideal: Linear,
    rows: Vec<Row>,
    figures: StepFigures,
    cost: f64,
}

struct Tuned {
    weight: f64,
    letter: &'static str,
    gamma: f64,
    responses: Vec<Response>,
}

/// Computes the section on Fig. 5: impulse and step responses for each bandwidth of W_e.
///
/// # Errors
/// [`Error::PitchNotTracked`]; [`Error::Design`] if a bandwidth allows no controller; the errors of
/// [`squid_flight::flight::fly`].
pub fn tuning(subject: &Subject) -> Result<Found, Error> {
    let all = in_parallel(TRIED.iter(), |(w, letter)| tune(subject, *w, letter));
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    let step = subject.stored.manoeuvre.step("pitch").to_degrees();
    let text = format!(
        "The (nominal) controller is synthesised again for each bandwidth of W_e; everything else is as in the \
            design file. Impulses, bandwidths and damping are those of the linear loop at frozen speed as \
            implemented: true linearisation, sampled controller, lags of the actuators. Steps of {step:.0} deg are \
            simulated with the nonlinear vehicle, the sampled autopilot, and lags and limits of the actuators.{}",
        if all.iter().flat_map(|t| &t.responses).any(|r| r.cost.is_nan()) {
            " Some of these simulations end early at the surface: - means unknown."
        } else {
            ""
        }
    );
    let parts = vec![
        Part::Text(text),
        Part::Figure(figure(subject, &all)),
        Part::Table(table(subject, &all)),
        Part::Table(costs_table(&all)),
    ];
    Ok((parts, vec![damping_claim(&all), bandwidth_claim(&all), best_claim(&all)]))
}

fn tune(subject: &Subject, weight: f64, letter: &'static str) -> Result<Tuned, Error> {
    let inputs =
        Inputs { design: subject.inputs.design.clone().with_bandwidth(weight), ..subject.inputs.clone() };
    let plant = augment(&inputs.vehicle.actuators, &inputs.design, subject.model.linear())?;
    let options = options(&inputs.design);
    let design = synthesise(&plant, options)?;
    let k = &design.controller;
    let lft = lft_matrices(k);
    let stored = subject.stored.controller.clone();
    let controller = ControllerDesign { lft, anti_windup: None, follow: vec![], ..stored };
    let pitch = subject.pitch()?;
    let respond = |i: usize| -> Result<Response, Error> {
        let truth = &subject.truth[i];
        let flight = subject.fly_step(subject.speeds[i], &controller)?;
        let (height, figures) = (subject.stored.manoeuvre.step("pitch"), subject.figures(&flight));
        let rows = flight.rows;
        Ok(Response {
            flying: Linear::of(&FrozenLoop::flying(subject, &design.controller, truth)?, pitch),
            ideal: Linear::of(&FrozenLoop::ideal(subject, &design.controller, truth)?, pitch),
            figures,
            // The cost of a flight that surfaced is unknown.
            cost: flight.surfacing.map_or_else(|| time_weighted_error(&rows, height), |_| f64::NAN),
            rows,
        })
    };
    let responses = (0..subject.speeds.len()).map(respond).collect::<Result<_, _>>()?;
    Ok(Tuned { weight, letter, gamma: design.certified.gamma, responses })
}

/// Integral of t |error|/height from the step on (ITAE, s^2): small for a response that is fast and does not ring.
///
/// Source: D. Graham, R. Lathrop, Trans. AIEE 72, 1953.
fn time_weighted_error(rows: &[Row], height: f64) -> f64 {
    let each = rows.windows(2).map(|w| {
        let (t, dt) = (w[1].time - STEP_TIME, w[1].time - w[0].time);
        t.max(0.0) * (w[1].error(PITCH) / height).abs() * dt
    });
    each.sum()
}

fn figure(subject: &Subject, all: &[Tuned]) -> Figure {
    let keys = subject.speed_keys();
    let shown = |points: Vec<(f64, f64)>| points.into_iter().filter(|p| p.0 <= SHOWN).collect::<Vec<_>>();
    let curves = |tuned: &Tuned, of: &dyn Fn(&Response) -> Vec<(f64, f64)>| {
        let each = tuned.responses.iter().enumerate();
        each.map(|(key, r)| Curve { key, points: shown(of(r)) }).collect::<Vec<Curve>>()
    };
    let mut charts = Vec::new();
    for tuned in all {
        let title = format!("{}, w_b {}: impulse", tuned.letter, tuned.weight);
        let impulses = curves(tuned, &|r| r.flying.impulse.clone());
        let chart = Chart::over_time(title, "pitch (deg per deg s)", impulses);
        charts.push(Chart { x: chart.x.over(0.0, SHOWN), ..chart });
    }
    for tuned in all {
        let title = format!("{}, w_b {}: step", tuned.letter, tuned.weight);
        let steps = curves(tuned, &|r| {
            let start = r.rows[0].reference(PITCH);
            r.rows.iter().map(|row| (row.time, (row.measured(PITCH) - start).to_degrees())).collect()
        });
        charts.push(Chart::over_time(title, "pitch from trim (deg)", steps));
    }
    Figure {
        name: "fig5-pitch-responses".into(),
        caption: format!(
            "Pitch of {} at six speeds after an impulse of the reference (above: pitch in degrees for an impulse of \
                1 deg s) and after a step (below).",
            subject.name()
        ),
        keys,
        charts,
    }
}

fn table(subject: &Subject, all: &[Tuned]) -> Table {
    let mut table = Table::new([
        "w_b (rad/s)",
        "speed (m/s)",
        "overshoot %",
        "10-90 % (s)",
        "settled to 2 % (s)",
        "steady error %",
        "actuator use %",
        "bandwidth (rad/s)",
        "damping of the modes",
        "damping of the response",
    ]);
    for tuned in all {
        for (v, r) in subject.speeds.iter().zip(&tuned.responses) {
            table.rows.push(vec![
                tuned.weight.to_string(),
                format!("{v:.2}"),
                format!("{:.1}", 100.0 * r.figures.overshoot),
                format!("{:.2}", r.figures.rise_time),
                known(r.figures.settling_time, 2),
                known(100.0 * r.figures.steady_error, 2),
                format!("{:.0}", 100.0 * r.figures.actuator_use),
                format!("{:.2}", r.flying.bandwidth),
                format!("{:.2}", r.flying.mode_damping),
                format!("{:.2}", r.flying.impulse_damping),
            ]);
        }
    }
    table
}

fn damping_claim(all: &[Tuned]) -> Claim {
    let each = || all.iter().flat_map(|t| &t.responses);
    let of = |of: fn(&Response) -> f64| each().map(of).collect::<Vec<f64>>();
    let (mode_damping, impulse_damping) = (of(|r| r.flying.mode_damping), of(|r| r.flying.impulse_damping));
    let least = |ratios: &[f64]| ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let enough = |ratios: &[f64]| ratios.iter().filter(|z| **z >= LEAST_DAMPING).count();
    let overshoot = of(|r| r.figures.overshoot).into_iter().fold(0.0, f64::max);
    let both: Vec<f64> = mode_damping.iter().chain(&impulse_damping).copied().collect();
    Claim {
        claim: "the closed loop is well damped at all speeds (Fig. 5).",
        criterion: format!(
            "at each of the six speeds and three bandwidths, for the loop as implemented, both the smallest damping \
                ratio of its modes and the one of its impulse response (by the logarithmic decrement of its largest \
                reversal, which zeros also increase) are at least {LEAST_DAMPING}, the lower limit of the best class \
                of short-period damping in MIL-F-8785C."
        ),
        finding: well_damped(&both),
        because: format!(
            "Of the modes {} of {} satisfy it, the smallest ratio being {:.3}; of the responses {} of {}, with \
                {:.3}. In continuous time the smallest ratios are {:.3} and {:.3}. The largest overshoot of a \
                simulated step is {:.1} %.",
            enough(&mode_damping),
            mode_damping.len(),
            least(&mode_damping),
            enough(&impulse_damping),
            impulse_damping.len(),
            least(&impulse_damping),
            least(&of(|r| r.ideal.mode_damping)),
            least(&of(|r| r.ideal.impulse_damping)),
            100.0 * overshoot
        ),
    }
}

fn bandwidth_claim(all: &[Tuned]) -> Claim {
    let each = |of: fn(&Response) -> f64| -> Vec<f64> {
        all.iter().map(|t| largest(0.0, t.responses.iter().map(of))).collect()
    };
    let (found, ideal) = (each(|r| r.flying.bandwidth), each(|r| r.ideal.bandwidth));
    let text = |found: &[f64]| -> String {
        let each = all.iter().zip(found).map(|(t, b)| format!("{b:.2} rad/s with w_b = {}", t.weight));
        each.collect::<Vec<_>>().join(", ")
    };
    Claim {
        claim: "the bandwidth of the closed loop is below 1 rad/s at all speeds (section 4).",
        criterion: format!(
            "the highest frequency at which |T| of pitch is 1/sqrt(2), for the loop as implemented and as the \
                largest value over the six speeds: confirmed if below {CLAIMED_BANDWIDTH} rad/s for each of the \
                three bandwidths of the weight, partly confirmed for some of them."
        ),
        finding: all_below(&found, CLAIMED_BANDWIDTH),
        because: format!("The largest is {}. In continuous time it is {}.", text(&found), text(&ideal)),
    }
}

/// Name, unit, and cost of each bandwidth at its worst or on average.
fn costs(all: &[Tuned]) -> [(&'static str, Vec<(f64, f64)>); 4] {
    let each = |of: &dyn Fn(&Response) -> f64, fold: &dyn Fn(&[f64]) -> f64| -> Vec<(f64, f64)> {
        let values = |t: &Tuned| t.responses.iter().map(of).collect::<Vec<f64>>();
        all.iter().map(|t| (t.weight, fold(&values(t)))).collect()
    };
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let most = |v: &[f64]| largest(0.0, v.iter().copied());
    [
        ("mean ITAE (s^2)", each(&|r| r.cost, &mean)),
        ("worst settling (s)", each(&|r| r.figures.settling_time, &most)),
        ("worst overshoot (%)", each(&|r| 100.0 * r.figures.overshoot, &most)),
        ("worst actuator use (%)", each(&|r| 100.0 * r.figures.actuator_use, &most)),
    ]
}

fn costs_table(all: &[Tuned]) -> Table {
    let costs = costs(all);
    let mut head = vec!["w_b (rad/s)".to_owned(), "gamma, bound".to_owned()];
    head.extend(costs.iter().map(|(name, _)| (*name).to_owned()));
    let row = |(i, tuned): (usize, &Tuned)| {
        let mut row = vec![tuned.weight.to_string(), above(tuned.gamma)];
        row.extend(costs.iter().map(|(_, values)| known(values[i].1, 2)));
        row
    };
    Table { head, rows: all.iter().enumerate().map(row).collect() }
}

fn best_claim(all: &[Tuned]) -> Claim {
    let costs = costs(all);
    let measures: Vec<Vec<(f64, f64)>> = costs.iter().map(|(_, values)| values.clone()).collect();
    let each: Vec<String> = costs
        .iter()
        .map(|(name, values)| match least(values) {
            Some(at) => format!("{at} by {name}"),
            None => format!("no single one by {name}"),
        })
        .collect();
    let is_between = |values: &&Vec<(f64, f64)>| {
        least(values).is_some_and(|at| at != PREFERRED) && worst(values).is_some_and(|at| at != PREFERRED)
    };
    let between = measures.iter().filter(is_between).count();
    Claim {
        claim: "from the point of view of time simulation w_b = 0.23 is the best of the three (section 4).",
        criterion:
            "the bandwidth with the smallest of four costs of the simulated steps over the six speeds: ITAE (the \
            time-weighted error), worst settling time, worst overshoot, worst actuator use. The paper does not state \
            its criterion; confirmed if it is the best by all four costs, partly confirmed if by some."
                .into(),
        finding: best(PREFERRED, &measures),
        because: format!(
            "The best w_b is {}. {PREFERRED} is neither the best nor the worst by {between} of {} costs.",
            each.join(", "),
            costs.len()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Finding;

    /// A loop that is good in continuous time but not as flown confirms nothing; both are reported.
    #[test]
    fn claims_concern_flown_loop() {
        let linear = |bandwidth, mode_damping, impulse_damping| Linear {
            impulse: vec![],
            bandwidth,
            mode_damping,
            impulse_damping,
        };
        let response = Response {
            flying: linear(1.2, 0.1, 0.2),
            ideal: linear(0.9, 0.8, 0.7),
            rows: vec![],
            figures: StepFigures::of(&[row(0.0, 0.0)], PITCH, (0.0, 0.2), &[]),
            cost: 0.0,
        };
        let all = [Tuned { weight: 0.46, letter: "a", gamma: 1.0, responses: vec![response] }];
        let (damping, bandwidth) = (damping_claim(&all), bandwidth_claim(&all));
        assert_eq!((damping.finding, bandwidth.finding), (Finding::NotConfirmed, Finding::NotConfirmed));
        insta::assert_snapshot!(format!("{}\n\n{}", damping.because, bandwidth.because));
    }

    /// First signals as given; the others are 0.
    fn signals_of(first: [f64; 2]) -> squid_auv::PerSignal<f64> {
        std::array::from_fn(|index| first.get(index).copied().unwrap_or_default())
    }

    fn row(time: f64, error: f64) -> Row {
        Row {
            time,
            used: [0.0, 1.0, 0.0],
            signals: squid_flight::flight::Signals {
                measured: signals_of([-error, 1.0]),
                references: [0.0, 1.0, 0.0],
            },
            depth: 0.0,
            rho: 0.0,
            out_of_range: false,
            commands: vec![],
        }
    }

    /// The error exp(-t) after the step has an ITAE of 1.
    #[test]
    fn itae_of_a_known_response() {
        let at = |i: u32| {
            let time = 1e-3 * f64::from(i);
            row(time, if time < STEP_TIME { 0.0 } else { 0.2 * (STEP_TIME - time).exp() })
        };
        let rows: Vec<Row> = (0..30_000).map(at).collect();
        assert!((time_weighted_error(&rows, 0.2) - 1.0).abs() < 1e-3);
    }
}
