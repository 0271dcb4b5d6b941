//! Figures of a finished design.

use crate::certify::controller_of;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::verdict::beyond::Beyond;
use crate::verdict::corners::Corners;
use crate::verdict::flown::{DefaultFlight, StepAtSpeed};
use crate::verdict::frozen::AtSpeed;
use crate::verdict::held::Held;
use crate::verdict::mu::MuAtSpeed;
use rayon::prelude::*;
use serde::Serialize;
use squid_lpv::controller::Controller;
use squid_scheduled::ControllerDesign;

/// Numbers of evenly spaced speeds at which the figures are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Number of speeds of the frozen loops.
    pub frozen: usize,
    /// `true` if the frozen loops include their gains between the ticks, which take most of their time.
    pub sampled: bool,
    /// Number of speeds of the simulated steps.
    pub flown: usize,
    /// Number of speeds of mu; 0 for none.
    pub mu: usize,
}

impl Effort {
    /// Effort for a finished design: the frozen loops at every other speed of its check, the other figures at the six
    /// speeds of the report.
    pub const FULL: Self = Self { frozen: 51, sampled: true, flown: 6, mu: 6 };
}

/// Figures of a finished design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Figures of the frozen loops.
    pub frozen: Vec<AtSpeed>,
    /// Figures of the simulated steps.
    pub steps: Vec<StepAtSpeed>,
    /// Flights beyond the envelope.
    pub beyond: Vec<Beyond>,
    /// Flights under loads that the actuators cannot hold.
    pub held: Vec<Held>,
    /// Steps at corners of the declared uncertainty.
    pub corners: Vec<Corners>,
    /// Default flight.
    pub flight: DefaultFlight,
    /// Bounds on mu.
    pub mu: Vec<MuAtSpeed>,
}

impl Found {
    /// Computes the figures of a frozen controller of a design.
    ///
    /// # Errors
    /// The errors of trim, linearisation and freezing. Figures of an unstable loop, of a lost flight, and mu without a
    /// bound are unknown, not errors.
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, effort: Effort) -> Result<Self, Error> {
        let k = controller_of(&controller.lft)?;
        let speeds = |count| speeds(inputs, count).into_par_iter();
        let frozen =
            || speeds(effort.frozen).map(|speed| AtSpeed::of(inputs, &k, speed, effort.sampled)).collect();
        let flown = || speeds(effort.flown).map(|speed| StepAtSpeed::of(inputs, controller, speed)).collect();
        let mu = || mu(inputs, &k, effort.mu);
        let (mu, (frozen, steps)) = rayon::join(mu, || rayon::join(frozen, flown));
        let (frozen, steps): (Result<Vec<_>, Error>, Result<Vec<Vec<_>>, Error>) = (frozen, steps);
        let beyond = Beyond::of(inputs, controller, effort.flown)?;
        let held = Held::of(inputs, controller, effort.flown)?;
        let corners = Corners::of(inputs, controller, effort.flown)?;
        let flight = DefaultFlight::of(inputs, controller)?;
        Ok(Self {
            frozen: frozen?,
            steps: steps?.into_iter().flatten().collect(),
            beyond,
            held,
            corners,
            flight,
            mu,
        })
    }

    /// Computes the figures of the frozen loops alone, without their gains between the ticks; all others are empty.
    ///
    /// # Errors
    /// The errors of trim and linearisation.
    pub fn of_frozen(inputs: &Inputs, k: &Controller) -> Result<Self, Error> {
        let speeds = speeds(inputs, Effort::FULL.frozen).into_par_iter();
        let frozen = speeds.map(|speed| AtSpeed::of(inputs, k, speed, false)).collect::<Result<_, _>>()?;
        Ok(Self {
            frozen,
            steps: vec![],
            beyond: vec![],
            held: vec![],
            corners: vec![],
            flight: DefaultFlight { uses: vec![], lost: None },
            mu: vec![],
        })
    }

    /// Replaces mu by that at `count` speeds.
    ///
    /// # Errors
    /// The errors of [`Found::of`].
    pub fn with_mu(
        self,
        inputs: &Inputs,
        controller: &ControllerDesign,
        count: usize,
    ) -> Result<Self, Error> {
        Ok(Self { mu: mu(inputs, &controller_of(&controller.lft)?, count), ..self })
    }
}

fn mu(inputs: &Inputs, k: &Controller, count: usize) -> Vec<MuAtSpeed> {
    speeds(inputs, count).into_par_iter().map(|speed| MuAtSpeed::of(inputs, k, speed)).collect()
}

/// Evenly spaced speeds, `count` of them; none for 0.
fn speeds(inputs: &Inputs, count: usize) -> Vec<f64> {
    if count == 0 { vec![] } else { inputs.design.spread(count) }
}
