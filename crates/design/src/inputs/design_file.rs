//! The design file: the requirements on the controller.
//!
//! Every key is explained in the design files that come with the vehicles.
//!
//! Weights are given by their parameters, not by polynomials: `W_e = (s/peak + bandwidth)/(s + bandwidth
//! steady_error)`, and W_u and the noise `low + (high - low) s/(s + corner)`. All are proper for every value in the
//! ranges below; a value that would make them improper or infinite (peak = 0, bandwidth = inf) is refused with file,
//! line and key.

mod manoeuvre;
mod require;
mod sea;
mod tables;
mod tracked;
mod uncertainty;
mod values;

use auv::Pitch;
use lpv::matrix::Mat;
use lpv::weights::{ReferenceModel, ReferenceWeight, RisingWeight};
pub use require::{REQUIREMENTS, Require, Requirement, Sense};
use scheduled::Manoeuvre;
pub use sea::WorkingSea;
use signals::{DEPTH, PITCH, SIGNALS, SPEED, Signal, States};
pub use uncertainty::{HalfRange, UncertainCoefficient, UncertainParameter, Uncertainty};

/// A range of numbers, with its text for messages.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    least: f64,
    most: f64,
    /// What is allowed.
    pub words: &'static str,
}

impl Range {
    /// Whether a number is in the range; not-a-number is not.
    pub fn allows(&self, v: f64) -> bool {
        (self.least..=self.most).contains(&v)
    }
}

/// w_b of W_e.
pub const BANDWIDTH: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6 (rad/s)" };

/// M_s of W_e. Towards 0 the gain 1/M_s at high frequency grows; at 0 the weight is not proper.
const PEAK: Range = Range {
    least: 1.0 + f64::EPSILON,
    most: 100.0,
    words: "above 1, at most 100; 1/peak is the gain of W_e at high frequency, and with 0 W_e would not be proper",
};

/// Scales of references, by which is divided.
const SCALE: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6" };

/// W_u.
const CONTROL_WEIGHT: Range = Range {
    least: 1e-6,
    most: 1e6,
    words: "from 1e-6 to 1e6; without a weight on the actuators their gains grow without limit",
};

/// Disturbances at the actuators: ten times the limits are far more than any controller could hold.
const DISTURBANCE: Range = Range {
    least: 0.0,
    most: 10.0,
    words: "from 0 to 10; 1 is the larger of |min| and |max| of each actuator",
};

/// Gains at high frequency, relative to those at frequency 0.
const RISE: Range = Range { least: 1.0, most: 1e6, words: "from 1, no less than at low frequencies, to 1e6" };

/// How much more slow references count.
const FOLLOW: Range = Range { least: 1.0, most: 1e4, words: "from 1, as much as fast ones, to 1e4" };

/// By how much waves count more than they are.
const WAVE_WEIGHT: Range = Range { least: 1e-3, most: 1e3, words: "from 0.001 to 1000" };

/// The bound on the rate of the speed.
pub const RATE: Range = Range { least: 1e-6, most: 1e3, words: "from 1e-6 to 1e3 (m/s^2)" };

/// Corners of weights and frequencies of reference models.
const FREQUENCY: Range = Range { least: 1e-4, most: 1e4, words: "from 1e-4 to 1e4 (rad/s)" };

/// Damping ratios of reference models.
const DAMPING: Range = Range { least: 0.3, most: 3.0, words: "from 0.3 to 3" };

/// The time between two ticks.
pub(crate) const SAMPLE_TIME: Range = Range { least: 1e-4, most: 1.0, words: "from 0.0001 to 1 (s)" };

/// Sizes of noise.
const NOISE: Range =
    Range { least: 1e-9, most: 1e6, words: "from 1e-9 to 1e6; without noise gains grow without limit" };

/// A tracked output with its weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// Its place in [`SIGNALS`].
    pub place: usize,
    /// The reference that counts as 1, SI.
    pub scale: f64,
    /// R: how much more slow references count.
    pub references: ReferenceWeight,
    /// W_e.
    pub weight: lpv::weights::TrackingWeight,
    /// The model that the output must follow.
    pub model: Option<ReferenceModel>,
}

