//! A flight of vehicle and autopilot in one loop, in this process.

use crate::error::Error;
use crate::sea::{Conditions, Sea};
use auv::{Current, Motion, Pitch, Plant, Speed, State, Vehicle, trim_with};
use scheduled::{Autopilot, ControllerDesign, Inputs as Measured, Manoeuvre, Outputs, Trim};
use signals::{Each, EachTracked, SIGNALS, measured};
use std::array::from_fn;

/// One row of a flight's record.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// s.
    pub time: f64,
    /// What is measured and wanted of each signal, SI.
    pub signals: Measured,
    /// m.
    pub depth: f64,
    /// The scheduling parameter.
    pub rho: f64,
    /// Whether the speed is outside the range of the design.
    pub out_of_range: bool,
    /// Commands, N or rad.
    pub commands: Vec<f64>,
}

impl Row {
    /// What is measured of the signal at a place in [`signals::SIGNALS`].
    pub fn measured(&self, place: usize) -> f64 {
        self.signals.measured[place]
    }

    /// What it is to follow, if it can be tracked.
    pub fn reference(&self, place: usize) -> f64 {
        self.signals.references[place]
    }

    /// How far it is off.
    pub fn error(&self, place: usize) -> f64 {
        self.reference(place) - self.measured(place)
    }
}

/// A vehicle that has come so far out of the water \[m\] has left it; less is rounding, of a flight that begins at
/// the surface.
const OUT_OF_WATER: f64 = 1e-3;

/// Whether a vehicle at a depth \[m\] is out of the water, where the equations are not valid.
pub fn out_of_water(depth: f64) -> bool {
    depth < -OUT_OF_WATER
}

/// Where a flight ended early.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfacing {
    /// s.
    pub time: f64,
    /// Forward speed through the water, m/s.
    pub speed: f64,
}

impl std::fmt::Display for Surfacing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the vehicle reaches the surface at {:.2} s, with {:.2} m/s", self.time, self.speed)
    }
}

/// A flight from trim to the end of its manoeuvre, or to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// A row for each tick, all in the water.
    pub rows: Vec<Row>,
    /// Where the vehicle left the water, if it did.
    pub surfacing: Option<Surfacing>,
    /// What the sea did at each tick; empty in still water.
    pub sea: Vec<SeaRow>,
}

/// What the sea did at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeaRow {
    /// The surface above the still water, over the vehicle, m.
    pub elevation: f64,
    /// How the water moved where the vehicle was.
    pub water: Current,
    /// What the sensors read of each signal, SI.
    pub read: Each<f64>,
}

/// What a control law answers at a tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Commands, N or rad.
    pub commands: Vec<f64>,
    /// The scheduling parameter.
    pub rho: f64,
    /// Whether the speed is outside the range of the design.
    pub out_of_range: bool,
}

/// Flies the vehicle from level trim, at a depth \[m\] and with a rule for its pitch, under its autopilot, in still
/// water.
///
/// # Errors
/// As [`fly_course`]; [`Error::NoReference`], [`Error::ControllerDesign`], [`Error::Tick`].
pub fn fly(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    level: (f64, &Pitch),
    manoeuvre: &Manoeuvre,
) -> Result<Flight, Error> {
    fly_varied(vehicle, design, level, manoeuvre, &Varied::default())
}

/// The same in a sea. The autopilot gets what the sensors read; the rows of the flight have what is there. It begins in
/// trim through the water, at the depth of the sea if that has one, and ends where the hull breaks the surface.
///
/// # Errors
/// As [`fly`]; [`Error::Sea`], [`Error::NoGeometry`], [`Error::AtTheSurface`].
pub fn fly_at_sea(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    level: (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    sea: &Sea,
) -> Result<Flight, Error> {
    fly_varied(vehicle, design, level, manoeuvre, &Varied { sea: Some(sea), ..Varied::default() })
}

/// In what a flight differs from one of the plain vehicle in still water.
#[derive(Debug, Clone, Copy, Default)]
pub struct Varied<'a> {
    /// The sea, if it is not still.
    pub sea: Option<&'a Sea>,
    /// What actuators put out in multiples of what they are commanded, up to their limits, in the order of the
    /// actuators; 1 where there is none. The rows of the flight have what they put out.
    pub gains: &'a [f64],
    /// How far off its trim the vehicle begins in each signal, SI.
    pub off_trim: Each<f64>,
}

