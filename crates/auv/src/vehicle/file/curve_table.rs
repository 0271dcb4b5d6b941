//! Keys `curve` and `T_nn` of a thruster or a group: from its command to its thrust.

use std::collections::BTreeMap;

use squid_signals::{COMMAND_UNITS, Curve, POINTS};

use crate::text::number;
use crate::toml_file::{Table, cited};
use crate::vehicle::allowed::Allowed;

/// Key of a table of points.
pub(super) const CURVE: &str = "curve";
/// Key of the factor of a square law, named like X_uu and M_qq of a hull.
pub(super) const SQUARE: &str = "T_nn";

/// Units of the factor of a square law, each with that of its command.
const SQUARES: [(&str, &str); 2] = [("N/rpm2", "rpm"), ("N.s2/rad2", "rad/s")];

/// Reads the curve of an actuator, if it has one; the outer option is `None` after a mistake.
pub(super) fn read(
    table: &Table<'_>,
    name: &str,
    sources: &mut BTreeMap<String, String>,
) -> Option<Option<Curve>> {
    let (key, read) = match (table.has(CURVE), table.has(SQUARE)) {
        (false, false) => return Some(None),
        (true, false) => (CURVE, points(table)),
        (false, true) => (SQUARE, square(table)),
        (true, true) => {
            let allowed = format!("omitted if '{CURVE}' is given: a thruster has one of the two");
            table.not_allowed(SQUARE, "given", allowed);
            return None;
        }
    };
    let (curve, source) = read?;
    sources.insert(format!("{name}.{key}"), source);
    Some(Some(curve))
}

fn points(table: &Table<'_>) -> Option<(Curve, String)> {
    let curve = table.table(CURVE)?;
    curve.allow_only(&["value", "unit", "source"]);
    let pairs = curve.pairs("value", POINTS);
    let unit = curve.one_of("unit", &COMMAND_UNITS);
    let source = curve.text("source");
    let (pairs, unit, source) = (pairs?, unit?, source?);
    let description = mistake(&pairs);
    match Curve::through(pairs, COMMAND_UNITS[unit]) {
        Ok(read) => Some((read, source)),
        Err(_) => {
            curve.not_allowed("value", description, POINTS);
            None
        }
    }
}

/// Describes the mistake in points that form no valid curve.
fn mistake(points: &[[f64; 2]]) -> String {
    let (first, last) = (points[0], points[points.len() - 1]);
    let falls = |pair: &&[[f64; 2]]| pair[0][0] >= pair[1][0] || pair[0][1] > pair[1][1];
    let [from, to] = match points.windows(2).find(falls) {
        Some(pair) => [pair[0], pair[1]],
        None => [first, last],
    };
    let [from, to] = [from, to].map(|[command, thrust]| format!("[{}, {}]", number(command), number(thrust)));
    match points {
        [_] => format!("only {from}"),
        _ if points.windows(2).any(|pair| falls(&pair)) => format!("{to} after {from}"),
        _ => format!("from {from} to {to}"),
    }
}

fn square(table: &Table<'_>) -> Option<(Curve, String)> {
    let found = table.quantity(SQUARE, &SQUARES.map(|(unit, _)| unit), Allowed::Positive)?;
    let (_, unit) = SQUARES.into_iter().find(|(unit, _)| *unit == found.unit)?;
    match Curve::square(found.value, unit) {
        Ok(curve) => Some((curve, found.source)),
        Err(reason) => {
            table.not_allowed(SQUARE, cited(&reason.to_string()), Allowed::Positive.describe());
            None
        }
    }
}
