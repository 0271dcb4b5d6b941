//! Closed loop of plant and autopilot, stepped in the order of a co-simulation master.

use squid_fmi2::{Log, Model};
use squid_fmu_controller::{Axis, RESOURCE, of_axis};
use squid_fmu_plant::PlantModel;

use crate::ClosedLoopError;
use squid_auv::longitudinal::{DEPTH, PITCH, SPEED};
use squid_auv::{REFERENCES, VIEWS, View, references};
use squid_scheduled::{Manoeuvre, ManoeuvreError, Trim};
use squid_signals::{Curve, Level, Signal};

/// External references, held between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Override {
    /// `true` if they replace the manoeuvre.
    pub manual: bool,
    /// Absolute value of each of [`references`] in SI units; the speed is that along the body axis, through the water.
    pub references: [f64; REFERENCES],
    /// Rates of the references \[SI/s\]; [`ClosedLoop::advance`] advances the references.
    pub slopes: [f64; REFERENCES],
}

/// A vehicle and its autopilot, following a manoeuvre or external references.
///
/// At each tick t = start + k Ts the autopilot reads the plant and commands it without delay; between ticks the
/// commands are held. Time is that of the experiment, for the manoeuvre as well.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    /// The vehicle.
    pub plant: PlantModel,
    /// Axes of the autopilot: surge, heave and pitch first; in six degrees of freedom also those of other views.
    pub axes: Vec<Axis>,
    /// Index in [`references`] of each reference of each axis.
    pub(crate) reference_indices: Vec<Vec<usize>>,
    views: Vec<&'static View>,
    /// Indices of the vehicle's actuators that each axis commands.
    pub(crate) commanded: Vec<Vec<usize>>,
    /// Manoeuvre, followed by default.
    pub manoeuvre: Manoeuvre,
    /// External references, followed while `manual` is true.
    pub outside: Override,
}

/// Returns the signal of a reference.
pub(crate) fn signal(index: usize) -> Option<&'static Signal> {
    references().nth(index).map(|(.., signal)| signal)
}

/// Checks that an axis belongs to this vehicle, and returns its view: the first view for the first axis, and an unused
/// view for each of the others.
fn matching_view(
    axis: &Axis,
    index: usize,
    plant: &PlantModel,
    before: &[&'static View],
) -> Result<&'static View, ClosedLoopError> {
    let (vehicle, design) = (plant.vehicle(), axis.design());
    let found: Vec<_> = design.signals.iter().map(|signal| signal.name.clone()).collect();
    let names =
        |view: &View| view.interface.signals.iter().map(|one| one.name.to_owned()).collect::<Vec<_>>();
    let mut open: Vec<&View> = VIEWS.to_vec();
    open.retain(|view| before.iter().all(|other| other.name != view.name));
    open.truncate(if index == 0 { 1 } else { VIEWS.len() });
    let Some(view) = open.iter().find(|view| view.has_signals(found.iter().map(String::as_str))) else {
        let expected = open.iter().map(|view| names(view).join(", ")).collect();
        return Err(ClosedLoopError::OtherSignals { file: of_axis(RESOURCE, index), found, expected });
    };
    if design.vehicle.name != vehicle.name {
        let (found, expected) = (design.vehicle.name.clone(), vehicle.name.clone());
        return Err(ClosedLoopError::OtherVehicle { file: of_axis(RESOURCE, index), found, expected });
    }
    Ok(*view)
}

/// Returns the index in [`references`] of each reference of an axis; all axes share the speed of the first view.
fn reference_indices(view: &View, axis: &Axis) -> Vec<usize> {
    let of = |index: usize| {
        let name = view.interface.signals[index].name;
        references().position(|(.., signal)| signal.name == name).unwrap_or(SPEED)
    };
    (0..axis.design().references().count()).map(of).collect()
}

