//! The plant with its settings and held inputs, independent of FMI.

use std::borrow::Cow;
use std::sync::Arc;

use squid_auv::{
    Ballast, Bottom, Coefficients, Current, Fidelity, Load, LpvModel, LpvModelError, Pitch, Plant, Slopes,
    Speed, State, Surroundings, Trim, TrimPoint, Vehicle, trim_with,
};

use crate::{PlantError, WaveParameters};

/// Settings, fixed before the simulation starts except for weight, buoyancy and centre of gravity.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Coefficients of the vehicle; [`PlantModel::take_on_ballast`] applies those changed in flight.
    pub coefficients: Coefficients,
    /// Initial speed along the path through the water \[m/s\].
    pub initial_speed: f64,
    /// Initial depth \[m\].
    pub initial_depth: f64,
    /// Initial heading \[rad\], for a vehicle in six degrees of freedom.
    pub initial_heading: f64,
    /// Equations of motion that are integrated.
    pub fidelity: Fidelity,
    /// Waves, for a vehicle whose dimensions are known.
    pub waves: WaveParameters,
    /// Seabed.
    pub bottom: Bottom,
}

/// Inputs of the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Command of each actuator: an output \[N or rad\], or the argument of its curve. Saturates at the limits of the
    /// actuator.
    pub commands: Vec<f64>,
    /// Velocity of the current.
    pub current: Current,
    /// Speed V along the path at which the LPV model is evaluated \[m/s\]; the nonlinear equations do not use it.
    pub operating_speed: f64,
    /// Forward speed through the water prescribed for a vehicle without surge dynamics \[m/s\]; others do not use it.
    pub given_speed: f64,
    /// External load.
    pub load: Load,
}

/// Initial properties of the vehicle that can change in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Launch {
    /// Weight \[N\] that corresponds to the mass in the settings.
    pub(crate) weight: f64,
    /// Buoyancy \[N\]; also of the hull volume on which the waves act.
    pub(crate) buoyancy: f64,
}

impl Launch {
    fn of(coefficients: &Coefficients) -> Self {
        Self { weight: coefficients.weight, buoyancy: coefficients.buoyancy }
    }
}

/// A vehicle that starts in level trim and then moves under its inputs.
///
/// A vehicle with coefficients of sway, roll and yaw moves in six degrees of freedom by the nonlinear equations; the
/// LPV model is then that of the same vehicle in the vertical plane, and only its trims are used.
#[derive(Debug, Clone)]
pub struct PlantModel {
    /// Settings; [`PlantModel::start`] applies them.
    pub settings: Settings,
    /// Inputs; [`PlantModel::advance`] applies them.
    pub inputs: Inputs,
    /// Rates of change of the inputs during [`PlantModel::advance`], which advances the inputs.
    pub slopes: Slopes,
    /// Rates as in `slopes`, with those of the requested outputs in place of the commands.
    requested: Slopes,
    pub(crate) vehicle: Arc<Vehicle>,
    pub(crate) lpv: Arc<LpvModel>,
    pub(crate) plant: Plant,
    pub(crate) trim: Trim,
    pub(crate) launch: Launch,
    /// Water about the vehicle, with the waves, since the start.
    pub(crate) surroundings: Option<Arc<Surroundings>>,
    pub(crate) above_surface: bool,
    pub(crate) out_of_range: bool,
}

impl PlantModel {
    /// Builds the plant near the centre of the speed range of its LPV model, at a trim of the model's table.
    ///
    /// Settings and inputs are copied from the files without arithmetic, so that they are the same on every platform.
    ///
    /// # Errors
    /// [`PlantError::OtherVehicle`], [`PlantError::Lpv`], or an error about a coefficient out of range.
    pub fn new(vehicle: Vehicle, lpv: LpvModel) -> Result<Self, PlantError> {
        if lpv.vehicle != vehicle.name {
            return Err(PlantError::OtherVehicle { found: lpv.vehicle, expected: vehicle.name });
        }
        let mut row = row_at_centre(&lpv)?.clone();
        let plane = plane_of(&vehicle);
        // The LPV model must match the vehicle in the vertical plane.
        Plant::new(&plane)?.with_lpv(lpv.clone())?;
        row.actuators = vehicle.outputs_of_plane(&plane, &row.actuators);
        let trim = trim_of(&row, lpv.depth, lpv.pitch());
        let lpv = Arc::new(lpv);
        let mut plant = plant_of(&vehicle, &lpv)?;
        plant.start(0.0, &trim)?;
        let commands =
            vehicle.actuators.iter().zip(row.actuators).map(|(one, output)| one.input_for(output).0);
        Ok(Self {
            settings: Settings {
                coefficients: vehicle.coefficients.clone(),
                initial_speed: row.speed,
                initial_depth: lpv.depth,
                initial_heading: 0.0,
                fidelity: Fidelity::Nonlinear,
                waves: WaveParameters::default(),
                bottom: Bottom::default(),
            },
            inputs: Inputs {
                commands: commands.collect(),
                current: Current::default(),
                operating_speed: row.speed,
                given_speed: row.forward_speed,
                load: Load::default(),
            },
            slopes: Slopes::held(vehicle.actuators.len()),
            requested: Slopes::held(vehicle.actuators.len()),
            launch: Launch::of(&vehicle.coefficients),
            vehicle: Arc::new(vehicle),
            lpv,
            plant,
            trim,
            surroundings: None,
            above_surface: false,
            out_of_range: false,
        })
    }

