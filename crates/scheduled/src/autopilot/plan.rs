//! Constant part of an autopilot.

use super::envelope::Envelope;
use super::following::Following;
use super::governor::{Governor, Saturation};
use super::opening::Opening;
use crate::design::Port;
use crate::ports::Inputs;
use crate::source::Sources;
use crate::{Actuator, ControllerDesign, DesignError, Kind, Lft, Matrix, Trim};
use squid_signals::Level;

/// Constant part of an autopilot.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) sample_time: f64,
    pub(super) centre: f64,
    pub(crate) half_range: f64,
    /// Signals of the design.
    pub(crate) signals: Vec<Port>,
    /// Index of the scheduling signal.
    pub(crate) speed: usize,
    /// Index of the signal, kind and scale of each controller input.
    pub(super) inputs: Vec<(usize, Kind, f64)>,
    /// Gain 1 - exp(-w_r Ts) of the filter of the speed reference, if there is one.
    pub(crate) filter: Option<f64>,
    /// `true` if V_r is the measured speed, which is imposed on the vehicle.
    pub(crate) speed_given: bool,
    /// `true` for each measured signal.
    pub(crate) measured: Vec<bool>,
    pub(crate) actuators: Vec<Actuator>,
    pub(crate) trim: Trim,
    pub(crate) envelope: Envelope,
    pub(crate) parameters: usize,
    /// Sampled anti-windup gain from phi to the controller's states, n x m.
    pub(crate) anti_windup: Option<Matrix>,
    pub(crate) following: Following,
    pub(crate) opening: Opening,
    pub(crate) governor: Governor,
    pub(crate) sources: Sources,
    /// Indices of the signals whose trim is an output.
    pub(crate) trimmed: Vec<usize>,
    /// Origin of each signal that is not measured; `None` for measured signals, whose origin is their value at
    /// initialisation.
    pub(super) origins: Vec<Option<f64>>,
    /// `true` for each tracked reference.
    pub(super) followed: Vec<bool>,
}

impl Plan {
    /// Creates the plan of a valid design with the controller `lft`.
    #[inline]
    pub(crate) fn new(design: &ControllerDesign, lft: &Lft) -> Result<Self, DesignError> {
        let missing = || DesignError::Empty { key: "signals" };
        let measured = |index: usize, signal: &Port| (!design.measures(index)).then_some(signal.start);
        Ok(Self {
            signals: design.signals.clone(),
            speed: design.scheduled().ok_or_else(missing)?,
            trimmed: design.trimmed().collect(),
            origins: design
                .signals
                .iter()
                .enumerate()
                .map(|(index, signal)| measured(index, signal))
                .collect(),
            followed: (0..design.references().count()).map(|index| design.follows(index)).collect(),
            sample_time: design.sample_time,
            centre: design.scheduling.centre,
            half_range: design.scheduling.half_range,
            inputs: design
                .controller_inputs
                .iter()
                .filter_map(|input| Some((design.index(&input.signal)?, input.kind, input.scale)))
                .collect(),
            filter: design.reference_filter.map(|bandwidth| -(-bandwidth * design.sample_time).exp_m1()),
            speed_given: design.speed_given,
            measured: (0..design.signals.len()).map(|index| design.measures(index)).collect(),
            actuators: design.actuators.clone(),
            trim: Trim::new(design.trim.clone(), &design.signals),
            envelope: Envelope::new(design),
            parameters: design.lft.blocks.len(),
            anti_windup: design
                .anti_windup_gain()?
                .map(|gain| lft.held_input(&gain, design.sample_time))
                .transpose()?,
            following: Following::new(design)?,
            opening: Opening::new(design),
            governor: Governor::new(design),
            sources: Sources::new(design, design.scheduled().ok_or_else(missing)?),
        })
    }

    /// Returns the requested reference of a signal after the `last` one, or at initialisation (`None`). There, a
    /// reference with a rate limit begins at the measured value if the level of the signal is its initial value. A
    /// circular angle is unwrapped to the nearest value: the vehicle turns the shorter way.
    pub(crate) fn requested(&self, signal: usize, inputs: &Inputs, last: Option<f64>) -> f64 {
        let begins = last.is_none() && self.begins_as_measured(signal);
        let requested = if begins { inputs.measured[signal] } else { inputs.references[signal] };
        self.signals[signal].nearest(requested, last.unwrap_or(inputs.measured[signal]))
    }

    /// Returns a measured value; a circular angle is unwrapped to the value nearest to the reference.
    pub(crate) fn measured_near(&self, signal: usize, inputs: &Inputs, references: &[f64]) -> f64 {
        let value = inputs.measured[signal];
        references.get(signal).map_or(value, |reference| self.signals[signal].nearest(value, *reference))
    }

    /// Returns `true` if a reference begins at the measured value.
    pub(crate) fn begins_as_measured(&self, signal: usize) -> bool {
        self.envelope.has_rate(signal) && self.starts_as_measured(signal)
    }

    /// Returns the origin of a signal in a flight that starts with these inputs.
    pub(crate) fn origin(&self, signal: usize, inputs: &Inputs) -> f64 {
        self.origins[signal].unwrap_or(inputs.measured[signal])
    }

    /// Returns `true` if the level of a signal is its initial measured value.
    pub(crate) fn starts_as_measured(&self, signal: usize) -> bool {
        self.signals[signal].level == Level::Start && self.origins[signal].is_none()
    }

    /// Returns the controller input y; `y0` gives a signal in level flight at V_r.
    pub(crate) fn y<'a>(
        &'a self,
        measured: impl Fn(usize) -> f64 + 'a,
        references: &'a [f64],
        y0: impl Fn(usize) -> f64 + 'a,
    ) -> impl Iterator<Item = f64> {
        self.inputs.iter().map(move |&(signal, kind, scale)| {
            let difference = match kind {
                Kind::Error => references[signal] - measured(signal),
                Kind::Reference => references[signal] - y0(signal),
                Kind::Measurement => measured(signal) - y0(signal),
            };
            difference / scale
        })
    }

    /// Returns the scheduling parameter at a forward speed in m/s, before clamping to [-1, 1].
    pub(crate) fn rho(&self, forward_speed: f64) -> f64 {
        (self.trim.speed(forward_speed) - self.centre) / self.half_range
    }

    /// Returns V_r (`speed`) if the thrusters that do not steer must not push against it, otherwise 0. They must not
    /// while a steering actuator is saturated: its entry in `values`, the commands before limiting, is beyond a limit,
    /// or its count in `before` is above 0.
    pub(crate) fn protected_speed(&self, speed: f64, before: &[Saturation], values: &[f64]) -> f64 {
        let is_beyond = |(index, value): (usize, &f64)| {
            let Actuator { minimum, maximum, .. } = self.actuators[index];
            let was_saturated = before.get(index).is_some_and(|one| one.ticks > 0);
            self.governor.steers(index) && (was_saturated || !(minimum..=maximum).contains(value))
        };
        if values.iter().enumerate().any(is_beyond) { speed } else { 0.0 }
    }

    /// Returns the limits of a command. If `protected_speed` \[m/s\] is not 0, a thruster that does not steer gives no
    /// force against it, or no more than in trim.
    pub(crate) fn limits(&self, index: usize, trim: f64, protected_speed: f64) -> [f64; 2] {
        let Actuator { minimum, maximum, .. } = self.actuators[index];
        let push = protected_speed * self.governor.pushes(index);
        [
            if push > 0.0 { minimum.max(trim.min(0.0)) } else { minimum },
            if push < 0.0 { maximum.min(trim.max(0.0)) } else { maximum },
        ]
    }
}
