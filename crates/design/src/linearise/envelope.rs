//! Envelope: the motions that the vehicle can hold, over the speeds of the trim table.
//!
//! ```text
//! pitch:  the largest theta up and down for which a steady climb or dive at the forward speed of the trim exists,
//!         with every actuator within authority times its limits, there and on the way from level flight
//! depth:  z' = w cos(theta) - u sin(theta) at the largest such theta whose path is no steeper than path_angle
//! speed:  V' by outputs of least effort that push along the hull without pitching, up to the limits; the least of all
//!         speeds
//! ```
//!
//! The boundary of pitch is found by steps and bisection along the branch of climbs that begins in level flight.

use crate::error::ModelError;
use crate::findings::step_limited;
use crate::inputs::design_file::{DesignFile, Envelope};
use rayon::prelude::*;
use squid_auv::longitudinal::{DEPTH, PITCH, SIGNALS, SPEED, turn_rate};
use squid_auv::{Actuator, Trim, Vehicle, climb, linearise};
use squid_base::numbers::decimals;
use squid_finding::Finding;
use squid_lpv::matrix::{Mat, pseudo_inverse};
use squid_scheduled::{ControllerDesign, Manoeuvre, OverSpeed, ReferenceLimits};
use std::collections::BTreeMap;

/// First and last step in pitch, rad.
const STEPS: [f64; 2] = [0.03, 1e-4];

/// Change of the incidence relative to that of pitch above which it is a jump to another branch.
const JUMP: f64 = 4.0;

/// Fraction of the largest singular value below which singular values count as zero.
const RANK: f64 = 1e-9;

/// Returns the limits of the references, at the speeds of these level trims.
///
/// # Errors
/// [`ModelError::Trim`].
pub fn envelope(
    vehicle: &Vehicle,
    file: &DesignFile,
    trims: &[Trim],
) -> Result<BTreeMap<String, ReferenceLimits>, ModelError> {
    let bounds = &file.envelope;
    let each = |trim: &Trim| Limits::at(vehicle, bounds, trim);
    let rows: Vec<Limits> = trims.par_iter().map(each).collect::<Result<_, _>>()?;
    let columns = |of: fn(&Limits) -> [f64; 2]| {
        let column = |end: usize| rows.iter().map(|row| of(row)[end]).collect::<Vec<f64>>();
        [column(0), column(1)]
    };
    let tracked = |index: usize| file.tracked.iter().any(|t| t.index == index);
    let mut all = BTreeMap::new();
    let mut add = |index: usize, limits: ReferenceLimits| {
        all.insert(SIGNALS[index].name.to_owned(), limits);
    };
    if tracked(PITCH) {
        let range = columns(|row| row.pitch).map(OverSpeed::from);
        add(PITCH, ReferenceLimits { range: Some(range), rate: None });
    }
    if tracked(DEPTH) {
        let rate = columns(|row| row.sinking).map(OverSpeed::from);
        add(DEPTH, ReferenceLimits { range: None, rate: Some(rate) });
    }
    if !vehicle.coefficients.surge.is_given() {
        let [least, most] = columns(|row| row.acceleration);
        let rate = [
            least.into_iter().fold(f64::NEG_INFINITY, f64::max),
            most.into_iter().fold(f64::INFINITY, f64::min),
        ];
        add(SPEED, ReferenceLimits { range: None, rate: Some(rate.map(OverSpeed::Constant)) });
    }
    Ok(all)
}

