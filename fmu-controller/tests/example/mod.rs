//! Small example designs.

#![allow(clippy::unwrap_used)]

use serde_json::{Value, json};

/// Returns a design with one state and one scheduled channel that tracks pitch with a thruster and a fin.
pub fn design() -> Value {
    json!({
        "format": "squid-controller/1",
        "vehicle": {"name": "Test", "status": "surrogate"}, "design": "default", "sample_time": 0.02,
        "signals": [
            {"name": "pitch", "unit": "rad", "measured": "pitch angle", "level": "trim", "nominal": 0.1,
             "range": [-std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2],
             "reference": {"name": "pitch_reference", "description": "wanted pitch angle"}},
            {"name": "speed", "unit": "m/s", "measured": "forward speed", "level": "scheduled", "nominal": 1.0,
             "reference": {"name": "speed_reference", "description": "wanted forward speed"}},
            {"name": "pitch_rate", "unit": "rad/s", "measured": "rate of pitch", "level": "zero", "nominal": 0.1}],
        "scheduling": {"quantity": "speed", "minimum": 0.5, "maximum": 3.0, "centre": 1.75, "half_range": 1.25},
        "controller_inputs": [{"signal": "pitch", "kind": "error", "unit": "rad", "scale": 0.17}],
        "actuators": [
            {"name": "thruster", "unit": "N", "scale": 100.0, "minimum": -60.0, "maximum": 100.0},
            {"name": "fin", "unit": "rad", "scale": 0.2, "minimum": -0.25, "maximum": 0.25}],
        "lft": {"blocks": [1], "A": [[-1.0]], "By": [[1.0]], "Bt": [[0.2]], "Cu": [[0.1], [0.3]],
                "Duy": [[0.0], [0.5]], "Dut": [[0.0], [0.1]], "Ct": [[0.3]], "Dty": [[0.1]], "Dtt": [[0.2]]},
        "trim": {"speed": [0.5, 3.0], "forward_speed": [0.49, 3.0], "signals": {"pitch": [-0.1, -0.01]},
                 "actuators": [[2.0, 0.1], [70.0, 0.01]]},
        "gamma": {"optimum": 0.79, "bound": 0.85, "back_off": 1.1, "certified": false},
        "inputs": {"vehicle_sha256": "00", "design_sha256": "11"}
    })
}

/// Returns the same design with measured pitch rate and filtered references.
pub fn with_pitch_rate() -> Value {
    let mut design = design();
    design["reference_filter"] = json!(0.5);
    design["controller_inputs"] = json!([
        {"signal": "pitch", "kind": "reference", "unit": "rad", "scale": 0.17},
        {"signal": "pitch", "kind": "measurement", "unit": "rad", "scale": 0.17},
        {"signal": "pitch_rate", "kind": "measurement", "unit": "rad/s", "scale": 0.1}]);
    design["lft"]["By"] = json!([[1.0, -1.0, 0.0]]);
    design["lft"]["Duy"] = json!([[0.0, 0.0, 0.0], [0.5, -0.5, -0.2]]);
    design["lft"]["Dty"] = json!([[0.1, -0.1, 0.0]]);
    design
}
