//! Comparison of the controller with what a practitioner would use: a gain-scheduled PID, and blended H-infinity
//! controllers.

pub mod beside;
pub mod course;
pub mod law;
pub mod line;
pub mod pid;
pub mod survival;
pub mod tune;

use crate::error::Error;
use crate::page::{Part, Table};
use crate::peers::course::{CourseFigures, fly_at, fly_ramp};
use crate::peers::law::{Blended, Law, Scheduled};
use crate::peers::line::{DRAW, Flights, Line, score};
use crate::peers::survival::{Fleet, fleet, survival};
use crate::peers::tune::{sharpness, tuned};
use crate::subject::Subject;
use crate::threads::in_parallel;
use squid_design::axis::Linearisation;
use squid_design::axis::VehicleModel;
use squid_design::check::flown::Flown;

/// The computational effort of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Evaluations of the optimiser in each search.
    pub evaluations: usize,
    /// Random points of the box, in addition to its vertices.
    pub points: usize,
}

/// The effort for the report.
pub(crate) const ON_THE_PAGE: Effort = Effort { evaluations: 120, points: 10 };

/// The comparison with other control laws at three speeds and on the speed ramp of the manoeuvre.
///
/// # Errors
/// The errors of trim, linearisation and the uncertain model.
pub fn compare(subject: &Subject, effort: Effort) -> Result<Vec<Part>, Error> {
    Ok(parts(subject, &flights(subject, effort, true)?))
}

/// The section on other control laws: [`compare`] with the effort for the report.
///
/// # Errors
/// As [`compare`].
pub(crate) fn peers(subject: &Subject) -> Result<Vec<Part>, Error> {
    Ok(parts(subject, on_the_page(subject)?))
}

/// The flights of the report under the controller of the design, PID and blended controllers; simulated once.
///
/// # Errors
/// [`Error::Flights`].
fn on_the_page<'a>(subject: &'a Subject) -> Result<&'a Flights, Error> {
    let fly = || flights(subject, ON_THE_PAGE, true).map_err(|reason| reason.to_string());
    subject.flights.get_or_init(fly).as_ref().map_err(|reason| Error::Flights { reason: reason.clone() })
}

/// How many rows of the comparison the design wins, draws and loses against the PID that is tuned in flight, in words;
/// or why there is no such PID.
///
/// # Errors
/// As [`compare`].
pub fn against_pid(subject: &Subject) -> Result<String, Error> {
    Ok(match flights(subject, ON_THE_PAGE, false)? {
        Ok((_, lines)) => score(&lines, 1, "a PID that is tuned in flight", "the design"),
        Err(reason) => reason,
    })
}

