//! What the source needs of the mathematical library.

use crate::real::Real;
use scheduled::{Actuator, ControllerDesign, Kind};
use signals::{Law, SIGNALS, STATES, place};

/// What must be linked.
pub(crate) fn of_library(functions: &[String]) -> String {
    format!("Of the mathematical library it calls {}: link with -lm.", functions.join(" and "))
}

/// The functions of the mathematical library that are called.
pub(crate) fn functions(design: &ControllerDesign, real: Real) -> Vec<String> {
    let squares =
        |actuator: &Actuator| actuator.curve.as_ref().is_some_and(|c| matches!(c.law(), Law::Square(_)));
    let square = design.actuators.iter().any(squares);
    let heave =
        design.controller_inputs.iter().any(|input| input.kind != Kind::Error && is(&input.signal, "w"));
    let called = [(square, "sqrt"), (square, "copysign"), (heave, "tan")];
    let names = called.iter().filter(|(is_called, _)| *is_called);
    names.map(|(_, name)| format!("{name}{}", real.suffix())).collect()
}

/// Whether a signal is the state with this symbol.
fn is(signal: &str, symbol: &str) -> bool {
    place(signal).is_some_and(|place| STATES[SIGNALS[place].state].symbol == symbol)
}
