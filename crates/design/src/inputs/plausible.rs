//! Improbable but allowed values in the files of a design.

use crate::findings;
use crate::inputs::Inputs;
use squid_finding::Finding;

/// Unit of the pitch error above which it is unusual, deg: the linear models do not hold so far.
const PITCH_SCALE: f64 = 45.0;

impl Inputs {
    /// Returns findings on improbable numbers in both files, after those of [`squid_auv::Vehicle::findings`].
    pub fn findings(&self) -> Vec<Finding> {
        let (file, depth) = (&self.design.file, self.design.depth);
        let mut all = self.six_dof.findings();
        let pitch = self.design.tracked.iter().filter(|t| t.signal.name == "pitch");
        let scales = pitch.map(|t| t.scale.to_degrees()).filter(|scale| *scale > PITCH_SCALE * (1.0 + 1e-9));
        all.extend(scales.map(|scale| findings::large_pitch_scale(file, scale, PITCH_SCALE)));
        // Half of the hull is above the water if its axis is at the surface.
        let submerged = self.vehicle.geometry.map_or(0.0, |hull| 0.5 * hull.diameter);
        if depth <= submerged {
            all.push(findings::not_submerged(file, depth, submerged));
        }
        let is_held = self.design.view().is_level_held || self.design.tracks("depth").is_some();
        if self.design.speed_min <= 0.0 && !is_held {
            all.push(findings::depth_not_held(file, self.design.speed_min));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use crate::inputs::tests::{shipped, shipped_axis};

    /// The shipped designs give no finding; an unusual pitch scale and trims at the surface give one each.
    #[test]
    fn finds_odd_scales_and_depths() {
        for (vehicle, design) in [("squid", "design"), ("squid", "paper"), ("remus100", "pitch")] {
            assert_eq!(shipped(vehicle, design).findings(), [], "{vehicle} {design}");
        }
        for axis in ["depth", "heading"] {
            assert_eq!(shipped_axis("remus100", "design", Some(axis)).findings(), [], "{axis}");
        }
        let adrift = shipped("bluerov2_heavy", "design").findings();
        let mut inputs = shipped("squid", "design");
        inputs.design.depth = 0.0;
        inputs.design.tracked[0].scale = 1.0;
        let all = [adrift, inputs.findings()].concat();
        let kinds: Vec<&str> = all.iter().map(|one| one.kind.as_str()).collect();
        assert_eq!(kinds, ["depth_not_held", "large_pitch_scale", "not_submerged"]);
        assert!((all[1].value.unwrap() - 1f64.to_degrees()).abs() < 1e-12 && all[2].value == Some(0.0));
        let text: Vec<String> = all.iter().map(ToString::to_string).collect();
        insta::assert_snapshot!(text.join("\n\n"));
    }

    /// 5 rad, written instead of 5 deg.
    #[test]
    fn rejects_impossible_pitch_scale() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid/design.toml");
        let text = squid_base::files::read(&path).unwrap();
        let unit = "\nunit = \"deg\"";
        assert!(text.find(unit).unwrap() < text.find("output = \"speed\"").unwrap());
        let wrong = text.replacen(unit, "\nunit = \"rad\"", 1);
        let refused = crate::inputs::design_file::DesignFile::parse(&wrong, "design.toml", "design");
        let problem = &refused.unwrap_err().mistakes[0].problem;
        assert_eq!(problem.key(), Some("track.scale"));
        insta::assert_snapshot!(problem);
    }
}
