//! The design file: the requirements on the controller.
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

/// A range of numbers, with its text for messages.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    least: f64,
    most: f64,
    /// The allowed range in words.
    pub words: &'static str,
}

impl Range {
    /// Whether a number is in the range; NaN is not.
    pub fn allows(&self, v: f64) -> bool {
        (self.least..=self.most).contains(&v)
    }
}

/// w_b of W_e.
pub const BANDWIDTH: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6 (rad/s)" };

/// M_s of W_e. As it approaches 0 the high-frequency gain 1/M_s grows; at 0 the weight is improper.
const PEAK: Range = Range {
    least: 1.0 + f64::EPSILON,
    most: 100.0,
    words: "above 1, at most 100; 1/peak is the gain of W_e at high frequency, and with 0 W_e would not be proper",
};

/// Scales of references, which are divisors.
const SCALE: Range = Range { least: 1e-6, most: 1e6, words: "from 1e-6 to 1e6" };

/// W_u.
const CONTROL_WEIGHT: Range = Range {
    least: 1e-6,
    most: 1e6,
    words: "from 1e-6 to 1e6; without a weight on the actuators their gains grow without limit",
};

/// Disturbances at the actuators: no controller could reject ten times their limits.
const DISTURBANCE: Range = Range {
    least: 0.0,
    most: 10.0,
    words: "from 0 to 10; 1 is the larger of |min| and |max| of each actuator",
};

/// High-frequency gains, relative to those at frequency 0.
const RISE: Range = Range { least: 1.0, most: 1e6, words: "from 1, no less than at low frequencies, to 1e6" };

/// The emphasis of slow references.
const FOLLOW: Range = Range { least: 1.0, most: 1e4, words: "from 1, as much as fast ones, to 1e4" };

/// The factor on the waves.
const WAVE_WEIGHT: Range = Range { least: 1e-3, most: 1e3, words: "from 0.001 to 1000" };

/// The rise of gamma for fewer controller states and channels.
const REDUCE: Range =
    Range { least: 0.0, most: 0.5, words: "from 0 to 0.5, a relative rise of gamma; 0 keeps all states" };
/// `reduce` where the file gives none.
const DEFAULT_REDUCE: f64 = 0.03;

/// The bound on the rate of the speed.
pub const RATE: Range = Range { least: 1e-6, most: 1e3, words: "from 1e-6 to 1e3 (m/s^2)" };

/// Corners of weights and frequencies of reference models.
const FREQUENCY: Range = Range { least: 1e-4, most: 1e4, words: "from 1e-4 to 1e4 (rad/s)" };

/// Damping ratios of reference models.
const DAMPING: Range = Range { least: 0.3, most: 3.0, words: "from 0.3 to 3" };

/// Sample times.
pub(crate) const SAMPLE_TIME: Range = Range { least: 1e-4, most: 1.0, words: "from 0.0001 to 1 (s)" };

/// Noise levels.
const NOISE: Range =
    Range { least: 1e-9, most: 1e6, words: "from 1e-9 to 1e6; without noise gains grow without limit" };

/// A tracked output with its weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// Its index among the signals of the interface.
    pub index: usize,
    /// Its row there.
    pub signal: &'static Signal,
    /// The unit of its reference, SI.
    pub scale: f64,
    /// R: the emphasis of slow references.
    pub references: ReferenceWeight,
    /// W_e.
    pub weight: squid_lpv::weights::TrackingWeight,
    /// The reference model of the output.
    pub model: Option<ReferenceModel>,
}

/// A measured signal with its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its index among the signals of the interface.
    pub index: usize,
    /// Its row there.
    pub signal: &'static Signal,
    /// Its unit, SI.
    pub scale: f64,
    /// The noise, in units of the scale.
    pub noise: RisingWeight,
}

impl Measured {
    /// `C` of the measurements from the states of the linear model, in units of their scales.
    pub fn scaled_outputs(measured: &[Self], states: States) -> Mat {
        scaled_outputs(measured.iter().map(|m| (m.signal, m.scale)), states)
    }
}