fn flights(subject: &Subject, effort: Effort, with_blended: bool) -> Result<Flights, Error> {
    let speeds = speeds(subject);
    let pid = match tuned(subject, &speeds, effort.evaluations)? {
        Ok(pid) => pid,
        Err(reason) => return Ok(Err(format!("No PID was tuned: {reason}."))),
    };
    let (ours, blended) = (Scheduled(subject), with_blended.then(|| Blended::new(subject)).flatten());
    let mut laws: Vec<(&'static str, &dyn Law)> = vec![("scheduled", &ours), ("PID", &pid)];
    laws.extend(blended.as_ref().map(|blended| ("blended H-infinity", blended as &dyn Law)));
    let mut lines = vec![];
    for speed in speeds {
        lines.extend(at_speed(subject, &laws, speed, &fleet(subject, speed, effort.points)?)?);
        subject.progress.done("report", &format!("  compared at {speed:.2} m/s"));
    }
    lines.extend(on_ramp(subject, &laws));
    Ok(Ok((laws.iter().map(|(name, _)| *name).collect(), lines)))
}

fn parts(subject: &Subject, flights: &Flights) -> Vec<Part> {
    let (laws, lines) = match flights {
        Ok(found) => found,
        Err(reason) => return vec![Part::Words(reason.clone())],
    };
    let mut table = Table::new(["", "m/s"]);
    table.head.extend(laws.iter().map(|name| (*name).to_owned()));
    table.head.extend(laws[1..].iter().map(|name| format!("against {name}")));
    table.rows = lines.iter().map(Line::row).collect();
    let scores: Vec<String> =
        (1..laws.len()).map(|i| score(lines, i, laws[i], "the scheduled controller")).collect();
    vec![Part::Words(words(subject)), Part::Table(table), Part::Words(scores.join(" "))]
}

/// Both ends of the speed ramp of the manoeuvre and the middle.
fn speeds(subject: &Subject) -> [f64; 3] {
    let m = &subject.stored.manoeuvre;
    let (low, high) = match (m.speed_from.min(m.speed_to), m.speed_from.max(m.speed_to)) {
        (low, high) if low < high => (low, high),
        _ => (subject.inputs.design.speed_min, subject.inputs.design.speed_max),
    };
    [low, 0.5 * (low + high), high]
}

fn words(subject: &Subject) -> String {
    let (axes, speed_step) = if subject.speed_is_given() {
        ("; the speed is given, to all alike", "a step of the given speed, not judged")
    } else {
        (", and PI of the speed", "a speed step")
    };
    format!(
        "The same nonlinear vehicle, sensors, sample time, lags, limits, trim feedforward and filtered {} under three \
            laws. PID: of pitch, with derivative on the measured rate and a weight on the reference{axes}, gains \
            scheduled on speed, integrals that stop at limits; tuned at the three speeds by COBYLA (M. J. D. Powell, \
            1994) over the flights of this table, with |S| no larger and commands under noise no rougher than the \
            scheduled controller's at that speed. Blended: H-infinity controllers of the same weights for six speeds, \
            all running, outputs blended by speed. Flights: a pitch step of {} deg, a gust of 0.3 m/s in heave, \
            {speed_step}; ITAE is the integral of t |error|/step, of the error to the reference itself, not to a model \
            of it. Box: the declared uncertainty, vehicles at corners and random points; one survives if its pitch is \
            within a tenth of the step at the end; overshoot is the worst of those. Rows closer than {:.0} % are \
            drawn, those without outcome are not compared.",
        subject.wanted_speed(),
        squid_auv::rounded(subject.stored.manoeuvre.step("pitch").to_degrees()),
        100.0 * DRAW
    )
}

/// The rows at one speed; the vehicles of the box are those of `fleet`.
fn at_speed(
    subject: &Subject,
    laws: &[(&str, &dyn Law)],
    speed: f64,
    fleet: &Fleet,
) -> Result<Vec<Line>, Error> {
    let l = subject.inputs.axis().linearise(speed)?;
    let judged = |(_, law): &(&str, &dyn Law)| -> Result<_, Error> {
        let lives = survival(subject, *law, speed, fleet);
        let sharp = sharpness(subject, *law, &l);
        Ok((fly_at(subject, *law, speed)?, sharp, delay(subject, *law, &l), lives))
    };
    let found = in_parallel(laws.iter(), judged).into_iter().collect::<Result<Vec<_>, Error>>()?;
    let of_flight = |of: fn(&CourseFigures) -> f64| found.iter().map(|f| of(&f.0)).collect::<Vec<f64>>();
    let of_loop = |of: fn(&tune::Sharpness) -> f64| {
        found.iter().map(|f| f.1.as_ref().map_or(f64::INFINITY, of)).collect::<Vec<f64>>()
    };
    let at = format!("{speed:.2}");
    let line = |name, decimals, slight, values| Line::new(name, &at, decimals, slight, values);
    let tick = subject.inputs.design.sample_time;
    let mut lines = vec![
        line("pitch step: ITAE (s^2)", 2, 0.0, of_flight(|f| f.pitch.itae)),
        line("pitch step: settled (s)", 2, tick, of_flight(|f| f.pitch.settling_time)),
        line("pitch step: overshoot (%)", 2, 0.5, of_flight(|f| 100.0 * f.pitch.overshoot)),
        line("speed step: ITAE (s^2)", 2, 0.0, of_flight(|f| f.speed.itae)),
        line("speed step: settled (s)", 2, tick, of_flight(|f| f.speed.settling_time)),
        line("speed step: overshoot (%)", 2, 0.5, of_flight(|f| 100.0 * f.speed.overshoot)),
        line("gust: peak of pitch (deg)", 2, 0.0, of_flight(|f| f.gust.to_degrees())),
        Line {
            reported: true,
            ..line("largest command (% of the way to a limit)", 0, 0.0, of_flight(|f| 100.0 * f.effort))
        },
        Line { reported: true, ..line("peak of |S|", 2, 0.0, of_loop(|s| s.peak)) },
        line("commands under noise, rms (% of reach)", 2, 0.0, of_loop(|s| 100.0 * s.roughness)),
        Line {
            largest: true,
            ..line("delay margin, all commands (s)", 3, 0.0, found.iter().map(|f| f.2).collect())
        },
    ];
    if subject.speed_is_given() {
        lines.retain(|line| !line.is_of_speed());
    }
    if !fleet.is_empty() {
        let share = found.iter().map(|f| 100.0 * f.3.share).collect();
        lines.push(Line { largest: true, ..line("box survived (%)", 0, 0.0, share) });
        let overshoot = found.iter().map(|f| 100.0 * f.3.overshoot).collect();
        lines.push(line("box: worst overshoot (%)", 1, 0.5, overshoot));
    }
    Ok(lines)
}

/// The delay margin of a law frozen at the speed of a trim, all commands at once; 0 for an unstable loop.
fn delay(subject: &Subject, law: &dyn Law, l: &Linearisation) -> f64 {
    let sampling = subject.sampling();
    let flown = law.frozen(l.trim.speed).map(|k| sampling.held(l).injected(&k));
    flown.and_then(|system| Flown::of_sampled(&sampling, &system)).map_or(0.0, |flown| flown.common_delay)
}

/// The rows for the speed ramp.
fn on_ramp(subject: &Subject, laws: &[(&str, &dyn Law)]) -> Vec<Line> {
    let flown: Vec<_> = laws.iter().map(|(_, law)| fly_ramp(subject, *law)).collect();
    let line = |name, decimals, slight, values| Line::new(name, "ramp", decimals, slight, values);
    let tick = subject.inputs.design.sample_time;
    let mut lines = vec![
        line("pitch step: ITAE (s^2)", 2, 0.0, flown.iter().map(|f| f.0.itae).collect()),
        line("pitch step: settled (s)", 2, tick, flown.iter().map(|f| f.0.settling_time).collect()),
        line("pitch step: overshoot (%)", 2, 0.5, flown.iter().map(|f| 100.0 * f.0.overshoot).collect()),
    ];
    if !subject.speed_is_given() {
        lines.push(line("largest speed error (m/s)", 3, 0.0, flown.iter().map(|f| f.1).collect()));
    }
    lines
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use squid_design::inputs::Inputs;
    use squid_design::store::{Stored, load};
    use std::path::Path;

    /// The committed design of Squid.
    pub(crate) fn squid() -> (Inputs, Stored) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let stored = load(&folder.join("frozen"), &inputs).unwrap();
        (inputs, stored)
    }

    /// At one speed and away from limits, each running law equals its frozen system.
    #[test]
    fn running_laws_equal_their_frozen_systems() {
        let (inputs, stored) = squid();
        let progress = squid_base::progress::Progress::default();
        let mut subject = Subject::new(&inputs, &stored, &progress).unwrap();
        // Two neighbours are enough for a blend.
        subject.speeds = vec![subject.speeds[0], subject.speeds[5]];
        let gains =
            |k: f64| pid::Gains { pitch: [2.0 * k, 0.3 * k, 3.0], weight: 0.8, speed: [1.0 + k, 0.2] };
        let at = [(&subject.truth[0], gains(1.0)), (&subject.truth[5], gains(3.0))];
        let pid = pid::Pid::new(&subject, &at).unwrap();
        let blended = Blended::new(&subject).unwrap();
        let speed = 1.3;
        for law in [&pid as &dyn Law, &blended] {
            let k = law.frozen(speed).unwrap();
            let (mut tick, mut x) = (law.start().unwrap(), squid_lpv::matrix::Mat::zeros(k.a.nrows(), 1));
            let limits = vec![(f64::NEG_INFINITY, f64::INFINITY); 3];
            for step in 0..50 {
                let y: Vec<f64> =
                    (0..5).map(|i| (0.3 * f64::from(step) + 1.7 * f64::from(i)).sin()).collect();
                let u = tick(speed, &y, &limits);
                let y = squid_lpv::matrix::Mat::from_column_slice(5, 1, &y);
                let expected = &k.c * &x + &k.d * &y;
                x = &k.a * &x + &k.b * &y;
                for (found, expected) in u.iter().zip(expected.iter()) {
                    assert!(
                        (found - expected).abs() < 1e-9 * expected.abs().max(1.0),
                        "{step}: {found} {expected}"
                    );
                }
            }
        }
    }

    /// The stored controller as a law, frozen at the speed of the flight, acts as the autopilot does, also with delayed
    /// commands.
    #[test]
    fn a_law_has_the_delay_of_the_autopilot() {
        struct Frozen<'a>(&'a Subject<'a>);
        impl Law for Frozen<'_> {
            fn frozen(&self, speed: f64) -> Option<squid_lpv::state_space::StateSpace> {
                Scheduled(self.0).frozen(speed)
            }
            fn start(&self) -> Option<law::RunningLaw<'_>> {
                let k = self.frozen(self.0.speeds[2])?;
                let mut x = squid_lpv::matrix::Mat::zeros(k.a.nrows(), 1);
                Some(Box::new(move |_, y, _| {
                    let y = squid_lpv::matrix::Mat::from_column_slice(y.len(), 1, y);
                    let u = &k.c * &x + &k.d * &y;
                    x = &k.a * &x + &k.b * &y;
                    u.as_slice().to_vec()
                }))
            }
        }
        let (inputs, mut stored) = squid();
        for delay in [0, 3] {
            stored.controller.delay_ticks = delay;
            let progress = squid_base::progress::Progress::default();
            let subject = Subject::new(&inputs, &stored, &progress).unwrap();
            let fly = |law: &dyn Law| {
                let demand = |time: f64| squid_flight::flight::Demand {
                    speed: subject.speeds[2],
                    above_trim: squid_auv::only(
                        squid_auv::longitudinal::PITCH,
                        if time < 1.0 { 0.0 } else { 0.01 },
                    ),
                    disturbance: squid_flight::flight::Disturbance::default(),
                };
                let course = squid_flight::flight::Course { duration: 6.0, demand };
                law::fly(&subject, law, &inputs.vehicle, &[1.0; 3], course).unwrap().rows
            };
            for (one, other) in fly(&Scheduled(&subject)).iter().zip(fly(&Frozen(&subject))) {
                // The speed, and with it the scheduled controller, hardly changes.
                assert!((one.measured(0) - other.measured(0)).abs() < 1e-4, "{delay} {one:?} {other:?}");
                assert!((one.commands[0] - other.commands[0]).abs() < 0.05, "{delay} {one:?} {other:?}");
            }
        }
    }

    /// With every command at its upper limit the integrals are held, and leave as soon as the error changes sign.
    #[test]
    fn the_integrals_stop_at_a_limit() {
        let (inputs, stored) = squid();
        let progress = squid_base::progress::Progress::default();
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let gains = pid::Gains { pitch: [0.0, 1.0, 0.0], weight: 1.0, speed: [0.0, 1.0] };
        let pid = pid::Pid::new(&subject, &[(&subject.truth[2], gains)]).unwrap();
        let mut tick = pid.start().unwrap();
        // y = [pitch reference, speed reference, pitch, speed, pitch rate]: only the speed is too low.
        let slow = [0.0, 0.0, 0.0, -1.0, 0.0];
        let free = [(-1.0, 1.0); 3];
        (0..200).for_each(|_| drop(tick(1.5, &slow, &free)));
        let held = tick(1.5, &slow, &[(-1.0, 0.0); 3]);
        (0..200).for_each(|_| drop(tick(1.5, &slow, &[(-1.0, 0.0); 3])));
        assert_eq!(held, tick(1.5, &slow, &[(-1.0, 0.0); 3]));
        let fast = [0.0, 0.0, 0.0, 1.0, 0.0];
        tick(1.5, &fast, &[(-1.0, 0.0); 3]);
        assert!(tick(1.5, &slow, &free)[0] < held[0]);
    }

    /// The tuned PID meets its constraints.
    #[test]
    fn the_tuned_pid_is_no_sharper_and_no_rougher() {
        let (inputs, stored) = squid();
        let progress = squid_base::progress::Progress::default();
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let speed = subject.truth[3].trim.speed;
        let pid = tuned(&subject, &[speed], 25).unwrap().unwrap();
        let (ours, found) = (Scheduled(&subject), sharpness(&subject, &pid, &subject.truth[3]).unwrap());
        let limits = sharpness(&subject, &ours, &subject.truth[3]).unwrap();
        assert!(found.peak <= 1.0002 * limits.peak && found.roughness <= 1.0002 * limits.roughness);
        assert!(fly_at(&subject, &pid, speed).unwrap().pitch.settling_time < 10.0);
    }
}
