//! Balls around the uncertain model that contain its error against the vehicle, one ball per row of `[A B]`.
//!
//! The model is reduced, fitted over speed, and first order in the trim. At samples of speed and of the coefficients it
//! is compared with the linearisation of the vehicle with these coefficients about its own trim. The trim parameters of
//! the model are set to that trim, as far as the box allows. Row i of the difference is `Delta_i F_i` with a row
//! `|Delta_i| <= 1`.

use crate::augment::model_position;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::linearise::scaled;
use crate::uncertain::errors::model_error;
use crate::uncertain::frozen::at_speed;
use crate::uncertain::model::UncertainModel;
use crate::uncertain::trim::random_corners;
use squid_lpv::matrix::Mat;
use squid_lpv::model_error::ModelError;
use squid_lpv::plant::GeneralisedPlant;

/// Samples at which the model is compared with the vehicle.
#[derive(Debug, Clone, Copy)]
struct Samples {
    speeds: usize,
    /// Random corners of the box per speed.
    corners: usize,
    /// Random interior points per speed.
    inside: usize,
    seed: u64,
}

const SAMPLES: Samples = Samples { speeds: 26, corners: 60, inside: 20, seed: 7 };

/// Factor by which the balls exceed the sampled errors.
pub const ENLARGEMENT: f64 = 1.6;

/// Rows whose error is below `EXACT` are exact. The half axis of a column is at least `LEAST_COLUMN` of the largest in
/// its row.
const EXACT: f64 = 1e-12;
const LEAST_COLUMN: f64 = 1e-3;

/// Returns the balls for the fraction `share` of the declared box, in the coordinates of the plant of that fraction.
///
/// # Errors
/// [`Error::Uncertain`], the errors of the linearisation.
pub fn around(
    inputs: &Inputs,
    model: &UncertainModel,
    share: f64,
    plant: &GeneralisedPlant,
) -> Result<Vec<ModelError>, Error> {
    let errors = sampled_errors(inputs, model, share, SAMPLES)?;
    let (n, m, w) = (plant.a().nrows(), inputs.vehicle.actuators.len(), plant.b1().ncols());
    let states = inputs.design.states.len();
    // Map from the plant's states and u to the model; the balls do not cover the effect of w on it.
    let right = model_position(&inputs.vehicle.actuators, &inputs.design.with_unweighted_references())?
        .right
        .remove_columns(n, w);
    let mut balls = vec![];
    for (row, axes) in (0..states).zip(half_axes(&errors)).filter_map(|(row, axes)| Some((row, axes?))) {
        let (mut e, mut f) = (Mat::zeros(n, 1), Mat::zeros(states + m, n + m));
        e[(row, 0)] = 1.0;
        for (j, size) in axes.into_iter().enumerate() {
            match j.checked_sub(states) {
                None => f[(j, j)] = size,
                Some(input) => {
                    let unit = inputs.vehicle.actuators[input].reach();
                    f.row_mut(j).copy_from(&(right.row(j) * (size / unit)));
                }
            }
        }
        let fu = f.columns(n, m).into_owned();
        balls.push(ModelError { e, f: f.columns(0, n).into_owned(), fw: Mat::zeros(states + m, w), fu });
    }
    Ok(balls)
}

/// Half axes of an enlarged ellipsoid that contains each row at all samples; `None` for an exact row.
fn half_axes(errors: &[Mat]) -> Vec<Option<Vec<f64>>> {
    let rows = errors.first().map_or(0, |m| m.nrows());
    let axes_of = |row: usize| {
        let columns = errors.first().map_or(0, |m| m.ncols());
        let most = |j: usize| errors.iter().map(|m| m[(row, j)].abs()).fold(0.0, f64::max);
        let each: Vec<f64> = (0..columns).map(most).collect();
        let largest = each.iter().copied().fold(0.0, f64::max);
        let axes: Vec<f64> = each.iter().map(|v| v.max(LEAST_COLUMN * largest)).collect();
        let norm =
            |m: &Mat| axes.iter().enumerate().map(|(j, a)| (m[(row, j)] / a).powi(2)).sum::<f64>().sqrt();
        let factor = ENLARGEMENT * errors.iter().map(norm).fold(0.0, f64::max);
        (largest > EXACT).then(|| axes.iter().map(|a| factor * a).collect())
    };
    (0..rows).map(axes_of).collect()
}

/// Errors of the model at the samples, with inputs in units of their reach.
fn sampled_errors(
    inputs: &Inputs,
    model: &UncertainModel,
    share: f64,
    Samples { speeds, corners, inside, seed }: Samples,
) -> Result<Vec<Mat>, Error> {
    let mut out = vec![];
    for (i, speed) in inputs.design.spread(speeds).into_iter().enumerate() {
        let frozen = at_speed(inputs, speed)?;
        let n = frozen.parameters.len();
        // Each speed has its own points. An interior point is the mean of two corners, or half of one, at random.
        let seed = seed + i as u64;
        let mut points = random_corners(n, corners, seed);
        let pairs = random_corners(n, 2 * inside, seed + 1000);
        let weights = random_corners(n, inside, seed + 2000);
        points.extend(pairs.chunks(2).zip(&weights).map(|(pair, weight)| {
            (0..n)
                .map(|j| if weight[j] > 0.0 { 0.5 * (pair[0][j] + pair[1][j]) } else { 0.5 * pair[0][j] })
                .collect()
        }));
        points.push(vec![0.0; n]);
        for point in points {
            let point: Vec<f64> = point.into_iter().map(|d| share * d).collect();
            let error = model_error(inputs, &frozen, model, &point, share)?;
            out.push(scaled(&inputs.vehicle.actuators, error));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Model;
    use crate::inputs::tests::shipped;
    use crate::uncertain::{Fidelity, over_range};

    /// The balls contain errors at other speeds, corners and points than those from which they were computed.
    #[test]
    fn balls_contain_vehicle_at_other_samples() {
        for (name, design) in [("squid", "design"), ("remus100", "pitch")] {
            let inputs = shipped(name, design);
            let fit = Model::new(&inputs.axis(), &inputs.design).unwrap();
            let other = Samples { speeds: 37, corners: 90, inside: 30, seed: 12345 };
            let model = over_range(&inputs, &fit, Fidelity::FINE).unwrap();
            let sampled = sampled_errors(&inputs, &model, 1.0, SAMPLES).unwrap();
            let fresh = sampled_errors(&inputs, &model, 1.0, other).unwrap();
            for (row, axes) in half_axes(&sampled).into_iter().enumerate() {
                let Some(axes) = axes else { continue };
                let norm = |m: &Mat| {
                    axes.iter().enumerate().map(|(j, a)| (m[(row, j)] / a).powi(2)).sum::<f64>().sqrt()
                };
                let farthest = fresh.iter().map(norm).fold(0.0, f64::max);
                println!("{name} row {row}: {farthest:.3} of the ball, axes {axes:.4?}");
                assert!(farthest <= 1.0, "{name} row {row}: {farthest}");
                assert!(farthest > 0.5, "{name} row {row}: the ball is much larger than it must be");
            }
        }
    }
}
