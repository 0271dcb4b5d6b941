//! Properties common to the axes of one autopilot.

use crate::inputs::Inputs;
use crate::inputs::together::common_speeds;
use squid_auv::Vehicle;
use squid_scheduled::Manoeuvre;

/// Returns the axis of pitch or depth and the axis of heading; `None` if one of them is missing.
pub fn level_and_heading<'a>(axes: &[&'a Inputs]) -> Option<[&'a Inputs; 2]> {
    let level = axes.iter().find(|one| !one.design.view().is_level_held)?;
    let heading = axes.iter().find(|one| one.design.tracks("heading").is_some())?;
    Some([*level, *heading])
}

/// Describes the common range of axes that are proved at different speeds, and tells if the default manoeuvre leaves
/// it; `None` if all ranges are the same.
pub fn narrower(axes: &[&Inputs]) -> Option<String> {
    let first = &axes.first()?.design;
    let is_other =
        |one: &&Inputs| [one.design.speed_min, one.design.speed_max] != [first.speed_min, first.speed_max];
    axes.iter().any(is_other).then(|| {
        let [low, high] = common_speeds(axes.iter().map(|one| &one.design));
        let leaves =
            [first.manoeuvre.speed_from, first.manoeuvre.speed_to].iter().any(|v| *v < low || *v > high);
        let leaves_text = if leaves { "; the default manoeuvre of the loop leaves this range" } else { "" };
        let names: Vec<&str> = axes.iter().map(|one| one.design.steered_signal()).collect();
        format!("the common speed range of {} is {low} to {high} m/s{leaves_text}", names.join(" and "))
    })
}

/// Returns the vehicle of plant and loop: restricted to the vertical plane unless an axis steers it out of that plane.
pub fn vehicle<'a>(axes: &[&'a Inputs]) -> Option<&'a Vehicle> {
    let first = axes.first()?;
    Some(if axes.iter().any(|one| one.design.view().is_level_held) { &first.six_dof } else { &first.plane })
}

/// Returns the default manoeuvre: that of the first axis, with the steps of all axes.
pub fn manoeuvre(axes: &[&Inputs]) -> Option<Manoeuvre> {
    let mut manoeuvre = axes.first()?.design.manoeuvre.clone();
    for axis in axes {
        manoeuvre.steps.extend(axis.design.manoeuvre.steps.clone());
    }
    Some(manoeuvre)
}
