//! Design with the weights of another.

use crate::error::InputError;
use crate::inputs::design_file::DesignFile;
use squid_lpv::weights::RisingWeight;

impl DesignFile {
    /// Returns the loop of this design with the W_e, W_u and disturbance of a design whose controller measures only the
    /// tracking errors. The errors are relative to the references themselves, without reference models; reference
    /// weights are 1 at all frequencies, and there is no noise.
    ///
    /// # Errors
    /// [`InputError::Weights`] if the other design has measurements, or other tracked outputs or scales.
    pub fn with_weights_of(&self, other: &Self) -> Result<Self, InputError> {
        let wrong = |why| InputError::Weights { design: self.name.clone(), weights: other.name.clone(), why };
        if !other.measured.is_empty() {
            return Err(wrong("it has [[measure]], whose noise and models belong to its own controller"));
        }
        let outputs = |d: &Self| d.tracked.iter().map(|t| (t.index, t.scale)).collect::<Vec<_>>();
        if outputs(self) != outputs(other) {
            return Err(wrong("its [[track]] differs; outputs, order and scales must be the same"));
        }
        let mut judged = self.with_unweighted_references();
        (judged.judged, judged.sea) = (true, None);
        judged.tracked.iter_mut().zip(&other.tracked).for_each(|(this, given)| this.weight = given.weight);
        judged.measured.iter_mut().for_each(|m| m.noise = RisingWeight::constant(0.0));
        (judged.control_weight, judged.disturbance) = (other.control_weight, other.disturbance);
        judged.relative_weights.clone_from(&other.relative_weights);
        Ok(judged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn design(path: &str) -> DesignFile {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
        DesignFile::parse(&std::fs::read_to_string(&path).unwrap(), path.to_str().unwrap(), "other").unwrap()
    }

    #[test]
    fn judges_design_in_weights_of_error_feedback() {
        let own = design("vehicles/squid/design.toml");
        let former = design("tests/designs/errors_alone.toml");
        let judged = own.with_weights_of(&former).unwrap();
        for (t, given) in judged.tracked.iter().zip(&former.tracked) {
            assert_eq!((t.weight, t.references.follow), (given.weight, 1.0));
        }
        assert_eq!((judged.control_weight, judged.disturbance), (former.control_weight, former.disturbance));
        assert!(judged.judged && judged.measured.iter().all(|m| m.noise.high == 0.0));
        // The loop itself is unchanged: filter, measurements, lags.
        assert_eq!((judged.reference_filter(), judged.lags), (own.reference_filter(), own.lags));

        let remus = design("tests/designs/remus100_errors_alone.toml");
        let refused = [&own, &remus].map(|other| own.with_weights_of(other).unwrap_err().to_string());
        insta::assert_snapshot!(refused.join("\n"));
    }
}
