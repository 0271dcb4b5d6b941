//! Progress lines of the stages before the proof.

use crate::axis::OperatingPoint;
use crate::fit::{Model, frequency};
use crate::inputs::Inputs;
use crate::inputs::design_file::DesignFile;
use squid_auv::longitudinal::{DEPTH, PITCH};
use squid_auv::{Pitch, Status};
use squid_base::numbers::decimals;
use squid_lpv::plant::GeneralisedPlant;

pub(super) fn vehicle_line(inputs: &Inputs) -> String {
    let v = &inputs.vehicle;
    let names: Vec<&str> = v.actuators.iter().map(|a| a.name.as_str()).collect();
    let standing = match v.status {
        Status::Surrogate => "SURROGATE coefficients, not those of the real vehicle",
        Status::Published => "published coefficients",
        Status::Measured => "measured coefficients",
    };
    format!("{} ({standing}); actuators: {}", v.name, names.join(", "))
}

pub(super) fn trim_line(inputs: &Inputs, model: &Model) -> String {
    if inputs.design.view().is_level_held {
        let (low, high) = (inputs.design.speed_min, inputs.design.speed_max);
        return format!(
            "straight and level at {} speeds, {low:.2} to {high:.2} m/s, {:.0} m deep; speed, pitch and depth are \
             held by another autopilot",
            model.grid.len(),
            inputs.design.depth
        );
    }
    let (first, last) = (&model.grid[0].1.trim, &model.grid[model.grid.len() - 1].1.trim);
    let angle = |trim: &OperatingPoint| decimals(trim.signals[PITCH].to_degrees(), 2);
    let default = inputs.design.pitch_asked.is_none();
    let pitch = match &inputs.design.pitch {
        Pitch::Free => format!("incidence {} to {} deg", angle(first), angle(last)),
        Pitch::Held(_) if default => {
            "pitch held at 0 deg, which the thrusters can do at every speed\n([trim] pitch \
            = \"free\" gives the trim of least effort)"
                .into()
        }
        Pitch::Held(_) => format!("pitch held at {} deg", angle(first)),
        Pitch::Followed(_) => format!(
            "incidence {} to {} deg,\nalong one branch, because the trims of least effort are discontinuous",
            angle(first),
            angle(last)
        ),
    };
    format!(
        "level at {} speeds, {:.2} to {:.2} m/s, {:.0} m deep; {pitch}",
        model.grid.len(),
        first.speed,
        last.speed,
        first.signals[DEPTH]
    )
}

/// Absolute real part below which a mode counts as an integrator, 1/s.
const INTEGRATES: f64 = 1e-9;

pub(super) fn linearise_line(model: &Model) -> String {
    let slowest =
        |i: usize| model.grid[i].1.eigenvalues().iter().map(|e| e.re).fold(f64::NEG_INFINITY, f64::max);
    let worst = (0..model.grid.len()).map(slowest).fold(f64::NEG_INFINITY, f64::max);
    let verdict = match worst {
        worst if worst < -INTEGRATES => "stable at every speed",
        worst if worst <= INTEGRATES => "stable without control, except for integrators",
        _ => "UNSTABLE without control",
    };
    let states = model.grid.first().map_or(&[][..], |(_, l)| l.states);
    let states: Vec<&str> = states.iter().map(|state| state.symbol).collect();
    format!("x = [{}]; {verdict} (largest real part {worst:+.3} rad/s)", states.join(" "))
}

pub(super) fn fit_line(inputs: &Inputs, model: &Model) -> String {
    let each: Vec<String> = model
        .residuals
        .iter()
        .map(|r| format!("order {}: {:.2} %", r.order, 100.0 * r.relative_to_variation))
        .collect();
    let errors = frequency::errors(&inputs.vehicle.actuators, &inputs.design.tracked, model);
    let responses = |of: &dyn Fn(&frequency::Errors) -> f64| -> String {
        let each = errors.iter().map(|e| format!("order {}: {:.2} %", e.order, 100.0 * of(e)));
        each.collect::<Vec<_>>().join(", ")
    };
    let most = frequency::turning_actuator(&inputs.vehicle.actuators, model);
    format!(
        "order {} in rho; rms residual of A relative to its variation over speed: {}\nlargest error of the frequency \
         response, in the scales of the design: {}\nfrom {} to {} only: {}",
        inputs.design.order,
        each.join(", "),
        responses(&|e| e.scaled),
        inputs.vehicle.actuators[most].name,
        frequency::angle(inputs.design.states).name,
        responses(&|e| e.of_angle(most))
    )
}

pub(super) fn lft_line(model: &Model) -> String {
    format!(
        "{} channels of rho, within {:.1e} of the polynomial; {} more for the slope of the trim",
        model.lft.size(),
        model.lft_error,
        model.trim_slope.size()
    )
}

pub(super) fn augment_line(file: &DesignFile, plant: &GeneralisedPlant) -> String {
    let s = plant.sizes();
    let tracked: Vec<String> = file
        .tracked
        .iter()
        .map(|t| format!("{} (w_b {} rad/s)", t.signal.name, t.weight.bandwidth))
        .collect();
    format!(
        "tracks {}; {} states, {} inputs w, {} outputs z, {} measurements, {} controls",
        tracked.join(" and "),
        s.x,
        s.w,
        s.z,
        s.y,
        s.u
    )
}
