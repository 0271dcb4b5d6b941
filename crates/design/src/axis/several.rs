//! What the axes of one autopilot have in common.

use crate::inputs::Inputs;
use crate::inputs::together::common_speeds;
use squid_auv::Vehicle;
use squid_scheduled::Manoeuvre;

/// The axes of pitch or depth and of heading among some; `None` without one of both.
pub fn level_and_heading<'a>(axes: &[&'a Inputs]) -> Option<[&'a Inputs; 2]> {
    let level = axes.iter().find(|one| !one.design.view().is_level_held)?;
    let heading = axes.iter().find(|one| one.design.tracks("heading").is_some())?;
    Some([*level, *heading])
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
    Some(if axes.iter().any(|one| one.design.view().is_level_held) { &first.whole } else { &first.plane })
}

/// The default manoeuvre: that of the first axis, with the steps of all.
pub fn manoeuvre(axes: &[&Inputs]) -> Option<Manoeuvre> {
    let mut manoeuvre = axes.first()?.design.manoeuvre.clone();
    for axis in axes {
        manoeuvre.steps.extend(axis.design.manoeuvre.steps.clone());
    }
    Some(manoeuvre)
}