/// A measured signal with its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its place in [`SIGNALS`].
    pub place: usize,
    /// What counts as 1, SI.
    pub scale: f64,
    /// The noise, in units of the scale.
    pub noise: RisingWeight,
}

impl Measured {
    /// `C` of the measurements in units of their scales, from the states of the linear model.
    pub fn scaled_outputs(measured: &[Self], states: States) -> Mat {
        scaled_outputs(measured.iter().map(|m| (m.place, m.scale)), states)
    }

    /// Its row of the table of signals.
    pub fn signal(&self) -> &'static Signal {
        &SIGNALS[self.place]
    }
}

impl Tracked {
    /// Its row of the table of signals.
    pub fn signal(&self) -> &'static Signal {
        &SIGNALS[self.place]
    }

    /// `C` of the tracked outputs, a row each, from the states of the linear model.
    pub fn outputs(tracked: &[Self], states: States) -> Mat {
        Mat::from_fn(tracked.len(), states.len(), |i, j| tracked[i].signal().output(&states[j]))
    }

    /// The same in units of their scales.
    pub fn scaled_outputs(tracked: &[Self], states: States) -> Mat {
        scaled_outputs(tracked.iter().map(|t| (t.place, t.scale)), states)
    }
}

/// `C` of signals by their places and scales, in units of these, from the states of the linear model.
pub fn scaled_outputs(signals: impl IntoIterator<Item = (usize, f64)>, states: States) -> Mat {
    let rows: Vec<(usize, f64)> = signals.into_iter().collect();
    Mat::from_fn(rows.len(), states.len(), |i, j| SIGNALS[rows[i].0].output(&states[j]) / rows[i].1)
}

/// A design file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignFile {
    /// The file's name without its ending, and what the command line changed.
    pub name: String,
    /// The file's name.
    pub file: String,
    /// One sentence for people.
    pub description: String,
    /// Lowest speed, m/s.
    pub speed_min: f64,
    /// Highest speed, m/s.
    pub speed_max: f64,
    /// Number of speeds at which the vehicle is linearised.
    pub speeds: usize,
    /// Depth, m.
    pub depth: f64,
    /// What is asked of the pitch in level trim; `None` without the key.
    pub pitch_asked: Option<Pitch>,
    /// What becomes of it, by [`Pitch::over`]; [`Inputs`](crate::inputs::Inputs) chooses it for the vehicle.
    pub pitch: Pitch,
    /// The states of the linear model, those of the vehicle, as above.
    pub states: States,
    /// Order of the polynomials in speed.
    pub order: usize,
    /// Singular values of the LFT below this fraction of the largest are dropped.
    pub drop: f64,
    /// The tracked outputs.
    pub tracked: Vec<Tracked>,
    /// What the controller measures, references apart; none for a controller that measures the tracking errors.
    pub measured: Vec<Measured>,
    /// W_u, in units of each actuator's limit.
    pub control_weight: RisingWeight,
    /// Disturbance at the input, in units of each actuator's limit.
    pub disturbance: f64,
    /// The sea that the controller is made for.
    pub sea: Option<WorkingSea>,
    /// Whether the lags of the actuators are part of the plant of the design.
    pub lags: bool,
    /// Relative back-off from the least gamma.
    pub back_off: f64,
    /// Whether the weights are another design's, see `judged_by`; never so in a file.
    pub judged: bool,
    /// Bound on the rate of the speed for which the controller is made, m/s^2; `None` for one that is made for any
    /// rate.
    pub rate: Option<f64>,
    /// Sample time of the autopilot, s.
    pub sample_time: f64,
    /// How late a command comes after the tick that computes it, s: a multiple of the sample time.
    pub delay: f64,
    /// Whether commands beyond the limits are fed back into the controller.
    pub anti_windup: bool,
    /// What the FMU of the whole loop flies by default.
    pub manoeuvre: Manoeuvre,
    /// Which numbers of the vehicle are uncertain; `None` without the section.
    pub uncertainty: Option<Uncertainty>,
    /// What the finished loop must reach.
    pub require: Require,
}