/// Describes the limits of the references of a frozen controller at its slowest, middle and fastest speed.
pub fn summary(controller: &ControllerDesign) -> String {
    let speeds = &controller.trim.speed;
    let rows = [0, speeds.len() / 2, speeds.len() - 1];
    let of = |signal: &String, what: &str, unit: &str, [least, most]: &[OverSpeed; 2]| {
        let (factor, unit) = if unit.starts_with("rad") {
            (1f64.to_degrees(), unit.replacen("rad", "deg", 1))
        } else {
            (1.0, unit.to_owned())
        };
        let shown = |v: f64| decimals(factor * v, 2);
        let each = rows.map(|row| format!("{} to {}", shown(least.at(row)), shown(most.at(row))));
        format!("{signal}{what}: {} {unit}", each.join(", "))
    };
    if controller.envelope.is_empty() {
        return "this axis has no envelope: references are not limited".to_owned();
    }
    let mut lines = vec![format!(
        "limits of the references, at {} m/s:",
        rows.map(|row| decimals(speeds[row], 2)).join(", ")
    )];
    for (name, limits) in &controller.envelope {
        let unit =
            controller.signals.iter().find(|signal| signal.name == *name).map_or("", |signal| &signal.unit);
        lines.extend(limits.range.iter().map(|range| of(name, "", unit, range)));
        lines.extend(limits.rate.iter().map(|rate| of(name, ", its rate", &per_second(unit), rate)));
    }
    lines.join("\n")
}

/// Returns a finding if the envelope is narrower than the pitch step of the default flight at some speed.
pub fn too_narrow(controller: &ControllerDesign, manoeuvre: &Manoeuvre) -> Option<Finding> {
    let name = SIGNALS[PITCH].name;
    let [least, most] = controller.envelope.get(name)?.range.as_ref()?;
    let (step, level) = (manoeuvre.step(name), controller.trim.signals.get(name)?);
    let distance =
        |row: usize| if step < 0.0 { level[row] - least.at(row) } else { most.at(row) - level[row] };
    let row = (0..level.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    (distance(row) < step.abs()).then(|| step_limited(step, distance(row), controller.trim.speed[row]))
}

/// Unit of a rate.
fn per_second(unit: &str) -> String {
    unit.strip_suffix("/s").map_or_else(|| format!("{unit}/s"), |unit| format!("{unit}/s^2"))
}

/// Least and largest motions that can be held at a speed.
struct Limits {
    /// Pitch, rad.
    pitch: [f64; 2],
    /// Rate of descent z', m/s.
    sinking: [f64; 2],
    /// Acceleration V', m/s^2.
    acceleration: [f64; 2],
}

impl Limits {
    fn at(vehicle: &Vehicle, bounds: &Envelope, trim: &Trim) -> Result<Self, ModelError> {
        let pitch = steepest(vehicle, bounds, trim, false).map(|trim| trim.pitch);
        let [one, other] = steepest(vehicle, bounds, trim, true).map(|trim| sinking(&trim));
        let sinking = [one.min(other).min(0.0), one.max(other).max(0.0)];
        Ok(Self { pitch, sinking, acceleration: acceleration(vehicle, trim)? })
    }
}

/// End of the envelope at a speed: the steepest steady motion with the nose down, or up.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// Pitch, rad.
    pub pitch: f64,
    /// Angle of the path through the water, rad, positive upwards; NaN at rest.
    pub path: f64,
    /// Limit that a steeper motion would exceed.
    pub limited_by: String,
}

impl End {
    /// Returns the ends at the speed of a level trim, for references of pitch or of depth.
    pub(super) fn both(vehicle: &Vehicle, bounds: &Envelope, level: &Trim, depth: bool) -> [Self; 2] {
        let mut ups = [false, true].into_iter();
        steepest(vehicle, bounds, level, depth).map(|trim| {
            let limited_by = limited_by(vehicle, bounds, &trim, ups.next() == Some(true));
            let path = (-sinking(&trim) / trim.forward_speed.hypot(trim.heave)).asin();
            Self { pitch: trim.pitch, path, limited_by }
        })
    }
}

