//! The loop of plant and autopilot, in the order in which a master steps the two.

use fmi2::{Log, Model};
use fmu_controller::{Axis, RESOURCE, of_axis};
use fmu_plant::PlantModel;

use crate::ClosedLoopError;
use auv::longitudinal::{self, DEPTH, PITCH, SPEED, TRACKED};
use auv::{LATERAL, LONGITUDINAL, lateral};
use scheduled::{Manoeuvre, ManoeuvreError, Trim};
use signals::{Curve, Signal};

/// References of the loop: those of [`auv::longitudinal::SIGNALS`] that can be tracked, and heading.
pub const REFERENCES: usize = TRACKED + 1;

/// The place of the reference of heading.
pub const HEADING: usize = TRACKED;

/// External references, held between two steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Override {
    /// Whether they replace the manoeuvre.
    pub manual: bool,
    /// Of each signal that can be tracked, absolute, SI; the speed along the body axis, through the water.
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
    /// The autopilot of surge, heave and pitch; that of heading, of a vehicle that leaves the vertical plane.
    pub axes: Vec<Axis>,
    /// Which of the vehicle's actuators each axis commands.
    pub(crate) commanded: Vec<Vec<usize>>,
    /// The manoeuvre flown by default.
    pub manoeuvre: Manoeuvre,
    /// The external references, flown while `manual` is true.
    pub outside: Override,
}

/// The signal of a reference.
pub(crate) fn signal(place: usize) -> &'static Signal {
    if place == HEADING { &lateral::SIGNALS[lateral::HEADING] } else { &longitudinal::SIGNALS[place] }
}

/// Checks that an axis is one of this vehicle, with these signals.
fn fits(axis: &Axis, index: usize, plant: &PlantModel, signals: &[Signal]) -> Result<(), ClosedLoopError> {
    let (vehicle, design) = (plant.vehicle(), axis.design());
    let found: Vec<_> = design.signals.iter().map(|signal| signal.name.clone()).collect();
    let expected: Vec<_> = signals.iter().map(|signal| signal.name.to_owned()).collect();
    if found != expected {
        return Err(ClosedLoopError::OtherSignals { file: of_axis(RESOURCE, index), found, expected });
    }
    if design.vehicle.name != vehicle.name {
        let (found, expected) = (design.vehicle.name.clone(), vehicle.name.clone());
        return Err(ClosedLoopError::OtherVehicle { file: of_axis(RESOURCE, index), found, expected });
    }
    Ok(())
}

impl ClosedLoop {
    /// Combines vehicle and autopilots: that of surge, heave and pitch, and that of heading for a vehicle that leaves
    /// the vertical plane.
    ///
    /// # Errors
    /// [`ClosedLoopError::OtherAxes`], [`ClosedLoopError::OtherSampleTime`], [`ClosedLoopError::OtherVehicle`],
    /// [`ClosedLoopError::OtherSignals`], [`ClosedLoopError::OtherActuators`], [`ClosedLoopError::Manoeuvre`].
    pub fn new(plant: PlantModel, axes: Vec<Axis>, manoeuvre: Manoeuvre) -> Result<Self, ClosedLoopError> {
        if axes.len() != if plant.turns() { 2 } else { 1 } {
            return Err(ClosedLoopError::OtherAxes);
        }
        for (index, (axis, signals)) in
            axes.iter().zip([&longitudinal::SIGNALS, &lateral::SIGNALS]).enumerate()
        {
            fits(axis, index, &plant, signals)?;
            let [one, other] = [&axes[0], axis].map(|axis| axis.design().sample_time);
            if one != other {
                return Err(ClosedLoopError::OtherSampleTime { one, other });
            }
        }
        let commanded = commanded(&plant, &axes)?;
        let references = level(axes[0].autopilot().trim(), manoeuvre.speed_from, &plant);
        let outside = Override { manual: false, references, slopes: [0.0; REFERENCES] };
        let mut whole = Self { plant, axes, commanded, manoeuvre, outside };
        whole.check()?;
        for place in whole.followed().into_iter().filter(|place| *place != SPEED) {
            whole.manoeuvre.steps.entry(signal(place).name.to_owned()).or_default();
        }
        Ok(whole)
    }

    /// Checks the manoeuvre: each axis has references of its own steps, and the speeds are ahead where the vehicle has
    /// trims for flight ahead only.
    fn check(&self) -> Result<(), ManoeuvreError> {
        self.manoeuvre.check()?;
        let turn = signal(HEADING).name;
        let mut level = self.manoeuvre.clone();
        if let Some(axis) = self.axes.get(1) {
            level.steps.remove(turn);
            level.with_step(turn, self.manoeuvre.step(turn)).check_steps(axis.design())?;
        }
        level.check_steps(self.axes[0].design())?;
        if self.plant.only_ahead() { level.check_ahead() } else { Ok(()) }
    }

    /// Whether there is an axis of heading.
    pub(crate) fn turns(&self) -> bool {
        self.axes.len() > 1
    }

    /// The places of the references that the loop has.
    pub(crate) fn followed(&self) -> Vec<usize> {
        let level = (0..TRACKED).filter(|place| self.axes[0].design().has_reference(*place));
        level.chain(self.turns().then_some(HEADING)).collect()
    }

    /// A reference as the law used it at the last tick.
    pub(crate) fn reference_used(&self, place: usize) -> f64 {
        let (axis, place) = if place == HEADING { (1, lateral::HEADING) } else { (0, place) };
        self.axes[axis].autopilot().references()[place]
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
        let measured = [&LONGITUDINAL, &LATERAL].map(|view| (view.measured)(&state));
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.inputs.measured.copy_from_slice(&measured[index]);
            for (place, reference) in axis.inputs.references.iter_mut().enumerate() {
                *reference = references[reference_of(index, place)];
            }
        }
        self.plant.inputs.operating_speed = path_speed;
        self.plant.inputs.given_speed = references[SPEED];
    }

    /// Passes the commands to the plant.
    fn command(&mut self) {
        for (axis, places) in self.axes.iter().zip(&self.commanded) {
            for (index, place) in places.iter().enumerate() {
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
        for (place, reference) in references.iter_mut().enumerate() {
            *reference += self.manoeuvre.above_trim(time, signal(place).name);
        }
        (references, path_speed)
    }
}

/// The place of a reference of an axis among those of the loop.
pub(crate) fn reference_of(axis: usize, place: usize) -> usize {
    if axis > 0 && place == lateral::HEADING { HEADING } else { place }
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
    std::array::from_fn(|place| match place {
        HEADING => settings.initial_heading,
        _ => trim.signal(forward_speed, place, settings.initial_depth),
    })
}
