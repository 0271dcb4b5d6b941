//! Comparison of the controller with common alternatives, a PID with gains scheduled on speed and blended H-infinity
//! controllers, and with other designs of the vehicle: sizes, proofs, flights and verdicts, with one column each.

pub mod beside;
pub mod course;
pub mod law;
mod line;
pub mod survival;

use crate::error::Error;
use crate::page::{Part, Table};
use crate::peers::beside::{NOTHING, proofs, verdicts};
use crate::peers::course::{fly_at, fly_ramp};
use crate::peers::law::Law;
use crate::peers::line::{DRAW, Line, score};
use crate::peers::survival::{Survival, fleet, survival};
use crate::subject::Subject;
use crate::threads::in_parallel;
use squid_design::axis::{Linearisation, VehicleModel};
use squid_design::check::flown::GUST;
use squid_pid::Pid;
use squid_tune::error::Error as TuneError;
use squid_tune::pid::in_flight::{Judged, tune_in_flight};
use std::iter::once;

/// Compares the controllers at three speeds and on the speed ramp of the manoeuvre.
///
/// # Errors
/// Errors of trim, linearisation, uncertain model and verdicts; [`Error::NothingSteps`].
pub(crate) fn peers(subject: &Subject) -> Result<Vec<Part>, Error> {
    subject.output()?;
    let designs: Vec<&Subject> = once(subject).chain(&subject.beside).collect();
    let mut laws: Vec<Law> = designs.iter().map(|one| Law::stored(one)).collect();
    let (pid, remark) = match tuned(subject)? {
        Ok((pid, cost)) => (
            Some(pid),
            format!(
                "The cost of this tuning, the mean ratio of its figures to those of the design, is {cost:.2}."
            ),
        ),
        Err(reason) => (None, no_pid(&reason)),
    };
    laws.extend(pid.into_iter().chain(Law::blended(subject)));
    let lines = flown(subject, &laws)?;
    let mut table = Table::new(["", if designs.len() > 1 { "m/s; required" } else { "m/s" }]);
    table.head.extend(laws.iter().map(|law| law.name.clone()));
    table.head.extend(laws[1..].iter().map(|law| format!("against {}", law.name)));
    if designs.len() > 1 {
        table.rows = proofs(&designs);
    }
    table.rows.extend(lines.iter().map(Line::row));
    if designs.len() > 1 {
        table.rows.extend(verdicts(&designs)?);
    }
    for row in table.rows.iter_mut().filter(|row| row.len() == 2 + designs.len()) {
        // Laws other than designs have neither proof nor verdict.
        row.resize(2 + laws.len(), NOTHING.into());
        row.resize(table.head.len(), String::new());
    }
    let scores: Vec<String> = (1..laws.len()).map(|i| score(&lines, i, &laws[i].name)).collect();
    let about = [explanation(subject), remark, beside::explanation(subject)].join(" ");
    Ok(vec![Part::Text(about.trim_end().into()), Part::Table(table), Part::Text(scores.join(" "))])
}

/// Counts the rows of the comparison that the design wins, draws and loses against the PID tuned in flight; returns the
/// score, or the reason why there is no such PID, as text.
///
/// # Errors
/// Errors of trim, linearisation and the uncertain model.
pub fn against_pid(subject: &Subject) -> Result<String, Error> {
    Ok(match tuned(subject)? {
        Ok((pid, _)) => score(&flown(subject, &[Law::stored(subject), pid])?, 1, "a PID tuned in simulation"),
        Err(reason) => no_pid(&reason),
    })
}

fn no_pid(reason: &str) -> String {
    format!("No PID was tuned: {reason}.")
}

/// Returns both ends and the middle of the speed ramp of the manoeuvre.
fn speeds(subject: &Subject) -> [f64; 3] {
    let m = &subject.stored.manoeuvre;
    let (low, high) = match (m.speed_from.min(m.speed_to), m.speed_from.max(m.speed_to)) {
        (low, high) if low < high => (low, high),
        _ => (subject.inputs.design.speed_min, subject.inputs.design.speed_max),
    };
    [low, 0.5 * (low + high), high]
}