/// The same, varied.
///
/// # Errors
/// As [`fly_at_sea`].
pub fn fly_varied(
    vehicle: &Vehicle,
    design: &ControllerDesign,
    (depth, pitch): (f64, &Pitch),
    manoeuvre: &Manoeuvre,
    &Varied { sea, gains, off_trim }: &Varied<'_>,
) -> Result<Flight, Error> {
    let steps = manoeuvre.steps();
    if let Some(place) = (0..steps.len()).find(|i| steps[*i] != 0.0 && !design.has_reference(*i)) {
        return Err(Error::NoReference { signal: SIGNALS[place].name });
    }
    let conditions = sea.map(|sea| sea.draw(vehicle, design.sample_time)).transpose()?;
    let level = (sea.and_then(|sea| sea.depth).unwrap_or(depth), pitch);
    let mut autopilot = Autopilot::new(design)?;
    let table = autopilot.trim().clone();
    let mut started = false;
    let course = (manoeuvre.duration, |time| Demand::of(manoeuvre, time));
    fly_in(vehicle, level, course, (design.sample_time, &table), (conditions, off_trim), |measured| {
        if !std::mem::replace(&mut started, true) {
            autopilot.initialise(0.0, measured)?;
        }
        autopilot.tick(measured)?;
        let Outputs { mut commands, scheduling_parameter: rho, out_of_range, .. } =
            autopilot.outputs().clone();
        for ((command, gain), actuator) in commands.iter_mut().zip(gains).zip(&vehicle.actuators) {
            *command = (*command * gain).clamp(actuator.min, actuator.max);
        }
        Ok(Answer { commands, rho, out_of_range })
    })
}

/// What is wanted at a time, and how the water moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Speed V along the path through the water, m/s.
    pub speed: f64,
    /// Each reference above that of the trim, and the depth above that of the start, SI; the speed apart.
    pub above_trim: EachTracked<f64>,
    /// The current. Where it steps, the velocity through the water does.
    pub current: Current,
}

impl Demand {
    /// That of a manoeuvre, in still water.
    pub fn of(manoeuvre: &Manoeuvre, time: f64) -> Self {
        Self {
            speed: manoeuvre.speed_reference(time),
            above_trim: manoeuvre.above_trim(time),
            current: Current::default(),
        }
    }
}

/// Flies the vehicle from trim on a course, a duration \[s\] and the demand at each time: a control law at each tick,
/// `t = k T`, the nonlinear vehicle in between. The table of trims turns the demand into references. The flight ends
/// at the surface, for the equations of motion are those of deep water.
///
/// # Errors
/// [`Error::Trim`], [`Error::Coefficient`], [`Error::Simulation`], those of the law.
pub fn fly_course(
    vehicle: &Vehicle,
    level: (f64, &Pitch),
    course: (f64, impl Fn(f64) -> Demand),
    ticks: (f64, &Trim),
    law: impl FnMut(&Measured) -> Result<Answer, Error>,
) -> Result<Flight, Error> {
    fly_in(vehicle, level, course, ticks, (None, Each::default()), law)
}

fn fly_in(
    vehicle: &Vehicle,
    level: (f64, &Pitch),
    (duration, course): (f64, impl Fn(f64) -> Demand),
    (sample_time, table): (f64, &Trim),
    (mut conditions, off_trim): (Option<Conditions>, Each<f64>),
    mut law: impl FnMut(&Measured) -> Result<Answer, Error>,
) -> Result<Flight, Error> {
    let speed = course(0.0).speed;
    let start = trim_with(vehicle, Speed::Path(speed), level.0, level.1)
        .map_err(|reason| Error::Trim { speed, reason })?;
    let mut plant = Plant::new(vehicle)?;
    if let Some(sea) = &conditions {
        plant = plant.with_water(sea.water());
    }
    plant.start(0.0, &start)?;
    plant.set_state(&displaced(plant.state(), off_trim));
    let steps = (duration / sample_time).round() as u64;
    let mut flight =
        Flight { rows: Vec::with_capacity(steps as usize + 1), surfacing: None, sea: Vec::new() };
    for k in 0..=steps {
        let time = k as f64 * sample_time;
        let Demand { speed, above_trim, current } = course(time);
        let demanded = table.forward_speed(speed);
        let level = table.signals(demanded, level.0);
        let references = from_fn(|place| level[place] + above_trim[place]);
        plant.set_current(current + conditions.as_ref().map(Conditions::wandering).unwrap_or_default())?;
        plant.set_given_speed(demanded)?;
        let State { motion: Motion { u, w, q, theta }, x, depth } = plant.state();
        let clearance =
            conditions.as_ref().map_or(depth, |sea| sea.surroundings().clearance(time, x, depth, theta));
        if out_of_water(clearance) {
            flight.surfacing = Some(Surfacing { time, speed: u });
            break;
        }
        let signals = Measured { measured: measured([u, w, q, theta, depth]), references };
        let mut read = signals;
        if let Some(sea) = &mut conditions {
            read.measured = sea.read(&signals.measured);
            let elevation = sea.surroundings().elevation(time, x);
            flight.sea.push(SeaRow { elevation, water: plant.flow(), read: read.measured });
            sea.advance(sample_time);
        }
        let Answer { commands, rho, out_of_range } = law(&read)?;
        for (i, command) in commands.iter().enumerate() {
            plant.set_command(i, *command)?;
        }
        flight.rows.push(Row { time, signals, depth, rho, out_of_range, commands });
        plant.advance((k + 1) as f64 * sample_time)?;
    }
    if flight.rows.is_empty() { Err(Error::AtTheSurface { depth: level.0 }) } else { Ok(flight) }
}

