//! Tuning keys of a design file.

use crate::error::Error;
use squid_design::inputs::design_file::DesignFile;
use std::fmt::{self, Display, Formatter};
use toml_edit::{DocumentMut, Item, Value};

/// Key whose number can be multiplied; for `follow`, its excess over 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knob {
    /// `frequency` of a `[[track]]`, by its index in the file.
    Frequency(usize),
    /// `bandwidth` of a `[[track]]`.
    Bandwidth(usize),
    /// `follow` of a `[[track]]`.
    Follow(usize),
    /// `noise` of a `[[measure]]`.
    Noise(usize),
    /// `weight` of `[control]`.
    Weight,
    /// `disturbance` of `[control]`.
    Disturbance,
}

impl Knob {
    /// Returns the tuning keys of a design.
    pub fn all(design: &DesignFile) -> Vec<Self> {
        let models = (0..design.tracked.len()).filter(|i| design.tracked[*i].model.is_some());
        let mut all: Vec<Self> = models.map(Self::Frequency).collect();
        all.extend((0..design.tracked.len()).map(Self::Bandwidth));
        let more = (0..design.tracked.len()).filter(|i| design.tracked[*i].references.follow > 1.0);
        all.extend(more.map(Self::Follow));
        all.extend((0..design.measured.len()).map(Self::Noise));
        all.push(Self::Weight);
        all.extend((design.disturbance > 0.0).then_some(Self::Disturbance));
        all
    }

    /// Multiplies the number of the key in a design.
    pub fn turn(self, design: &mut DesignFile, factor: f64) {
        for number in self.numbers(design) {
            *number = self.turned(*number, factor);
        }
    }

    /// Returns the numbers of a design that belong to the key.
    fn numbers(self, design: &mut DesignFile) -> Vec<&mut f64> {
        match self {
            Self::Frequency(i) => design.tracked[i].model.iter_mut().map(|m| &mut m.frequency).collect(),
            Self::Bandwidth(i) => vec![&mut design.tracked[i].weight.bandwidth],
            Self::Follow(i) => vec![&mut design.tracked[i].references.follow],
            Self::Noise(i) => {
                let noise = &mut design.measured[i].noise;
                vec![&mut noise.low, &mut noise.high]
            }
            Self::Weight => {
                let weight = &mut design.control_weight;
                vec![&mut weight.low, &mut weight.high]
            }
            Self::Disturbance => vec![&mut design.disturbance],
        }
    }

    /// Returns a number times a factor.
    fn turned(self, number: f64, factor: f64) -> f64 {
        match self {
            Self::Follow(_) => 1.0 + (number - 1.0) * factor,
            _ => number * factor,
        }
    }

    /// Returns the table of the key, its index in an array of tables, and the name of the key.
    fn key(self) -> (&'static str, Option<usize>, &'static str) {
        match self {
            Self::Frequency(i) => ("track", Some(i), "frequency"),
            Self::Bandwidth(i) => ("track", Some(i), "bandwidth"),
            Self::Follow(i) => ("track", Some(i), "follow"),
            Self::Noise(i) => ("measure", Some(i), "noise"),
            Self::Weight => ("control", None, "weight"),
            Self::Disturbance => ("control", None, "disturbance"),
        }
    }

    /// Returns the key with the signal of its table, as text.
    pub fn name(self, design: &DesignFile) -> String {
        match self {
            Self::Frequency(i) | Self::Bandwidth(i) | Self::Follow(i) => {
                format!("{self} of {}", design.tracked[i].signal.name)
            }
            Self::Noise(i) => format!("{self} of {}", design.measured[i].signal.name),
            Self::Weight | Self::Disturbance => self.to_string(),
        }
    }

