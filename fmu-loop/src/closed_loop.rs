//! The loop of plant and autopilot, in the order in which a master steps the two.

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
    /// Whether they replace the manoeuvre.
    pub manual: bool,
    /// The value of each of [`references`], absolute, SI; the speed along the body axis, through the water.
    pub references: [f64; REFERENCES],
    /// The rates of the references \[SI per s\]; [`ClosedLoop::advance`] advances the references.
    pub slopes: [f64; REFERENCES],
}

/// A vehicle and its autopilot, flying a manoeuvre or external references.
///
/// At each tick, at t = start + k Ts, the autopilot measures the plant and commands it without delay; in between the
/// plant moves under held commands. Time is that of the experiment, also for the manoeuvre.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    /// The vehicle.
    pub plant: PlantModel,
    /// The autopilot of surge, heave and pitch; of a vehicle that leaves the vertical plane also those of other views.
    pub axes: Vec<Axis>,
    /// The place among [`references`] of each reference of each axis.
    pub(crate) taken: Vec<Vec<usize>>,
    views: Vec<&'static View>,
    /// Which of the vehicle's actuators each axis commands.
    pub(crate) commanded: Vec<Vec<usize>>,
    /// The manoeuvre flown by default.
    pub manoeuvre: Manoeuvre,
    /// The external references, flown while `manual` is true.
    pub outside: Override,
}

/// The signal of a reference.
pub(crate) fn signal(index: usize) -> Option<&'static Signal> {
    references().nth(index).map(|(.., signal)| signal)
}

