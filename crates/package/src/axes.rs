//! Axes that are packed into one FMU.

use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_scheduled::ControllerDesign;

/// Files and stored design of each axis, in the order of the design file.
pub type Designs<'a> = &'a [(&'a Inputs, &'a Stored)];

/// Returns the files of each axis.
pub fn inputs<'a>(designs: Designs<'a>) -> Vec<&'a Inputs> {
    designs.iter().map(|(inputs, _)| *inputs).collect()
}

/// Returns the controller of each axis.
pub fn controllers<'a>(designs: Designs<'a>) -> Vec<&'a ControllerDesign> {
    designs.iter().map(|(_, stored)| &stored.controller).collect()
}

/// Returns a statement of what the proofs of several axes do not cover; `coupled` is `true` if both axes are proved
/// together.
pub fn unproved(axes: usize, coupled: bool) -> Option<&'static str> {
    (axes > 1).then_some(if coupled {
        "Otherwise each axis is proved separately, for straight level flight without roll. The proof for both axes \
         applies to the linear motion in continuous time, without limits of actuators; everything else is simulated \
         (squid simulate)."
    } else {
        "Each axis is proved separately, for straight level flight without roll, where the axes decouple. The \
         coupling in turns or roll is not proved, but simulated and checked in frozen turns (squid simulate)."
    })
}

/// Prefixes a text about an axis with the axis's name if there are several axes.
pub fn prefixed(axes: usize, name: &str, text: &str) -> String {
    if axes > 1 { format!("{name}: {text}") } else { text.to_owned() }
}