impl Tracked {
    /// `C` of the tracked outputs from the states of the linear model, one row each.
    pub fn outputs(tracked: &[Self], states: States) -> Mat {
        Mat::from_fn(tracked.len(), states.len(), |i, j| tracked[i].signal.output(&states[j]))
    }

    /// `C` of the tracked outputs in units of their scales.
    pub fn scaled_outputs(tracked: &[Self], states: States) -> Mat {
        scaled_outputs(tracked.iter().map(|t| (t.signal, t.scale)), states)
    }
}

/// `C` of signals with their scales, from the states of the linear model, in units of the scales.
pub fn scaled_outputs<'a>(signals: impl IntoIterator<Item = (&'a Signal, f64)>, states: States) -> Mat {
    let rows: Vec<(&Signal, f64)> = signals.into_iter().collect();
    Mat::from_fn(rows.len(), states.len(), |i, j| rows[i].0.output(&states[j]) / rows[i].1)
}

/// What the references may ask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Envelope {
    /// The share of each actuator's limits that holding a pitch may take.
    pub authority: f64,
    /// The least and the largest pitch, rad, where the actuators hold more.
    pub pitch: [f64; 2],
    /// The steepest path, up or down, of a reference of depth, rad.
    pub path_angle: f64,
    /// The fastest turn of a reference of heading, rad/s.
    pub turn_rate: f64,
}

impl Default for Envelope {
    fn default() -> Self {
        let [steepest, path_angle, turn_rate] = [30.0f64, 30.0, 10.0].map(f64::to_radians);
        Self { authority: 0.85, pitch: [-steepest, steepest], path_angle, turn_rate }
    }
}

/// What is flown when sensors fail.
#[derive(Debug, Clone, PartialEq)]
pub struct Failsafe {
    /// A measurement that is the same for this long, and should have moved, is lost, s; 0 if it never is for that.
    pub stale_after: f64,
    /// What the actuators get where the vehicle cannot be controlled.
    pub safe: Safe,
    /// What is said of single sensors.
    pub sensors: Vec<SensorKeys>,
}

impl Default for Failsafe {
    fn default() -> Self {
        Self { stale_after: 0.5, safe: Safe::Slow, sensors: Vec::new() }
    }
}

/// The keys of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorKeys {
    /// The signal.
    pub signal: &'static Signal,
    /// The steps of its values, SI; `None` for those that follow from its noise.
    pub resolution: Option<f64>,
    /// The longest time between two values, s; 0 for one with a value at each tick.
    pub period: f64,
}

/// What the actuators get where nothing can be controlled; control surfaces are at zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Safe {
    /// Thrusters as in the trim of the slowest speed.
    Slow,
    /// No thrust.
    Stop,
}

impl Safe {
    /// Each.
    pub const ALL: [Self; 2] = [Self::Slow, Self::Stop];

    /// Its name in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Stop => "stop",
        }
    }
}

