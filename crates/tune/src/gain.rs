//! Tuned gains, and a design file with them.

use crate::error::Error;
use crate::knob::section_mut;
use squid_design::inputs::Inputs;
use toml_edit::{Array, DocumentMut, InlineTable, Item, value};

/// Tuned gain or reference weight.
#[derive(Debug, Clone, PartialEq)]
pub struct TunedGain {
    /// Key in `[controller]`, for instance `pitch.kp`.
    pub name: String,
    /// SI unit; 1 for a reference weight.
    pub unit: String,
    /// Coefficients of 1 and rho.
    pub coefficients: Vec<f64>,
}

impl TunedGain {
    /// Returns `true` for a reference weight, `false` for a gain.
    pub(crate) fn is_weight(&self) -> bool {
        self.unit == "1"
    }
}

/// Allowed range of reference weights.
pub(crate) const WEIGHTS: [f64; 2] = [0.0, 10.0];

/// Returns the text of a design file with gains in its `[controller]`, and its inputs.
pub(crate) fn with_gains(
    inputs: &Inputs,
    text: &str,
    gains: &[TunedGain],
) -> Result<(String, Inputs), Error> {
    let file = &inputs.design.file;
    let written = written(text, gains, inputs.design.axis)
        .ok_or_else(|| Error::NotATable { file: file.clone(), key: "controller".into() })?;
    let design = inputs.design.parse_again(&written)?;
    Ok((written, inputs.redesigned(design)?))
}

/// Returns the text of a design file with gains in its `[controller]`; `None` if that is not a table of tables.
fn written(text: &str, gains: &[TunedGain], axis: Option<usize>) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    let controller = section_mut(&mut document, "controller", axis)?;
    for gain in gains {
        let (axis, key) = gain.name.split_once('.')?;
        let numbers: Vec<f64> =
            gain.coefficients.iter().map(|v| squid_auv::rounded(*v).parse().unwrap_or(*v)).collect();
        let item = controller.get_mut(axis)?.as_table_like_mut()?;
        item.insert(key, entry(&numbers, &gain.unit));
    }
    Some(document.to_string())
}

fn entry(numbers: &[f64], unit: &str) -> Item {
    match numbers {
        [one] if unit == "1" => value(*one),
        _ => {
            let mut table = InlineTable::new();
            match numbers {
                [one] => table.insert("value", (*one).into()),
                all => table.insert("value", all.iter().copied().collect::<Array>().into()),
            };
            table.insert("unit", unit.into());
            value(table)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writes_gains_and_keeps_other_text() {
        let text = "a = 1 # one\n[controller]\nkind = \"pid\" # mine\n[controller.pitch]\nrolloff = 0.1\n\
            kp = { value = [1.0, 2.0], unit = \"N.m/deg\" }\n";
        let gain = |name: &str, unit: &str, coefficients: &[f64]| TunedGain {
            name: name.into(),
            unit: unit.into(),
            coefficients: coefficients.to_vec(),
        };
        let gains = [
            gain("pitch.kp", "N.m/rad", &[464.48206]),
            gain("pitch.kd", "N.m.s/rad", &[2.0, -0.25]),
            gain("pitch.reference_weight", "1", &[0.5]),
        ];
        let expected = "a = 1 # one\n[controller]\nkind = \"pid\" # mine\n[controller.pitch]\nrolloff = 0.1\n\
            kp = { value = 464.482, unit = \"N.m/rad\" }\nkd = { value = [2.0, -0.25], unit = \"N.m.s/rad\" }\n\
            reference_weight = 0.5\n";
        assert_eq!(written(text, &gains, None).as_deref(), Some(expected));
        assert_eq!(written("controller = 1\n", &gains, None), None);
    }
}
