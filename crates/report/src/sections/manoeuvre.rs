//! Default manoeuvre: a step during a speed ramp.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, capital};
use crate::subject::Subject;
use squid_auv::longitudinal::{DEPTH, PITCH, SPEED};
use squid_flight::flight::{Row, fly};

/// Returns the section on the design's manoeuvre: pitch or heading, speed and commands over time.
///
/// # Errors
/// Errors of [`fly`].
pub fn manoeuvre(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (inputs, stored) = (subject.inputs, subject.stored);
    let flight = fly(&inputs.vehicle, &stored.controller, inputs.design.level(), &stored.manoeuvre)?;
    let rows = flight.rows;
    let mut keys = vec![Key::reference("reference"), Key::nth(0, "flown")];
    let series = |key: usize, of: &dyn Fn(&Row) -> f64| Curve {
        key,
        points: rows.iter().map(|r| (r.time, of(r))).collect(),
    };
    let step = subject.step();
    let both = |index: usize, factor: f64| {
        vec![series(0, &|r| factor * r.reference(index)), series(1, &|r| factor * r.measured(index))]
    };
    let drawn = |index: usize, factor: f64| {
        let mut both = both(index, factor);
        both.drain(..usize::from(!stored.controller.has_reference(index)));
        both
    };
    let speed = vec![series(0, &|r| r.reference(SPEED)), series(1, &|r| r.measured(SPEED))];
    let signals = inputs.design.interface.signals;
    let mut charts = vec![
        Chart::over_time("", format!("{} (deg)", signals[PITCH].name), drawn(PITCH, 1f64.to_degrees())),
        Chart::over_time("", "forward speed (m/s)", speed),
    ];
    if !inputs.design.view().is_level_held {
        charts.push(Chart::over_time("", "depth (m)", drawn(DEPTH, 1.0)));
    }
    for (unit, label, factor) in [("N", "thrust (N)", 1.0), ("rad", "deflection (deg)", 1f64.to_degrees())] {
        let own = inputs.vehicle.actuators.iter().enumerate().filter(|(_, a)| a.unit() == unit);
        let curves: Vec<Curve> = own
            .map(|(j, actuator)| {
                keys.push(Key::nth(keys.len() - 1, actuator.name.clone()));
                series(keys.len() - 1, &|r| factor * r.commands[j])
            })
            .collect();
        if !curves.is_empty() {
            charts.push(Chart::over_time("", label, curves));
        }
    }
    let m = &stored.manoeuvre;
    let last = rows.last().map_or(f64::NAN, |r| step.factor * r.error(step.index));
    let off = rows.iter().map(|r| r.error(SPEED).abs()).fold(0.0, f64::max);
    let outside = rows.iter().filter(|r| r.out_of_range).count() as f64 / rows.len() as f64;
    let text = format!(
        "A {} step of {} at {} s while the speed changes from {} to {} m/s within {} s. At the end the {} error is \
            {:.3} {}; the largest speed error is {off:.3} m/s, and the speed is outside the range of the design \
            during {:.1} % of the simulation.",
        step.name,
        step.text(),
        m.step_time,
        m.speed_from,
        m.speed_to,
        m.ramp_duration,
        step.name,
        last.abs(),
        step.unit,
        100.0 * outside
    );
    let early = flight.surfacing.map(|s| format!("{text} The simulation ends early: {s}."));
    let text = early.unwrap_or(text);
    let caption = format!("{}: nonlinear simulation with the sampled autopilot.", capital(&subject.name()));
    let figure = Figure { name: format!("{}-step-on-a-ramp", step.name), caption, keys, charts };
    Ok(vec![Part::Text(text), Part::Figure(figure)])
}
