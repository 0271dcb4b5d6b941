//! Design file: the requirements on the controller.
//!
//! Every key is explained in the design files of the shipped vehicles.
//!
//! Weights are given by their parameters, not by polynomials: `W_e = (s/peak + bandwidth)/(s + bandwidth
//! steady_error)`; W_u and the noise are `low + (high - low) s/(s + corner)`. All are proper for every value in the
//! ranges below. A value that would make them improper or infinite (peak = 0, bandwidth = inf) is refused with file,
//! line and key.

mod envelope;
mod failsafe;
mod manoeuvre;
pub mod relative_weight;
mod require;
mod sea;
mod tables;
mod tracked;
mod uncertainty;
mod values;

use relative_weight::RelativeWeight;
pub use require::{REQUIREMENTS, Require, Requirement, Sense};
pub use sea::WorkingSea;
use squid_auv::longitudinal::DEPTH;
use squid_auv::{Pitch, View};
use squid_lpv::matrix::Mat;
use squid_lpv::weights::{ReferenceModel, ReferenceWeight, RisingWeight};
use squid_pid::Pid;
use squid_scheduled::Manoeuvre;
use squid_signals::{Interface, Signal, States};
pub use uncertainty::{HalfRange, UncertainCoefficient, UncertainParameter, Uncertainty};

/// Range of numbers, with its text for messages.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    least: f64,
    most: f64,
    /// Text of the allowed range.
    pub text: &'static str,
}

impl Range {
    /// Returns `true` if a number is in the range; NaN is not.
    pub fn allows(&self, v: f64) -> bool {
        (self.least..=self.most).contains(&v)
    }
}

/// Bandwidths w_b of W_e.
pub const BANDWIDTH: Range = Range { least: 1e-6, most: 1e6, text: "from 1e-6 to 1e6 (rad/s)" };

/// Peaks M_s of W_e. The high-frequency gain 1/M_s grows as the peak approaches 0, where the weight is improper.
const PEAK: Range = Range {
    least: 1.0 + f64::EPSILON,
    most: 100.0,
    text: "above 1, at most 100 (1/peak is the gain of W_e at high frequency; with 0 W_e would be improper)",
};

/// Scales of references, which are divisors.
const SCALE: Range = Range { least: 1e-6, most: 1e6, text: "from 1e-6 to 1e6" };

/// Weights W_u on the commands.
const CONTROL_WEIGHT: Range = Range {
    least: 1e-6,
    most: 1e6,
    text: "from 1e-6 to 1e6 (without a weight on the actuators the gains grow without limit)",
};

/// Disturbances at the actuators: no controller could reject ten times their limits.
const DISTURBANCE: Range = Range {
    least: 0.0,
    most: 10.0,
    text: "from 0 to 10 (1 is the larger of |min| and |max| of each actuator)",
};

/// High-frequency gains, relative to those at frequency 0.
const RISE: Range = Range { least: 1.0, most: 1e6, text: "from 1 (no smaller than at low frequency) to 1e6" };

/// Emphasis of slow references.
const FOLLOW: Range =
    Range { least: 1.0, most: 1e4, text: "from 1 (equal to that of fast references) to 1e4" };

/// Factors on the wave amplitude.
const WAVE_WEIGHT: Range = Range { least: 1e-3, most: 1e3, text: "from 0.001 to 1000" };

/// Relative rise of gamma for fewer controller states and channels.
const REDUCE: Range =
    Range { least: 0.0, most: 0.5, text: "from 0 to 0.5, a relative increase of gamma (0 keeps all states)" };
/// Default of `reduce`.
const DEFAULT_REDUCE: f64 = 0.03;

/// Bounds on the rate of the speed.
pub const RATE: Range = Range { least: 1e-6, most: 1e3, text: "from 1e-6 to 1e3 (m/s^2)" };

/// Corners of weights and frequencies of reference models.
const FREQUENCY: Range = Range { least: 1e-4, most: 1e4, text: "from 1e-4 to 1e4 (rad/s)" };

/// Damping ratios of reference models.
const DAMPING: Range = Range { least: 0.3, most: 3.0, text: "from 0.3 to 3" };

/// Sample times.
pub(crate) const SAMPLE_TIME: Range = Range { least: 1e-4, most: 1.0, text: "from 0.0001 to 1 (s)" };