/// Returns the PID of least cost for the flights at the three speeds, and that cost; or the reason why there is none,
/// as text.
///
/// The cost is the mean of ratios to the design's figures on the same course: ITAE and settling time of the stepped
/// output, ITAE of the speed, and the peak after the gust. |S| and the noise in the commands must be no larger than the
/// design's at each speed.
///
/// # Errors
/// Errors of trim and linearisation.
fn tuned<'a>(subject: &'a Subject) -> Result<Result<(Law<'a>, f64), String>, Error> {
    let linear = |v: &f64| Ok(subject.inputs.axis().linearise(*v)?);
    let linear: Vec<Linearisation> = speeds(subject).iter().map(linear).collect::<Result<_, Error>>()?;
    let figures = |law: &Law| -> Option<Vec<([f64; 2], [f64; 4])>> {
        let at = |l: &Linearisation| {
            let [peak, rough, _] = law.at(l)?;
            let [itae, settled, _, speed, .., gust, _] = fly_at(subject, law, l.trim.speed).ok()?;
            Some(([peak, rough], [itae, settled, speed, gust]))
        };
        in_parallel(linear.iter(), at).into_iter().collect()
    };
    let Some(ours) = figures(&Law::stored(subject)) else {
        return Ok(Err("the design's own loop is unstable at one of the three speeds".into()));
    };
    let judge = |pid: &Pid| {
        let found = figures(&Law::pid(subject, pid)?)?;
        let ratios = found.iter().zip(&ours).flat_map(|((_, one), (_, own))| {
            one.iter().zip(own).map(|(one, own)| one / own).filter(|ratio| !ratio.is_nan())
        });
        let ratios: Vec<f64> = ratios.map(|ratio| ratio.min(WORST)).collect();
        let margins = found.iter().zip(&ours).flat_map(|((one, _), (own, _))| {
            one.iter().zip(own).map(|(one, own)| (own / one).ln()).collect::<Vec<f64>>()
        });
        let cost = ratios.iter().sum::<f64>() / ratios.len() as f64;
        Some(Judged { cost, margins: margins.collect() })
    };
    let found = tune_in_flight(subject.inputs, 2 * linear.len(), &judge);
    let law = |(cost, pid): (f64, Pid)| Some((Law::pid(subject, &pid)?, cost));
    Ok(match found {
        Ok(found) => found.and_then(law).ok_or_else(|| {
            "the search found no gains with |S| and commands under noise as small as those of the design"
                .into()
        }),
        Err(TuneError::NoPid { reason, .. }) => Err(reason),
        Err(TuneError::Design(reason)) => return Err(reason.into()),
        Err(other) => Err(other.to_string()),
    })
}

/// Largest ratio to a figure of the design in the cost.
const WORST: f64 = 10.0;

/// Returns the rows of laws at three speeds and on the ramp, without rows that have no figure.
fn flown(subject: &Subject, laws: &[Law]) -> Result<Vec<Line>, Error> {
    let (name, tick) = (subject.step().name, subject.inputs.design.sample_time);
    let stepped = |what: &str| {
        [("ITAE (s^2)", 0.0), ("settled (s)", tick), ("overshoot (%)", 0.5)]
            .map(|(figure, slight)| Line::new(format!("{what} step: {figure}"), 2, slight))
    };
    let reported = |name: &str, decimals| Line { reported: true, ..Line::new(name, decimals, 0.0) };
    let largest = |name: &str, decimals| Line { largest: true, ..Line::new(name, decimals, 0.0) };
    let at_speed: Vec<Line> = stepped(name)
        .into_iter()
        .chain(stepped("speed"))
        .chain([
            Line::new(format!("gust: peak of {name} ({})", subject.step().unit), 2, 0.0),
            reported("largest command (% of the way to a limit)", 0),
            reported("peak of |S|", 2),
            Line::new("commands under noise, rms (% of reach)", 2, 0.0),
            largest("delay margin, all commands (s)", 3),
            largest("box survived (%)", 0),
            Line::new("box: worst overshoot (%)", 1, 0.5),
        ])
        .collect();
    let mut lines: Vec<Line> = vec![];
    for speed in speeds(subject) {
        let fleet = fleet(subject, speed)?;
        let found = in_parallel(laws.iter(), |law| -> Result<Vec<f64>, Error> {
            let l = law.subject.inputs.axis().linearise(speed)?;
            let [peak, rough, delay] = law.at(&l).unwrap_or([f64::INFINITY, f64::INFINITY, 0.0]);
            let Survival { share, overshoot } = survival(subject, law, speed, &fleet);
            let of_loop = [peak, 100.0 * rough, delay, 100.0 * share, 100.0 * overshoot];
            Ok(fly_at(subject, law, speed)?.into_iter().chain(of_loop).collect())
        });
        let found = found.into_iter().collect::<Result<Vec<_>, Error>>()?;
        lines.extend(Line::filled(&at_speed, &format!("{speed:.2}"), &found));
        subject.progress.done("report", &format!("  compared at {speed:.2} m/s"));
    }
    let on_ramp: Vec<Line> =
        stepped(name).into_iter().chain([Line::new("largest speed error (m/s)", 3, 0.0)]).collect();
    let found = in_parallel(laws.iter(), |law| Ok(fly_ramp(subject, law)?.to_vec()));
    lines.extend(Line::filled(&on_ramp, "ramp", &found.into_iter().collect::<Result<Vec<_>, Error>>()?));
    lines.retain(|line| line.values.iter().any(|value| !value.is_nan()));
    Ok(lines)
}