/// Limit that a motion a little steeper than one at the end of the envelope would exceed.
fn limited_by(vehicle: &Vehicle, bounds: &Envelope, end: &Trim, up: bool) -> String {
    let [least, most] = bounds.pitch;
    if (up && end.pitch >= most) || (!up && end.pitch <= least) {
        return "`envelope.pitch`".into();
    }
    let steeper = 2.0 * if up { STEPS[1] } else { -STEPS[1] };
    match climb(vehicle, end, end.pitch + steeper) {
        Err(_) => "no steady motion beyond this point".into(),
        Ok(trim) => match overloaded(vehicle, bounds, &trim).as_slice() {
            [] if sinking(&trim).abs() > steep(bounds, &trim) => "`envelope.path_angle`".into(),
            [] => "another branch of trims beyond this point".into(),
            names => names.join(", "),
        },
    }
}

/// Actuators that exceed their share of the limits in a motion.
fn overloaded<'a>(vehicle: &'a Vehicle, bounds: &Envelope, trim: &Trim) -> Vec<&'a str> {
    let held = |a: &Actuator, output| (bounds.authority * a.min..=bounds.authority * a.max).contains(output);
    let all = vehicle.actuators.iter().zip(&trim.actuators);
    all.filter(|(a, output)| !held(a, output)).map(|(a, _)| a.name.as_str()).collect()
}

/// Largest z' of a reference of depth, m/s.
fn steep(bounds: &Envelope, trim: &Trim) -> f64 {
    bounds.path_angle.sin() * trim.forward_speed.abs()
}

/// Steepest steady motions with the nose down and up that hold a reference of pitch or of depth.
fn steepest(vehicle: &Vehicle, bounds: &Envelope, level: &Trim, depth: bool) -> [Trim; 2] {
    let allowed = |trim: &Trim| {
        let flat = !depth || sinking(trim).abs() <= steep(bounds, level);
        flat && overloaded(vehicle, bounds, trim).is_empty()
    };
    let [least, most] = bounds.pitch;
    [least.min(level.pitch), most.max(level.pitch)].map(|end| farthest(vehicle, level, end, &allowed))
}

/// Rate of descent z' of a steady motion, m/s.
fn sinking(trim: &Trim) -> f64 {
    trim.heave * trim.pitch.cos() - trim.forward_speed * trim.pitch.sin()
}

/// Returns the allowed climb or dive that is farthest from level flight on the way to a pitch; level flight itself if
/// that is not allowed.
fn farthest(vehicle: &Vehicle, level: &Trim, end: f64, allowed: &dyn Fn(&Trim) -> bool) -> Trim {
    let mut at = level.clone();
    let mut step = STEPS[0];
    let up = end > level.pitch;
    while allowed(&at) && step > STEPS[1] && at.pitch != end {
        let next = if up { (at.pitch + step).min(end) } else { (at.pitch - step).max(end) };
        let jumps = |trim: &Trim| (trim.incidence - at.incidence).abs() > JUMP * (next - at.pitch).abs();
        match climb(vehicle, &at, next) {
            Ok(trim) if allowed(&trim) && !jumps(&trim) => at = trim,
            _ => step *= 0.5,
        }
    }
    at
}

/// Least and largest V' that the actuators produce without pitching, with outputs of least effort, m/s^2.
fn acceleration(vehicle: &Vehicle, trim: &Trim) -> Result<[f64; 2], ModelError> {
    let l = linearise(vehicle, trim)?;
    let rate = turn_rate(l.states);
    let reach: Vec<f64> = vehicle.actuators.iter().map(Actuator::reach).collect();
    let effect = Mat::from_fn(2, reach.len(), |i, j| l.b[([0, rate][i], j)] * reach[j]);
    let push = pseudo_inverse(&effect, RANK).column(0).into_owned();
    let pushed = (effect * &push)[0];
    let most = |sign: f64| {
        let each = vehicle.actuators.iter().zip(&trim.actuators).zip(push.iter().zip(&reach));
        let room = each.map(|((a, now), (push, reach))| {
            let per = sign * push * reach;
            let end = if per > 0.0 { a.max } else { a.min };
            if per == 0.0 { f64::INFINITY } else { ((end - now) / per).max(0.0) }
        });
        room.fold(f64::INFINITY, f64::min) * pushed
    };
    Ok([-most(-1.0), most(1.0)])
}
