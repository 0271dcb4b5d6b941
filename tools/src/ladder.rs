//! What `squid design --ladder` prints: what each assumption about the speed costs.

use crate::design::Finished;
use crate::error::Error;
use crate::inputs::Inputs;
use lpv::ladder::{Ladder, LadderOptions, ladder};

/// Rates of speed at which the finished loop is analysed, m/s^2.
const ACCELERATIONS: [f64; 4] = [0.01, 0.05, 0.125, 0.5];

/// Speeds for which a controller of their own is sought.
const FROZEN_SPEEDS: usize = 6;

/// Climbs the ladder of a finished design.
///
/// # Errors
/// [`Error::Ladder`] when the design is not one of a scheduled plant.
pub fn climb(inputs: &Inputs, finished: &Finished) -> Result<String, Error> {
    let (centre, half_range) = inputs.design.scheduling();
    let theta_of = |v: f64| (v - centre) / half_range;
    let options = LadderOptions {
        thetas: crate::model::speeds(inputs, FROZEN_SPEEDS).into_iter().map(theta_of).collect(),
        rates: ACCELERATIONS.iter().map(|a| a / half_range).collect(),
        ..LadderOptions::default()
    };
    let found = ladder(&finished.plant, &finished.design, &options)?;
    Ok(words(&found, centre, half_range))
}

fn words(found: &Ladder, centre: f64, half_range: f64) -> String {
    let mut out = String::from("The best controller under each assumption, least gamma\n");
    let row = |name: &str, value: Result<f64, String>| match value {
        Ok(gamma) => format!("  {name:<62} {gamma:8.4}\n"),
        Err(reason) => format!("  {name:<62} {reason}\n"),
    };
    for (theta, gamma) in &found.frozen_optimum {
        let v = centre + half_range * theta;
        out += &row(&format!("made for {v:.2} m/s alone"), gamma.clone().map_err(|e| e.to_string()));
    }
    let text = |r: &Result<f64, lpv::error::SynthesisError>| r.clone().map_err(|e| e.to_string());
    out += &row("scheduled, any course of speed; symmetric and skew scalings", text(&found.scheduled));
    out += &row("the same with symmetric scalings alone", text(&found.scheduled_symmetric));
    out += "\nThe gain of the finished loop\n";
    let frozen_speed = centre + half_range * found.frozen_gain.theta;
    out += &row(&format!("frozen speed, largest at {frozen_speed:.2} m/s"), Ok(found.frozen_gain.gamma));
    for (rate, bound) in &found.bounded_rate {
        let value = bound.as_ref().map(|b| b.gamma).map_err(ToString::to_string);
        out += &row(&format!("speed changing by at most {:.3} m/s^2 (on a grid)", rate * half_range), value);
    }
    let fast = found.arbitrarily_fast.as_ref().map(|b| b.gamma).map_err(ToString::to_string);
    out += &row("speed changing arbitrarily fast (on a grid)", fast);
    out += &row("the same, certified (no grid)", Ok(found.certified));
    for disorder in found.disorders() {
        out += &format!("  CONTRADICTION with theory beyond the solver's tolerance: {disorder:?}\n");
    }
    out
}