    /// Multiplies the number of the key in the text of a design file, to three digits; the other text is unchanged.
    ///
    /// # Errors
    /// [`Error::NotATable`].
    pub fn write(self, document: &mut DocumentMut, factor: f64, design: &DesignFile) -> Result<(), Error> {
        let (section, index, key) = self.key();
        let file = design.file.clone();
        let found = section_mut(document, section, design.axis).and_then(|item| match index {
            Some(i) => item.as_array_of_tables_mut()?.get_mut(i)?.get_mut(key)?.as_value_mut(),
            None => item.as_table_like_mut()?.get_mut(key)?.as_value_mut(),
        });
        let number = found.as_ref().and_then(|v| v.as_float().or_else(|| Some(v.as_integer()? as f64)));
        let (Some(value), Some(number)) = (found, number) else {
            return Err(Error::NotATable { file, key: format!("{section}.{key}") });
        };
        let decor = value.decor().clone();
        *value = Value::from(three_digits(self.turned(number, factor)));
        *value.decor_mut() = decor;
        Ok(())
    }
}

/// Returns a section in the text of a design file: in the `[[axis]]` with index `axis` if that has it, otherwise
/// outside all axes.
pub fn section_mut<'d>(
    document: &'d mut DocumentMut,
    section: &str,
    axis: Option<usize>,
) -> Option<&'d mut Item> {
    let own = axis.filter(|index| {
        let axis = document.get("axis").and_then(|axes| axes.as_array_of_tables()?.get(*index));
        axis.is_some_and(|axis| axis.contains_key(section))
    });
    match own {
        Some(index) => document.get_mut("axis")?.as_array_of_tables_mut()?.get_mut(index)?.get_mut(section),
        None => document.get_mut(section),
    }
}

impl Display for Knob {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (section, _, key) = self.key();
        write!(f, "{section}.{key}")
    }
}

/// Rounds a number to three significant digits.
pub fn three_digits(v: f64) -> f64 {
    format!("{v:.2e}").parse().unwrap_or(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn squid() -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/design.toml");
        squid_base::files::read(&path).unwrap()
    }

    /// Factor that keeps a number with three digits exact.
    const TEN: f64 = 10.0;

    /// Changing a key in the text equals changing it in the design, and no comment is lost.
    #[test]
    fn key_changes_agree_in_text_and_design() {
        let text = squid();
        let design = DesignFile::parse(&text, "design.toml", "design").unwrap();
        let knobs = Knob::all(&design);
        assert_eq!(knobs.len(), 11, "{knobs:?}");
        for knob in knobs {
            let mut document: DocumentMut = text.parse().unwrap();
            knob.write(&mut document, TEN, &design).unwrap();
            let written = document.to_string();
            let changed = text.lines().zip(written.lines()).filter(|(old, new)| old != new).count();
            assert_eq!((changed, written.lines().count()), (1, text.lines().count()), "{knob}");
            let comments = |text: &str| text.matches('#').count();
            assert_eq!(comments(&written), comments(&text));
            let mut turned = design.clone();
            knob.turn(&mut turned, TEN);
            let parsed = DesignFile::parse(&written, "design.toml", "design").unwrap();
            assert!(parsed != design && close(&parsed, &turned), "{knob} {parsed:?} {turned:?}");
        }
    }

    /// Compares to rounding: the products are formed in another order.
    fn close(one: &DesignFile, other: &DesignFile) -> bool {
        let numbers = |d: &DesignFile| -> Vec<f64> {
            let of_track = d.tracked.iter().flat_map(|t| {
                [t.weight.bandwidth, t.references.follow, t.model.map_or(0.0, |model| model.frequency)]
            });
            let of_noise = d.measured.iter().flat_map(|m| [m.noise.low, m.noise.high]);
            let rest = [d.control_weight.low, d.control_weight.high, d.disturbance];
            of_track.chain(of_noise).chain(rest).collect()
        };
        numbers(one).iter().zip(numbers(other)).all(|(a, b)| (a - b).abs() < 1e-12 * b.abs())
    }

    #[test]
    fn inline_tables_are_rejected() {
        let mut document: DocumentMut = "track = [{ frequency = 1.0 }]".parse().unwrap();
        let design = DesignFile::parse(&squid(), "design.toml", "design").unwrap();
        let error = Knob::Frequency(0).write(&mut document, 2.0, &design).unwrap_err();
        assert!(matches!(&error, Error::NotATable { file, .. } if file == "design.toml"), "{error}");
        insta::assert_snapshot!(error);
    }
}
