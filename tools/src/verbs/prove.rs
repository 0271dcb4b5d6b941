//! `squid prove`: proves a given controller, and prints the properties of its loop.

pub mod gains;

use crate::cli::Prove;
use crate::error::Error;
use crate::output::answer;
use crate::progress::show;
use serde_json::{Value, json};
use squid_base::files::read;
use squid_base::numbers::{above, decimals};
use squid_base::progress::Progress;
use squid_design::certify::claims;
use squid_design::error::InputError;
use squid_design::inputs::Inputs;
use squid_design::inputs::design_file::DesignFile;
use squid_design::run::{Finished, run as run_stages};
use squid_design::store::Stored;
use squid_design::synthesise::{given, synthesise};
use squid_design::verdict::frozen::AtSpeed;
use squid_proof::claim::Proof;
use squid_report::peers::law::Law;
use squid_report::peers::survival::{Survival, fleet, survival};
use squid_report::subject::Subject;

/// Proves the controller and prints the result; writes nothing.
///
/// # Errors
/// Errors of the files and of the stages; [`Error::Unproved`]; [`Error::Missed`] with `strict`.
pub fn run(options: &Prove) -> Result<(), Error> {
    let mut inputs = Inputs::read_axis(&options.vehicle, &options.design, options.axis.as_deref())?;
    if let Some(path) = &options.controller {
        let (text, file) = (read(path)?, path.display().to_string());
        inputs = inputs.with_controller(squid_pid::read_file(&text, &file)?, &text);
    }
    let design = options.design.clone();
    let Some(pid) = inputs.design.controller.clone() else {
        return Err(InputError::NoController { file: format!("{design}.toml") }.into());
    };
    let progress = Progress::new(&show);
    let finished = run_stages(&inputs, &progress)?;
    let (growth, at) = given::growth(&inputs.axis(), &inputs.design, &finished.design.controller)?;
    let survival = progress.timed("box", "simulations of vehicles of the declared uncertainty", || {
        survivals(&inputs, &finished)
    });
    let survival = survival.0?;
    let own = DesignFile { controller: None, ..inputs.design.clone() };
    let quiet = Progress::default();
    let full_order = progress.timed("full order", "controller of full order on the same weights", || {
        synthesise(&inputs.vehicle.actuators, &own, &finished.plant, &quiet)
    });
    let full_order = full_order.0.map(|full_order| full_order.certified.gamma);
    let full_order = full_order.map_err(|reason| reason.to_string());
    report(&inputs, &finished, (growth, at), &survival, &full_order, &progress);
    answer(&to_json(&pid.file, &finished, (growth, at), &survival, &full_order))?;
    if let Err(reason) = finished.proof {
        return Err(Error::Unproved { reason });
    }
    let missed: Vec<String> = finished.verdict.missed().map(crate::verbs::design::missed).collect();
    if options.strict && !missed.is_empty() { Err(Error::Missed { missed }) } else { Ok(()) }
}

/// Speed (m/s), number of vehicles, and survival of the declared uncertainty.
type Survivals = Vec<(f64, usize, Survival)>;

/// Returns the survivals at both ends and the centre of the speed range; empty without declared uncertainty or a
/// reference that steps.
fn survivals(inputs: &Inputs, finished: &Finished) -> Result<Survivals, Error> {
    if !inputs.is_uncertain() {
        return Ok(vec![]);
    }
    let stored = Stored::of(&finished.frozen, inputs);
    let quiet = Progress::default();
    let subject = Subject::new(inputs, &stored, &quiet)?;
    let at = |speed: f64| {
        let fleet = fleet(&subject, speed)?;
        Ok((speed, fleet.len(), survival(&subject, &Law::stored(&subject), speed, &fleet)))
    };
    inputs.design.spread(3).into_iter().map(at).collect()
}