/// Noise levels.
const NOISE: Range =
    Range { least: 1e-9, most: 1e6, text: "from 1e-9 to 1e6 (without noise the gains grow without limit)" };

/// Tracked output with its weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// Index among the signals of the interface.
    pub index: usize,
    /// Signal of that index.
    pub signal: &'static Signal,
    /// Unit of the reference, SI.
    pub scale: f64,
    /// Weight R, the emphasis of slow references.
    pub references: ReferenceWeight,
    /// Weight W_e on the tracking error.
    pub weight: squid_lpv::weights::TrackingWeight,
    /// Reference model of the output.
    pub model: Option<ReferenceModel>,
}

/// Measured signal with its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Index among the signals of the interface.
    pub index: usize,
    /// Signal of that index.
    pub signal: &'static Signal,
    /// Unit of the measurement, SI.
    pub scale: f64,
    /// Noise, in units of the scale.
    pub noise: RisingWeight,
}

impl Measured {
    /// Returns `C` of the measurements from the states of the linear model, in units of their scales.
    pub fn scaled_outputs(measured: &[Self], states: States) -> Mat {
        scaled_outputs(measured.iter().map(|m| (m.signal, m.scale)), states)
    }
}

impl Tracked {
    /// Returns `C` of the tracked outputs from the states of the linear model, one row each.
    pub fn outputs(tracked: &[Self], states: States) -> Mat {
        Mat::from_fn(tracked.len(), states.len(), |i, j| tracked[i].signal.output(&states[j]))
    }

    /// Returns `C` of the tracked outputs in units of their scales.
    pub fn scaled_outputs(tracked: &[Self], states: States) -> Mat {
        scaled_outputs(tracked.iter().map(|t| (t.signal, t.scale)), states)
    }
}

/// Returns `C` of signals with their scales, from the states of the linear model, in units of the scales.
pub fn scaled_outputs<'a>(signals: impl IntoIterator<Item = (&'a Signal, f64)>, states: States) -> Mat {
    let rows: Vec<(&Signal, f64)> = signals.into_iter().collect();
    Mat::from_fn(rows.len(), states.len(), |i, j| rows[i].0.output(&states[j]) / rows[i].1)
}

/// Limits of the references.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Envelope {
    /// Fraction of each actuator's limits that is available to hold a pitch.
    pub authority: f64,
    /// Least and largest pitch reference, rad, even if the actuators can hold more.
    pub pitch: [f64; 2],
    /// Steepest path, up or down, of a reference of depth, rad.
    pub path_angle: f64,
    /// Fastest turn of a reference of heading, rad/s.
    pub turn_rate: f64,
}

impl Default for Envelope {
    fn default() -> Self {
        let [steepest, path_angle, turn_rate] = [30.0f64, 30.0, 10.0].map(f64::to_radians);
        Self { authority: 0.85, pitch: [-steepest, steepest], path_angle, turn_rate }
    }
}

/// Behaviour of the autopilot when sensors fail.
#[derive(Debug, Clone, PartialEq)]
pub struct Failsafe {
    /// Time without change after which a measurement that should have moved counts as lost, s; 0 for never.
    pub stale_after: f64,
    /// Actuator outputs if the vehicle cannot be controlled.
    pub safe: Safe,
    /// Settings of single sensors.
    pub sensors: Vec<SensorKeys>,
}

impl Default for Failsafe {
    fn default() -> Self {
        Self { stale_after: 0.5, safe: Safe::Slow, sensors: Vec::new() }
    }
}

/// Settings of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorKeys {
    /// Signal of the sensor.
    pub signal: &'static Signal,
    /// Quantisation of its values, SI; `None` if it follows from its noise.
    pub resolution: Option<f64>,
    /// Longest time between two values, s; 0 for a value at each tick.
    pub period: f64,
}

/// Actuator outputs if the vehicle cannot be controlled; control surfaces are at zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Safe {
    /// Thrust of the trim at the slowest speed.
    Slow,
    /// Zero thrust.
    Stop,
}

impl Safe {
    /// All variants.
    pub const ALL: [Self; 2] = [Self::Slow, Self::Stop];

    /// Returns the name in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Stop => "stop",
        }
    }
}

