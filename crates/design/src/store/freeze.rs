//! Frozen design: the contents of the FMUs' resources.

use crate::axis::VehicleModel;
use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::inputs::design_file::{DesignFile, Safe, SensorKeys};
use crate::linearise::TRIM_ROWS;
use crate::synthesise::given;
use squid_auv::LpvModel;
use squid_auv::longitudinal::turn_rate;
use squid_lpv::synthesis::Design;
use squid_scheduled::{
    Actuator, CONTROLLER_FORMAT, ControllerDesign, ControllerInput, Failsafe, Gamma, InputHashes, Kind,
    LftMatrices, OverSpeed, Port, ReferenceLimits, Scheduling, TrimTable, VehicleName,
};
use squid_signals::{Level, Signal};
use std::collections::BTreeMap;

/// Contents of the two frozen files.
#[derive(Debug, Clone)]
pub struct Frozen {
    /// Contents of `controller.json`.
    pub controller: ControllerDesign,
    /// Contents of `plant.json`; only for surge, heave and pitch.
    pub plant: Option<LpvModel>,
}

/// Returns the gammas of a design.
pub fn gamma(design: &Design, certified: bool) -> Gamma {
    Gamma {
        optimum: design.gamma_optimum,
        bound: design.certified.gamma,
        back_off: crate::synthesise::back_off(design),
        certified,
    }
}

/// Returns the contents of the frozen files of a controller, without anti-windup.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn frozen(inputs: &Inputs, model: &Model, lft: LftMatrices, gamma: Gamma) -> Result<Frozen, Error> {
    let controller = controller(&inputs.axis(), &inputs.design, &inputs.hashes, lft, gamma)?;
    Ok(Frozen { controller, plant: lpv_model(inputs, model)? })
}

/// Returns the frozen LPV model of the vehicle; `None` for lateral axes, for which an FMU has only the nonlinear
/// equations.
///
/// # Errors
/// [`StoreError::LpvModel`](crate::error::StoreError::LpvModel), [`ModelError::Trim`](crate::error::ModelError::Trim).
pub fn lpv_model(inputs: &Inputs, model: &Model) -> Result<Option<LpvModel>, Error> {
    let (vehicle, file) = (&inputs.vehicle, &inputs.design);
    if file.view().is_level_held {
        return Ok(None);
    }
    let trims = inputs.axis().level(&file.spread(TRIM_ROWS))?;
    // The plant computes the depth itself from the other states.
    let others = vehicle.coefficients.surge.states(false).len();
    let (mut a, mut b) = model.coefficients();
    a.iter_mut().for_each(|a| *a = a.view((0, 0), (others, others)).into_owned());
    b.iter_mut().for_each(|b| *b = b.rows(0, others).into_owned());
    Ok(Some(LpvModel::new(&vehicle.name, file.depth, file.scheduling(), &a, &b, &trims)?))
}

