//! The cascade for a vehicle: states, signals, gains, and the controller whose matrices are affine in the gains.

use crate::allocation::{Allocation, allocations};
use crate::file::{Pid, TurnLoop};
use crate::gain::{Given, Misfit, Role, Unit, pitch_units, value};
use crate::refusal::not_allowed;
use squid_auv::Actuator;
use squid_auv::toml_file::FileError;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, pseudo_inverse};
use squid_lpv::weights::ReferenceModel;

/// A signal in the controller's input y.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Name of the signal.
    pub signal: &'static str,
    /// Unit of the signal in y, SI.
    pub scale: f64,
}

/// The controller's input y: references, then measurements, as deviations from trim in units of their scales.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layout {
    /// The references.
    pub references: Vec<Port>,
    /// The measurements.
    pub measurements: Vec<Port>,
}

/// Properties of the vehicle and of the design that the cascade depends on.
#[derive(Debug, Clone, Copy)]
pub struct Vehicle<'a> {
    /// The actuators.
    pub actuators: &'a [Actuator],
    /// `true` if the speed is controlled externally.
    pub speed_given: bool,
    /// Input y.
    pub layout: &'a Layout,
    /// Centre and half range in rho = (V - centre)/half_range, m/s.
    pub scheduling: (f64, f64),
    /// Name of the design file for messages.
    pub design: &'a str,
}

/// A gain: its polynomial times a signal is one term of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Gain {
    /// Name, for instance `pitch.kp`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Index of the command, a column of the allocation.
    pub axis: usize,
    /// Coefficients of 1, rho, rho^2.
    pub coefficients: Vec<f64>,
    /// Signal as a row over `[x; y]`, SI.
    signal: Mat,
}

/// The cascade and its gains.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Names of the states.
    pub states: Vec<String>,
    /// The gains.
    pub gains: Vec<Gain>,
    /// The commands.
    pub allocations: Vec<Allocation>,
    /// Misfits of the polynomials against the tables.
    pub misfits: Vec<Misfit>,
    /// State equation, `x' = rates [x; y]`.
    rates: Mat,
    /// Allocation: output of each actuator in units of its reach per unit of each command, m x axes.
    shares: Mat,
    /// Integrators with the indices of their gains.
    integrators: Vec<Integrator>,
    tracking_time: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
struct Integrator {
    state: usize,
    axis: usize,
    /// Unit of the state, SI.
    scale: f64,
    /// Indices of the gains of the integrator's loop.
    kp: usize,
    ki: usize,
}

/// A controller that is affine in its gains, `base + sum_i value_i matrix_i`, each `[A By Bt; Cu Duy Dut; Ct Dty Dtt]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Affine {
    /// Matrix for zero gains.
    pub base: Mat,
    /// One direction per coefficient of each gain.
    pub directions: Vec<Direction>,
    /// Numbers of states, measurements and controls.
    pub sizes: [usize; 3],
    /// Number of repetitions of rho.
    pub blocks: Vec<usize>,
}

/// Direction of one coefficient of a gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Name of the gain, for instance `pitch.kp`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Power of rho.
    pub power: usize,
    /// Value of the coefficient.
    pub value: f64,
    /// Matrix per unit of the coefficient.
    pub matrix: Mat,
}

impl Affine {
    /// Returns the matrix for given coefficients, in the order of the directions.
    pub fn at(&self, values: &[f64]) -> Mat {
        self.directions
            .iter()
            .zip(values)
            .fold(self.base.clone(), |sum, (one, value)| sum + &one.matrix * *value)
    }

    /// Returns the controller for given coefficients, in the order of the directions.
    pub fn controller(&self, values: &[f64]) -> Controller {
        let [states, y, u] = self.sizes;
        Controller::from_matrix(&self.at(values), states, y, u, self.blocks.clone())
    }
}

/// Number of speeds at which the signs of gains are checked.
const SIGN_SAMPLES: usize = 101;

/// Cascade under construction; signals are rows over `[x; y]`.
struct Builder<'a> {
    pid: &'a Pid,
    vehicle: Vehicle<'a>,
    states: Vec<String>,
    /// Row of the derivative of each state.
    rates: Vec<Mat>,
    /// Numbers of states and of signals in y.
    width: [usize; 2],
    gains: Vec<Gain>,
    integrators: Vec<Integrator>,
    misfits: Vec<Misfit>,
}