impl DesignFile {
    /// The design with references that count alike at all frequencies. How closely a model is followed is asked of the
    /// nominal vehicle; what is said of uncertain ones is said in these weights.
    pub fn with_even_references(&self) -> Self {
        let mut even = self.clone();
        even.tracked.iter_mut().for_each(|t| t.references.follow = 1.0);
        even
    }

    /// `count` speeds, evenly spread over the range of the design, both ends included \[m/s\].
    pub fn spread(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.speed_min, self.speed_max);
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
    }

    /// The place in [`SIGNALS`] of the output of which a step is judged first: the pitch, or the depth where that is
    /// tracked and the pitch is not.
    pub fn stepped(&self) -> usize {
        let is_tracked = |place: usize| self.tracked.iter().any(|t| t.place == place);
        if is_tracked(DEPTH) && !is_tracked(PITCH) { DEPTH } else { PITCH }
    }

    /// Whether the depth is tracked or measured, and so a state of the linear models.
    pub fn has_depth(&self) -> bool {
        let places = self.tracked.iter().map(|t| t.place).chain(self.measured.iter().map(|m| m.place));
        places.into_iter().any(|place| place == DEPTH)
    }

    /// Depth \[m\], and what becomes of the pitch in level trim.
    pub fn level(&self) -> (f64, &Pitch) {
        (self.depth, &self.pitch)
    }

    /// The scheduling parameter rho = (V - centre)/half_range: centre and half range, m/s.
    pub fn scheduling(&self) -> (f64, f64) {
        (0.5 * (self.speed_min + self.speed_max), 0.5 * (self.speed_max - self.speed_min))
    }

    /// The scheduling parameter at a speed V along the path \[m/s\].
    pub fn rho(&self, speed: f64) -> f64 {
        let (centre, half_range) = self.scheduling();
        (speed - centre) / half_range
    }

    /// What the controller takes in of the vehicle, each by its place in [`SIGNALS`] with its scale: the measurements,
    /// or the errors. References apart are taken in as they are; there is no loop through them.
    pub fn fed_back(&self) -> Vec<(usize, f64)> {
        if self.measured.is_empty() {
            self.tracked.iter().map(|t| (t.place, t.scale)).collect()
        } else {
            self.measured.iter().map(|m| (m.place, m.scale)).collect()
        }
    }

    /// The place in y of the measurement of a tracked output, or of its error; `None` for one that is not measured.
    pub fn feedback_row(&self, tracked: usize) -> Option<usize> {
        if self.measured.is_empty() {
            return Some(tracked);
        }
        let place = self.tracked[tracked].place;
        self.measured.iter().position(|m| m.place == place).map(|row| self.tracked.len() + row)
    }

    /// The delay in ticks.
    pub fn delay_ticks(&self) -> usize {
        (self.delay / self.sample_time).round() as usize
    }

    /// The frequency w of the filter of the speed reference, `w/(s + w)`, rad/s: the model that the speed follows,
    /// for a controller with references apart; `None` for one that measures the errors.
    pub fn reference_filter(&self) -> Option<f64> {
        let speed = self.tracked.iter().find(|t| t.place == SPEED && !self.measured.is_empty())?;
        Some(speed.model?.frequency)
    }

    /// The file, and the name of what the command line made of it.
    pub fn source(&self) -> String {
        let Self { name, file, .. } = self;
        if *file == format!("{name}.toml") { file.clone() } else { format!("{file} as {name}") }
    }

    /// The same design with another bandwidth of every W_e, as the paper tunes it in its Fig. 5.
    #[must_use]
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Self {
        for tracked in &mut self.tracked {
            tracked.weight.bandwidth = bandwidth;
        }
        self.name = format!("{}-bandwidth-{bandwidth}", self.name);
        self
    }
}