/// Checks that an axis is one of this vehicle, and returns its view: the first for the first axis, and for another one
/// that none of those before has.
fn fits(
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

/// The place among [`references`] of each reference of an axis of a view; the speed is that of the first view.
fn taken(view: &View, axis: &Axis) -> Vec<usize> {
    let of = |index: usize| {
        let name = view.interface.signals[index].name;
        references().position(|(.., signal)| signal.name == name).unwrap_or(SPEED)
    };
    (0..axis.design().references().count()).map(of).collect()
}

impl ClosedLoop {
    /// Combines vehicle and autopilots: that of surge, heave and pitch, and others for a vehicle that leaves the
    /// vertical plane.
    ///
    /// # Errors
    /// [`ClosedLoopError::OtherAxes`], [`ClosedLoopError::OtherSampleTime`], [`ClosedLoopError::OtherVehicle`],
    /// [`ClosedLoopError::OtherSignals`], [`ClosedLoopError::OtherActuators`], [`ClosedLoopError::Manoeuvre`].
    pub fn new(plant: PlantModel, axes: Vec<Axis>, manoeuvre: Manoeuvre) -> Result<Self, ClosedLoopError> {
        if axes.is_empty() || plant.turns() != (axes.len() > 1) {
            return Err(ClosedLoopError::OtherAxes);
        }
        let mut views: Vec<&View> = Vec::new();
        for (index, axis) in axes.iter().enumerate() {
            views.push(fits(axis, index, &plant, &views)?);
            let [one, other] = [&axes[0], axis].map(|axis| axis.design().sample_time);
            if one != other {
                return Err(ClosedLoopError::OtherSampleTime { one, other });
            }
        }
        let commanded = commanded(&plant, &axes)?;
        let taken = views.iter().zip(&axes).map(|(view, axis)| taken(view, axis)).collect();
        let references = level(axes[0].autopilot().trim(), manoeuvre.speed_from, &plant);
        let outside = Override { manual: false, references, slopes: [0.0; REFERENCES] };
        let mut whole = Self { plant, axes, taken, views, commanded, manoeuvre, outside };
        whole.check()?;
        for signal in whole.followed().into_iter().filter(|place| *place != SPEED).filter_map(signal) {
            whole.manoeuvre.steps.entry(signal.name.to_owned()).or_default();
        }
        Ok(whole)
    }

    /// Checks the manoeuvre: each axis has references of its own steps, and the speeds are ahead where the vehicle has
    /// trims for flight ahead only.
    fn check(&self) -> Result<(), ManoeuvreError> {
        self.manoeuvre.check()?;
        let designs: Vec<_> = self.axes.iter().map(Axis::design).collect();
        self.manoeuvre.check_steps_of(&designs)?;
        if self.plant.only_ahead() { self.manoeuvre.check_ahead() } else { Ok(()) }
    }

    /// Returns whether there are axes beside that of level flight.
    pub(crate) fn turns(&self) -> bool {
        self.axes.len() > 1
    }

    /// The places of the references that the loop has.
    pub(crate) fn followed(&self) -> Vec<usize> {
        let has = |index: &usize| {
            self.owner(*index).is_some_and(|(axis, own)| self.axes[axis].design().has_reference(own))
        };
        (0..REFERENCES).filter(has).collect()
    }

    /// The axis that takes a reference, and its place there.
    pub(crate) fn owner(&self, index: usize) -> Option<(usize, usize)> {
        let of = |taken: &Vec<usize>| taken.iter().position(|one| *one == index);
        self.taken.iter().enumerate().find_map(|(axis, taken)| Some((axis, of(taken)?)))
    }

    /// A reference as the law used it at the last tick.
    pub(crate) fn reference_used(&self, index: usize) -> f64 {
        self.owner(index).map_or(0.0, |(axis, own)| self.axes[axis].autopilot().references()[own])
    }

    /// Puts the vehicle into level trim at the manoeuvre's speed, and the autopilot's state to zero, at a time \[s\].
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
        // Actuators without lag follow the first commands at once.
        Ok(self.plant.apply_inputs()?)
    }

    /// Moves the loop to a time \[s\] without allocating.
    ///
    /// # Errors
    /// [`ClosedLoopError::Plant`], [`ClosedLoopError::Controller`].
    pub fn advance(&mut self, to: f64, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        // A tick at the present time must use the new inputs.
        self.plant.apply_inputs()?;
        while self.axes[0].autopilot().is_due_before(to) {
            let due = self.axes[0].autopilot().next_tick_time();
            self.move_plant(due, log)?;
            self.tick(log)?;
        }
        self.move_plant(to, log)
    }

    /// Runs the next tick on the plant as it is.
    ///
    /// # Errors
    /// [`ClosedLoopError::Controller`].
    pub fn tick(&mut self, log: &mut dyn Log) -> Result<(), ClosedLoopError> {
        self.measure(self.axes[0].autopilot().next_tick_time());
        self.axes.iter_mut().try_for_each(|axis| axis.tick(log))?;
        self.command();
        Ok(())
    }

    /// Advances the plant and the external references; the plant may already be past a tick, by rounding.
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

    /// Passes measurements and references to the autopilots, and the operating speed to the LPV model. What is measured
    /// are the rates of the angles, theta' and psi'.
    fn measure(&mut self, time: f64) {
        let (references, path_speed) = self.references(time);
        let state = self.plant.state();
        for ((axis, taken), view) in self.axes.iter_mut().zip(&self.taken).zip(&self.views) {
            for (to, sensed) in axis.inputs.measured.iter_mut().zip(view.sensed) {
                *to = (sensed.value)(&state);
            }
            for (reference, index) in axis.inputs.references.iter_mut().zip(taken) {
                *reference = references[*index];
            }
        }
        self.plant.inputs.operating_speed = path_speed;
        self.plant.inputs.given_speed = references[SPEED];
    }

    /// Passes the commands to the plant.
    fn command(&mut self) {
        for (axis, indices) in self.axes.iter().zip(&self.commanded) {
            for (index, place) in indices.iter().enumerate() {
                self.plant.inputs.commands[*place] = axis.command(index);
            }
        }
    }

    /// The output whose error is put out: the pitch if there is a reference of it, the depth otherwise.
    pub(crate) fn stepped(&self) -> usize {
        if self.axes[0].design().has_reference(PITCH) { PITCH } else { DEPTH }
    }

    /// The references of the autopilots, and the speed along the path.
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

/// Which actuators of the vehicle each axis commands: all, in their order, in the vertical plane, and none two
/// axes.
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
    let place = |name: &String| expected.iter().position(|one| one == name);
    let places = names.iter().map(|names| names.iter().map(place).collect::<Option<Vec<usize>>>());
    let places: Option<Vec<Vec<usize>>> = places.collect();
    let found = names.concat();
    let once = found.iter().all(|name| found.iter().filter(|other| *other == name).count() == 1);
    match places.filter(|_| once && (plant.turns() || found == expected)) {
        Some(places) => Ok(places),
        None => Err(ClosedLoopError::OtherActuators { found, expected }),
    }
}

/// The references of level flight at a speed along the path \[m/s\], at the depth and the heading of the start, by the
/// trim table of the design.
fn level(trim: &Trim, path_speed: f64, plant: &PlantModel) -> [f64; REFERENCES] {
    let forward_speed = trim.forward_speed(path_speed);
    let settings = &plant.settings;
    let mut all = [0.0; REFERENCES];
    for (value, (view, place, signal)) in all.iter_mut().zip(references()) {
        *value = match (view, signal.level) {
            (0, _) => trim.signal(forward_speed, place, settings.initial_depth),
            (_, Level::Start) => settings.initial_heading,
            _ => 0.0,
        };
    }
    all
}
