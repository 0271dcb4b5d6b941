//! Ends of the envelope, and their limits.

use crate::designs::inputs;

/// REMUS 100 climbs less steeply than 30 deg at low speed, because its planes hold the weight of its bow. A path of at
/// most 10 deg is possible at the highest speed.
#[test]
fn each_end_names_its_limit() {
    let mut inputs = inputs("remus100");
    let speeds = [inputs.design.speed_min, inputs.design.speed_max];
    let [slow, fast]: [_; 2] = inputs.axis().ends(&speeds, false).unwrap().try_into().unwrap();
    let by = |ends: &[squid_design::linearise::envelope::End; 2]| {
        ends.iter().map(|end| end.limited_by.clone()).collect::<Vec<String>>()
    };
    assert_eq!(by(&slow), ["`envelope.pitch`", "stern_planes"]);
    assert_eq!(by(&fast), ["`envelope.pitch`", "`envelope.pitch`"]);
    for [down, up] in [&slow, &fast] {
        assert!(down.pitch < 0.0 && down.path < 0.0 && up.pitch > 0.0 && up.path > 0.0, "{down:?} {up:?}");
    }
    assert!((fast[1].pitch.to_degrees() - 30.0).abs() < 1e-9, "{fast:?}");
    inputs.design.envelope.path_angle = 10f64.to_radians();
    let [fast]: [_; 1] = inputs.axis().ends(&speeds[1..], true).unwrap().try_into().unwrap();
    assert_eq!(by(&fast), ["`envelope.path_angle`"; 2]);
    assert!(fast.iter().all(|end| (end.path.abs().to_degrees() - 10.0).abs() < 0.1), "{fast:?}");
}
