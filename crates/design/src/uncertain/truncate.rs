//! Fewer channels for a small, measured error: what a robust synthesis can carry.
//!
//! Channel directions that matter little go one by one. Of the channels of one parameter the least is the last
//! singular direction of what they carry from the inputs to the outputs, other parameters' channels among both; of
//! all parameters that one goes whose loss moves `[A B]` least, as long as that is within a tolerance. The gain of an
//! actuator must also keep the actuator's own column within it, which may be small beside the others. The projection
//! is the oblique one that balances what goes in with what comes out, as in B. C. Moore, IEEE Trans. Automatic
//! Control 26(1), 1981.

use crate::error::{Error, UncertainError};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::linearise::scaled;
use crate::uncertain::closed_loop::uncertain_plant;
use crate::uncertain::model::{Block, Uncertain, UncertainModel};
use crate::uncertain::reduce::runs;
use crate::uncertain::trim::random_corners;
use auv::Actuator;
use lpv::lft::Lft;
use lpv::matrix::{Mat, block, svd};
use lpv::robust::UncertainPlant;

/// A model with fewer channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Truncated {
    /// The model; parameters that lost all their channels are gone.
    pub model: UncertainModel,
    /// The largest relative difference of `[A B]` from the model before, over points of the whole box.
    pub error: f64,
    /// The names of the parameters that are gone.
    pub gone: Vec<String>,
}

/// The uncertain model over the range of speed without the channels that move `[A B]` by no more than a relative
/// tolerance in a part of the declared box, and the plant with its weights.
///
/// # Errors
/// [`UncertainError::NothingLeft`] where no parameter is left; [`ModelError::Lft`](crate::error::ModelError::Lft)
/// where the model has no value; as [`uncertain_plant`].
pub fn thinned(
    inputs: &Inputs,
    whole: &UncertainModel,
    model: &Model,
    (size, tolerance): (f64, f64),
) -> Result<(Truncated, UncertainPlant), Error> {
    let fewer = truncated(&inputs.vehicle.actuators, whole, size, tolerance)?;
    if fewer.model.blocks.is_empty() {
        let (design, names) = (inputs.design.file.clone(), fewer.gone);
        return Err(UncertainError::NothingLeft { design, names, size, tolerance }.into());
    }
    let plant = uncertain_plant(inputs, &fewer.model, model.linear())?;
    Ok((fewer, UncertainPlant { plant, scheduled: 1 }))
}

/// Values of rho at which models are compared.
const RHOS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// Corners of the box, at each rho: while searching, and for the reported error.
const CORNERS: usize = 8;
const REPORTED: usize = 200;

/// An LFT with a channel less, of `parameter`.
struct Shorter {
    /// How far it is off, relative.
    error: f64,
    parameter: usize,
    /// How far it is off in the column of the actuator whose gain the parameter is.
    in_own: f64,
    lft: Lft,
}

/// Takes channels off a scheduled model while `[A B]` moves by no more than `tolerance`, relative, anywhere in the
/// box of `|delta_i| <= size`; those of an actuator's gain while its own column does not, either.
///
/// # Errors
/// [`ModelError::Lft`](crate::error::ModelError::Lft) where the model has no value.
fn truncated(
    actuators: &[Actuator],
    model: &UncertainModel,
    size: f64,
    tolerance: f64,
) -> Result<Truncated, Error> {
    let whole = &model.lft;
    let points = points(model, size, CORNERS);
    let wanted = values(actuators, whole, &points)?;
    let mut lft = whole.clone();
    // What each actuator's column has lost by the removed channels of its gain.
    let mut lost = vec![0.0; 1 + model.blocks.len()];
    loop {
        let now = values(actuators, &lft, &points)?;
        let mut best: Option<Shorter> = None;
        for (parameter, first, count) in runs(&lft.channels) {
            let Some(shorter) = without_least(actuators, &lft, first, count, size) else { continue };
            let found = values(actuators, &shorter, &points)?;
            let own = parameter.checked_sub(1).and_then(|i| column_of(model.blocks.get(i)?, actuators.len()));
            let in_own =
                own.map_or(0.0, |from_last| distance(&last(&found, from_last), &last(&now, from_last)));
            let in_own = lost[parameter] + in_own;
            let error = distance(&found, &wanted).max(in_own);
            if best.as_ref().is_none_or(|least| error < least.error) {
                best = Some(Shorter { error, parameter, in_own, lft: shorter });
            }
        }
        match best.filter(|best| best.error <= tolerance) {
            Some(best) => {
                lost[best.parameter] = best.in_own;
                lft = best.lft;
            }
            None => break,
        }
    }
    let points = self::points(model, 1.0, REPORTED);
    let error = distance(&values(actuators, &lft, &points)?, &values(actuators, whole, &points)?);
    let left = UncertainModel::from_lft(lft, &model.blocks);
    let is_left = |name: &str| left.blocks.iter().any(|b| b.name == name);
    let gone = model.blocks.iter().filter(|b| !is_left(&b.name)).map(|b| b.name.clone()).collect();
    Ok(Truncated { model: left, error, gone })
}