fn explanation(subject: &Subject) -> String {
    let step = subject.step();
    let speed_step = if subject.inputs.design.tracked_speed().is_some() {
        "a speed step"
    } else {
        "the speed is imposed, equally for all"
    };
    format!(
        "Each control law is simulated with the same nonlinear vehicle, sensors, sample time, lags, limits, trim \
            feedforward and filtered {}. PID: the structure of [controller] in a design file, with gains linear in \
            speed and reference weights, tuned at the three speeds by COBYLA (M. J. D. Powell, 1994) over the \
            simulations of this table, with |S| and commands under noise no larger than those of the design at this \
            speed. Blended: H-infinity controllers with the same weights for six speeds, all active, with outputs \
            blended by speed. Simulations: a {} step of {}, a gust of {GUST} m/s across the path, {speed_step}. ITAE \
            is the integral of t |error|/step, where the error is relative to the reference itself, not to its \
            model. Box: vehicles at corners and random points of the declared uncertainty; a vehicle survives if its \
            {} is within a tenth of the step at the end; the overshoot is the largest of these. Rows that differ by \
            less than {:.0} % count as drawn; rows without figure are not compared.",
        subject.speed_reference(),
        step.name,
        step.text(),
        step.name,
        100.0 * DRAW
    )
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::peers::law::fly_instead;
    use squid_base::progress::Progress;
    use squid_design::inputs::Inputs;
    use squid_design::store::{Stored, load};
    use squid_flight::flight::Variations;
    use squid_lpv::matrix::Mat;
    use std::path::Path;

    /// Returns the committed design of Squid.
    pub(crate) fn squid() -> (Inputs, Stored) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let stored = load(&folder.join("frozen"), &inputs).unwrap();
        (inputs, stored)
    }

    /// Flights of each law at one speed and away from limits equal those of its frozen system, also with delayed
    /// commands.
    #[test]
    fn laws_match_their_frozen_systems() {
        let (inputs, mut stored) = squid();
        stored.manoeuvre = stored.manoeuvre.with_step("pitch", 0.01);
        for delay in [0, 3] {
            stored.controller.delay_ticks = delay;
            let progress = Progress::default();
            let mut subject = Subject::new(&inputs, &stored, &progress).unwrap();
            // Two adjacent speeds suffice for a blend.
            subject.speeds = vec![subject.speeds[2], subject.speeds[3]];
            let speed = 0.7 * subject.speeds[0] + 0.3 * subject.speeds[1];
            let manoeuvre = subject.stepped(speed, (1.0, f64::MAX), 6.0);
            let variations = Variations::default();
            for law in [Law::stored(&subject), Law::blended(&subject).unwrap()] {
                let k = law.frozen(speed).unwrap();
                let mut x = Mat::zeros(k.a.nrows(), 1);
                let frozen = fly_instead(&subject, &inputs.vehicle, &manoeuvre, &variations, |_, y| {
                    let u = &k.c * &x + &k.d * y;
                    x = &k.a * &x + &k.b * y;
                    u
                });
                let (frozen, flown) =
                    (frozen.unwrap().rows, law.fly(&inputs.vehicle, &manoeuvre, &variations).unwrap().rows);
                assert!(flown.iter().any(|row| (row.commands[0] - flown[0].commands[0]).abs() > 1.0));
                for (one, other) in flown.iter().zip(frozen) {
                    // The speed, and hence the law, hardly changes.
                    assert!((one.measured(0) - other.measured(0)).abs() < 1e-4, "{delay} {one:?} {other:?}");
                    assert!((one.commands[0] - other.commands[0]).abs() < 0.05, "{delay} {one:?} {other:?}");
                }
            }
        }
    }

    /// A PID flown in place of a controller has its gains: with a reference weight of 0 a step of the reference has no
    /// effect.
    #[test]
    fn pid_flies_with_its_gains() {
        let (inputs, stored) = squid();
        let progress = Progress::default();
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let text = |weight: f64| {
            format!(
                "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = {{ value = 300, unit = \"N.m/rad\" }}\n\
                 kd = {{ value = 300, unit = \"N.m.s/rad\" }}\nreference_weight = {weight}\n[controller.speed]\n\
                 kp = {{ value = 100, unit = \"N.s/m\" }}\n"
            )
        };
        let moved = |weight: f64| {
            let law = Law::pid(&subject, &squid_pid::read_file(&text(weight), "pid").unwrap()).unwrap();
            let manoeuvre = subject.stepped(1.5, (1.0, f64::MAX), 6.0);
            let rows = law.fly(&inputs.vehicle, &manoeuvre, &Variations::default()).unwrap().rows;
            let index = subject.step().index;
            rows.iter().map(|row| (row.measured(index) - rows[0].measured(index)).abs()).fold(0.0, f64::max)
        };
        assert!(moved(0.0) < 1e-3 && moved(1.0) > 0.05, "{} {}", moved(0.0), moved(1.0));
    }
}
