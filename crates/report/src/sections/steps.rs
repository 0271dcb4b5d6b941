//! Steps of pitch and of speed at six speeds, flown: what is tracked, and every actuator.

use crate::error::Error;
use crate::page::chart::{Chart, Curve};
use crate::page::figure::Figure;
use crate::page::key::Key;
use crate::page::section::Part;
use crate::peers::course::speed_step;
use crate::peers::law::{Scheduled, fly};
use crate::subject::{SHOWN, STEP_TIME, Subject};
use auv::Current;
use signals::{PITCH, SPEED};
use squid_design::numbers::readable;
use squid_flight::flight::{Demand, Flight, Row};

/// The section on steps of each reference.
///
/// # Errors
/// As [`squid_flight::flight::fly`]; [`Error::PitchNotTracked`].
pub fn steps(subject: &Subject) -> Result<Vec<Part>, Error> {
    subject.pitch()?;
    let lft = &subject.stored.controller.lft;
    let pitched =
        subject.speeds.iter().map(|v| subject.fly_step(*v, lft)).collect::<Result<Vec<Flight>, Error>>()?;
    let faster =
        subject.speeds.iter().map(|v| step_speed(subject, *v)).collect::<Result<Vec<Flight>, Error>>()?;
    let degrees = subject.stored.manoeuvre.pitch_step.to_degrees();
    let name = subject.name();
    Ok(vec![
        Part::Words(format!(
            "The nonlinear vehicle with the sampled autopilot, lags and limits of the actuators, from trim.{}{}",
            ends(subject, &pitched, "pitch"),
            ends(subject, &faster, "speed")
        )),
        Part::Figure(Figure {
            name: "pitch-steps".into(),
            caption: format!("Steps of the pitch reference of {name} by {degrees:.0} deg at six speeds."),
            ..figure(subject, &pitched)
        }),
        Part::Figure(Figure {
            name: "speed-steps".into(),
            caption: format!(
                "Steps of the {} of {name} by {:.2} m/s, towards the middle of the range, at six speeds.",
                subject.wanted_speed(),
                speed_step(subject, subject.speeds[0])
            ),
            ..figure(subject, &faster)
        }),
    ])
}

/// Which of the flights end at the surface.
fn ends(subject: &Subject, flown: &[Flight], what: &str) -> String {
    let ends = flown.iter().zip(&subject.speeds).filter_map(|(f, v)| Some((v, f.surfacing?)));
    ends.map(|(v, s)| format!(" In the step of {what} at {v:.2} m/s {s}, and the flight ends there."))
        .collect()
}

/// A step of the speed reference at [`STEP_TIME`].
fn step_speed(subject: &Subject, speed: f64) -> Result<Flight, Error> {
    let step = speed_step(subject, speed);
    let demand = |time: f64| Demand {
        speed: if time + 1e-9 < STEP_TIME { speed } else { speed + step },
        pitch_above_trim: 0.0,
        current: Current::default(),
    };
    let vehicle = &subject.inputs.vehicle;
    let gains = vec![1.0; vehicle.actuators.len()];
    fly(subject, &Scheduled(subject), (vehicle, &gains), (SHOWN, demand))
}

/// Pitch, speed, and the command of each actuator with its limits over time, of a flight at each of the six speeds.
pub fn figure(subject: &Subject, flights: &[Flight]) -> Figure {
    let curves = |of: &dyn Fn(&Row, &Row) -> f64| -> Vec<Curve> {
        let points = |rows: &[Row]| {
            let shown = rows.iter().filter(|r| r.time <= SHOWN);
            shown.map(|r| (r.time, of(r, &rows[0]))).collect()
        };
        flights.iter().enumerate().map(|(key, f)| Curve { key, points: points(&f.rows) }).collect()
    };
    let mut charts = vec![
        Chart::over_time(
            "",
            "pitch from trim (deg)",
            curves(&|r, start| (r.measured(PITCH) - start.measured(PITCH)).to_degrees()),
        ),
        Chart::over_time(
            "",
            "forward speed from trim (m/s)",
            curves(&|r, start| r.measured(SPEED) - start.measured(SPEED)),
        ),
    ];
    for (j, actuator) in subject.inputs.vehicle.actuators.iter().enumerate() {
        let (factor, unit) = readable(actuator.unit());
        let mut drawn = curves(&|r, _| factor * r.commands[j]);
        drawn.extend([actuator.min, actuator.max].map(|limit| Curve {
            key: flights.len(),
            points: vec![(0.0, factor * limit), (SHOWN, factor * limit)],
        }));
        charts.push(Chart::over_time(actuator.name.as_str(), format!("command ({unit})"), drawn));
    }
    let mut keys = subject.speed_keys();
    keys.push(Key::reference("limits"));
    Figure { name: String::new(), caption: String::new(), keys, charts }
}
