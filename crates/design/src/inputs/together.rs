//! The axes of one autopilot, which fly one vehicle.

use crate::error::InputError;
use crate::inputs::Inputs;
use crate::inputs::design_file::DesignFile;
use auv::{Pitch, Vehicle, number};
use scheduled::Manoeuvre;

/// A key that all axes share, and its value in words.
type Shared = (&'static str, fn(&DesignFile) -> String);

/// Checks that the axes command different actuators, at one rate, from one level flight, and have speeds in common;
/// `file` is for messages.
///
/// # Errors
/// [`InputError::SharedActuator`], [`InputError::AxesDiffer`], [`InputError::NoCommonSpeed`].
pub(super) fn check(designs: &[DesignFile], vehicles: &[Vehicle], file: &str) -> Result<(), InputError> {
    let Some(first) = designs.first() else { return Ok(()) };
    let file = || file.to_owned();
    for (place, design) in designs.iter().enumerate() {
        let taken = |name: &str| {
            let mut before = designs.iter().zip(vehicles).take(place);
            before.find(|(_, vehicle)| vehicle.actuators.iter().any(|one| one.name == name))
        };
        for actuator in &vehicles[place].actuators {
            if let Some((other, _)) = taken(&actuator.name) {
                let (one, other) = (other.steered(), design.steered());
                return Err(InputError::SharedActuator {
                    file: file(),
                    actuator: actuator.name.clone(),
                    one,
                    other,
                });
            }
        }
        let shared: [Shared; 3] = [
            ("autopilot.sample_time", |one| number(one.sample_time)),
            ("model.depth", |one| number(one.depth)),
            ("trim.pitch", |one| match &one.pitch_asked {
                None => "left out".into(),
                Some(Pitch::Held(angle)) => format!("{} deg", number(angle.to_degrees())),
                Some(_) => "\"free\"".into(),
            }),
        ];
        for (key, of) in shared {
            if of(first) != of(design) {
                let said = |axis: &DesignFile| format!("{} for {}", of(axis), axis.steered());
                let values = format!("{} and {}", said(first), said(design));
                return Err(InputError::AxesDiffer { file: file(), key, values });
            }
        }
    }
    let [low, high] = common_speeds(designs);
    if low > high {
        let of = |one: &DesignFile| format!("{} {} to {} m/s", one.steered(), one.speed_min, one.speed_max);
        let ranges = designs.iter().map(of).collect::<Vec<_>>().join(", ");
        return Err(InputError::NoCommonSpeed { file: file(), ranges });
    }
    Ok(())
}

/// The least and the largest speed in the range of every axis, m/s; the first is above the second if there is none.
pub fn common_speeds<'a>(designs: impl IntoIterator<Item = &'a DesignFile>) -> [f64; 2] {
    designs.into_iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], one| {
        [low.max(one.speed_min), high.min(one.speed_max)]
    })
}

/// An axis of pitch or depth and one of heading; `None` of other axes.
pub fn level_and_heading<'a>(axes: &[&'a Inputs]) -> Option<[&'a Inputs; 2]> {
    match axes {
        [one, other] if !one.design.is_lateral() && other.design.is_lateral() => Some([*one, *other]),
        _ => None,
    }
}

/// That the axes are proved at different speeds, and whether the default manoeuvre leaves those that they have in
/// common; `None` of axes with one range.
pub fn narrower(axes: &[&Inputs]) -> Option<String> {
    let first = &axes.first()?.design;
    let is_other =
        |one: &&Inputs| [one.design.speed_min, one.design.speed_max] != [first.speed_min, first.speed_max];
    axes.iter().any(is_other).then(|| {
        let [low, high] = common_speeds(axes.iter().map(|one| &one.design));
        let leaves =
            [first.manoeuvre.speed_from, first.manoeuvre.speed_to].iter().any(|v| *v < low || *v > high);
        let flown = if leaves { "; the default manoeuvre of the loop leaves that range" } else { "" };
        let names: Vec<&str> = axes.iter().map(|one| one.design.steered()).collect();
        format!("{} have the speeds {low} to {high} m/s in common{flown}", names.join(" and "))
    })
}

/// The vehicle as plant and loop have it: in the vertical plane, if no axis steers it out of that.
pub fn vehicle<'a>(axes: &[&'a Inputs]) -> Option<&'a Vehicle> {
    let first = axes.first()?;
    Some(if axes.iter().any(|one| one.design.is_lateral()) { &first.whole } else { &first.plane })
}

/// The default manoeuvre: that of the first axis, with the steps of all.
pub fn manoeuvre(axes: &[&Inputs]) -> Option<Manoeuvre> {
    let mut manoeuvre = axes.first()?.design.manoeuvre.clone();
    for axis in axes {
        manoeuvre.steps.extend(axis.design.manoeuvre.steps.clone());
    }
    Some(manoeuvre)
}