/// Checked design file.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignFile {
    /// Name of the design: that of the autopilot, or, of several axes, the signal that this one steers, plus changes
    /// from the command line.
    pub name: String,
    /// Name of the autopilot: the file's name without extension, plus changes from the command line.
    pub autopilot: String,
    /// Index of this axis in its file; `None` in a file of one axis.
    pub axis: Option<usize>,
    /// Name of the file.
    pub file: String,
    /// Description in one sentence.
    pub description: String,
    /// Lowest speed, m/s.
    pub speed_min: f64,
    /// Highest speed, m/s.
    pub speed_max: f64,
    /// Number of speeds at which the vehicle is linearised.
    pub speeds: usize,
    /// Depth, m.
    pub depth: f64,
    /// Pitch in level trim as given in the file; `None` without the key.
    pub pitch_asked: Option<Pitch>,
    /// Pitch in level trim for the vehicle, by [`Pitch::over`]; set by [`Inputs`](crate::inputs::Inputs).
    pub pitch: Pitch,
    /// States of the linear model; set by [`Inputs`](crate::inputs::Inputs).
    pub states: States,
    /// States and signals of the vehicle.
    pub interface: &'static Interface,
    /// Order of the polynomials in speed.
    pub order: usize,
    /// Fraction of the largest singular value of the LFT below which singular values are dropped.
    pub drop: f64,
    /// Tracked outputs.
    pub tracked: Vec<Tracked>,
    /// Measurements of a controller with separate references; empty for one that measures the tracking errors.
    pub measured: Vec<Measured>,
    /// Weight W_u, in units of each actuator's limit.
    pub control_weight: RisingWeight,
    /// Weights of single actuators, relative to W_u; 1 for those that are not named.
    pub relative_weights: Vec<RelativeWeight>,
    /// Disturbance at the input, in units of each actuator's limit.
    pub disturbance: f64,
    /// Sea for which the controller is designed.
    pub sea: Option<WorkingSea>,
    /// `true` if the plant of the design has the actuator lags.
    pub lags: bool,
    /// Given controller, whose bound is found and proved; `None` if the design computes one.
    pub controller: Option<Pid>,
    /// Relative back-off from the least gamma.
    pub back_off: f64,
    /// Allowed relative rise of gamma for fewer controller states and channels; `None` keeps all.
    pub reduce: Option<f64>,
    /// `true` if the weights are those of another design, see `with_weights_of`; never in a file.
    pub judged: bool,
    /// Bound on the rate of the speed for the synthesis, m/s^2; `None` for arbitrary rates.
    pub rate: Option<f64>,
    /// Sample time of the autopilot, s.
    pub sample_time: f64,
    /// Delay of a command after its tick, s: a multiple of the sample time.
    pub delay: f64,
    /// `true` if the controller has anti-windup.
    pub anti_windup: bool,
    /// Limits of the references.
    pub envelope: Envelope,
    /// Behaviour when sensors fail.
    pub failsafe: Failsafe,
    /// Default manoeuvre of the FMU of the complete loop.
    pub manoeuvre: Manoeuvre,
    /// Uncertain parameters of the vehicle; `None` without the section.
    pub uncertainty: Option<Uncertainty>,
    /// Requirements on the finished loop.
    pub require: Require,
}

impl DesignFile {
    /// Returns the design with reference weights of 1 at all frequencies. The emphasis of slow references is for the
    /// nominal vehicle; results for uncertain vehicles are in these weights.
    pub fn with_unweighted_references(&self) -> Self {
        let mut unweighted = self.clone();
        unweighted.tracked.iter_mut().for_each(|t| t.references.follow = 1.0);
        unweighted
    }

    /// Returns the weight of an actuator relative to W_u.
    pub fn relative_weight(&self, actuator: &str) -> f64 {
        self.relative_weights.iter().find(|one| one.actuator == actuator).map_or(1.0, |one| one.factor)
    }

    /// Returns W_u of an actuator.
    pub fn weight_on(&self, actuator: &str) -> RisingWeight {
        let (factor, all) = (self.relative_weight(actuator), self.control_weight);
        RisingWeight { low: factor * all.low, high: factor * all.high, ..all }
    }

