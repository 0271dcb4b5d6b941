//! What the source needs of the mathematical library.

use crate::real::Real;
use squid_scheduled::{Actuator, ControllerDesign};
use squid_signals::Law;

/// What must be linked.
pub(crate) fn of_library(functions: &[String]) -> String {
    format!("Of the mathematical library it calls {}: link with -lm.", functions.join(" and "))
}

/// The functions of the mathematical library that are called.
pub(crate) fn functions(design: &ControllerDesign, real: Real) -> Vec<String> {
    let squares =
        |actuator: &Actuator| actuator.curve.as_ref().is_some_and(|c| matches!(c.law(), Law::Square(_)));
    let square = design.actuators.iter().any(squares);
    let called = if square { &["sqrt", "copysign"][..] } else { &[] };
    called.iter().map(|name| format!("{name}{}", real.suffix())).collect()
}
