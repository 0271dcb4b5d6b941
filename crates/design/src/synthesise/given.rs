//! A given controller in the place of the synthesis: a bound of its loop, from which the proof begins.

use crate::axis::VehicleModel;
use crate::certify::lft_matrices;
use crate::check::CHECKED_SPEEDS;
use crate::check::sampled::Sampling;
use crate::error::{Error, InputError, Refusal};
use crate::findings::gain_fit;
use crate::inputs::design_file::DesignFile;
use squid_auv::Actuator;
use squid_base::numbers::above;
use squid_base::progress::Progress;
use squid_lpv::analysis::given_loop;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{Mat, spectral_abscissa};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::synthesis::Design;
use squid_pid::{Drive, Layout, Pid, Port, Structure, Vehicle};
use squid_scheduled::{Gain, LftMatrices};

/// The cascade of a design file for its vehicle.
///
/// # Errors
/// [`InputError::File`] with the first value that does not fit.
pub fn structure(actuators: &[Actuator], file: &DesignFile, pid: &Pid) -> Result<Structure, InputError> {
    // A design without measurements has errors in y, and no separate references.
    let separate = file.tracked.iter().filter(|_| !file.measured.is_empty());
    let references = separate.map(|t| Port { signal: t.signal.name, scale: t.scale }).collect();
    let measurements = file.measured.iter().map(|m| Port { signal: m.signal.name, scale: m.scale }).collect();
    let scheduled = file.interface.scheduled().map(|index| &file.interface.signals[index]);
    let vehicle = Vehicle {
        actuators,
        speed_given: scheduled.is_none_or(|signal| !signal.is_among(file.states)),
        layout: &Layout { references, measurements },
        scheduling: file.scheduling(),
        design: &file.file,
    };
    Ok(Structure::new(pid, vehicle)?)
}

/// The anti-windup of the given controller, unless the design file has none; see [`Structure::anti_windup`]. One from
/// matrix inequalities would empty the slow integrals of a PID at every step.
///
/// # Errors
/// As [`structure`].
pub fn anti_windup(actuators: &[Actuator], file: &DesignFile) -> Result<Option<Mat>, InputError> {
    let given = file.controller.as_ref().filter(|_| file.anti_windup);
    given.map(|pid| Ok(structure(actuators, file, pid)?.anti_windup())).transpose()
}

/// The gains of the given controller; none for one that is computed.
///
/// # Errors
/// As [`structure`].
pub fn gains(actuators: &[Actuator], file: &DesignFile) -> Result<Vec<Gain>, InputError> {
    let Some(pid) = &file.controller else { return Ok(vec![]) };
    let all = structure(actuators, file, pid)?.gains.into_iter();
    Ok(all
        .map(|squid_pid::Gain { name, unit, coefficients, .. }| Gain { name, unit, coefficients })
        .collect())
}

/// The matrices of the given controller; `None` for one that is computed.
///
/// # Errors
/// As [`structure`].
pub fn matrices(actuators: &[Actuator], file: &DesignFile) -> Result<Option<LftMatrices>, InputError> {
    let of = |pid: &Pid| Ok(lft_matrices(&structure(actuators, file, pid)?.controller()));
    file.controller.as_ref().map(of).transpose()
}

/// The given controller with a bound of its loop, found by an inequality for the whole range of speed.
///
/// # Errors
/// As [`structure`]; [`Refusal::UnstableGiven`]; [`Refusal::Unbounded`].
pub fn given(
    actuators: &[Actuator],
    file: &DesignFile,
    plant: &GeneralisedPlant,
    pid: &Pid,
    progress: &Progress,
) -> Result<Design, Error> {
    let structure = structure(actuators, file, pid)?;
    progress.done("controller", &summary(actuators, pid, &structure));
    for misfit in &structure.misfits {
        progress.warn(&gain_fit(&misfit.key, misfit.relative, misfit.speed));
    }
    let controller = structure.controller();
    let closed = plant.close(&controller);
    let worst = file
        .spread(CHECKED_SPEEDS)
        .into_iter()
        .map(|speed| Ok((speed, spectral_abscissa(&closed.frozen(&[file.rho(speed)])?.a))))
        .collect::<Result<Vec<_>, Error>>()?
        .into_iter()
        .fold((f64::NAN, f64::NEG_INFINITY), |most, one| if one.1 > most.1 { one } else { most });
    if worst.1 >= 0.0 {
        return Err(Refusal::UnstableGiven { speed: worst.0, growth: worst.1 }.into());
    }
    let what = "solving the matrix inequality of the loop";
    let (certified, seconds) = progress.timed("bound", what, || given_loop(&closed));
    let certified = certified.map_err(|part| {
        let (centre, half_range) = file.scheduling();
        let (from, to) = (centre - part * half_range, centre + part * half_range);
        Refusal::Unbounded { from, to, part, low: file.speed_min, high: file.speed_max }
    })?;
    progress.done(
        "bound",
        &format!(
            "gain of the loop below {} for any trajectory of speed in the range ({seconds:.1} s)\n(eigenvalues in \
             floating point; the closest to zero is {:.1e})",
            above(certified.gamma),
            certified.largest_eigenvalue
        ),
    );
    let gamma = certified.gamma;
    Ok(Design::new(controller, gamma, gamma, certified))
}

/// The largest real part \[1/s\] of the modes of the loop with the true linearisations, and the speed of it \[m/s\].
///
/// # Errors
/// Those of trim and linearisation; [`ModelError::System`](crate::error::ModelError::System).
pub fn growth(
    vehicle: &dyn VehicleModel,
    file: &DesignFile,
    controller: &Controller,
) -> Result<(f64, f64), Error> {
    let at = |speed: f64| {
        let frozen = controller.frozen(&vec![file.rho(speed); controller.blocks.len()])?;
        let plant = Sampling::of(vehicle.actuators(), file).ideal(&vehicle.linearise(speed)?);
        Ok::<_, Error>((spectral_abscissa(&plant.injected(&frozen).a), speed))
    };
    let all = file.spread(CHECKED_SPEEDS).into_iter().map(at).collect::<Result<Vec<_>, Error>>()?;
    Ok(all
        .into_iter()
        .fold((f64::NEG_INFINITY, f64::NAN), |most, one| if one.0 > most.0 { one } else { most }))
}

/// Describes the controller: its origin, its size, and the effect of its commands.
fn summary(actuators: &[Actuator], pid: &Pid, structure: &Structure) -> String {
    let command = |(axis, allocation): (usize, &squid_pid::Allocation)| {
        let unit = if allocation.drive == Drive::Deflection { "rad" } else { "N" };
        let moved = actuators.iter().zip(&allocation.outputs).filter(|(_, output)| **output != 0.0);
        let moved: Vec<String> =
            moved.map(|(a, output)| format!("{} {} {unit}", a.name, squid_auv::rounded(*output))).collect();
        let per = match allocation.drive {
            Drive::Deflection => "per rad",
            Drive::Moment => "per N m",
            Drive::Force => "per N",
        };
        format!("\n{} command {per}: {}", [pid.turn.angle.name(), "speed"][axis], moved.join(", "))
    };
    let channels = structure.affine().blocks.iter().sum::<usize>();
    let head = format!(
        "PID of {}: {}, {} of rho",
        pid.file,
        counted(structure.states.len(), "state"),
        counted(channels, "channel")
    );
    let used = structure.allocations.iter().enumerate().filter(|(axis, _)| *axis == 0 || pid.speed.is_some());
    used.map(command).fold(head, |all, one| all + &one)
}

/// A number of things.
fn counted(number: usize, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}
