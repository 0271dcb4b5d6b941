//! Initial deviations from trim.

use serde::{Deserialize, Serialize};
use squid_auv::PerSignal;
use squid_auv::longitudinal::SIGNALS;
use squid_signals::Signal;
use std::fmt::{Display, Formatter};
use std::str::FromStr;

/// Largest initial deviation from the trim of the vehicle in each of [`SIGNALS`] \[SI\]; 0 to start in trim.
///
/// The text form is a list such as `pitch=10deg,heave=0.1m/s`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Starts(pub PerSignal<f64>);

impl Starts {
    /// Returns `true` if all flights start in trim.
    pub fn in_trim(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the signals with an initial deviation, each with its index.
    pub fn off(&self) -> impl Iterator<Item = (usize, &'static Signal)> {
        SIGNALS.iter().enumerate().filter(|(index, _)| self.0[*index] > 0.0)
    }

    /// Returns the suffix of a campaign's name; empty if all flights start in trim.
    pub fn text(&self) -> String {
        let names: Vec<&str> = self.off().map(|(_, signal)| signal.name).collect();
        if names.is_empty() {
            String::new()
        } else {
            format!(", with initial deviations from trim in {}", names.join(", "))
        }
    }
}

impl Display for Starts {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let one =
            |(index, signal): (usize, &Signal)| format!("{}={}{}", signal.name, self.0[index], signal.unit);
        f.write_str(&self.off().map(one).collect::<Vec<_>>().join(","))
    }
}

impl FromStr for Starts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut starts = Self::default();
        for part in text.split(',') {
            let (index, size) =
                start(part).ok_or_else(|| format!("'{part}' is not allowed; allowed are {}", allowed()))?;
            if starts.0[index] > 0.0 {
                return Err(format!("{} is given twice", SIGNALS[index].name));
            }
            starts.0[index] = size;
        }
        Ok(starts)
    }
}

/// Parses the index of a signal, and its largest deviation, SI.
fn start(part: &str) -> Option<(usize, f64)> {
    let (name, size) = part.split_once('=')?;
    let index = SIGNALS.iter().position(|signal| signal.name == name)?;
    let read =
        |unit: &squid_signals::Unit| Some(size.strip_suffix(unit.name)?.parse::<f64>().ok()? * unit.factor);
    let size = SIGNALS[index].units.iter().find_map(read)?;
    (size > 0.0 && size.is_finite()).then_some((index, size))
}

/// Returns the allowed signals and units, as text.
fn allowed() -> String {
    let units = |signal: &Signal| signal.units.iter().map(|unit| unit.name).collect::<Vec<_>>().join(" or ");
    let one = |signal: &Signal| format!("{}=NUMBER in {}", signal.name, units(signal));
    let all: Vec<String> = SIGNALS.iter().map(one).collect();
    format!("{}, each a number above 0 with its unit, as in pitch=10deg,heave=0.1m/s", all.join(", "))
}

impl TryFrom<String> for Starts {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Starts> for String {
    fn from(starts: Starts) -> Self {
        starts.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_auv::longitudinal::{PITCH, SPEED};

    #[test]
    fn list_round_trips_to_the_bit() {
        let starts: Starts = "pitch=10deg,heave=0.1m/s,pitch_rate=1e-3rad/s".parse().unwrap();
        assert_eq!((starts.0[PITCH], starts.0[SPEED]), (10f64.to_radians(), 0.0));
        assert_eq!(starts.to_string().parse(), Ok(starts));
        insta::assert_snapshot!(starts.text());
        assert!(Starts::default().in_trim() && !starts.in_trim());
    }

    #[test]
    fn rejects_an_invalid_list() {
        for text in
            ["", "pitch", "pitch=10", "pitch=-1deg", "pitch=0deg", "pitch=infrad", "roll=1deg", "heave=1deg"]
        {
            assert!(text.parse::<Starts>().unwrap_err().starts_with(&format!("'{text}' ")));
        }
        let messages = ["pitch=10", "pitch=1deg,pitch=2deg"].map(|text| text.parse::<Starts>().unwrap_err());
        insta::assert_snapshot!(messages.join("\n"));
    }
}
