//! Model reduction with a small, measured error, for a robust synthesis of moderate size.
//!
//! Channel directions with little effect are removed one at a time. The candidate of each parameter is the last
//! singular direction of the map through its channels, from the inputs to the outputs and including the channels of
//! other parameters. The candidate whose removal changes `[A B]` least is removed, as long as the total change is
//! within a tolerance. The removal of an actuator's gain must also change the column of that actuator, which may be
//! small, by no more than the tolerance. The projection is oblique and balances channel inputs with outputs, as in B.
//! C. Moore, IEEE Trans. Automatic Control 26(1), 1981.

use crate::error::{Error, UncertainError};
use crate::fit::Model;
use crate::inputs::Inputs;
use crate::linearise::scaled;
use crate::uncertain::closed_loop::uncertain_plant;
use crate::uncertain::model::{Block, Uncertain, UncertainModel};
use crate::uncertain::reduce::runs;
use crate::uncertain::trim::random_corners;
use squid_auv::Actuator;
use squid_lpv::lft::Lft;
use squid_lpv::matrix::{Mat, block, svd};
use squid_lpv::robust::UncertainPlant;

/// Extent of a reduction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reduction {
    /// Fraction of the declared box in which the model is compared.
    pub size: f64,
    /// Allowed relative change of `[A B]` there.
    pub tolerance: f64,
}

/// Model with fewer channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Truncated {
    /// Model without the parameters that have lost all their channels.
    pub model: UncertainModel,
    /// Largest relative change of `[A B]`, over points of the full box.
    pub error: f64,
    /// Names of the removed parameters.
    pub removed: Vec<String>,
}

/// Removes the channels of an uncertain model over the range of speed that change `[A B]` by at most a relative
/// tolerance in a fraction of the declared box, and builds its plant with the weights.
///
/// # Errors
/// [`UncertainError::NothingLeft`] if no parameter is left; [`ModelError::System`](crate::error::ModelError::System) if
/// the model has no value; the errors of [`uncertain_plant`].
pub fn reduced(
    inputs: &Inputs,
    full: &UncertainModel,
    model: &Model,
    Reduction { size, tolerance }: Reduction,
) -> Result<(Truncated, UncertainPlant), Error> {
    let truncated = truncate(&inputs.vehicle.actuators, full, size, tolerance)?;
    if truncated.model.blocks.is_empty() {
        let (design, names) = (inputs.design.file.clone(), truncated.removed);
        return Err(UncertainError::NothingLeft { design, names, size, tolerance }.into());
    }
    let plant = uncertain_plant(inputs, &truncated.model, model.linear())?;
    Ok((truncated, UncertainPlant { plant, scheduled: 1 }))
}

/// Values of rho at which models are compared.
const RHOS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// Number of corners of the box at each rho: for the search, and for the reported error.
const CORNERS: usize = 8;
const REPORTED: usize = 200;

/// LFT with one channel of `parameter` removed.
struct Candidate {
    /// Relative error of the LFT.
    error: f64,
    parameter: usize,
    /// Relative error in the column of the actuator, if the parameter is an actuator's gain.
    own_error: f64,
    lft: Lft,
}

/// Removes channels of a scheduled model while the relative change of `[A B]` is at most `tolerance` anywhere in the
/// box of `|delta_i| <= size`, and, for an actuator's gain, that of its own column as well.
///
/// # Errors
/// [`ModelError::System`](crate::error::ModelError::System) if the model has no value.
fn truncate(
    actuators: &[Actuator],
    model: &UncertainModel,
    size: f64,
    tolerance: f64,
) -> Result<Truncated, Error> {
    let full = &model.lft;
    let points = points(model, size, CORNERS);
    let reference = values(actuators, full, &points)?;
    let mut lft = full.clone();
    // Relative error of each actuator's column from the removed channels of its gain.
    let mut own_errors = vec![0.0; 1 + model.blocks.len()];
    loop {
        let current = values(actuators, &lft, &points)?;
        let mut best: Option<Candidate> = None;
        for (parameter, first, count) in runs(&lft.channels) {
            let Some(shorter) = without_least(actuators, &lft, first, count, size) else { continue };
            let found = values(actuators, &shorter, &points)?;
            let own = parameter.checked_sub(1).and_then(|i| column_of(model.blocks.get(i)?, actuators.len()));
            let own_error =
                own.map_or(0.0, |from_last| distance(&last(&found, from_last), &last(&current, from_last)));
            let own_error = own_errors[parameter] + own_error;
            let error = distance(&found, &reference).max(own_error);
            if best.as_ref().is_none_or(|least| error < least.error) {
                best = Some(Candidate { error, parameter, own_error, lft: shorter });
            }
        }
        match best.filter(|best| best.error <= tolerance) {
            Some(best) => {
                own_errors[best.parameter] = best.own_error;
                lft = best.lft;
            }
            None => break,
        }
    }
    let points = self::points(model, 1.0, REPORTED);
    let error = distance(&values(actuators, &lft, &points)?, &values(actuators, full, &points)?);
    let left = UncertainModel::from_lft(lft, &model.blocks);
    let is_left = |name: &str| left.blocks.iter().any(|b| b.name == name);
    let removed = model.blocks.iter().filter(|b| !is_left(&b.name)).map(|b| b.name.clone()).collect();
    Ok(Truncated { model: left, error, removed })
}

