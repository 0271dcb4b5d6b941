//! Open-loop response of the paper's Fig. 6.

use crate::claims::{Claim, Found, each_smaller};
use squid_auv::readable;
use squid_flight::flight::{ActuatorStep, fly_open_loop};
use squid_flight::metrics::SETTLED;
use squid_report::error::Error;
use squid_report::page::{Axis, Chart, Curve, Figure, Part, Table, capital, known};
use squid_report::subject::{FLOWN, STEP_TIME, Subject};

/// Step of the actuator relative to its reach.
const STEP: f64 = 0.02;
/// Number of speeds shown by the paper: the lower half of its six.
const SHOWN_SPEEDS: usize = 3;
/// Largest pitch drawn (deg): an unstable vehicle turns over.
const LARGEST_PITCH: f64 = 90.0;

/// Computes the section on Fig. 6: the step response of the vehicle without controller at the three lower speeds.
///
/// # Errors
/// The errors of [`fly_open_loop`] and [`squid_flight::flight::fly`].
pub fn open_loop(subject: &Subject) -> Result<Found, Error> {
    let (index, actuator) = subject.turning_actuator();
    let step = STEP * actuator.reach();
    let (factor, unit) = readable(actuator.unit());
    let (mut curves, mut pairs) = (Vec::new(), Vec::new());
    let mut table = Table::new([
        "speed (m/s)",
        "open loop: settled to 2 % (s)",
        "closed loop: settled (s)",
        "open loop: largest real part (rad/s)",
    ]);
    for (i, speed) in subject.speeds.iter().copied().take(SHOWN_SPEEDS).enumerate() {
        let points = alone(subject, speed, index, step)?;
        let flight = subject.fly_step(speed, &subject.stored.controller)?;
        let closed = subject.figures(&flight).settling_time;
        // A vehicle that surfaces first might have settled, or not.
        let surfaced = points.last().is_some_and(|p| p.0 < FLOWN - 0.5 * STEP_TIME);
        let open = if surfaced { f64::NAN } else { settling_time(&points) };
        let slowest = subject.truth[i].eigenvalues().iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max);
        table.rows.push(vec![
            format!("{speed:.2}"),
            if surfaced { "reaches the surface".into() } else { known(open, 2) },
            known(closed, 2),
            format!("{slowest:+.3}"),
        ]);
        pairs.push((closed, open));
        curves.push(Curve { key: i, points });
    }
    let low = curves.iter().flat_map(|c| &c.points).map(|p| p.1).fold(0.0, f64::min).max(-LARGEST_PITCH);
    let high = curves.iter().flat_map(|c| &c.points).map(|p| p.1).fold(0.0, f64::max).min(LARGEST_PITCH);
    let padding = 0.06 * (high - low) + 1e-6;
    let y = Axis::linear("pitch from trim (deg)").over(low - padding, high + padding);
    let figure = Figure {
        name: "fig6-open-loop".into(),
        caption: format!(
            "{} in open loop after a step of {} by {:.2} {unit}, nonlinear.",
            capital(&subject.name()),
            actuator.name,
            factor * step
        ),
        keys: subject.speed_keys().into_iter().take(SHOWN_SPEEDS).collect(),
        charts: vec![Chart { y, ..Chart::over_time("", "", curves) }],
    };
    Ok((vec![Part::Figure(figure), Part::Table(table)], vec![claim(&pairs)]))
}

fn claim(pairs: &[(f64, f64)]) -> Claim {
    let faster = pairs.iter().filter(|(closed, open)| closed < open).count();
    Claim {
        claim: "compared with the open-loop vehicle (Fig. 6), the responses of the closed loop are fast (section 4).",
        criterion: format!(
            "the pitch step of the closed loop settles to {:.0} % sooner than the open-loop vehicle after a step of \
                its actuator, within {FLOWN} s, at each of the {} speeds.",
            100.0 * SETTLED,
            pairs.len()
        ),
        finding: each_smaller(pairs),
        because: format!(
            "The closed loop is faster at {faster} of {} speeds; the times are in the table.",
            pairs.len()
        ),
    }
}

/// Time (s) and pitch from trim (deg) of the vehicle alone.
fn alone(subject: &Subject, speed: f64, index: usize, step: f64) -> Result<Vec<(f64, f64)>, Error> {
    let (interval, level) = (subject.stored.controller.sample_time, subject.inputs.design.level());
    let step = ActuatorStep { actuator: index, height: step };
    let rows = fly_open_loop(
        &subject.inputs.vehicle,
        subject.inputs.design.view(),
        level,
        speed,
        step,
        interval,
        FLOWN,
    )?;
    Ok(rows.iter().map(|(t, pitch)| (*t, pitch.to_degrees())).collect())
}

/// Time until pitch stays within 2 % of its final value; infinite if that is only in the last fifth of the record, or
/// if the vehicle turned over.
fn settling_time(points: &[(f64, f64)]) -> f64 {
    let Some(&(duration, end)) = points.last() else { return f64::NAN };
    let outside = |p: &(f64, f64)| (p.1 - end).abs() > SETTLED * end.abs();
    let turned = points.iter().any(|p| p.1.abs() > LARGEST_PITCH);
    let settled = points.iter().rposition(outside).map_or(0.0, |i| points[i].0);
    if turned || settled > 0.8 * duration { f64::INFINITY } else { settled }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::Finding;

    /// The response 1 - exp(-t) is within 2 % of its end after ln 50 = 3.91 s; a growing oscillation never is.
    #[test]
    fn settling_of_known_responses() {
        let record = |of: fn(f64) -> f64| {
            (0..6000).map(|i| 0.01 * f64::from(i)).map(|t| (t, of(t))).collect::<Vec<_>>()
        };
        assert!((settling_time(&record(|t| 1.0 - (-t).exp())) - 50f64.ln()).abs() < 0.02);
        assert_eq!(settling_time(&record(|t| (0.1 * t).exp() * t.sin())), f64::INFINITY);
        assert_eq!(settling_time(&record(|t| if t < 1.0 { 100.0 } else { 1.0 })), f64::INFINITY);
    }

    #[test]
    fn claim_follows_settling_times() {
        assert_eq!(claim(&[(5.0, f64::INFINITY), (4.0, 9.0)]).finding, Finding::Confirmed);
        assert_eq!(claim(&[(9.0, 5.0)]).finding, Finding::NotConfirmed);
    }
}
