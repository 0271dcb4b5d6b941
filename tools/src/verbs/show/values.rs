//! Values of `squid show --json`: the numbers of the tables, in SI units.

use crate::error::Error;
use serde_json::{Value, json};
use squid_design::fit::Model;
use squid_design::inputs::Inputs;
use squid_design::uncertain::{Fidelity, over_range};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::to_rows;
use squid_scheduled::Gamma;

/// Returns the residuals of the fits, and the size of the LFT.
pub fn fit(model: &Model) -> Value {
    let order = |r: &squid_design::fit::Residual| {
        json!({
            "order": r.order,
            "rms_relative": r.a.relative_rms,
            "rms_relative_to_variation": r.relative_to_variation,
            "largest": to_rows(&r.ab.largest),
        })
    };
    json!({
        "orders": model.residuals.iter().map(order).collect::<Vec<_>>(),
        "lft_channels": model.lft.size(),
        "lft_error": model.lft_error,
    })
}

/// Returns a controller: its sizes, gammas, and poles at the ends and the centre of the range.
///
/// # Errors
/// [`ModelError::System`](squid_design::error::ModelError::System).
pub fn controller(inputs: &Inputs, k: &Controller, gamma: &Gamma) -> Result<Value, Error> {
    let (centre, half_range) = inputs.design.scheduling();
    let poles = [-1.0, 0.0, 1.0].map(|rho| {
        let poles: Vec<_> = k.frozen(&[rho])?.poles().iter().map(|pole| [pole.re, pole.im]).collect();
        Ok(json!({ "speed": centre + half_range * rho, "poles": poles }))
    });
    Ok(json!({
        "states": k.a().nrows(),
        "channels": k.bt().ncols(),
        "measurements": k.by().ncols(),
        "commands": k.cu().nrows(),
        "gamma_optimum": gamma.optimum,
        "back_off": gamma.back_off,
        "gamma_bound": gamma.bound,
        "poles": poles.into_iter().collect::<Result<Vec<_>, Error>>()?,
    }))
}

/// Returns the uncertain parameters with their ranges and their channels over the speed range.
///
/// # Errors
/// [`Error::Design`].
pub fn uncertainty(inputs: &Inputs) -> Result<Value, Error> {
    let model = Model::new(&inputs.axis(), &inputs.design)?;
    let joint = over_range(inputs, &model, Fidelity::COARSE)?;
    let block = |b: &squid_design::uncertain::model::Block| {
        json!({
            "name": b.name,
            "value": b.value,
            "half_range": b.half_range,
            "unit": b.unit,
            "channels": b.repetitions,
        })
    };
    Ok(json!({
        "parameters": joint.blocks.iter().map(block).collect::<Vec<_>>(),
        "channels_of_rho": joint.scheduled,
    }))
}
