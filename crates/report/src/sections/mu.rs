//! Bounds on mu for robust stability over frequency, at six speeds.

mod at_speed;
mod worst_gain;

use crate::error::Error;
use crate::page::{Axis, Chart, Curve, Figure, Key, Part, Table};
use crate::sections::robust::{between, vehicle};
use crate::subject::{MuBounds, Subject};
use crate::threads::in_parallel;
use at_speed::{Change, DECADES, SpeedMu};
use squid_design::error::{Error as DesignError, UncertainError};
use worst_gain::PARTS;

/// Number of speeds per panel.
const IN_A_PANEL: usize = 3;
/// Smallest share in the instability of a listed parameter.
const NAMED: f64 = 0.1;
/// Returns the section on mu: bounds for robust stability over frequency, and worst-case gains, at six speeds.
///
/// # Errors
/// Errors of [`SpeedMu::new`].
pub fn mu(subject: &Subject) -> Result<Vec<Part>, Error> {
    let (mut found, mut without) = (vec![], vec![]);
    for at in at_all_speeds(subject) {
        match at {
            Ok(at) => found.push(at),
            Err(Error::Design(DesignError::Uncertain(UncertainError::NothingUncertain { design }))) => {
                return Ok(vec![Part::Words(format!(
                    "{design} declares no uncertainty, so that there is nothing to analyse: a section \
                         [uncertainty] in it names coefficients with their ranges."
                ))]);
            }
            Err(reason) => without.push(reason),
        }
    }
    if found.is_empty()
        && let Some(reason) = without.pop()
    {
        return Err(reason);
    }
    let mut parts = vec![Part::Words(about(&found, subject.inputs.design.lags))];
    let missing = without.iter().map(|reason| Part::Words(format!("One speed is missing below: {reason}.")));
    parts.extend(missing);
    parts.extend([
        Part::Figure(figure(subject, &found)),
        Part::Table(table(&found)),
        Part::Words(about_vehicles()),
        Part::Table(vehicles_table(&found)),
        Part::Table(causes_table(&found)),
        Part::Words(about_gain()),
        Part::Table(gain_table(&found)),
    ]);
    if without.is_empty() {
        subject.mu.get_or_init(|| bounds(&found));
    }
    Ok(parts)
}

/// Analyses all speeds in parallel.
fn at_all_speeds(subject: &Subject) -> Vec<Result<SpeedMu, Error>> {
    in_parallel(subject.speeds.iter(), |speed| {
        let analysis = SpeedMu::new(subject, *speed);
        subject.progress.done("report", &format!("  mu at {speed:.2} m/s"));
        analysis
    })
}

fn bounds(found: &[SpeedMu]) -> Vec<MuBounds> {
    let of = |f: &SpeedMu| MuBounds {
        speed: f.speed,
        guaranteed: f.guaranteed(),
        vehicle: f.vehicle[0].map_or(f64::NAN, f64::recip),
    };
    found.iter().map(of).collect()
}

fn about(found: &[SpeedMu], has_lags: bool) -> String {
    let lags = if has_lags { "with" } else { "without" };
    let (parameters, channels) = found.iter().map(|f| f.size).max().unwrap_or((0, 0));
    format!(
        "mu is one over the size of the smallest perturbation that destabilises the loop of the linear model \
            and the controller, both frozen at a speed; 1 is the uncertainty that the design file declares. \
            It is up to {parameters} real \
            parameters in {channels} channels: coefficients with their relative errors, the gain of each \
            actuator, and how far all that moves the trim. The coefficients enter exactly, the trim to first \
            order. The upper bound of the table holds at every frequency from zero to infinity, between the \
            points of the curves as well; each lower bound is shown by a perturbation of the model, with which \
            its loop has a pole on the axis. In the model the incidence, which moves the trim, is an \
                 independent parameter; the next table is about vehicles, whose trim follows from their \
                 coefficients. Figure and first table are of the loop in continuous time, as it was designed: {lags} \
            the lags of the actuators. The bounds are for constant perturbations at a constant speed; a \
                 changing speed is covered by the certificate."
    )
}

fn figure(subject: &Subject, found: &[SpeedMu]) -> Figure {
    let mut keys = subject.speed_keys();
    let dots = keys.len();
    keys.extend(subject.speed_keys().into_iter().map(|key| Key { name: String::new(), ..key }.dotted()));
    keys.push(Key::reference("mu = 1"));
    let shown = [DECADES.0, DECADES.1].map(|k| 10f64.powi(k));
    let highest = found.iter().map(SpeedMu::guaranteed).fold(1.0, f64::max);
    let chart = |speeds: &[f64]| {
        let mut curves = vec![Curve { key: keys.len() - 1, points: shown.map(|o| (o, 1.0)).to_vec() }];
        for f in found.iter().filter(|f| speeds.contains(&f.speed)) {
            let key = subject.speeds.iter().position(|v| *v == f.speed).unwrap_or(0);
            curves.push(Curve { key, points: f.upper.clone() });
            let inside = |&(omega, value): &(f64, f64)| (omega.clamp(shown[0], shown[1]), value);
            let lower = f.lower.iter().map(inside).collect();
            curves.push(Curve { key: dots + key, points: lower });
        }
        let ends = [speeds.first(), speeds.last()].map(|v| v.map_or(f64::NAN, |v| *v));
        let title = format!("{:.2} to {:.2} m/s", ends[0], ends[1]);
        Chart::over_frequency(title, Axis::linear("mu (-)").over(0.0, 1.06 * highest), curves)
    };
    let charts = subject.speeds.chunks(IN_A_PANEL).map(chart).collect();
    Figure {
        name: "fig7-mu-bounds".into(),
        caption: format!(
            "mu for robust stability of {} with the controller frozen at six speeds. Curves: upper bounds; \
                dots of the same colour: lower bounds, each shown by a perturbation at that very \
                frequency (at the left edge: at frequency zero, which has no place on the axis and where the \
                upper bound, too, may be above the curve). For real parameters a lower bound is found at some \
                frequencies and not at others.",
            subject.name()
        ),
        keys,
        charts,
    }
}

