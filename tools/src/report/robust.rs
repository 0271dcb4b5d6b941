//! The robust controller against the nominal one, where the design is a robust one.

use super::axis::Axis;
use super::chart::{Chart, Curve, Key};
use super::figure::Figure;
use super::section::{Part, Table};
use super::subject::Subject;
use crate::error::Error;
use crate::robust::{Frozen, PRICE, RobustFigures};

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
    Ok(vec![
        Part::Words(about(found)),
        Part::Table(ladder(found)),
        Part::Words(proof(found)),
        Part::Words(constant(found)),
        Part::Figure(figure(subject, found)),
        Part::Table(frozen(found)),
    ])
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

fn about(found: &RobustFigures) -> String {
    let (parameters, channels, rho) = found.sizes;
    format!(
        "The controller of this report is the robust one (Fig. 5, where W_e is varied, and the switched controllers are of the nominal synthesis). Coefficients that change arbitrarily fast: at a gain of {:.3}, which is {PRICE} times the bound of the \
         nominal controller, the robust controller bears {} of the declared uncertainty and the nominal one {}. Both are judged by the same inequality, in \
         which {parameters} coefficients ({channels} channels) and the speed ({rho} channels) may change at any rate within their ranges. The table has the gain that is \
         not exceeded when a smaller or a larger part of the declared uncertainty is let loose.",
        found.gamma,
        percent(found.robust_bears),
        percent(found.nominal_bears)
    )
}

fn proof(found: &RobustFigures) -> String {
    format!(
        "The bound of the robust controller, at the part that it bears, is proved in exact arithmetic (robust_certificate.json). {}",
        found.not_proved()
    )
}

fn constant(found: &RobustFigures) -> String {
    format!(
        "Coefficients that are off but do not change are a milder test. For these the figure and its table show both controllers, frozen at a speed: an upper bound on \
         mu for robust stability (1 is all of the declared uncertainty, less is better), and the worst-case gain at {} of the declared uncertainty, \
         of which the first number was found with coefficients that have it, and the second is guaranteed.",
        whole_percent(found.constant_size)
    )
}

fn whole_percent(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "none found".into(), |v| format!("{v:.3}"))
}

fn ladder(found: &RobustFigures) -> Table {
    let mut table =
        Table::new(["part of the declared uncertainty", "gain below: nominal", "gain below: robust"]);
    let row = |(size, nominal, robust): &(f64, Option<f64>, Option<f64>)| {
        vec![percent(*size), number(*nominal), number(*robust)]
    };
    table.rows = found.ladder.iter().map(row).collect();
    table
}

/// Both controllers over speed, the nominal one first.
fn figure(subject: &Subject, found: &RobustFigures) -> Figure {
    let curve = |which: usize, of: &dyn Fn(&Frozen) -> Option<f64>| Curve {
        key: which,
        points: found.frozen.iter().filter_map(|f| Some((f.speed, of(f)?))).collect(),
    };
    let chart = |title: &str, y: Axis, curves: Vec<Curve>| Chart {
        title: title.into(),
        x: Axis::linear("speed V (m/s)"),
        y,
        curves,
    };
    let gain = format!("worst-case gain at {}", whole_percent(found.constant_size));
    Figure {
        name: "robust-and-nominal".into(),
        caption: format!(
            "Upper bounds at six frozen speeds, of {}, with constant coefficients anywhere in their ranges. Less is better.",
            subject.name()
        ),
        keys: vec![Key::nth(1, "nominal controller"), Key { dash: "", ..Key::nth(0, "robust controller") }],
        charts: vec![
            chart("", Axis::linear("mu"), [0, 1].map(|i| curve(i, &|f| f.mu[i])).into()),
            chart(
                "",
                Axis::linear(gain),
                [0, 1].map(|i| curve(i, &|f| f.worst[i].map(|(upper, _)| upper))).into(),
            ),
        ],
    }
}

fn frozen(found: &RobustFigures) -> Table {
    let at = whole_percent(found.constant_size);
    let mut table = Table::new(["speed (m/s)", "mu below: nominal", "mu below: robust", "", ""]);
    table.head[3] = format!("worst-case gain at {at}: nominal");
    table.head[4] = format!("worst-case gain at {at}: robust");
    let row = |f: &Frozen| {
        let [nominal, robust] = f.mu.map(number);
        let [nominal_gain, robust_gain] = f.worst.map(between);
        vec![format!("{:.2}", f.speed), nominal, robust, nominal_gain, robust_gain]
    };
    table.rows = found.frozen.iter().map(row).collect();
    table
}

/// A gain between what was found and what is guaranteed: (below, at least).
pub fn between(gain: Option<(f64, f64)>) -> String {
    match gain.map(|(upper, lower)| (format!("{lower:.3}"), format!("{upper:.3}"))) {
        None => "no bound".into(),
        Some((lower, upper)) if lower == upper => upper,
        Some((lower, upper)) => format!("{lower} to {upper}"),
    }
}