impl ClosedLoop {
    /// Combines vehicle and autopilots: that of surge, heave and pitch, and others for a vehicle in six degrees of
    /// freedom.
    ///
    /// # Errors
    /// [`ClosedLoopError::OtherAxes`], [`ClosedLoopError::OtherSampleTime`], [`ClosedLoopError::OtherVehicle`],
    /// [`ClosedLoopError::OtherSignals`], [`ClosedLoopError::OtherActuators`], [`ClosedLoopError::Manoeuvre`].
    pub fn new(plant: PlantModel, axes: Vec<Axis>, manoeuvre: Manoeuvre) -> Result<Self, ClosedLoopError> {
        if axes.is_empty() || plant.has_six_dof() != (axes.len() > 1) {
            return Err(ClosedLoopError::OtherAxes);
        }
        let mut views: Vec<&View> = Vec::new();
        for (index, axis) in axes.iter().enumerate() {
            views.push(matching_view(axis, index, &plant, &views)?);
            let [one, other] = [&axes[0], axis].map(|axis| axis.design().sample_time);
            if one != other {
                return Err(ClosedLoopError::OtherSampleTime { one, other });
            }
        }
        let commanded = commanded(&plant, &axes)?;
        let reference_indices =
            views.iter().zip(&axes).map(|(view, axis)| reference_indices(view, axis)).collect();
        let references = level(axes[0].autopilot().trim(), manoeuvre.speed_from, &plant);
        let outside = Override { manual: false, references, slopes: [0.0; REFERENCES] };
        let mut model = Self { plant, axes, reference_indices, views, commanded, manoeuvre, outside };
        model.check()?;
        for signal in model.followed().into_iter().filter(|index| *index != SPEED).filter_map(signal) {
            model.manoeuvre.steps.entry(signal.name.to_owned()).or_default();
        }
        Ok(model)
    }

    /// Checks the manoeuvre: each axis has references for its own steps, and the speeds are positive if the vehicle has
    /// trims for ahead motion only.
    fn check(&self) -> Result<(), ManoeuvreError> {
        self.manoeuvre.check()?;
        let designs: Vec<_> = self.axes.iter().map(Axis::design).collect();
        self.manoeuvre.check_steps_of(&designs)?;
        if self.plant.only_ahead() { self.manoeuvre.check_ahead() } else { Ok(()) }
    }

    /// Returns `true` if there are axes besides that of level flight.
    pub(crate) fn has_six_dof(&self) -> bool {
        self.axes.len() > 1
    }

    /// Returns the indices of the references that the loop follows.
    pub(crate) fn followed(&self) -> Vec<usize> {
        let has = |index: &usize| {
            self.owner(*index).is_some_and(|(axis, own)| self.axes[axis].design().has_reference(own))
        };
        (0..REFERENCES).filter(has).collect()
    }

    /// Returns the axis that uses a reference, and the index of the reference there.
    pub(crate) fn owner(&self, index: usize) -> Option<(usize, usize)> {
        let own = |indices: &Vec<usize>| indices.iter().position(|one| *one == index);
        self.reference_indices.iter().enumerate().find_map(|(axis, indices)| Some((axis, own(indices)?)))
    }

    /// Returns a reference as the controller used it at the last tick.
    pub(crate) fn reference_used(&self, index: usize) -> f64 {
        self.owner(index).map_or(0.0, |(axis, own)| self.axes[axis].autopilot().references()[own])
    }