    /// Returns the vehicle of the file.
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Returns the LPV model.
    pub fn lpv(&self) -> &LpvModel {
        &self.lpv
    }

    /// Returns `true` if all trim speeds of the LPV model are above zero.
    pub fn only_ahead(&self) -> bool {
        self.lpv.trim.iter().all(|row| row.speed > 0.0)
    }

    /// Returns `true` if the forward speed is prescribed by an input.
    pub fn has_given_speed(&self) -> bool {
        self.vehicle.coefficients.surge.is_given()
    }

    /// Returns `true` if waves can be simulated, for which the dimensions of the hull must be known.
    pub fn supports_waves(&self) -> bool {
        self.vehicle.geometry.is_some()
    }

    /// Returns `true` if the vehicle moves in six degrees of freedom.
    pub fn has_six_dof(&self) -> bool {
        self.vehicle.coefficients.leaves_plane()
    }

    /// Returns the trim from which the simulation starts.
    pub fn trim(&self) -> &Trim {
        &self.trim
    }

    /// Returns the current time \[s\].
    pub fn time(&self) -> f64 {
        self.plant.time()
    }

    /// Returns position, and motion through the water.
    pub fn state(&self) -> State {
        let state = self.plant.state();
        State { bottom: self.settings.bottom.depth_at(state.x, state.east), ..state }
    }

    /// Returns the speed along the path through the water, sqrt(u^2 + v^2 + w^2) \[m/s\].
    pub fn path_speed(&self) -> f64 {
        self.plant.speed()
    }

    /// Returns the output of each actuator, after lag and limits \[N or rad\].
    pub fn actuator_outputs(&self) -> &[f64] {
        self.plant.outputs()
    }

    /// Sets the vehicle to level trim through the water at the initial speed and depth, at `time` \[s\].
    ///
    /// Actuators with lag start at their trim outputs and then follow the commands; others follow immediately.
    ///
    /// # Errors
    /// [`PlantError`] for coefficients or waves out of range, a start above the surface, or if there is no trim.
    pub fn start(&mut self, time: f64) -> Result<(), PlantError> {
        let Settings { coefficients, initial_speed, initial_depth, initial_heading, fidelity, waves, .. } =
            &self.settings;
        coefficients.check()?;
        if *initial_depth < 0.0 {
            return Err(PlantError::AboveSurface { depth: *initial_depth });
        }
        if self.only_ahead() && *initial_speed <= 0.0 {
            return Err(PlantError::NotAhead { speed: *initial_speed });
        }
        let vehicle = self.with(coefficients);
        let plane = plane_of(&vehicle);
        let trim = trim_with(&plane, Speed::Path(*initial_speed), *initial_depth, &self.lpv.pitch())?;
        let trim = Trim { actuators: vehicle.outputs_of_plane(&plane, &trim.actuators), ..trim };
        let mut plant = plant_of(&vehicle, &self.lpv)?;
        plant.set_fidelity(*fidelity)?;
        plant.set_current(self.inputs.current)?;
        plant.set_load(self.inputs.load)?;
        let surroundings = waves.about(&vehicle)?;
        if let Some(water) = &surroundings {
            plant = plant.with_water(water.clone());
        }
        plant.start(time, &trim)?;
        if self.has_six_dof() {
            plant.set_state(&State { heading: *initial_heading, ..plant.state() });
        }
        let clearance = surroundings.as_ref().map(|water| water.clearance(time, &plant.state().pose()));
        if let Some(clearance) = clearance.filter(|clearance| *clearance < 0.0) {
            return Err(PlantError::BreaksSurface { depth: trim.depth, out: -clearance });
        }
        self.launch = Launch::of(&vehicle.coefficients);
        (self.plant, self.trim, self.surroundings) = (plant, trim, surroundings);
        (self.above_surface, self.out_of_range) = (false, false);
        self.apply_commands()
    }