impl Structure {
    /// Builds the cascade of a file for a vehicle and the signals of a design.
    ///
    /// # Errors
    /// [`FileError`] with the first invalid value: an unknown unit, a gain of the wrong sign, an integrator without
    /// gain, a signal that the design does not have.
    pub fn new(pid: &Pid, vehicle: Vehicle<'_>) -> Result<Self, FileError> {
        let y = vehicle.layout.references.len() + vehicle.layout.measurements.len();
        let mut builder = Builder {
            pid,
            vehicle,
            states: vec![],
            rates: vec![],
            width: [count_states(pid), y],
            gains: vec![],
            integrators: vec![],
            misfits: vec![],
        };
        let TurnLoop { angle, line, .. } = pid.turn;
        builder.measured(angle.name(), line, &format!("controller.{angle}"))?;
        let (centre, _) = vehicle.scheduling;
        let allocations = allocations(pid, vehicle.actuators, centre, vehicle.speed_given)?;
        builder.turn(&allocations[0])?;
        builder.speed(allocations.get(1))?;
        let Builder { states, rates, width: [n, y], gains, integrators, misfits, .. } = builder;
        let reach: Vec<f64> = vehicle.actuators.iter().map(Actuator::reach).collect();
        let shares =
            Mat::from_fn(reach.len(), allocations.len(), |j, axis| allocations[axis].outputs[j] / reach[j]);
        let rates = Mat::from_fn(n, n + y, |i, j| rates[i][j]);
        let tracking_time = pid.tracking_time;
        Ok(Self { states, gains, allocations, misfits, rates, shares, integrators, tracking_time })
    }

    /// Returns the controller as an affine function of the coefficients of the gains.
    ///
    /// Horner's rule over rho for each command: `v = g0 s + w1`, `z1 = g1 s + w2`, `z2 = g2 s`, `w = rho z`, with as
    /// many channels as the highest power of its gains. Channels are in units of the largest reach.
    pub fn affine(&self) -> Affine {
        let (n, width) = self.rates.shape();
        let (y, (m, axes)) = (width - n, self.shares.shape());
        let of_axis = |axis: usize| self.gains.iter().filter(move |gain| gain.axis == axis);
        let powers: Vec<usize> = (0..axes)
            .map(|axis| of_axis(axis).map(|gain| gain.coefficients.len() - 1).max().unwrap_or(0))
            .collect();
        let first = |axis: usize| powers[..axis].iter().sum::<usize>();
        let r: usize = powers.iter().sum();
        let unit = |axis: usize| self.shares.column(axis).amax();
        let mut base = Mat::zeros(n + m + r, width + r);
        base.view_mut((0, 0), (n, width)).copy_from(&self.rates);
        for axis in (0..axes).filter(|axis| powers[*axis] > 0) {
            let column = self.shares.column(axis) / unit(axis);
            base.view_mut((n, width + first(axis)), (m, 1)).copy_from(&column);
            for k in 1..powers[axis] {
                base[(n + m + first(axis) + k - 1, width + first(axis) + k)] = 1.0;
            }
        }
        let mut directions = vec![];
        for gain in &self.gains {
            for (power, value) in gain.coefficients.iter().enumerate() {
                let mut matrix = Mat::zeros(n + m + r, width + r);
                if power == 0 {
                    let part = self.shares.column(gain.axis) * &gain.signal;
                    matrix.view_mut((n, 0), (m, width)).copy_from(&part);
                } else {
                    let row = n + m + first(gain.axis) + power - 1;
                    matrix.view_mut((row, 0), (1, width)).copy_from(&(&gain.signal * unit(gain.axis)));
                }
                let (name, unit) = (gain.name.clone(), gain.unit.clone());
                directions.push(Direction { name, unit, power, value: *value, matrix });
            }
        }
        Affine { base, directions, sizes: [n, y, m], blocks: vec![r] }
    }

    /// Returns the controller with the gains of the file.
    pub fn controller(&self) -> Controller {
        let affine = self.affine();
        let values: Vec<f64> = affine.directions.iter().map(|one| one.value).collect();
        affine.controller(&values)
    }