/// Corners of the box at each rho, and its middle.
fn points(model: &UncertainModel, size: f64, corners: usize) -> Vec<Vec<f64>> {
    let mut all = random_corners(model.blocks.len(), corners, 3);
    all.push(vec![0.0; model.blocks.len()]);
    let at =
        |rho: f64, corner: &Vec<f64>| std::iter::once(rho).chain(corner.iter().map(|d| d * size)).collect();
    RHOS.iter().flat_map(|rho| all.iter().map(move |corner| at(*rho, corner))).collect()
}

fn values(actuators: &[Actuator], lft: &Lft, points: &[Vec<f64>]) -> Result<Vec<Mat>, Error> {
    points.iter().map(|point| Ok(scaled(actuators, lft.evaluate(point)?))).collect()
}

/// The column of `[A B]` that an actuator's gain scales, counted from the last: 1 is the last one.
fn column_of(block: &Block, actuators: usize) -> Option<usize> {
    match block.uncertain {
        Uncertain::Gain(actuator) => Some(actuators - actuator),
        Uncertain::Parameter(_) => None,
    }
}

/// A column of each matrix, counted from the last.
fn last(all: &[Mat], place: usize) -> Vec<Mat> {
    all.iter().map(|m| m.columns(m.ncols() - place, 1).into_owned()).collect()
}

/// The largest distance of two matrices at the same point, relative to the second; 0 for two that are the same.
fn distance(found: &[Mat], wanted: &[Mat]) -> f64 {
    let relative = |(f, w): (&Mat, &Mat)| match (f - w).norm() {
        same if same <= 0.0 => 0.0,
        off => off / w.norm(),
    };
    found.iter().zip(wanted).map(relative).fold(0.0, f64::max)
}

/// The LFT without the least direction of `count` channels of one parameter.
fn without_least(actuators: &[Actuator], lft: &Lft, first: usize, count: usize, size: f64) -> Option<Lft> {
    let k = lft.size();
    let others: Vec<usize> = (0..k).filter(|i| *i < first || *i >= first + count).collect();
    // Delta's channels count as far as Delta goes.
    let reach = |i: usize| if lft.channels[i] == 0 { 1.0 } else { size };
    let mut inner = lft.inner.clone();
    for i in 0..k {
        inner.column_mut(i).scale_mut(reach(i));
    }
    let out = block(&[
        &[&lft.left.columns(first, count).into_owned()],
        &[&inner.columns(first, count).select_rows(&others)],
    ]);
    let right = scaled(actuators, lft.right.rows(first, count).into_owned());
    let into = block(&[&[&right, &inner.rows(first, count).select_columns(&others)]]);
    let decomposition = svd(&(&out * &into));
    let kept = count - 1;
    if kept > 0 && decomposition.s.get(kept - 1).is_none_or(|s| *s <= 0.0) {
        return None;
    }
    let root = Mat::from_diagonal(&nalgebra::DVector::from_iterator(
        kept,
        decomposition.s.iter().take(kept).map(|s| 1.0 / s.sqrt()),
    ));
    let own_to = &into * decomposition.v.columns(0, kept) * &root;
    let own_from = &root * decomposition.u.columns(0, kept).transpose() * &out;
    let mut to = Mat::zeros(k, k - 1);
    let mut from = Mat::zeros(k - 1, k);
    let place = |i: usize| if i < first { i } else { i - 1 };
    for &i in &others {
        to[(i, place(i))] = 1.0;
        from[(place(i), i)] = 1.0;
    }
    to.view_mut((first, first), (count, kept)).copy_from(&own_to);
    from.view_mut((first, first), (kept, count)).copy_from(&own_from);
    let mut channels = lft.channels.clone();
    channels.remove(first);
    Some(lft.transformed(&from, &to, channels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;
    use crate::uncertain::{Fidelity, over_range};

    /// REMUS 100 with `actuator_gain` alone, as a design that `squid tune` begins.
    fn of_gains(gain: f64) -> Result<Truncated, Error> {
        let mut inputs = shipped("remus100", "design");
        inputs.uncertain.clear();
        inputs.design.uncertainty.as_mut().unwrap().actuator_gain = gain;
        let model = Model::new(&inputs.vehicle, &inputs.design).unwrap();
        let whole = over_range(&inputs, &model, Fidelity::COARSE).unwrap();
        thinned(&inputs, &whole, &model, (0.5, 0.01)).map(|(fewer, _)| fewer)
    }

    /// The propeller's column is small beside `[A B]`: all of its gain is less than the tolerance of that.
    #[test]
    fn the_gain_of_a_weak_actuator_stays() {
        let found = of_gains(0.1).unwrap();
        assert_eq!(found.gone, Vec::<String>::new());
        let names: Vec<&str> = found.model.blocks.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["gain of propeller", "gain of stern_planes"]);
    }

    #[test]
    fn a_model_with_nothing_uncertain_left_is_refused() {
        let refused = of_gains(0.001).unwrap_err().to_string();
        assert!(refused.contains("nothing of what is declared is left in the model"), "{refused}");
        assert!(refused.contains("gain of propeller, gain of stern_planes"), "{refused}");
    }
}