/// A design file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignFile {
    /// The name of the design: that of the autopilot, or of several axes what this one steers, plus changes from the
    /// command line.
    pub name: String,
    /// The name of the autopilot: the file's name without extension, plus changes from the command line.
    pub autopilot: String,
    /// The place of this axis among those of its file; `None` in a file of one.
    pub axis: Option<usize>,
    /// The file's name.
    pub file: String,
    /// One descriptive sentence.
    pub description: String,
    /// Lowest speed, m/s.
    pub speed_min: f64,
    /// Highest speed, m/s.
    pub speed_max: f64,
    /// Number of speeds at which the vehicle is linearised.
    pub speeds: usize,
    /// Depth, m.
    pub depth: f64,
    /// The pitch in level trim as given in the file; `None` without the key.
    pub pitch_asked: Option<Pitch>,
    /// The pitch in level trim for the vehicle, by [`Pitch::over`]; set by [`Inputs`](crate::inputs::Inputs).
    pub pitch: Pitch,
    /// The states of the linear model; set by [`Inputs`](crate::inputs::Inputs).
    pub states: States,
    /// The states and signals of the vehicle.
    pub interface: &'static Interface,
    /// Order of the polynomials in speed.
    pub order: usize,
    /// Singular values of the LFT below this fraction of the largest are dropped.
    pub drop: f64,
    /// The tracked outputs.
    pub tracked: Vec<Tracked>,
    /// The measurements of a controller with separate references; empty for one that measures the tracking errors.
    pub measured: Vec<Measured>,
    /// W_u, in units of each actuator's limit.
    pub control_weight: RisingWeight,
    /// The weights of single actuators, relative to W_u; 1 for those that are not named.
    pub relative_weights: Vec<RelativeWeight>,
    /// Disturbance at the input, in units of each actuator's limit.
    pub disturbance: f64,
    /// The sea for which the controller is designed.
    pub sea: Option<WorkingSea>,
    /// Whether the plant of the design has the actuator lags.
    pub lags: bool,
    /// A given controller, whose bound is found and proved; `None` for the one that the design computes.
    pub controller: Option<Pid>,
    /// Relative back-off from the least gamma.
    pub back_off: f64,
    /// Allowed relative rise of gamma for fewer controller states and channels; `None` keeps all.
    pub reduce: Option<f64>,
    /// Whether the weights are those of another design, see `with_weights_of`; never in a file.
    pub judged: bool,
    /// Bound on the rate of the speed for the synthesis, m/s^2; `None` for arbitrary rates.
    pub rate: Option<f64>,
    /// Sample time of the autopilot, s.
    pub sample_time: f64,
    /// Delay of a command after its tick, s: a multiple of the sample time.
    pub delay: f64,
    /// Whether the controller has anti-windup.
    pub anti_windup: bool,
    /// What the references may ask.
    pub envelope: Envelope,
    /// What is flown when sensors fail.
    pub failsafe: Failsafe,
    /// The default manoeuvre of the FMU of the complete loop.
    pub manoeuvre: Manoeuvre,
    /// The uncertain numbers of the vehicle; `None` without the section.
    pub uncertainty: Option<Uncertainty>,
    /// The requirements on the finished loop.
    pub require: Require,
}

impl DesignFile {
    /// The design with reference weights of 1 at all frequencies. The emphasis of slow references is for the nominal
    /// vehicle; results for uncertain vehicles are in these weights.
    pub fn with_unweighted_references(&self) -> Self {
        let mut even = self.clone();
        even.tracked.iter_mut().for_each(|t| t.references.follow = 1.0);
        even
    }

    /// W_u of an actuator over W_u.
    pub fn relative_weight(&self, actuator: &str) -> f64 {
        self.relative_weights.iter().find(|one| one.actuator == actuator).map_or(1.0, |one| one.factor)
    }

    /// W_u of an actuator.
    pub fn weight_on(&self, actuator: &str) -> RisingWeight {
        let (factor, all) = (self.relative_weight(actuator), self.control_weight);
        RisingWeight { low: factor * all.low, high: factor * all.high, ..all }
    }

