//! The robust controller against the nominal one, where the design is a robust one.

use super::section::{Part, Table};
use super::subject::Subject;
use crate::error::Error;
use crate::robust::{PRICE, RobustFigures};

/// Both controllers side by side, or how to get there.
///
/// # Errors
/// None; sections have one signature.
pub fn robust(subject: &Subject) -> Result<Vec<Part>, Error> {
    let Some(found) = &subject.stored.robust else {
        let words = "The controller of this report is the nominal one. `squid design --robust` looks for one that bears more of the declared uncertainty, \
                     and this section then shows both side by side.";
        return Ok(vec![Part::Words(words.into())]);
    };
    Ok(vec![Part::Words(about(found)), Part::Table(ladder(found)), Part::Table(frozen(found))])
}

fn about(found: &RobustFigures) -> String {
    let (parameters, channels, rho) = found.sizes;
    let left_out = match found.left_out.as_slice() {
        [] => String::new(),
        names => format!(" Left out were {}.", names.join(", ")),
    };
    format!(
        "The controller of this report is the robust one: at a gain of {:.3}, {PRICE} times the bound of the nominal controller, it bears {:.1} % of the declared uncertainty, \
         the nominal one {:.1} %, both by the same inequality, in which {parameters} coefficients ({channels} channels) and the speed ({rho} channels) may change arbitrarily \
         fast within their ranges. That is much harder than constant coefficients, for which the second table speaks. Channels that were taken off the model move it by \
         {:.2} % at most.{left_out} The bound of the robust controller is proved in exact arithmetic (robust_certificate.json).",
        found.gamma,
        100.0 * found.robust_bears,
        100.0 * found.nominal_bears,
        100.0 * found.model_error
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "none found".into(), |v| format!("{v:.3}"))
}

fn ladder(found: &RobustFigures) -> Table {
    let mut table =
        Table::new(["part of the declared uncertainty", "gain below: nominal", "gain below: robust"]);
    table.rows = found
        .ladder
        .iter()
        .map(|(size, nominal, robust)| {
            vec![format!("{:.1} %", 100.0 * size), number(*nominal), number(*robust)]
        })
        .collect();
    table
}

fn frozen(found: &RobustFigures) -> Table {
    let at = format!("{:.0} %", 100.0 * found.constant_size);
    let mut table = Table::new(["speed (m/s)", "mu below: nominal", "robust", "", ""]);
    table.head[3] = format!("worst-case gain at {at}, constant: nominal");
    table.head[4] = "robust".into();
    let gain = |g: Option<(f64, f64)>| {
        g.map_or_else(|| "no bound".into(), |(upper, lower)| format!("{lower:.3} to {upper:.3}"))
    };
    let row = |f: &crate::robust::Frozen| {
        let [nominal, robust] = f.mu.map(number);
        let [nominal_gain, robust_gain] = f.worst.map(gain);
        vec![format!("{:.2}", f.speed), nominal, robust, nominal_gain, robust_gain]
    };
    table.rows = found.frozen.iter().map(row).collect();
    table
}