    /// Applies weight, buoyancy and centre of gravity of the settings in flight, without allocating. The mass changes
    /// with the weight, `m = W/g`; velocities and position do not jump.
    ///
    /// # Errors
    /// [`PlantError::Ballast`], [`PlantError::BallastOfLpv`]; the settings are then restored.
    pub fn take_on_ballast(&mut self) -> Result<(), PlantError> {
        let (requested, now) = (self.settings.coefficients.ballast(), self.plant.ballast());
        let ratio = requested.weight / self.launch.weight;
        // An invalid weight is reported as such, not as the mass that would follow from it.
        let mass = if ratio > 0.0 { requested.mass * ratio } else { now.mass };
        let requested = Ballast { mass, ..requested };
        let outcome = match self.settings.fidelity {
            _ if requested == now => Ok(()),
            Fidelity::Nonlinear => self.plant.set_ballast(&requested).map_err(PlantError::Ballast),
            Fidelity::Lpv => Err(PlantError::BallastOfLpv),
        };
        if outcome.is_err() {
            let mass = self.settings.coefficients.mass;
            self.settings.coefficients.set_ballast(&Ballast { mass, ..now });
        }
        outcome
    }

    /// Returns the vehicle with other coefficients.
    pub(crate) fn with(&self, coefficients: &Coefficients) -> Vehicle {
        Vehicle { coefficients: coefficients.clone(), ..(*self.vehicle).clone() }
    }

    /// Advances the vehicle to the time `to` \[s\] under inputs that are held or change at their rates, without
    /// allocating.
    ///
    /// A ramp through an actuator's curve is approximated by a ramp between the thrusts at its ends.
    ///
    /// # Errors
    /// [`PlantError::Simulation`]; the vehicle then keeps its previous state.
    pub fn advance(&mut self, to: f64) -> Result<(), PlantError> {
        let duration = to - self.plant.time();
        (self.requested.current, self.requested.operating_speed) =
            (self.slopes.current, self.slopes.operating_speed);
        (self.requested.given_speed, self.requested.load) = (self.slopes.given_speed, self.slopes.load);
        for (index, actuator) in self.vehicle.actuators.iter().enumerate() {
            let (command, slope) = (self.inputs.commands[index], self.slopes.commands[index]);
            let now = actuator.requested_output(command).0;
            self.plant.set_command(index, now)?;
            let curved = actuator.curve.is_some() && slope != 0.0 && duration > 0.0;
            let end = || actuator.requested_output(command + slope * duration).0;
            self.requested.commands[index] = if curved { (end() - now) / duration } else { slope };
        }
        self.plant.set_current(self.inputs.current)?;
        self.plant.set_operating_speed(self.inputs.operating_speed)?;
        self.plant.set_given_speed(self.inputs.given_speed)?;
        self.plant.set_load(self.inputs.load)?;
        self.plant.set_slopes(&self.requested)?;
        self.plant.advance(to)?;
        for (command, slope) in self.inputs.commands.iter_mut().zip(&self.slopes.commands) {
            *command += slope * duration;
        }
        self.inputs.current = self.plant.current();
        self.inputs.operating_speed = self.plant.operating_speed();
        self.inputs.given_speed = self.plant.given_speed();
        self.inputs.load = self.plant.load();
        Ok(())
    }
}

/// Returns the vehicle in the vertical plane.
fn plane_of(vehicle: &Vehicle) -> Cow<'_, Vehicle> {
    if vehicle.coefficients.leaves_plane() { Cow::Owned(vehicle.in_plane()) } else { Cow::Borrowed(vehicle) }
}

/// Returns the plant at rest, with the LPV model if the vehicle moves in the vertical plane.
fn plant_of(vehicle: &Vehicle, lpv: &Arc<LpvModel>) -> Result<Plant, PlantError> {
    let plant = Plant::new(vehicle)?;
    Ok(if vehicle.coefficients.leaves_plane() { plant } else { plant.with_lpv(Arc::clone(lpv))? })
}

/// Returns the row of the trim table whose speed is nearest to the centre of the scheduled speeds; the first of two at
/// equal distance.
fn row_at_centre(lpv: &LpvModel) -> Result<&TrimPoint, LpvModelError> {
    lpv.check()?;
    let off_centre = |row: &TrimPoint| (row.speed - lpv.speed_centre).abs();
    let nearest = lpv.trim.iter().min_by(|a, b| off_centre(a).total_cmp(&off_centre(b)));
    nearest.ok_or(LpvModelError::Empty { matrix: "trim" })
}

fn trim_of(row: &TrimPoint, depth: f64, rule: Pitch) -> Trim {
    let TrimPoint { speed, forward_speed, heave, pitch, ref actuators } = *row;
    let actuators = actuators.clone();
    Trim { speed, forward_speed, heave, incidence: pitch, pitch, rule, depth, actuators, residual: 0.0 }
}