    /// Returns the back-calculation matrix E, states x actuators, with `x' = ... + E (u - sat u)`, u in units of reach:
    /// the integral term of a saturated command decays with the tracking time Tt, or with `kp/ki` if none is given.
    ///
    /// `I' = ... - (v - sat v)/(Tt ki)`, where v is the command recovered from the actuator commands, with the gains at
    /// the centre of the speed range.
    pub fn anti_windup(&self) -> Mat {
        let commands = pseudo_inverse(&self.shares, 1e-9);
        let mut all = Mat::zeros(self.rates.nrows(), self.shares.nrows());
        for Integrator { state, axis, scale, kp, ki } in &self.integrators {
            let [kp, ki] = [kp, ki].map(|gain| self.gains[*gain].coefficients[0]);
            let fall = -1.0 / (self.tracking_time.map_or(kp, |time| time * ki) * scale);
            all.row_mut(*state).copy_from(&(commands.row(*axis) * fall));
        }
        all
    }
}

/// Returns the number of states of a cascade.
fn count_states(pid: &Pid) -> usize {
    let pitch = usize::from(pid.turn.ki.is_some())
        + usize::from(pid.turn.rolloff > 0.0)
        + 2 * usize::from(pid.turn.model.is_some());
    let depth = pid.depth.as_ref().is_some_and(|depth| depth.ki.is_some());
    let speed = pid.speed.as_ref().map_or(0, |s| usize::from(s.ki.is_some()) + usize::from(s.rolloff > 0.0));
    pitch + usize::from(depth) + speed
}

