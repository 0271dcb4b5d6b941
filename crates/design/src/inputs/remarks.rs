//! Improbable but allowed values in the files of a design.

use crate::inputs::Inputs;
use squid_auv::rounded;

/// Unit of the pitch error above which it is unusual, deg: the linear models do not hold so far.
const PITCH_SCALE: f64 = 45.0;

impl Inputs {
    /// Returns remarks on improbable numbers in both files, one sentence each, including those of
    /// [`squid_auv::Vehicle::remarks`].
    pub fn remarks(&self) -> Vec<String> {
        let (file, depth) = (&self.design.file, self.design.depth);
        let pitch =
            self.design.tracked.iter().filter(|t| t.signal.name == "pitch").map(|t| t.scale.to_degrees());
        let pitch = pitch.filter(|scale| *scale > PITCH_SCALE * (1.0 + 1e-9)).map(|scale| {
            format!(
                "{file}: the unit of the pitch error ('track.scale') is {} deg; more than {PITCH_SCALE} deg is \
                 unusual: check its unit",
                rounded(scale)
            )
        });
        // Half of the hull is above the water if its axis is at the surface.
        let submerged = self.vehicle.geometry.map_or(0.0, |hull| 0.5 * hull.diameter);
        let surfaced = (depth <= submerged).then(|| {
            format!(
                "{file}: 'model.depth' is {} m, where the hull is not submerged: the equations hold in deep water; \
                 give the depth at which the vehicle works",
                squid_auv::number(depth)
            )
        });
        let is_held = self.design.view().is_level_held || self.design.tracks("depth").is_some();
        let adrift = (self.design.speed_min <= 0.0 && !is_held).then(|| {
            format!(
                "{file}: nothing holds the depth at {} m/s ('model.speed_min'), where no pitch changes it: track \
                 \"depth\", too, or begin the range above 0 m/s",
                squid_auv::number(self.design.speed_min)
            )
        });
        self.whole.remarks().into_iter().chain(pitch).chain(surfaced).chain(adrift).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::inputs::tests::{shipped, shipped_axis};

    /// The shipped designs get no remark; an unusual pitch scale and trims at the surface get one each, with the
    /// numbers.
    #[test]
    fn remarks_on_odd_scales_and_depths() {
        for (vehicle, design) in [("squid", "design"), ("squid", "paper"), ("remus100", "pitch")] {
            assert_eq!(shipped(vehicle, design).remarks(), [""; 0], "{vehicle} {design}");
        }
        for axis in ["depth", "heading"] {
            assert_eq!(shipped_axis("remus100", "design", Some(axis)).remarks(), [""; 0], "{axis}");
        }
        let adrift = shipped("bluerov2_heavy", "design").remarks();
        let mut inputs = shipped("squid", "design");
        inputs.design.depth = 0.0;
        inputs.design.tracked[0].scale = 1.0;
        let remarks = inputs.remarks();
        assert_eq!((adrift.len(), remarks.len()), (1, 2), "{adrift:?} {remarks:?}");
        insta::assert_snapshot!([adrift, remarks].concat().join("\n\n"));
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
