//! The axes that are packed into one FMU.

use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_scheduled::ControllerDesign;

/// The files of each axis, and its stored design, in the order of the design file.
pub type Designs<'a> = &'a [(&'a Inputs, &'a Stored)];

/// The files of each axis.
pub fn inputs<'a>(designs: Designs<'a>) -> Vec<&'a Inputs> {
    designs.iter().map(|(inputs, _)| *inputs).collect()
}

/// The controllers of each axis.
pub fn controllers<'a>(designs: Designs<'a>) -> Vec<&'a ControllerDesign> {
    designs.iter().map(|(_, stored)| &stored.controller).collect()
}

/// What the proofs of a number of axes do not say; `coupled` is whether there is one of all together.
pub fn unproved(axes: usize, coupled: bool) -> Option<&'static str> {
    (axes > 1).then_some(if coupled {
        "Beyond that each axis is proved alone, about straight level flight without roll. What is proved of both is of \
         the linear motion, in continuous time and without limits of actuators; the rest is simulated (squid simulate)."
    } else {
        "Each axis is proved alone, about straight level flight without roll, where the axes decouple. What a turn or \
         a roll couples is simulated, and checked in frozen turns (squid simulate), not proved."
    })
}

/// Words about an axis that is called `name`: after its name, if there are others.
pub fn said(axes: usize, name: &str, words: &str) -> String {
    if axes > 1 { format!("{name}: {words}") } else { words.to_owned() }
}