    /// `count` speeds, evenly spaced over the range of the design, including both ends \[m/s\].
    pub fn spread(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.speed_min, self.speed_max);
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
    }

    /// The index of the signal whose step is assessed first: the first in the interface that is tracked, besides the
    /// one that is scheduled on.
    pub fn stepped(&self) -> usize {
        let others =
            self.tracked.iter().map(|t| t.index).filter(|index| Some(*index) != self.interface.scheduled());
        others.min().unwrap_or_default()
    }

    /// The name of the signal whose step is assessed first: what the axis steers.
    pub fn steered(&self) -> &'static str {
        self.interface.signals[self.stepped()].name
    }

    /// Whether a signal is tracked or measured.
    pub fn uses(&self, index: usize) -> bool {
        self.tracked.iter().any(|t| t.index == index) || self.measured.iter().any(|m| m.index == index)
    }

    /// Whether depth is tracked or measured, and therefore a state of the linear models.
    pub fn has_depth(&self) -> bool {
        !self.view().is_level_held && self.uses(DEPTH)
    }

    /// The view of the vehicle's motion that the axis has.
    pub fn view(&self) -> &'static View {
        View::of_states(self.interface.states)
    }

    /// The index among the tracked outputs of one by its name.
    pub fn tracks(&self, name: &str) -> Option<usize> {
        self.tracked.iter().position(|t| t.signal.name == name)
    }

    /// The index among the tracked outputs of the signal that is scheduled on.
    pub fn tracked_speed(&self) -> Option<usize> {
        self.tracked.iter().position(|t| Some(t.index) == self.interface.scheduled())
    }

    /// Depth \[m\], and the pitch in level trim.
    pub fn level(&self) -> (f64, &Pitch) {
        (self.depth, &self.pitch)
    }

    /// Centre and half range of the scheduling parameter rho = (V - centre)/half_range, m/s.
    pub fn scheduling(&self) -> (f64, f64) {
        (0.5 * (self.speed_min + self.speed_max), 0.5 * (self.speed_max - self.speed_min))
    }

    /// The scheduling parameter at a speed V along the path \[m/s\].
    pub fn rho(&self, speed: f64) -> f64 {
        let (centre, half_range) = self.scheduling();
        (speed - centre) / half_range
    }

    /// The signals that the controller measures, each with its scale: the measurements, or the errors. Separate
    /// references are not included, because no loop closes through them.
    pub fn fed_back(&self) -> Vec<(&'static Signal, f64)> {
        if self.measured.is_empty() {
            self.tracked.iter().map(|t| (t.signal, t.scale)).collect()
        } else {
            self.measured.iter().map(|m| (m.signal, m.scale)).collect()
        }
    }

    /// The index in y of the measurement or the error of a tracked output; `None` if it is not measured.
    pub fn feedback_row(&self, tracked: usize) -> Option<usize> {
        if self.measured.is_empty() {
            return Some(tracked);
        }
        let index = self.tracked[tracked].index;
        self.measured.iter().position(|m| m.index == index).map(|row| self.tracked.len() + row)
    }

    /// The delay in ticks.
    pub fn delay_ticks(&self) -> usize {
        (self.delay / self.sample_time).round() as usize
    }

    /// The frequency w of the filter of the speed reference, `w/(s + w)`, rad/s: the reference model of the speed, for
    /// a controller with separate references; `None` for one that measures the errors.
    pub fn reference_filter(&self) -> Option<f64> {
        let speed = self.tracked_speed().filter(|_| !self.measured.is_empty())?;
        Some(self.tracked[speed].model?.frequency)
    }

    /// The file name, with the axis in a file of several, and the autopilot's name if the command line changed it.
    pub fn source(&self) -> String {
        let own = self.axis.map(|_| format!("{} of ", self.steered())).unwrap_or_default();
        own + &self.source_of_all()
    }

    /// The file name, and the autopilot's name if the command line changed it.
    pub fn source_of_all(&self) -> String {
        let Self { autopilot, file, .. } = self;
        if *file == format!("{autopilot}.toml") { file.clone() } else { format!("{file} as {autopilot}") }
    }

    /// The design under another name: the changes from the command line after those of design and autopilot.
    #[must_use]
    pub fn renamed(mut self, changes: &str) -> Self {
        for name in [&mut self.name, &mut self.autopilot] {
            *name = format!("{name}-{changes}");
        }
        self
    }

    /// The design with another bandwidth of every W_e, which the paper tunes in its Fig. 5.
    #[must_use]
    pub fn with_bandwidth(mut self, bandwidth: f64) -> Self {
        for tracked in &mut self.tracked {
            tracked.weight.bandwidth = bandwidth;
        }
        self.renamed(&format!("bandwidth-{bandwidth}"))
    }
}