/// A flight, or none where it cannot be followed to its end: the autopilot or the motion cannot be computed any more.
///
/// # Errors
/// All others.
pub fn unless_lost(flown: Result<Flight, Error>) -> Result<Option<Flight>, Error> {
    match flown {
        Err(Error::Tick(_) | Error::Simulation(_)) => Ok(None),
        flown => flown.map(Some),
    }
}

/// A state with another motion, by what is added to each signal; the same to the bit where that is 0.
fn displaced(state: State, by: Each<f64>) -> State {
    let State { motion: Motion { u, w, q, theta }, depth, .. } = state;
    let mut motion = [u, w, q, theta, depth];
    for (signal, by) in SIGNALS.iter().zip(by).filter(|(_, by)| *by != 0.0) {
        motion[signal.state] += by;
    }
    let [u, w, q, theta, depth] = motion;
    State { motion: Motion { u, w, q, theta }, depth, ..state }
}

/// The vehicle alone: from trim at a speed, one actuator (its index, and by how much) stepped. Time (s) and pitch
/// from trim (rad), up to the surface if it comes there.
///
/// # Errors
/// [`Error::Trim`], [`Error::Simulation`].
pub fn fly_open_loop(
    vehicle: &Vehicle,
    level: (f64, &Pitch),
    speed: f64,
    (actuator, step): (usize, f64),
    interval: f64,
    duration: f64,
) -> Result<Vec<(f64, f64)>, Error> {
    let start = trim_with(vehicle, Speed::Path(speed), level.0, level.1)
        .map_err(|reason| Error::Trim { speed, reason })?;
    let mut plant = Plant::new(vehicle)?;
    plant.start(0.0, &start)?;
    plant.set_command(actuator, start.actuators[actuator] + step)?;
    let steps = (duration / interval).round() as u64;
    let mut rows = vec![(0.0, 0.0)];
    for k in 1..=steps {
        let time = k as f64 * interval;
        plant.advance(time)?;
        if out_of_water(plant.state().depth) {
            break;
        }
        rows.push((time, plant.state().motion.theta - start.pitch));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::inputs::Inputs;
    use std::path::Path;

    /// The committed design of Squid, 10 degrees bow up from a metre below the surface: it comes out of the water,
    /// and no row is above.
    #[test]
    fn a_flight_ends_at_the_surface() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let frozen = base::files::read(&folder.join("frozen/controller.json")).unwrap();
        let design = ControllerDesign::from_json(&frozen).unwrap();
        let manoeuvre = &inputs.design.manoeuvre;
        let flown = |depth| fly(&inputs.vehicle, &design, (depth, &Pitch::Free), manoeuvre).unwrap();
        let deep = flown(50.0);
        assert_eq!((deep.surfacing, deep.rows.len()), (None, 3001));

        let flight = flown(1.0);
        let Surfacing { time, speed } = flight.surfacing.unwrap();
        let last = flight.rows.last().unwrap();
        assert!((last.time + design.sample_time - time).abs() < 1e-9, "{time}");
        assert!(last.depth.abs() < 0.05 && flight.rows.iter().all(|row| !out_of_water(row.depth)));
        // The step comes at 10 s; from a metre down at 1 m/s and 10 degrees it takes some 5 s.
        assert!((12.0..20.0).contains(&time) && (0.6..2.9).contains(&speed), "{time} s, {speed} m/s");
        let words = flight.surfacing.unwrap().to_string();
        assert!(words.starts_with("the vehicle reaches the surface at 1"), "{words}");
    }
}
