//! Reads the section `[require]`: the requirements on the finished loop in flight.

use serde::Serialize;
use squid_auv::number;
use squid_auv::toml_file::Table;

/// Required side of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sense {
    /// The figure must be above its limit.
    Above,
    /// The figure must be below its limit.
    Below,
}

/// Key of `[require]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// Name of the key.
    pub key: &'static str,
    /// Unit of the limit.
    pub unit: &'static str,
    /// Side of the limit that meets the requirement.
    pub sense: Sense,
    /// Limit if the file gives none; `None` for a figure that is only reported.
    pub default: Option<f64>,
}

const fn above(key: &'static str, unit: &'static str, default: Option<f64>) -> Requirement {
    Requirement { key, unit, sense: Sense::Above, default }
}

const fn below(key: &'static str, unit: &'static str, default: Option<f64>) -> Requirement {
    Requirement { key, unit, sense: Sense::Below, default }
}

/// All keys of `[require]`, in the order of the verdict.
pub const REQUIREMENTS: [Requirement; 27] = [
    below("gamma", "", None),
    below("sampled_gain", "", None),
    below("overshoot", "%", Some(10.0)),
    below("pitch_rise", "s", None),
    below("pitch_settling", "s", None),
    below("depth_rise", "s", None),
    below("depth_settling", "s", None),
    below("heading_rise", "s", None),
    below("heading_settling", "s", None),
    below("speed_rise", "s", None),
    below("speed_settling", "s", None),
    below("steady_error", "%", None),
    below("actuator_use", "%", Some(100.0)),
    above("gain_margin", "dB", None),
    above("phase_margin", "deg", Some(45.0)),
    above("disk_margin", "deg", Some(35.0)),
    above("delay_margin", "s", Some(0.2)),
    below("mu", "", Some(1.0)),
    below("gust", "deg", None),
    below("beyond_speed", "%", Some(10.0)),
    below("beyond_recovery", "%", Some(15.0)),
    below("held_speed", "%", Some(10.0)),
    below("held_recovery", "%", Some(2.0)),
    below("corner_overshoot", "%", Some(50.0)),
    below("corner_error", "%", None),
    below("noise", "%", Some(2.0)),
    below("controller_mode", "%", Some(20.0)),
];

/// Largest limit.
const LARGEST: f64 = 1e6;

/// Limits, in the order of [`REQUIREMENTS`] and in their units.
#[derive(Debug, Clone, PartialEq)]
pub struct Require {
    limits: [Option<f64>; REQUIREMENTS.len()],
}

impl Default for Require {
    fn default() -> Self {
        Self { limits: REQUIREMENTS.map(|requirement| requirement.default) }
    }
}

impl Require {
    /// Reads the section; a missing key has its default.
    pub(super) fn of(table: &Table<'_>) -> Option<Self> {
        table.allow_only(&REQUIREMENTS.map(|requirement| requirement.key));
        let mut require = Self::default();
        for (limit, Requirement { key, unit, .. }) in require.limits.iter_mut().zip(REQUIREMENTS) {
            if table.has(key) {
                let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
                let allowed_text = format!("from 0 to {}{unit}", number(LARGEST));
                *limit = Some(table.number(key, |v| (0.0..=LARGEST).contains(&v), &allowed_text)?);
            }
        }
        Some(require)
    }

    /// Returns the limit of a key, if one is required.
    pub fn limit(&self, key: &str) -> Option<f64> {
        REQUIREMENTS
            .iter()
            .position(|requirement| requirement.key == key)
            .and_then(|index| self.limits[index])
    }
}