    /// Returns `count` speeds, evenly spaced over the range of the design, including both ends \[m/s\].
    pub fn spread(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.speed_min, self.speed_max);
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
    }

    /// Returns the index of the signal whose step is assessed first: the first tracked signal of the interface besides
    /// the scheduled one.
    pub fn stepped(&self) -> usize {
        let others =
            self.tracked.iter().map(|t| t.index).filter(|index| Some(*index) != self.interface.scheduled());
        others.min().unwrap_or_default()
    }

    /// Returns the name of the signal whose step is assessed first: the signal that the axis steers.
    pub fn steered_signal(&self) -> &'static str {
        self.interface.signals[self.stepped()].name
    }

    /// Returns `true` if a signal is tracked or measured.
    pub fn uses(&self, index: usize) -> bool {
        self.tracked.iter().any(|t| t.index == index) || self.measured.iter().any(|m| m.index == index)
    }

    /// Returns `true` if depth is tracked or measured, and therefore a state of the linear models.
    pub fn has_depth(&self) -> bool {
        !self.view().is_level_held && self.uses(DEPTH)
    }

    /// Returns the view of the vehicle's motion to which the axis belongs.
    pub fn view(&self) -> &'static View {
        View::of_states(self.interface.states)
    }

    /// Returns the index of a signal, by its name, among the tracked outputs.
    pub fn tracks(&self, name: &str) -> Option<usize> {
        self.tracked.iter().position(|t| t.signal.name == name)
    }

    /// Returns the index of the scheduled signal among the tracked outputs.
    pub fn tracked_speed(&self) -> Option<usize> {
        self.tracked.iter().position(|t| Some(t.index) == self.interface.scheduled())
    }

    /// Returns the depth \[m\] and the pitch in level trim.
    pub fn level(&self) -> (f64, &Pitch) {
        (self.depth, &self.pitch)
    }

    /// Returns centre and half range of the scheduling parameter rho = (V - centre)/half_range, m/s.
    pub fn scheduling(&self) -> (f64, f64) {
        (0.5 * (self.speed_min + self.speed_max), 0.5 * (self.speed_max - self.speed_min))
    }

    /// Returns the scheduling parameter at a speed V along the path \[m/s\].
    pub fn rho(&self, speed: f64) -> f64 {
        let (centre, half_range) = self.scheduling();
        (speed - centre) / half_range
    }

    /// Returns the signals that the controller measures, each with its scale: the measurements, or the errors. Separate
    /// references are not included, because no loop closes through them.
    pub fn fed_back(&self) -> Vec<(&'static Signal, f64)> {
        if self.measured.is_empty() {
            self.tracked.iter().map(|t| (t.signal, t.scale)).collect()
        } else {
            self.measured.iter().map(|m| (m.signal, m.scale)).collect()
        }
    }

    /// Returns the index in y of the measurement or the error of a tracked output; `None` if it is not measured.
    pub fn feedback_row(&self, tracked: usize) -> Option<usize> {
        if self.measured.is_empty() {
            return Some(tracked);
        }
        let index = self.tracked[tracked].index;
        self.measured.iter().position(|m| m.index == index).map(|row| self.tracked.len() + row)
    }

    /// Returns the delay in ticks.
    pub fn delay_ticks(&self) -> usize {
        (self.delay / self.sample_time).round() as usize
    }

    /// Returns the frequency w of the filter of the speed reference, `w/(s + w)`, rad/s: the reference model of the
    /// speed, for a controller with separate references; `None` for one that measures the errors.
    pub fn reference_filter(&self) -> Option<f64> {
        let speed = self.tracked_speed().filter(|_| !self.measured.is_empty())?;
        Some(self.tracked[speed].model?.frequency)
    }

    /// Returns the file name, with the axis in a file of several, and the autopilot's name if the command line changed
    /// it.
    pub fn source(&self) -> String {
        let own = self.axis.map(|_| format!("{} of ", self.steered_signal())).unwrap_or_default();
        own + &self.source_of_all()
    }

    /// Returns the file name, and the autopilot's name if the command line changed it.
    pub fn source_of_all(&self) -> String {
        let Self { autopilot, file, .. } = self;
        if *file == format!("{autopilot}.toml") { file.clone() } else { format!("{file} as {autopilot}") }
    }

    /// Returns the design under another name: the changes are appended to the names of design and autopilot.
    #[must_use]
    pub fn renamed(mut self, changes: &str) -> Self {
        for name in [&mut self.name, &mut self.autopilot] {
            *name = format!("{name}-{changes}");
        }
        self
    }

    /// Returns the design with another bandwidth of every W_e, which the paper tunes in its Fig. 5.
    #[must_use]
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Self {
        for tracked in &mut self.tracked {
            tracked.weight.bandwidth = bandwidth;
        }
        self.renamed(&format!("bandwidth-{bandwidth}"))
    }
}
