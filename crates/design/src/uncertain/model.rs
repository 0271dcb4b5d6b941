//! Linear model with its uncertain channels.

use crate::error::ModelError;
use crate::uncertain::reduce::runs;
use squid_auv::{Parameter, Vehicle};
use squid_lpv::lft::Lft;
use squid_lpv::matrix::Mat;
use squid_lpv::plant::channels;

/// Uncertain quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uncertain {
    /// Coefficient, or quantity of the trim.
    Parameter(Parameter),
    /// Gain of an actuator.
    Gain(usize),
}

impl Uncertain {
    /// Returns the name of the quantity.
    pub fn name(self, vehicle: &Vehicle) -> String {
        match self {
            Self::Parameter(parameter) => parameter.name(vehicle),
            Self::Gain(actuator) => format!("gain of {}", vehicle.actuators[actuator].name),
        }
    }

    /// Returns `true` for a quantity of the trim, which follows from the coefficients.
    pub fn is_of_trim(self) -> bool {
        matches!(self, Self::Parameter(Parameter::Incidence | Parameter::Output(_)))
    }
}

/// Normalised uncertain parameter: `value + half_range delta`, |delta| <= 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Uncertain quantity.
    pub uncertain: Uncertain,
    /// Name of the quantity.
    pub name: String,
    /// Nominal value, SI; for a quantity of the trim, that at the middle of the range of speed.
    pub value: f64,
    /// Half range, SI; for a quantity of the trim, that at the middle of the range of speed.
    pub half_range: f64,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Number of repetitions, equal to its number of channels.
    pub repetitions: usize,
}

/// Linear model with its uncertain channels.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainModel {
    /// LFT of `[A B]`: its parameters are rho, if rho has channels, followed by the blocks.
    pub lft: Lft,
    /// Number of channels of the scheduling parameter rho, which come first; 0 at a frozen speed.
    pub scheduled: usize,
    /// Uncertain parameters in the order of their channels; each has at least one.
    pub blocks: Vec<Block>,
}

impl UncertainModel {
    /// Builds the model from an LFT of `[A B]` whose parameter 0 is rho and parameter 1 + i is `all[i]`.
    pub(crate) fn from_lft(lft: Lft, all: &[Block]) -> Self {
        let mut scheduled = 0;
        let mut blocks = Vec::new();
        for (parameter, _, count) in runs(&lft.channels) {
            match parameter.checked_sub(1).and_then(|i| all.get(i)) {
                Some(block) => blocks.push(Block { repetitions: count, ..block.clone() }),
                None => scheduled = count,
            }
        }
        let mut model = Self { lft, scheduled, blocks };
        model.lft.channels = channels(&model.repetitions());
        model
    }

    /// Returns the number of channels.
    pub fn channels(&self) -> usize {
        self.lft.size()
    }

    /// Returns the repetitions: those of rho first, if it has channels, then those of every block.
    pub fn repetitions(&self) -> Vec<usize> {
        let scheduled = (self.scheduled > 0).then_some(self.scheduled);
        scheduled.into_iter().chain(self.blocks.iter().map(|b| b.repetitions)).collect()
    }

    /// Evaluates `[A B]` at rho (ignored by a model at one speed) and at one delta per block.
    ///
    /// # Errors
    /// [`ModelError::System`] if `I - Ddd Delta` is singular.
    pub fn evaluate(&self, rho: f64, delta: &[f64]) -> Result<Mat, ModelError> {
        let scheduled = (self.scheduled > 0).then_some(rho);
        let values: Vec<f64> = scheduled.into_iter().chain(delta.iter().copied()).collect();
        Ok(self.lft.evaluate(&values)?)
    }
}