impl Builder<'_> {
    fn refuse<T>(&self, line: usize, key: &str, found: &str, allowed: &str) -> Result<T, FileError> {
        Err(not_allowed(&self.pid.file, line, key, found, allowed))
    }

    fn unit_row(&self, index: usize) -> Mat {
        let mut row = Mat::zeros(1, self.width[0] + self.width[1]);
        row[index] = 1.0;
        row
    }

    /// Adds a state with its derivative, in the state's own unit; returns index and row.
    fn state(&mut self, name: &str, rate: Mat) -> (usize, Mat) {
        let index = self.states.len();
        self.states.push(name.to_owned());
        self.rates.push(rate);
        (index, self.unit_row(index))
    }

    /// Returns a reference in SI, and its scale.
    fn reference(&self, signal: &str, line: usize, key: &str) -> Result<(Mat, f64), FileError> {
        let all = &self.vehicle.layout.references;
        match all.iter().position(|port| port.signal == signal) {
            Some(index) => {
                let scale = all[index].scale;
                Ok((self.unit_row(self.width[0] + index) * scale, scale))
            }
            None => {
                let tracked: Vec<&str> = all.iter().map(|port| port.signal).collect();
                let allowed = format!(
                    "a loop of a tracked output whose reference is separate from its measurement; in {} these are: \
                        {}",
                    self.vehicle.design,
                    if tracked.is_empty() { "none".into() } else { tracked.join(" and ") }
                );
                self.refuse(line, key, &format!("a loop of {signal}"), &allowed)
            }
        }
    }

    /// Returns a measurement in SI, and its scale.
    fn measured(&self, signal: &str, line: usize, key: &str) -> Result<(Mat, f64), FileError> {
        let Vehicle { layout, design, .. } = self.vehicle;
        match layout.measurements.iter().position(|port| port.signal == signal) {
            Some(index) => {
                let scale = layout.measurements[index].scale;
                Ok((self.unit_row(self.width[0] + layout.references.len() + index) * scale, scale))
            }
            None => {
                let found = format!("a gain on {signal}, which {design} does not measure");
                let allowed =
                    format!("omitted, or {design} must have a [[measure]] with signal = \"{signal}\"");
                self.refuse(line, key, &found, &allowed)
            }
        }
    }

    /// Adds a gain on a signal, and checks its sign against the allocation.
    fn gain(
        &mut self,
        given: &Given,
        units: &[Unit],
        (axis, sign): (usize, f64),
        signal: Mat,
    ) -> Result<usize, FileError> {
        let coefficients = self.coefficients(given, units, Some(sign))?;
        let name = given.key.trim_start_matches("controller.").to_owned();
        self.gains.push(Gain { name, unit: units[0].0.to_owned(), axis, coefficients, signal });
        Ok(self.gains.len() - 1)
    }

    /// Returns the coefficients in SI; with a sign given, that sign times the gain must be positive over the speed
    /// range.
    fn coefficients(
        &mut self,
        given: &Given,
        units: &[Unit],
        sign: Option<f64>,
    ) -> Result<Vec<f64>, FileError> {
        let (centre, half_range) = self.vehicle.scheduling;
        let (found, misfit) = given.coefficients(&self.pid.file, units, self.vehicle.scheduling)?;
        self.misfits.extend(misfit);
        let Some(sign) = sign else { return Ok(found) };
        let rhos = (0..SIGN_SAMPLES).map(|i| 2.0 * i as f64 / (SIGN_SAMPLES - 1) as f64 - 1.0);
        let wrong = rhos.map(|rho| (rho, value(&found, rho))).find(|(_, gain)| sign * gain <= 0.0);
        let Some((rho, gain)) = wrong else { return Ok(found) };
        let at = if found.len() > 1 {
            format!(" at {} m/s", squid_auv::rounded(centre + rho * half_range))
        } else {
            String::new()
        };
        let found = format!("{} {}{at}", squid_auv::rounded(gain), units[0].0);
        let integral = given.key.ends_with("ki");
        let side = if sign > 0.0 { "above 0" } else { "below 0, with this [controller.allocation]," };
        let allowed = match (gain == 0.0, integral) {
            (true, true) => format!(
                "{side} at every speed, or omitted (the output of an integrator with zero gain stays constant, and \
                 no bound could be proved)"
            ),
            (true, false) => format!("{side} at every speed, or omitted"),
            (false, _) => format!("{side} at every speed, because the other sign is positive feedback"),
        };
        self.refuse(given.line, &given.key, &found, &allowed)
    }

    /// Adds an integrator of `error` \[SI\] in units of `scale`; returns its index and the integral in SI.
    fn integral(&mut self, name: &str, error: &Mat, scale: f64) -> (usize, Mat) {
        let (index, row) = self.state(name, error / scale);
        (index, row * scale)
    }

    /// Returns the reference of the angle in SI, with its unit: its own, or the output of the depth loop for pitch.
    fn turn_reference(&mut self, scale: f64) -> Result<(Mat, f64), FileError> {
        let pid = self.pid;
        let Some(depth) = &pid.depth else {
            if self.vehicle.layout.references.iter().any(|port| port.signal == "depth") {
                let allowed = format!("given, because {} tracks depth", self.vehicle.design);
                return self.refuse(pid.line, "controller.depth", "missing", &allowed);
            }
            return self.reference(
                pid.turn.angle.name(),
                pid.turn.line,
                &format!("controller.{}", pid.turn.angle),
            );
        };
        let (depth_reference, unit) = self.reference("depth", depth.line, "controller.depth")?;
        let (found, _) = self.measured("depth", depth.line, "controller.depth")?;
        let error = depth_reference - found;
        // The bow must rise to reduce depth at positive speed.
        let ahead = self.vehicle.scheduling.0.signum();
        let kp = self.coefficients(&depth.kp, &pitch_units(Role::Proportional), Some(ahead))?[0];
        let mut reference = &error * -kp;
        if let Some(given) = &depth.ki {
            let ki = self.coefficients(given, &pitch_units(Role::Integral), Some(ahead))?[0];
            let (_, integral) = self.integral("integral of the depth error", &error, unit);
            reference -= integral * ki;
        }
        Ok((reference, scale))
    }

    fn turn(&mut self, allocation: &Allocation) -> Result<(), FileError> {
        let angle_loop = &self.pid.turn;
        let angle = angle_loop.angle;
        let key = format!("controller.{angle}");
        let axis = (0, allocation.sign);
        let units = |role| allocation.drive.units(role);
        let (measured_angle, scale) = self.measured(angle.name(), angle_loop.line, &key)?;
        let (reference, scale) = self.turn_reference(scale)?;
        let rate = match angle_loop.kd.as_ref() {
            Some(kd) => Some(self.measured(&format!("{angle}_rate"), kd.line, &kd.key)?),
            None => None,
        };
        let model = angle_loop.model.map(|model| self.follow(model, &reference, scale));
        let [target, target_rate, target_acceleration] =
            model.unwrap_or_else(|| [reference.clone(), &reference * 0.0, &reference * 0.0]);
        let weighted =
            if angle_loop.model.is_some() { target.clone() } else { &target * angle_loop.reference_weight };
        let kp = self.gain(&angle_loop.kp, &units(Role::Proportional), axis, weighted - &measured_angle)?;
        if let Some(ki) = &angle_loop.ki {
            let (state, integral) =
                self.integral(&format!("integral of the {angle} error"), &(target - &measured_angle), scale);
            let ki = self.gain(ki, &units(Role::Integral), axis, integral)?;
            self.integrators.push(Integrator { state, axis: 0, scale, kp, ki });
        }
        if let Some((kd, (rate, unit))) = angle_loop.kd.as_ref().zip(rate) {
            let rate = self.filtered(&format!("filtered {angle} rate"), rate, unit, angle_loop.rolloff);
            self.gain(kd, &units(Role::Derivative), axis, target_rate - rate)?;
        } else if angle_loop.rolloff > 0.0 {
            let allowed = "omitted, because without kd no rate is filtered";
            return self.refuse(angle_loop.line, &format!("{key}.rolloff"), "given", allowed);
        }
        if let Some(feedforward) = &angle_loop.feedforward {
            self.gain(feedforward, &units(Role::Feedforward), axis, target_acceleration)?;
        }
        Ok(())
    }

    /// Adds the reference model; returns its output, rate and acceleration, SI.
    fn follow(&mut self, model: ReferenceModel, reference: &Mat, scale: f64) -> [Mat; 3] {
        let (w, damping) = (model.frequency, model.damping.unwrap_or(1.0));
        let index = self.states.len();
        let [output, rate] = [index, index + 1].map(|index| self.unit_row(index));
        let acceleration = (reference / scale - &output) * (w * w) - &rate * (2.0 * damping * w);
        self.state(&format!("reference model of {}", self.pid.turn.angle), rate.clone());
        self.state("its rate", acceleration.clone());
        [output * scale, rate * scale, acceleration * scale]
    }

    /// Returns a measurement, low-pass filtered if the time constant is above 0.
    fn filtered(&mut self, name: &str, signal: Mat, unit: f64, time: f64) -> Mat {
        if time <= 0.0 {
            return signal;
        }
        let own = self.unit_row(self.states.len());
        let (_, state) = self.state(name, (&signal / unit - own) / time);
        state * unit
    }

    fn speed(&mut self, allocation: Option<&Allocation>) -> Result<(), FileError> {
        let key = "controller.speed";
        let pid = self.pid;
        let (speed_loop, allocation) = match (&pid.speed, allocation) {
            (None, None) => return Ok(()),
            (None, Some(_)) => {
                let allowed = format!("given, because {} tracks speed", self.vehicle.design);
                return if self.vehicle.layout.references.iter().any(|port| port.signal == "speed") {
                    self.refuse(pid.line, key, "missing", &allowed)
                } else {
                    Ok(())
                };
            }
            (Some(given), None) => {
                let allowed = "omitted, because the speed of this vehicle is imposed from outside";
                return self.refuse(given.line, key, "given", allowed);
            }
            (Some(given), Some(allocation)) => (given, allocation),
        };
        let axis = (1, allocation.sign);
        let units = |role| allocation.drive.units(role);
        let (ahead, _) = self.reference("speed", speed_loop.line, key)?;
        let (speed, scale) = self.measured("speed", speed_loop.line, key)?;
        let smooth = self.filtered("filtered speed", speed.clone(), scale, speed_loop.rolloff);
        let error = ahead * speed_loop.reference_weight - smooth;
        let kp = self.gain(&speed_loop.kp, &units(Role::Proportional), axis, error)?;
        if let Some(ki) = &speed_loop.ki {
            let (state, integral) = self.integral("integral of the speed error", &-speed, scale);
            let ki = self.gain(ki, &units(Role::Integral), axis, integral)?;
            self.integrators.push(Integrator { state, axis: 1, scale, kp, ki });
        }
        Ok(())
    }
}
