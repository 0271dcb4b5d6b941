//! Subject of a report: a vehicle, its model, and the stored controller.

use crate::error::Error;
use crate::page::Key;
use squid_auv::longitudinal::PITCH;
use squid_auv::readable;
use squid_auv::{Actuator, Status, Vehicle};
use squid_base::progress::Progress;
use squid_certificate::Theorem;
use squid_design::augment::augment;
use squid_design::axis::Linearisation;
use squid_design::axis::VehicleModel;
use squid_design::certify::controller_of;
use squid_design::check::sampled::Sampling;
use squid_design::error::ModelError;
use squid_design::fit::Model;
use squid_design::fit::frequency;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_design::synthesise::options;
use squid_design::verdict::Verdict;
use squid_design::verdict::found::Effort;
use squid_design::verdict::row::Outcome;
use squid_flight::flight::{Flight, fly};
use squid_flight::metrics::StepFigures;
use squid_flight::sea::Sea;
use squid_lpv::controller::Controller;
use squid_lpv::error::SynthesisError;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;
use squid_lpv::synthesis::{Design, by_inequalities};
use squid_scheduled::{ControllerDesign, Manoeuvre};
use std::sync::OnceLock;

/// Number of speeds over the range of the design.
const SPEEDS: usize = 6;

/// Time of a step (s).
pub const STEP_TIME: f64 = 1.0;
/// Duration of a step response (s).
pub const FLOWN: f64 = 60.0;
/// Default plotted duration of a response (s).
pub const SHOWN: f64 = 30.0;

/// Returns the plotted duration of step responses (s), from the longest settling time (s).
pub fn shown(slowest: f64) -> f64 {
    if slowest < 0.6 * SHOWN { SHOWN } else { FLOWN }
}

/// Bounds on mu over all frequencies at a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuBounds {
    /// Speed along the path, m/s.
    pub speed: f64,
    /// Upper bound of mu of the model's loop in continuous time.
    pub guaranteed: f64,
    /// Inverse of the size of an uncertainty for which the retrimmed vehicle is unstable; NaN if none was found.
    pub vehicle: f64,
}

/// A vehicle, its model and its controller.
#[derive(Debug)]
pub struct Subject<'a> {
    /// Vehicle and design files.
    pub inputs: &'a Inputs,
    /// Stored design.
    pub stored: &'a Stored,
    /// Linearisations and fits.
    pub model: Model,
    /// Generalised plant of the design.
    pub plant: GeneralisedPlant,
    /// Stored controller.
    pub controller: Controller,
    /// Six speeds over the range.
    pub speeds: Vec<f64>,
    /// True linearisations at these speeds.
    pub truth: Vec<Linearisation>,
    /// Progress reports.
    pub progress: &'a Progress<'a>,
    /// Sea for simulations, and the text of its file.
    pub sea: Option<(Sea, String)>,
    /// Other designs of the vehicle, for comparison with this one.
    pub beside: Vec<Subject<'a>>,
    /// `true` if the verdict uses stored results of long computations, where available.
    pub brief: bool,
    /// Bounds of the section on mu, once computed, if there are bounds at every speed.
    pub mu: OnceLock<Vec<MuBounds>>,
    alone: OnceLock<Vec<Result<Design, SynthesisError>>>,
    proof: OnceLock<Result<Theorem, String>>,
    verdict: OnceLock<Result<Verdict, String>>,
}

/// Step of a design's default flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Index of the output among the signals of the axis.
    pub index: usize,
    /// Name of the output.
    pub name: &'static str,
    /// Height, rad or m.
    pub height: f64,
    /// Factor from SI to `unit`.
    pub factor: f64,
    /// Unit for display, deg or m.
    pub unit: &'static str,
}

impl Step {
    /// Returns the step of a manoeuvre of a design.
    pub fn of(inputs: &Inputs, manoeuvre: &Manoeuvre) -> Self {
        let index = inputs.design.stepped();
        let signal = &inputs.design.interface.signals[index];
        let (factor, unit) = readable(signal.unit);
        Self { index, name: signal.name, height: manoeuvre.step(signal.name), factor, unit }
    }