/// Returns the frozen controller of an axis, without anti-windup.
///
/// # Errors
/// [`ModelError::Trim`](crate::error::ModelError::Trim); the errors of a given controller.
pub fn controller(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    hashes: &InputHashes,
    lft: LftMatrices,
    gamma: Gamma,
) -> Result<ControllerDesign, Error> {
    let trims = vehicle.trims(&file.spread(TRIM_ROWS))?;
    let signals = vehicle.interface().signals;
    let scheduled =
        vehicle.interface().scheduled().map(|signal_index| (signal_index, &signals[signal_index]));
    let (centre, half_range) = file.scheduling();
    let column =
        |signal_index: usize| trims.iter().map(|trim| trim.signals[signal_index]).collect::<Vec<f64>>();
    let mut envelope = envelope(vehicle, file)?;
    if let Some((signal_index, signal)) = scheduled.filter(|_| !vehicle.is_speed_given()) {
        let speeds = column(signal_index);
        let range = [0, speeds.len() - 1].map(|end| OverSpeed::Constant(speeds[end]));
        envelope.entry(signal.name.to_owned()).or_default().range = Some(range);
    }
    let steers = steering(vehicle, file)?;
    let steered = file.tracked.iter().map(|tracked| tracked.signal);
    let steered: Vec<String> =
        steered.filter(|signal| signal.level != Level::Scheduled).map(|signal| signal.name.into()).collect();
    let start = |signal_index: usize| trims.first().map_or(0.0, |trim| trim.signals[signal_index]);
    let ports = signals.iter().enumerate().map(|(signal_index, signal)| {
        let starts = signal.level == Level::Start && file.uses(signal_index);
        let mut port = Port { start: if starts { start(signal_index) } else { 0.0 }, ..Port::from(signal) };
        let model = file.tracks(signal.name).and_then(|index| file.tracked[index].model);
        if let (Some(reference), Some(model)) = (&mut port.reference, model) {
            reference.lag = model.lag();
        }
        port
    });
    let trimmed = signals.iter().enumerate().filter(|(_, signal)| signal.level == Level::Trim);
    let mut controller = ControllerDesign {
        format: CONTROLLER_FORMAT.into(),
        vehicle: VehicleName { name: vehicle.name().into(), status: vehicle.status() },
        design: file.name.clone(),
        sample_time: file.sample_time,
        delay_ticks: file.delay_ticks(),
        signals: ports.collect(),
        scheduling: Scheduling {
            quantity: scheduled.map_or_else(String::new, |(_, signal)| signal.name.into()),
            minimum: file.speed_min,
            maximum: file.speed_max,
            centre,
            half_range,
        },
        controller_inputs: controller_inputs(file),
        reference_filter: file.reference_filter(),
        speed_given: vehicle.is_speed_given(),
        actuators: vehicle
            .actuators()
            .iter()
            .zip(steers)
            .map(|(a, steers)| Actuator {
                name: a.name.clone(),
                unit: a.unit().into(),
                scale: a.reach(),
                minimum: a.min,
                maximum: a.max,
                curve: a.curve.clone(),
                steers: if steers { steered.clone() } else { vec![] },
                force: Some(a.force_per_output()),
                lateral_force: Some(a.lateral_force_per_output()).filter(|force| *force != [0.0; 3]),
            })
            .collect(),
        lft,
        gains: given::gains(vehicle.actuators(), file)?,
        anti_windup: None,
        follow: vec![],
        trim: TrimTable {
            speed: trims.iter().map(|trim| trim.speed).collect(),
            forward_speed: scheduled.map_or_else(Vec::new, |(signal_index, _)| column(signal_index)),
            signals: trimmed
                .map(|(signal_index, signal)| (signal.name.to_owned(), column(signal_index)))
                .collect(),
            actuators: trims.iter().map(|trim| trim.actuators.clone()).collect(),
        },
        envelope,
        failsafe: None,
        gamma,
        inputs: hashes.clone(),
    };
    controller.failsafe = failsafe(vehicle, file, &controller)?;
    Ok(controller)
}

/// Failsafe data of the measured signals; `None` for a vehicle whose model does not know how its signals move.
fn failsafe(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    controller: &ControllerDesign,
) -> Result<Option<Failsafe>, Error> {
    let measured = |name: &String| controller.index(name).is_some_and(|index| controller.measures(index));
    let mut sensors = vehicle.sensors(&file.spread(ENVELOPE_SPEEDS))?;
    sensors.retain(|name, _| measured(name));
    for SensorKeys { signal, resolution, period } in &file.failsafe.sensors {
        if let Some(sensor) = sensors.get_mut(signal.name) {
            sensor.resolution = resolution.unwrap_or(sensor.resolution);
            sensor.period = *period;
        }
    }
    let slowness = |row: &usize| controller.trim.speed[*row].abs();
    let slowest = (0..TRIM_ROWS).min_by(|one, other| slowness(one).total_cmp(&slowness(other)));
    let trim = slowest.map(|row| &controller.trim.actuators[row]);
    let safe = vehicle.actuators().iter().zip(trim.into_iter().flatten()).map(|(one, trim)| {
        let slow = file.failsafe.safe == Safe::Slow && one.unit() == "N";
        if slow { *trim } else { 0.0f64.clamp(one.min, one.max) }
    });
    let failsafe = Failsafe { stale_after: file.failsafe.stale_after, safe: safe.collect(), sensors };
    Ok((!failsafe.sensors.is_empty()).then_some(failsafe))
}

