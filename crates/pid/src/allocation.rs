//! Control allocation: the actuators that carry out a command of an angle or of speed, and the unit of that command.

use crate::file::{Pid, Shares};
use crate::gain::{Role, Unit, deflection_units, force_units, moment_units};
use crate::refusal::not_allowed;
use squid_auv::Actuator;
use squid_auv::toml_file::FileError;
use squid_lpv::matrix::{Mat, pseudo_inverse};

/// Physical kind of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// A deflection of control surfaces, rad.
    Deflection,
    /// A moment of thrusters, N m.
    Moment,
    /// A force of thrusters along the hull, N.
    Force,
}

impl Drive {
    /// Returns the units allowed for a gain to this kind of command.
    pub(crate) fn units(self, role: Role) -> Vec<Unit> {
        match self {
            Self::Deflection => deflection_units(role),
            Self::Moment => moment_units(role),
            Self::Force => force_units(role),
        }
    }
}

/// A command and its allocation to the actuators.
#[derive(Debug, Clone, PartialEq)]
pub struct Allocation {
    /// Kind of the command.
    pub drive: Drive,
    /// Output of each actuator per unit of the command, N or rad.
    pub outputs: Vec<f64>,
    /// 1 if a positive command raises the angle or speeds the vehicle up, -1 if it does the opposite.
    pub sign: f64,
    /// `true` if the file gives the shares.
    pub stated: bool,
}

/// Shares below this fraction of the largest, in units of reach, are rounding and set to 0.
const LEAST_SHARE: f64 = 1e-6;

/// Allocates the commands of the cascade: the angle, and the speed unless its control is external.
///
/// Shares not given in the file are the least-norm outputs, in units of reach, for a moment without force along the
/// hull, and for a force along the hull without moment, ahead at `speed` \[m/s\].
pub(crate) fn allocations(
    pid: &Pid,
    actuators: &[Actuator],
    speed: f64,
    speed_given: bool,
) -> Result<Vec<Allocation>, FileError> {
    let force = |j: usize| actuators[j].force(speed, 1.0);
    let m = actuators.len();
    let angle = pid.turn.angle;
    let moment = |j: usize| angle.moment(&actuators[j], speed);
    let moments: Vec<f64> = (0..m).map(moment).collect();
    let forces: Vec<f64> =
        (0..m).map(|j| if is_surface(&actuators[j]) { 0.0 } else { force(j)[0] }).collect();
    let rows: Vec<&Vec<f64>> = if speed_given { vec![&moments] } else { vec![&moments, &forces] };
    let reach: Vec<f64> = actuators.iter().map(Actuator::reach).collect();
    let least = pseudo_inverse(&Mat::from_fn(rows.len(), m, |i, j| rows[i][j] * reach[j]), 1e-9);
    let stated = [&pid.turn_shares, &pid.speed_shares];
    let names = [angle.name(), "speed"];
    let mut all = vec![];
    for axis in 0..rows.len() {
        let outputs = match stated[axis] {
            Some(shares) => shares.outputs(pid, names[axis], actuators)?,
            None => {
                let column: Vec<f64> = least.column(axis).iter().copied().collect();
                let largest = column.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
                let output =
                    |(v, reach): (&f64, &f64)| if v.abs() > LEAST_SHARE * largest { v * reach } else { 0.0 };
                column.iter().zip(&reach).map(output).collect()
            }
        };
        all.push(command(pid, names[axis], axis, actuators, outputs, rows[axis], stated[axis].as_ref())?);
    }
    Ok(all)
}

/// Scales the outputs to a unit command: 1 rad of the largest deflection, or 1 N (1 N m) in total.
fn command(
    pid: &Pid,
    name: &str,
    axis: usize,
    actuators: &[Actuator],
    outputs: Vec<f64>,
    effects: &[f64],
    stated: Option<&Shares>,
) -> Result<Allocation, FileError> {
    let key = format!("controller.allocation.{name}");
    let line = stated.map_or(pid.line, |shares| shares.line);
    let refuse = |found: &str, allowed: &str| Err(not_allowed(&pid.file, line, &key, found, allowed));
    let used = || actuators.iter().zip(&outputs).filter(|(_, output)| **output != 0.0).map(|(a, _)| a);
    let effect: f64 = outputs.iter().zip(effects).map(|(output, effect)| output * effect).sum();
    let turns = format!("turns the vehicle in {}", pid.turn.angle);
    let required = [turns.as_str(), "exerts a force along the hull"][axis];
    if effect == 0.0 || !effect.is_finite() {
        return refuse("without effect", &format!("of actuators at least one of which {required}"));
    }
    let surfaces = used().filter(|a| is_surface(a)).count();
    let (drive, unit) = match (axis, surfaces, used().count()) {
        (1, 0, _) => (Drive::Force, effect.abs()),
        (1, ..) => {
            return refuse(
                "of a control surface",
                "of thrusters, the only actuators with a force along the \
            hull",
            );
        }
        (_, 0, _) => (Drive::Moment, effect.abs()),
        (_, some, all) if some == all => {
            (Drive::Deflection, outputs.iter().fold(0.0, |most: f64, output| most.max(output.abs())))
        }
        _ => {
            let allowed = "either of control surfaces (gains such as \"deg/deg\") or of thrusters (\"N.m/rad\"), in \
                         the form { ACTUATOR = SHARE, ... }";
            return refuse("of both control surfaces and thrusters", allowed);
        }
    };
    let outputs = outputs.into_iter().map(|output| output / unit).collect();
    Ok(Allocation { drive, outputs, sign: effect.signum(), stated: stated.is_some() })
}

impl Shares {
    /// Returns the share of each actuator of a vehicle.
    fn outputs(&self, pid: &Pid, name: &str, actuators: &[Actuator]) -> Result<Vec<f64>, FileError> {
        if let Some((unknown, _)) =
            self.each.iter().find(|(name, _)| actuators.iter().all(|a| a.name != *name))
        {
            let names: Vec<&str> = actuators.iter().map(|a| a.name.as_str()).collect();
            let key = format!("controller.allocation.{name}");
            let allowed = format!("of the vehicle's actuators: {}", names.join(", "));
            return Err(not_allowed(&pid.file, self.line, &key, format!("of '{unknown}'"), allowed));
        }
        let share = |a: &Actuator| {
            self.each.iter().find(|(name, _)| *name == a.name).map_or(0.0, |(_, share)| *share)
        };
        Ok(actuators.iter().map(share).collect())
    }
}

fn is_surface(actuator: &Actuator) -> bool {
    actuator.unit() == "rad"
}
