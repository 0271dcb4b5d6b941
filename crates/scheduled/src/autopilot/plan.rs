//! The constant part of an autopilot.

use super::envelope::Envelope;
use super::following::Following;
use super::governor::{Governor, Saturation};
use super::opening::Opening;
use crate::design::Port;
use crate::ports::Inputs;
use crate::source::Sources;
use crate::{Actuator, ControllerDesign, DesignError, Kind, Lft, Matrix, Trim};
use squid_signals::Level;

/// The constant part of an autopilot.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) sample_time: f64,
    pub(super) centre: f64,
    pub(crate) half_range: f64,
    /// The signals of the design.
    pub(crate) signals: Vec<Port>,
    /// The index of the signal that is scheduled on.
    pub(crate) speed: usize,
    /// Index of the signal, kind and scale of each controller input.
    pub(super) inputs: Vec<(usize, Kind, f64)>,
    /// Gain 1 - exp(-w_r Ts) of the filter of the speed reference, if there is one.
    pub(crate) filter: Option<f64>,
    /// Whether V_r is the measured speed, which is imposed on the vehicle.
    pub(crate) speed_given: bool,
    /// Whether each signal is measured.
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
    /// The indices of the signals whose trim is put out.
    pub(crate) trimmed: Vec<usize>,
    /// The origin of each signal that is not measured; `None` of those that are: their value at initialisation.
    pub(super) origins: Vec<Option<f64>>,
    /// Whether each reference is followed.
    pub(super) followed: Vec<bool>,
}

impl Plan {
    /// The plan of a valid design with the controller `lft`.
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

    /// What is asked of a signal after the `last` reference, or at initialisation. A reference whose rate is limited
    /// begins where the vehicle is. Of an angle that comes back to itself it is the nearest: the vehicle turns the
    /// shorter way.
    pub(crate) fn asked(&self, signal: usize, inputs: &Inputs, last: Option<f64>) -> f64 {
        let begins = last.is_none() && self.begins_as_measured(signal);
        let asked = if begins { inputs.measured[signal] } else { inputs.references[signal] };
        self.signals[signal].nearest(asked, last.unwrap_or(inputs.measured[signal]))
    }

    /// A measured value, of an angle that comes back to itself the one nearest to the reference.
    pub(crate) fn measured_near(&self, signal: usize, inputs: &Inputs, references: &[f64]) -> f64 {
        let value = inputs.measured[signal];
        references.get(signal).map_or(value, |reference| self.signals[signal].nearest(value, *reference))
    }

    /// Whether a reference begins at the measured value.
    pub(crate) fn begins_as_measured(&self, signal: usize) -> bool {
        self.envelope.has_rate(signal) && self.starts_as_measured(signal)
    }

    /// The origin of a signal in a flight that starts with these inputs.
    pub(crate) fn origin(&self, signal: usize, inputs: &Inputs) -> f64 {
        self.origins[signal].unwrap_or(inputs.measured[signal])
    }

    /// Whether the origin of a signal is its level, and moves with the measured value.
    pub(crate) fn starts_as_measured(&self, signal: usize) -> bool {
        self.signals[signal].level == Level::Start && self.origins[signal].is_none()
    }

    /// The controller input y; `y0` gives a signal in level flight at V_r.
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

    /// The scheduling parameter at a forward speed in m/s, before clamping to [-1, 1].
    pub(crate) fn rho(&self, forward_speed: f64) -> f64 {
        (self.trim.speed(forward_speed) - self.centre) / self.half_range
    }

    /// The speed V_r against which no thruster pushes, 0 where each may: while an actuator that steers is beyond its
    /// limit with one of `values`, the commands before they are limited, or was in the ticks before.
    pub(crate) fn ahead(&self, speed: f64, before: &[Saturation], values: &[f64]) -> f64 {
        let is_beyond = |(index, value): (usize, &f64)| {
            let Actuator { minimum, maximum, .. } = self.actuators[index];
            let was = before.get(index).is_some_and(|one| one.ticks > 0);
            self.governor.steers(index) && (was || !(minimum..=maximum).contains(value))
        };
        if values.iter().enumerate().any(is_beyond) { speed } else { 0.0 }
    }

    /// The limits of a command. Where the vehicle is to keep going `ahead` \[m/s\], 0 for either way, a thruster that
    /// does not steer gives nothing against it, or no more than in trim.
    pub(crate) fn limits(&self, index: usize, trim: f64, ahead: f64) -> [f64; 2] {
        let Actuator { minimum, maximum, .. } = self.actuators[index];
        let way = ahead * self.governor.pushes(index);
        [
            if way > 0.0 { minimum.max(trim.min(0.0)) } else { minimum },
            if way < 0.0 { maximum.min(trim.max(0.0)) } else { maximum },
        ]
    }
}
