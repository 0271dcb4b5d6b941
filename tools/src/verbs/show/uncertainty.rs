//! `squid show --uncertainty`: the uncertain parameters, their channels in the LFT, and the model's errors.

use crate::error::Error;
use squid_auv::readable;
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::uncertain::errors::{ModelErrors, errors};
use squid_design::uncertain::frozen::at_speed;
use squid_design::uncertain::model::UncertainModel;
use squid_design::uncertain::{Fidelity, over_range};

/// Number of speeds in the tables, evenly spread over the range.
const SPEEDS: usize = 6;

/// Returns the uncertain parameters with their ranges and repetitions, the deviations of the trim, and the errors of
/// the models.
///
/// # Errors
/// [`ModelError::Trim`](squid_design::error::ModelError::Trim),
/// [`ModelError::System`](squid_design::error::ModelError::System), and those of [`over_range`].
pub fn uncertainty(inputs: &Inputs) -> Result<String, Error> {
    let frozen = inputs
        .design
        .spread(SPEEDS)
        .into_iter()
        .map(|v| at_speed(inputs, v))
        .collect::<Result<Vec<_>, _>>()?;
    let model = Model::new(&inputs.axis(), &inputs.design)?;
    let joint = over_range(inputs, &model, Fidelity::COARSE)?;
    let mut out = blocks_table(&joint, &frozen.iter().map(|f| &f.model).collect::<Vec<_>>());
    out += "\nTrim at the corners of the box of coefficients\n       V    changes by at most\n";
    for f in &frozen {
        out += &format!("  {:>6.2}", f.speed);
        for (parameter, deviation) in &f.trim_range.deviations {
            let (factor, unit) = readable(parameter.unit(&inputs.vehicle));
            out += &format!("   {} {:.3} {unit}", parameter.name(&inputs.vehicle), factor * deviation);
        }
        out += &format!(
            "   (beyond the limits of the actuators at {} of {} corners)\n",
            f.trim_range.beyond_limits, f.trim_range.corners
        );
    }
    out += "\n\
            [A B] at corners of the box, largest relative error (Frobenius norm)\n\x20      V     change     of it \
            through trim   LFT: trim held   LFT: new trim    over the range\n";
    for f in &frozen {
        let own: ModelErrors = errors(inputs, f, &f.model)?;
        let over = errors(inputs, f, &joint)?;
        out += &format!(
            "  {:>6.2}   {:6.2} %             {:6.2} %          {:8.1e}         {:6.3} %         {:6.2} %\n",
            f.speed,
            100.0 * own.movement,
            100.0 * own.through_trim,
            own.at_held_trim,
            100.0 * own.remainder,
            100.0 * over.remainder
        );
    }
    Ok(out)
}

fn blocks_table(joint: &UncertainModel, frozen: &[&UncertainModel]) -> String {
    let mut out = String::from(
        "Uncertain parameters and their channels in the LFT: at one speed (the largest number over the speeds),\n\
         over the speed range\n",
    );
    for b in &joint.blocks {
        let (factor, unit) = readable(b.unit);
        let (value, half_range) = (factor * b.value, factor * b.half_range);
        let same = frozen.iter().flat_map(|f| &f.blocks).filter(|other| other.uncertain == b.uncertain);
        let most = same.map(|other| other.repetitions).max().unwrap_or(0);
        out += &format!(
            "  {:<28} {value:>12.4} +- {half_range:<10.4} {unit:<11} {most:>3} {:>3}\n",
            b.name, b.repetitions
        );
    }
    let most = frozen.iter().map(|f| f.channels()).max().unwrap_or(0);
    let uncertain = joint.channels() - joint.scheduled;
    out += &format!(
        "  {:<68} {most:>3} {uncertain:>3}\n  {:<72} {:>3}\n",
        "channels", "and of rho", joint.scheduled
    );
    out
}
