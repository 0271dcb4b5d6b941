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
                return Ok(vec![Part::Text(format!(
                    "{design} declares no uncertainty, so there is nothing to analyse; a table [uncertainty] lists \
                         coefficients with their ranges."
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
    let mut parts = vec![Part::Text(about(&found, subject.inputs.design.lags))];
    let missing = without.iter().map(|reason| Part::Text(format!("One speed is missing below: {reason}.")));
    parts.extend(missing);
    parts.extend([
        Part::Figure(figure(subject, &found)),
        Part::Table(table(&found)),
        Part::Text(about_vehicles()),
        Part::Table(vehicles_table(&found)),
        Part::Table(causes_table(&found)),
        Part::Text(about_gain()),
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
        "mu is the inverse of the size of the smallest perturbation that destabilises the loop of the linear model \
            and the controller, both frozen at a speed; size 1 is the uncertainty declared in the design file. It \
            consists of up to {parameters} real parameters in {channels} channels: coefficients with their relative \
            errors, the gain of each actuator, and the resulting change of the trim. The coefficients enter exactly, \
            the trim to first order. The upper bounds in the table hold at every frequency from zero to infinity, \
            also between the points of the curves; each lower bound is attained by a perturbation of the model that \
            places a pole of the loop on the imaginary axis. In the model the incidence, which determines the trim, \
            is an independent parameter; the next table is about vehicles, whose trim follows from their \
            coefficients. The figure and the first table apply to the loop in continuous time, as designed: {lags} \
            the lags of the actuators. The bounds are for constant perturbations at a constant speed; the \
            certificate covers a changing speed."
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
            "mu for robust stability of {} with the controller frozen at six speeds. Curves: upper bounds; dots of \
                the same colour: lower bounds, each attained by a perturbation at this frequency (dots at the left \
                edge are at frequency zero, which is not on the axis and where the upper bound may also be above the \
                curve). For real parameters lower bounds are found at some frequencies only.",
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
    "The same for vehicles, for the loop as implemented, sampled and with the lags of the actuators, and in \
        continuous time, as designed. The perturbation of the model, without its trim part, is increased step by \
        step; the vehicle with these coefficients and actuator gains is trimmed again (within the limits of its \
        actuators) and linearised. This is a single direction: another vehicle may be unstable with smaller errors."
        .into()
}

fn vehicles_table(found: &[SpeedMu]) -> Table {
    let mut table =
        Table::new(["speed (m/s)", "vehicle found unstable at, as implemented", "in continuous time"]);
    for f in found {
        let size =
            |size: Option<f64>| size.map_or_else(|| "none found".into(), |v| format!("{:.0} %", 100.0 * v));
        table.rows.push(vec![format!("{:.2}", f.speed), size(f.vehicle[0]), size(f.vehicle[1])]);
    }
    table
}

fn causes_table(found: &[SpeedMu]) -> Table {
    let mut table = Table::new([
        "speed (m/s)",
        "largest components of the destabilising perturbation, with their shares",
    ]);
    table.rows = found.iter().map(|f| vec![format!("{:.2}", f.speed), causes(&f.worst)]).collect();
    table
}

fn about_gain() -> String {
    format!(
        "The worst-case gain measures the remaining performance: the largest gain of the loop from w to z in \
            continuous time, which the gamma of the design bounds nominally, over all constant coefficients in the \
            fraction of the declared uncertainty given at the head of the column ({} % is all of it). The first of \
            two numbers is attained by a perturbation, the second is guaranteed at every frequency, both for the \
            model, in which the incidence is an independent parameter. 'Vehicle': the gain of a vehicle with the \
            coefficients and actuator gains of the perturbation, trimmed again. 'No bound': stability is not shown \
            at this size.",
        100.0 * PARTS[PARTS.len() - 1]
    )
}

fn gain_table(found: &[SpeedMu]) -> Table {
    let mut table = Table::new(["speed (m/s)", "nominal gain"]);
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
