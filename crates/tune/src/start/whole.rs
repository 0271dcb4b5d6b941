//! First design file with all axes of a vehicle.

use crate::error::Error;
use crate::start::heading::{Beside, start_heading};
use crate::start::start;
use squid_auv::Vehicle;
use squid_design::inputs::design_file::DesignFile;

/// Returns the text of a first design file with all axes of a vehicle: pitch and speed, and heading if it can be
/// controlled; `files` are the names of vehicle and design in messages. Also returns the reason if heading is left out
/// although the vehicle leaves the vertical plane.
///
/// # Errors
/// Errors of [`start`].
pub fn start_whole(vehicle: &Vehicle, files: [&str; 2]) -> Result<(String, Option<Error>), Error> {
    let level = start(vehicle)?;
    if !vehicle.coefficients.leaves_plane() {
        return Ok((level, None));
    }
    let design = DesignFile::parse(&level, "design.toml", "design")?;
    let speeds = [design.speed_min, design.speed_max];
    let beside = Beside { speeds, depth: design.depth, sample_time: design.sample_time };
    Ok(match start_heading(vehicle, files, Some(beside)) {
        Ok(heading) => ([level, heading].map(|text| as_axis(&text)).join("\n"), None),
        Err(reason) => (level, Some(reason)),
    })
}

/// Converts the text of a design file of one axis to an axis of a file with several.
fn as_axis(text: &str) -> String {
    let moved = |line: &str| {
        let opened = line.len() - line.trim_start_matches('[').len();
        let (opened, rest) = line.split_at(opened);
        if opened.is_empty() { format!("{line}\n") } else { format!("{opened}axis.{rest}\n") }
    };
    format!("[[axis]]\n{}", text.lines().map(moved).collect::<String>())
}