/// Reports the results that the stages do not.
fn report(
    inputs: &Inputs,
    finished: &Finished,
    (growth, at): (f64, f64),
    survival: &Survivals,
    full_order: &Result<f64, String>,
    progress: &Progress,
) {
    let most = finished.verdict.found.frozen.iter().max_by(|a, b| a.gain.value.total_cmp(&b.gain.value));
    let gain = most.map_or_else(String::new, |most| {
        format!("\nlargest gain {} at {} m/s", decimals(most.gain.value, 3), decimals(most.speed, 2))
    });
    let growth = format!("slowest mode {} 1/s at {} m/s", decimals(growth, 3), decimals(at, 2));
    progress.done("frozen", &format!("stable at every speed: {growth}{gain}"));
    let proved = |proof: &Result<Proof, String>, how: &str| match proof {
        Ok(proof) => format!("PROVED below {} for {how}", claims::bound(&proof.theorem)),
        Err(_) => format!("NOT PROVED for {how}; the reason is above"),
    };
    progress.done("gain", &proved(&finished.proof, "any trajectory of speed in the range"));
    let hint = if finished.sampled.is_err() { delay_hint(inputs, finished) } else { String::new() };
    progress.done("sampled", &(proved(&finished.sampled, "a speed that is constant between ticks") + &hint));
    let summary = match (full_order, &finished.proof) {
        (Ok(full_order), Ok(_)) if finished.design.certified.gamma > LARGE * full_order => format!(
            "gain below {} on the same weights, by the controller of `squid design`\n\
             a much larger gain of the PID is not critical in itself, because slow errors have a weight above 100\n\
             (margins, mu and the simulations are more informative; see docs/pid.md)",
            above(*full_order)
        ),
        (Ok(full_order), _) => {
            format!(
                "gain below {} on the same weights, by the controller of `squid design`",
                above(*full_order)
            )
        }
        (Err(reason), _) => format!("none: {reason}"),
    };
    progress.done("full order", &summary);
    let line = |(speed, vehicles, Survival { share, overshoot }): &(f64, usize, Survival)| {
        format!(
            "{} m/s: {} % of {vehicles} vehicles of [uncertainty] complete the step, overshoot at most {} %",
            decimals(*speed, 2),
            decimals((100.0 * share).floor(), 0),
            decimals(100.0 * overshoot, 1)
        )
    };
    let lines: Vec<String> = survival.iter().map(line).collect();
    if !lines.is_empty() {
        progress.done("box", &lines.join("\n"));
    }
    progress.done("verdict", &finished.verdict.summary());
}

/// Returns a likely reason for which a sampled loop has no bound.
fn delay_hint(inputs: &Inputs, finished: &Finished) -> String {
    let (delay, tick) = (finished.verdict.found.frozen.iter().map(AtSpeed::delay), inputs.design.sample_time);
    match delay.reduce(f64::min) {
        Some(delay) if delay < 2.0 * tick => {
            format!("\nthe delay margin of {} s is below two sample times of {tick} s", decimals(delay, 3))
        }
        _ => String::new(),
    }
}

/// Multiple of the full-order gain above which a gain is explained.
const LARGE: f64 = 3.0;

fn to_json(
    file: &str,
    finished: &Finished,
    (growth, at): (f64, f64),
    survival: &Survivals,
    full_order: &Result<f64, String>,
) -> Value {
    let sizes = finished.design.controller.parts.sizes();
    let gamma = |proof: &Result<Proof, String>| proof.as_ref().ok().and_then(|p| p.theorem.gamma);
    let survival: Vec<Value> = survival
        .iter()
        .map(|(speed, vehicles, found)| {
            let Survival { share, overshoot } = found;
            json!({ "speed": speed, "vehicles": vehicles, "survived": share, "overshoot": overshoot })
        })
        .collect();
    json!({
        "status": if finished.proof.is_ok() { "proved" } else { "not_proved" },
        "reason": finished.proof.as_ref().err(),
        "controller": file,
        "states": sizes.x,
        "channels": sizes.t,
        "frozen_growth": growth,
        "frozen_growth_speed": at,
        "frozen_gain": finished.checks.gain_fit,
        "gain": gamma(&finished.proof),
        "gain_with_model_error": finished.proof.as_ref().ok().and_then(|p| p.theorem.gamma_with_model_error),
        "sampled_gain": gamma(&finished.sampled),
        "not_sampled_because": finished.sampled.as_ref().err(),
        "full_order_gain": full_order.as_ref().ok(),
        "box": survival,
        "verdict": finished.verdict,
    })
}