fn table(found: &[SpeedMu]) -> Table {
    let mut table = Table::new([
        "speed (m/s)",
        "mu below",
        "peak (rad/s)",
        "mu at least",
        "at (rad/s)",
        "model stable up to",
        "model unstable at",
    ]);
    for f in found {
        let lower = f.bounds.lower.as_ref();
        let number =
            |v: Option<f64>, unit: &str| v.map_or_else(|| "none found".into(), |v| format!("{v:.3}{unit}"));
        table.rows.push(vec![
            format!("{:.2}", f.speed),
            format!("{:.3}", f.guaranteed()),
            format!("{:.2}", f.peak),
            number(f.shown(), ""),
            lower.and_then(|l| l.frequency).map_or_else(String::new, |o| format!("{o:.2}")),
            format!("{:.0} %", 100.0 / f.guaranteed()),
            f.shown().map_or_else(|| "none found".into(), |v| format!("{:.0} %", 100.0 / v)),
        ]);
    }
    table
}

fn about_vehicles() -> String {
    "The same for vehicles, as the loop flies, with the lags of the actuators and sampled, and in continuous \
        time, as it was designed. The perturbation of the model, without its part of the trim, is increased \
             step by step; the vehicle with its coefficients and actuator gains is trimmed again (within \
             the limits of its actuators) and linearised. This is one direction only: another vehicle may \
             be unstable with smaller errors."
        .into()
}

fn vehicles_table(found: &[SpeedMu]) -> Table {
    let mut table =
        Table::new(["speed (m/s)", "vehicle found unstable at, as it flies", "in continuous time"]);
    for f in found {
        let size =
            |size: Option<f64>| size.map_or_else(|| "none found".into(), |v| format!("{:.0} %", 100.0 * v));
        table.rows.push(vec![format!("{:.2}", f.speed), size(f.vehicle[0]), size(f.vehicle[1])]);
    }
    table
}

fn causes_table(found: &[SpeedMu]) -> Table {
    let mut table =
        Table::new(["speed (m/s)", "the largest parts of the destabilising perturbation, and their shares"]);
    table.rows = found.iter().map(|f| vec![format!("{:.2}", f.speed), causes(&f.worst)]).collect();
    table
}

fn about_gain() -> String {
    format!(
        "The worst-case gain says what is left of performance: the largest gain of the loop in continuous time \
            from w to z, of which the gamma of the design is a bound, with \
         constant coefficients anywhere in the part of the declared uncertainty at the head of the column ({} % \
         is all of it). Of two numbers the first is reached by a perturbation, the \
         second is guaranteed at every frequency, both for the model, in which the incidence is an \
         independent parameter. 'Vehicle': the gain of a vehicle with the coefficients \
         and gains of actuators of the perturbation, trimmed again. 'No bound': at that size the loop is \
         not shown to stay stable.",
        100.0 * PARTS[PARTS.len() - 1]
    )
}

fn gain_table(found: &[SpeedMu]) -> Table {
    let mut table = Table::new(["speed (m/s)", "gain at no uncertainty"]);
    for part in PARTS {
        table.head.push(format!("worst case at {:.0} %: model", 100.0 * part));
        table.head.push(format!("at {:.0} %: vehicle", 100.0 * part));
    }
    for f in found {
        let mut row = vec![format!("{:.2}", f.speed), format!("{:.3}", f.gain.nominal)];
        for (model, own) in f.gain.at.into_iter().zip(f.gain.vehicle) {
            row.extend([between(model), vehicle(own)]);
        }
        table.rows.push(row);
    }
    table
}

/// Returns the parameters with the largest shares, in decreasing order.
fn causes(worst: &[Change]) -> String {
    let named = worst.iter().filter(|c| c.share >= NAMED);
    named.map(|c| format!("{} {} ({:.0} %)", c.name, c.by, 100.0 * c.share)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_only_large_shares() {
        let change = |name: &str, share| Change { name: name.into(), by: "+40 %".into(), share };
        assert_eq!(causes(&[change("M_uw", 0.62), change("Z_w", 0.05)]), "M_uw +40 % (62 %)");
    }
}
