//! Fewer channels for a small, measured error: what a robust synthesis can carry.
//!
//! Channel directions that matter little go one by one. Of the channels of one parameter the least is the last
//! singular direction of what they carry from the inputs to the outputs, other parameters' channels among both; of
//! all parameters that one goes whose loss moves `[A B]` least, as long as that is within a tolerance. The projection
//! is the oblique one that balances what goes in with what comes out, as in B. C. Moore, IEEE Trans. Automatic
//! Control 26(1), 1981.

use crate::error::Error;
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::linearise::scaled;
use crate::uncertain::closed_loop::uncertain_plant;
use crate::uncertain::model::UncertainModel;
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
/// [`ModelError::Lft`](crate::error::ModelError::Lft) where the model has no value; as [`uncertain_plant`].
pub fn thinned(
    inputs: &Inputs,
    whole: &UncertainModel,
    model: &Model,
    (size, tolerance): (f64, f64),
) -> Result<(Truncated, UncertainPlant), Error> {
    let fewer = truncated(&inputs.vehicle.actuators, whole, size, tolerance)?;
    let plant = uncertain_plant(inputs, &fewer.model, model.linear())?;
    Ok((fewer, UncertainPlant { plant, scheduled: 1 }))
}

/// Values of rho at which models are compared.
const RHOS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// Corners of the box, at each rho: while searching, and for the reported error.
const CORNERS: usize = 8;
const REPORTED: usize = 200;

/// Takes channels off a scheduled model while `[A B]` moves by no more than `tolerance`, relative, anywhere in the
/// box of `|delta_i| <= size`.
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
    loop {
        let mut best: Option<(f64, Lft)> = None;
        for (_, first, count) in runs(&lft.channels) {
            let Some(shorter) = without_least(actuators, &lft, first, count, size) else { continue };
            let error = distance(&values(actuators, &shorter, &points)?, &wanted);
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, shorter));
            }
        }
        match best {
            Some((error, shorter)) if error <= tolerance => lft = shorter,
            _ => break,
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

fn distance(found: &[Mat], wanted: &[Mat]) -> f64 {
    found.iter().zip(wanted).map(|(f, w)| (f - w).norm() / w.norm()).fold(0.0, f64::max)
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