/// Limits of the references over the trim table, interpolated between those at a few speeds.
fn envelope(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
) -> Result<BTreeMap<String, ReferenceLimits>, Error> {
    let few = file.spread(ENVELOPE_SPEEDS);
    let between = |number: &OverSpeed| {
        let OverSpeed::Table(column) = number else { return number.clone() };
        let at = |row: usize| {
            let (lower, part) =
                (row * (few.len() - 1) / (TRIM_ROWS - 1), row * (few.len() - 1) % (TRIM_ROWS - 1));
            let part = part as f64 / (TRIM_ROWS - 1) as f64;
            let next = column[(lower + 1).min(few.len() - 1)];
            column[lower] + part * (next - column[lower])
        };
        OverSpeed::from((0..TRIM_ROWS).map(at).collect::<Vec<f64>>())
    };
    let rows = |ends: &[OverSpeed; 2]| [between(&ends[0]), between(&ends[1])];
    let all = vehicle.envelope(&few)?.into_iter().map(|(signal, limits)| {
        let [range, rate] = [&limits.range, &limits.rate].map(|ends| ends.as_ref().map(rows));
        (signal, ReferenceLimits { range, rate })
    });
    Ok(all.collect())
}

/// Number of speeds at which limits of references are computed.
const ENVELOPE_SPEEDS: usize = 11;

/// Fraction of the largest acceleration by an actuator below which another one does not steer.
const STEERS: f64 = 0.1;

/// Determines which actuators steer: at the limit of its output, in the middle of the range of speed, a steering
/// actuator causes at least [`STEERS`] of the largest transverse acceleration, or of the largest angular one, of all
/// actuators.
fn steering(vehicle: &dyn VehicleModel, file: &DesignFile) -> Result<Vec<bool>, Error> {
    let linear = vehicle.linearise(file.scheduling().0)?;
    let across = linear.states.iter().position(|state| ["w", "v"].contains(&state.symbol));
    let rows = across.into_iter().chain([turn_rate(linear.states)]);
    let reaches: Vec<f64> = vehicle.actuators().iter().map(|one| one.reach()).collect();
    let mut all = vec![false; reaches.len()];
    for row in rows {
        let effects: Vec<f64> =
            reaches.iter().enumerate().map(|(j, reach)| (linear.b[(row, j)] * reach).abs()).collect();
        let most = effects.iter().copied().fold(0.0, f64::max);
        all.iter_mut().zip(effects).for_each(|(one, effect)| *one |= effect > 0.0 && effect >= STEERS * most);
    }
    Ok(all)
}

/// Inputs of the controller, in the order of y: the errors, or the references and then the measurements.
fn controller_inputs(file: &DesignFile) -> Vec<ControllerInput> {
    let input = |signal: &Signal, kind: Kind, scale: f64| ControllerInput {
        signal: signal.name.into(),
        kind,
        unit: signal.unit.into(),
        scale,
    };
    let kind = if file.measured.is_empty() { Kind::Error } else { Kind::Reference };
    let tracked = file.tracked.iter().map(|t| input(t.signal, kind, t.scale));
    let measured = file.measured.iter().map(|m| input(m.signal, Kind::Measurement, m.scale));
    tracked.chain(measured).collect()
}