    /// Returns the height with its unit as text.
    pub fn text(&self) -> String {
        format!("{} {}", squid_auv::rounded(self.factor * self.height), self.unit)
    }

    /// Returns the axis label of the output's deviation from trim or, for depth and heading, from the start.
    pub fn from_trim(&self) -> String {
        let from = if ["depth", "heading"].contains(&self.name) { "start" } else { "trim" };
        format!("{} from {from} ({})", self.name, self.unit)
    }
}

/// Returns the name of a vehicle, with the word surrogate if it is one.
pub(crate) fn name(vehicle: &Vehicle) -> String {
    match vehicle.status {
        Status::Surrogate => format!("the {} surrogate", vehicle.name),
        _ => vehicle.name.clone(),
    }
}

impl<'a> Subject<'a> {
    /// Returns `true` if the speed is imposed externally.
    pub fn speed_is_given(&self) -> bool {
        self.inputs.vehicle.coefficients.surge.is_given()
    }

    /// Returns the name of the commanded speed.
    pub fn speed_reference(&self) -> &'static str {
        if self.speed_is_given() { "given speed" } else { "speed reference" }
    }

    /// Linearises and fits the vehicle again, and takes the controller from the stored design.
    ///
    /// # Errors
    /// Errors of [`Model::new`]; [`ProofError::Mismatch`](squid_proof::error::ProofError::Mismatch) if the stored
    /// controller has ragged matrices.
    pub fn new(inputs: &'a Inputs, stored: &'a Stored, progress: &'a Progress<'a>) -> Result<Self, Error> {
        let model = Model::new(&inputs.axis(), &inputs.design)?;
        let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear())?;
        let controller = controller_of(&stored.controller.lft)?;
        let speeds = inputs.design.spread(SPEEDS);
        let truth = speeds.iter().map(|v| inputs.axis().linearise(*v)).collect::<Result<_, ModelError>>()?;
        let (mu, alone, proof, verdict) = Default::default();
        Ok(Self {
            inputs,
            stored,
            model,
            plant,
            controller,
            speeds,
            truth,
            progress,
            sea: None,
            beside: vec![],
            brief: false,
            mu,
            alone,
            proof,
            verdict,
        })
    }

    /// Returns the H-infinity controller for the linearisation at each of the six speeds, by the same inequalities;
    /// computed once.
    pub fn alone(&self) -> &[Result<Design, SynthesisError>] {
        let options = options(&self.inputs.design);
        let made = |v: &f64| {
            let singular = |_| SynthesisError::Numerical {
                stage: "freezing",
                diagnosis: "the plant has no value".into(),
            };
            by_inequalities(&self.plant.frozen(&[self.rho(*v)]).map_err(singular)?, options)
        };
        self.alone.get_or_init(|| self.speeds.iter().map(made).collect())
    }

    /// Returns the proof of the stored certificate; computed once.
    pub fn proof(&self) -> &Result<Theorem, String> {
        self.proof.get_or_init(|| self.stored.prove(self.inputs))
    }

    /// Returns this subject with a proof that is already known.
    pub(crate) fn proved(mut self, proof: &Result<Theorem, String>) -> Self {
        self.proof = OnceLock::from(proof.clone());
        self
    }

    /// Returns the verdict on the stored controller with the advice of `squid design`; computed once.
    ///
    /// # Errors
    /// [`Error::Verdict`].
    pub fn verdict(&self) -> Result<&Verdict, Error> {
        let reached = || {
            let (controller, rows) = (&self.stored.controller, &self.stored.rows);
            let reached = if self.brief && !rows.is_empty() {
                Verdict::of_stored(self.inputs, controller, rows)
            } else {
                Verdict::of(self.inputs, controller, Effort::FULL)
            };
            let mut verdict = reached.map_err(|reason| reason.to_string())?;
            for row in verdict.rows.iter_mut().filter(|row| row.outcome == Outcome::Missed) {
                let stored = rows.iter().find(|stored| stored.name == row.name);
                row.advice = stored.and_then(|stored| stored.advice.clone());
            }
            Ok(verdict)
        };
        self.verdict.get_or_init(reached).as_ref().map_err(|reason| Error::Verdict { reason: reason.clone() })
    }

    /// Returns the name of the vehicle, with the word surrogate if it is one.
    pub fn name(&self) -> String {
        name(&self.inputs.vehicle)
    }

    /// Returns the scheduling parameter `rho = (V - centre)/half_range` at a speed V along the path (m/s).
    pub fn rho(&self, speed: f64) -> f64 {
        self.inputs.design.rho(speed)
    }

    /// Returns a speed (m/s) as text.
    pub fn speed_name(v: f64) -> String {
        format!("{v:.2} m/s")
    }

    /// Returns a key for each of the speeds, from the slowest to the fastest.
    pub fn speed_keys(&self) -> Vec<Key> {
        self.speeds.iter().map(|v| Key::along(0.5 * (self.rho(*v) + 1.0), Self::speed_name(*v))).collect()
    }

    /// Returns the index of the stepped output among the tracked outputs.
    ///
    /// # Errors
    /// [`Error::NothingSteps`].
    pub fn output(&self) -> Result<usize, Error> {
        let (tracked, stepped) = (&self.inputs.design.tracked, self.inputs.design.stepped());
        tracked.iter().position(|t| t.index == stepped).ok_or(Error::NothingSteps)
    }

    /// Returns the index of pitch among the tracked outputs.
    ///
    /// # Errors
    /// [`Error::PitchNotTracked`].
    pub fn pitch(&self) -> Result<usize, Error> {
        let tracked = &self.inputs.design.tracked;
        tracked.iter().position(|t| t.index == PITCH).ok_or(Error::PitchNotTracked)
    }

    /// Returns the step of the default flight.
    pub fn step(&self) -> Step {
        Step::of(self.inputs, &self.stored.manoeuvre)
    }

    /// Returns the actuator of [`frequency::turning_actuator`], with its index.
    pub fn turning_actuator(&self) -> (usize, &Actuator) {
        let most = frequency::turning_actuator(&self.inputs.vehicle.actuators, &self.model);
        (most, &self.inputs.vehicle.actuators[most])
    }

    /// Returns the manoeuvre of the design at a constant speed (m/s) with its step from one time to another (s).
    pub(crate) fn stepped(&self, speed: f64, (from, to): (f64, f64), duration: f64) -> Manoeuvre {
        let step = self.step();
        Manoeuvre {
            speed_from: speed,
            speed_to: speed,
            step_time: from,
            step_end: to,
            duration,
            ..self.stored.manoeuvre.with_step(step.name, step.height)
        }
    }

    /// Simulates the step of the design file on the nonlinear vehicle at a constant speed (m/s), with the stored
    /// or another controller; the step is at [`STEP_TIME`].
    ///
    /// # Errors
    /// Errors of [`fly`].
    pub fn fly_step(&self, speed: f64, controller: &ControllerDesign) -> Result<Flight, Error> {
        let step = self.stepped(speed, (STEP_TIME, f64::MAX), STEP_TIME + FLOWN);
        Ok(fly(&self.inputs.vehicle, controller, self.inputs.design.level(), &step)?)
    }

    /// Simulates the step with the stored controller at each of the six speeds.
    ///
    /// # Errors
    /// Errors of [`fly`].
    pub fn fly_steps(&self) -> Result<Vec<Flight>, Error> {
        self.speeds.iter().map(|speed| self.fly_step(*speed, &self.stored.controller)).collect()
    }

    /// Returns a controller frozen at the speed of a trim.
    ///
    /// # Errors
    /// [`ModelError::System`] if `I - Dtt Theta` is singular.
    pub fn frozen(&self, controller: &Controller, l: &Linearisation) -> Result<StateSpace, Error> {
        Ok(controller.frozen(&vec![self.rho(l.trim.speed); controller.blocks.len()])?)
    }

    /// Returns the figures of a flight of [`Subject::fly_step`].
    pub fn figures(&self, flight: &Flight) -> StepFigures {
        let Step { index, height, .. } = self.step();
        StepFigures::of_flight(flight, index, (STEP_TIME, height), &self.inputs.limits())
    }

    /// Returns the sampling of the loop.
    pub fn sampling(&self) -> Sampling<'_> {
        Sampling::of(&self.inputs.vehicle.actuators, &self.inputs.design)
    }
}
