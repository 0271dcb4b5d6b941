//! Reads and writes a design as JSON. `delay_ticks` is omitted if 0, `speed_given` if false, `envelope` if empty, and
//! `reference_filter`, `anti_windup`, `failsafe` and the `curve` of an actuator if absent.

use crate::{ControllerDesign, DesignError};

impl ControllerDesign {
    /// Reads and checks a design.
    ///
    /// # Errors
    /// [`DesignError`] with the key at fault.
    #[inline]
    pub fn from_json(text: &str) -> Result<Self, DesignError> {
        let design: Self = serde_json::from_str(text)?;
        design.validate()?;
        Ok(design)
    }

    /// Writes the design as JSON, one matrix row per line; numbers read back to the same `f64`.
    ///
    /// # Errors
    /// [`DesignError`] if the design is invalid and could not be read back.
    pub fn to_json(&self) -> Result<String, DesignError> {
        self.validate()?;
        let mut text = join_rows(&serde_json::to_string_pretty(self)?);
        text.push('\n');
        Ok(text)
    }
}

/// Puts each innermost list on one line.
fn join_rows(pretty: &str) -> String {
    let mut joined = String::with_capacity(pretty.len());
    let mut rest = pretty;
    // A line break follows the opening bracket of a list; strings contain no line breaks.
    while let Some(open) = rest.find("[\n") {
        let (before, list) = rest.split_at(open);
        joined.push_str(before);
        let end = list.find(']').map_or(list.len(), |close| close + 1);
        if list[1..end].contains(['[', '{', '"']) {
            joined.push('[');
            rest = &list[1..];
        } else {
            let numbers = list[1..end - 1].split_whitespace().collect::<Vec<_>>().join(" ");
            joined.extend(["[", &numbers, "]"]);
            rest = &list[end..];
        }
    }
    joined.push_str(rest);
    joined
}