/// Corners of the box and its centre, at each rho.
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

/// Column of `[A B]` that an actuator's gain scales, counted from the last, which is 1.
fn column_of(block: &Block, actuators: usize) -> Option<usize> {
    match block.uncertain {
        Uncertain::Gain(actuator) => Some(actuators - actuator),
        Uncertain::Parameter(_) => None,
    }
}

/// One column of each matrix, counted from the last.
fn last(all: &[Mat], index: usize) -> Vec<Mat> {
    all.iter().map(|m| m.columns(m.ncols() - index, 1).into_owned()).collect()
}

/// Largest relative distance of two matrices at the same point; 0 if they are equal.
fn distance(found: &[Mat], reference: &[Mat]) -> f64 {
    let relative = |(f, w): (&Mat, &Mat)| match (f - w).norm() {
        same if same <= 0.0 => 0.0,
        off => off / w.norm(),
    };
    found.iter().zip(reference).map(relative).fold(0.0, f64::max)
}

/// LFT without the least significant direction of `count` channels of one parameter.
fn without_least(actuators: &[Actuator], lft: &Lft, first: usize, count: usize, size: f64) -> Option<Lft> {
    let k = lft.size();
    let others: Vec<usize> = (0..k).filter(|i| *i < first || *i >= first + count).collect();
    // Channels are weighted by the size of their parameter.
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
    let rank = count - 1;
    if rank > 0 && decomposition.s.get(rank - 1).is_none_or(|s| *s <= 0.0) {
        return None;
    }
    let root = Mat::from_diagonal(&nalgebra::DVector::from_iterator(
        rank,
        decomposition.s.iter().take(rank).map(|s| 1.0 / s.sqrt()),
    ));
    let own_to = &into * decomposition.v.columns(0, rank) * &root;
    let own_from = &root * decomposition.u.columns(0, rank).transpose() * &out;
    let mut to = Mat::zeros(k, k - 1);
    let mut from = Mat::zeros(k - 1, k);
    let index = |i: usize| if i < first { i } else { i - 1 };
    for &i in &others {
        to[(i, index(i))] = 1.0;
        from[(index(i), i)] = 1.0;
    }
    to.view_mut((first, first), (count, rank)).copy_from(&own_to);
    from.view_mut((first, first), (rank, count)).copy_from(&own_from);
    let mut channels = lft.channels.clone();
    channels.remove(first);
    Some(lft.transformed(&from, &to, channels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inputs::tests::shipped;
    use crate::uncertain::{Fidelity, over_range};

    /// Names of the gains of the actuators of REMUS 100.
    const GAINS: [&str; 2] = ["gain of propeller", "gain of stern_planes"];

    /// REMUS 100 with `actuator_gain` alone, like a new design of `squid tune`.
    fn with_gain(gain: f64) -> Result<Truncated, Error> {
        let mut inputs = shipped("remus100", "pitch");
        inputs.uncertain.clear();
        inputs.design.uncertainty.as_mut().unwrap().actuator_gain = gain;
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let full = over_range(&inputs, &model, Fidelity::COARSE).unwrap();
        reduced(&inputs, &full, &model, Reduction { size: 0.5, tolerance: 0.01 })
            .map(|(truncated, _)| truncated)
    }

    /// The propeller's column is small compared with `[A B]`: its entire gain is within the tolerance of `[A B]`.
    #[test]
    fn keeps_gain_of_weak_actuator() {
        let found = with_gain(0.1).unwrap();
        assert_eq!(found.removed, Vec::<String>::new());
        assert_eq!(found.model.blocks.iter().map(|b| b.name.clone()).collect::<Vec<_>>(), GAINS);
    }

    #[test]
    fn rejects_model_without_remaining_uncertainty() {
        let refused = with_gain(0.001).unwrap_err();
        let Error::Uncertain(UncertainError::NothingLeft { names, .. }) = &refused else {
            panic!("{refused}")
        };
        assert_eq!(names, &GAINS);
        insta::assert_snapshot!(refused);
    }
}
