//! Failed checks of a controller.

use serde::Serialize;
use strum::IntoStaticStr;
use thiserror::Error;

/// Failed check of a controller.
#[derive(Debug, Clone, PartialEq, Error, IntoStaticStr, Serialize)]
#[strum(serialize_all = "snake_case")]
#[serde(tag = "check", rename_all = "snake_case")]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum Refusal {
    /// The loop with the fitted model is not stable.
    #[error(
        "at {speed:.3} m/s the loop with the fitted model has a mode with real part {real_part:.3e} rad/s"
    )]
    UnstableFit { speed: f64, real_part: f64 },
    /// The loop of a given controller is not stable.
    #[error(
        "its loop is unstable: the fastest growth is {growth:.2} 1/s, at {speed:.2} m/s; change the gains (often a \
            larger 'kd' helps), or narrow the speed range"
    )]
    UnstableGiven {
        speed: f64,
        /// Real part of the fastest growing mode, 1/s.
        growth: f64,
    },
    /// The loop of a given controller has no gain bound over the range of speed.
    #[error(
        "it is stable at each constant speed, but no gain bound was found for arbitrary trajectories of speed from \
            {low} to {high} m/s{}; narrow the speed range, or let the gains vary less with speed",
        inner(*from, *to, *part)
    )]
    Unbounded {
        /// Largest range with a bound about its centre, m/s.
        from: f64,
        to: f64,
        /// Width of that range relative to the full range.
        part: f64,
        low: f64,
        high: f64,
    },
    /// The loop with the true linearisation is not stable.
    #[error(
        "at {speed:.3} m/s the loop with the true linearisation has a mode with real part {real_part:.3e} rad/s: the \
            fit is too inaccurate; raise model.order, or narrow the speed range"
    )]
    UnstableTruth { speed: f64, real_part: f64 },
    /// The frozen gain exceeds the bound.
    #[error("at {speed:.3} m/s the frozen gain is {gain:.6}, above the bound {bound:.6}")]
    Gain { speed: f64, gain: f64, bound: f64 },
    /// The sampled loop is unstable.
    #[error(
        "at {speed:.3} m/s the loop sampled at {sample_time} s, with the lags of the actuators, is unstable (a mode \
            of modulus {radius:.4}); reduce autopilot.sample_time, or raise control.weight for a slower controller"
    )]
    UnstableSampled {
        speed: f64,
        /// Sample time, s.
        sample_time: f64,
        radius: f64,
    },
    /// The loop is unstable with the actuator lags, which the design ignores.
    #[error(
        "at {speed:.3} m/s the loop with the lags of the actuators has a mode with real part {real_part:.3e} rad/s, \
            even without sampling; set 'lags = true' in [control] to include the lags in the design"
    )]
    UnstableWithLags { speed: f64, real_part: f64 },
    /// The frozen gain with the true linearisation is not finite.
    #[error(
        "at {speed:.3} m/s the frozen gain with the true linearisation is {gain:.4}, not a finite number"
    )]
    TrueGain { speed: f64, gain: f64 },
    /// The parameter loop is not well posed inside the box.
    #[error("the controller's parameter loop is not well posed at rho = {rho:.4}")]
    NotWellPosed { rho: f64 },
}

/// Text of the range of speeds for which a gain was found.
fn inner(from: f64, to: f64, part: f64) -> String {
    if part > 0.0 { format!(", but only for {from:.2} to {to:.2} m/s") } else { String::new() }
}