    /// Sets the vehicle to level trim at the manoeuvre's speed, and the autopilot's state to zero, at a time \[s\].
    ///
    /// # Errors
    /// [`ClosedLoopError::Manoeuvre`], [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn start(&mut self, time: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.check()?;
        self.plant.settings.initial_speed = self.manoeuvre.speed_reference(time);
        self.plant.initialise(time, log)?;
        self.measure(time);
        self.axes.iter_mut().try_for_each(|axis| axis.initialise(time))?;
        self.command();
        // Actuators without lag follow the first commands immediately.
        Ok(self.plant.apply_inputs()?)
    }

    /// Advances the loop to the time `to` \[s\] without allocating.
    ///
    /// # Errors
    /// [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn advance(&mut self, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        // A tick at the current time must use the new inputs.
        self.plant.apply_inputs()?;
        while self.axes[0].autopilot().is_due_before(to) {
            let due = self.axes[0].autopilot().next_tick_time();
            self.move_plant(due, log)?;
            self.tick(log)?;
        }
        self.move_plant(to, log)
    }

    /// Runs the next tick with the current state of the plant.
    ///
    /// # Errors
    /// [`ClosedLoopError::Controller`].
    pub fn tick(&mut self, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.measure(self.axes[0].autopilot().next_tick_time());
        self.axes.iter_mut().try_for_each(|axis| axis.tick(log))?;
        self.command();
        Ok(())
    }

    /// Advances the plant and the external references; rounding may have taken the plant past a tick already.
    fn move_plant(&mut self, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        let now = self.plant.time();
        if to > now {
            self.plant.step(now, to, log)?;
            let outside = &mut self.outside;
            for (reference, slope) in outside.references.iter_mut().zip(outside.slopes) {
                *reference += slope * (to - now);
            }
        }
        Ok(())
    }

    /// Passes measurements and references to the autopilots, and the operating speed to the LPV model. The measured
    /// rates are the derivatives of the angles, theta' and psi'.
    fn measure(&mut self, time: f64) {
        let (references, path_speed) = self.references(time);
        let state = self.plant.state();
        for ((axis, indices), view) in self.axes.iter_mut().zip(&self.reference_indices).zip(&self.views) {
            for (measured, sensed) in axis.inputs.measured.iter_mut().zip(view.sensed) {
                *measured = (sensed.value)(&state);
            }
            for (reference, index) in axis.inputs.references.iter_mut().zip(indices) {
                *reference = references[*index];
            }
        }
        self.plant.inputs.operating_speed = path_speed;
        self.plant.inputs.given_speed = references[SPEED];
    }

    /// Passes the commands to the plant.
    fn command(&mut self) {
        for (axis, indices) in self.axes.iter().zip(&self.commanded) {
            for (index, actuator) in indices.iter().enumerate() {
                self.plant.inputs.commands[*actuator] = axis.command(index);
            }
        }
    }

    /// Returns the index of the signal whose tracking error is an output: pitch if it has a reference, else depth.
    pub(crate) fn tracked(&self) -> usize {
        if self.axes[0].design().has_reference(PITCH) { PITCH } else { DEPTH }
    }

    /// Returns the references of the autopilots, and the speed along the path.
    fn references(&self, time: f64) -> ([f64; REFERENCES], f64) {
        let trim = self.axes[0].autopilot().trim();
        if self.outside.manual {
            let references = self.outside.references;
            return (references, trim.speed(references[SPEED]));
        }
        let path_speed = self.manoeuvre.speed_reference(time);
        let mut references = level(trim, path_speed, &self.plant);
        for (reference, (.., signal)) in references.iter_mut().zip(squid_auv::references()) {
            *reference += self.manoeuvre.above_trim(time, signal.name);
        }
        (references, path_speed)
    }
}

/// Returns the indices of the vehicle's actuators that each axis commands. In the vertical plane these must be all
/// actuators in their order; no two axes may share one.
fn commanded(plant: &PlantModel, axes: &[Axis]) -> Result<Vec<Vec<usize>>, ClosedLoopError> {
    let named = |name: &str, curve: Option<&Curve>| match curve {
        Some(curve) => format!("{name} [{}]", curve.unit()),
        None => name.to_owned(),
    };
    let own = plant.vehicle().actuators.iter();
    let expected: Vec<_> = own.map(|one| named(&one.name, one.curve.as_ref())).collect();
    let commands = |axis: &Axis| -> Vec<String> {
        axis.design().actuators.iter().map(|one| named(&one.name, one.curve.as_ref())).collect()
    };
    let names: Vec<Vec<String>> = axes.iter().map(commands).collect();
    let index = |name: &String| expected.iter().position(|one| one == name);
    let indices = names.iter().map(|names| names.iter().map(index).collect::<Option<Vec<usize>>>());
    let indices: Option<Vec<Vec<usize>>> = indices.collect();
    let found = names.concat();
    let is_unique = found.iter().all(|name| found.iter().filter(|other| *other == name).count() == 1);
    match indices.filter(|_| is_unique && (plant.has_six_dof() || found == expected)) {
        Some(indices) => Ok(indices),
        None => Err(ClosedLoopError::OtherActuators { found, expected }),
    }
}

/// Returns the references of level flight at a speed along the path \[m/s\], at the initial depth and heading, from the
/// trim table of the design.
fn level(trim: &Trim, path_speed: f64, plant: &PlantModel) -> [f64; REFERENCES] {
    let forward_speed = trim.forward_speed(path_speed);
    let settings = &plant.settings;
    let mut all = [0.0; REFERENCES];
    for (value, (view, index, signal)) in all.iter_mut().zip(references()) {
        *value = match (view, signal.level) {
            (0, _) => trim.signal(forward_speed, index, settings.initial_depth),
            (_, Level::Start) => settings.initial_heading,
            _ => 0.0,
        };
    }
    all
}
