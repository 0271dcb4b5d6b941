//! Balls around the uncertain model that contain what it misses of the vehicle, a ball for each row of `[A B]`.
//!
//! The model is reduced, fitted over speed, and to first order in the trim. At speeds and values of the coefficients
//! it is compared with the vehicle that has these coefficients, trimmed again and linearised; its parameters of the
//! trim are put where that trim is, as far as the box goes. Row i of the difference is `Delta_i F_i` with a row
//! `|Delta_i| <= 1`.

use crate::augment::place;
use crate::error::Error;
use crate::inputs::Inputs;
use crate::linearise::scaled;
use crate::uncertain::errors::missing;
use crate::uncertain::frozen::at_speed;
use crate::uncertain::model::UncertainModel;
use crate::uncertain::trim::random_corners;
use lpv::matrix::Mat;
use lpv::model_error::ModelError;
use lpv::plant::GeneralisedPlant;

/// Speeds, and at each the corners and the points inside at which the model is compared.
const SPEEDS: usize = 26;
const CORNERS: usize = 60;
const INSIDE: usize = 20;

/// How much larger than measured the balls are.
pub const WIDER: f64 = 1.6;

/// Rows whose difference is below this are exact; columns count at least as this part of the largest of their row.
const EXACT: f64 = 1e-12;
const LEAST_COLUMN: f64 = 1e-3;

/// The balls for `share` of the declared box, in the coordinates of the plant of that share.
///
/// # Errors
/// [`Error::Uncertain`], those of the linearisation.
pub fn around(
    inputs: &Inputs,
    model: &UncertainModel,
    share: f64,
    plant: &GeneralisedPlant,
) -> Result<Vec<ModelError>, Error> {
    let off = differences(inputs, model, share, (SPEEDS, CORNERS, INSIDE, 7))?;
    let (n, m, w) = (plant.a().nrows(), inputs.vehicle.actuators.len(), plant.b1().ncols());
    let states = inputs.design.states.len();
    // What acts on the model, of the plant's states and u; what w adds is not in the balls.
    let right =
        place(&inputs.vehicle.actuators, &inputs.design.with_even_references())?.right.remove_columns(n, w);
    let mut balls = vec![];
    for (row, reach) in (0..states).zip(reaches(&off)).filter_map(|(row, reach)| Some((row, reach?))) {
        let (mut e, mut f) = (Mat::zeros(n, 1), Mat::zeros(states + m, n + m));
        e[(row, 0)] = 1.0;
        for (j, size) in reach.into_iter().enumerate() {
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

/// For each row, unless it is exact, the half axes of an ellipsoid that contains it at all samples, widened.
fn reaches(off: &[Mat]) -> Vec<Option<Vec<f64>>> {
    let rows = off.first().map_or(0, |m| m.nrows());
    let reach = |row: usize| {
        let columns = off.first().map_or(0, |m| m.ncols());
        let most = |j: usize| off.iter().map(|m| m[(row, j)].abs()).fold(0.0, f64::max);
        let each: Vec<f64> = (0..columns).map(most).collect();
        let largest = each.iter().copied().fold(0.0, f64::max);
        let axes: Vec<f64> = each.iter().map(|v| v.max(LEAST_COLUMN * largest)).collect();
        let norm =
            |m: &Mat| axes.iter().enumerate().map(|(j, a)| (m[(row, j)] / a).powi(2)).sum::<f64>().sqrt();
        let factor = WIDER * off.iter().map(norm).fold(0.0, f64::max);
        (largest > EXACT).then(|| axes.iter().map(|a| factor * a).collect())
    };
    (0..rows).map(reach).collect()
}

/// What the model misses, inputs in units of their reach: at so many speeds, and at each so many corners of the box and
/// points inside, random from a seed on.
fn differences(
    inputs: &Inputs,
    model: &UncertainModel,
    share: f64,
    (speeds, corners, inside, seed): (usize, usize, usize, u64),
) -> Result<Vec<Mat>, Error> {
    let mut out = vec![];
    for (i, speed) in inputs.design.spread(speeds).into_iter().enumerate() {
        let frozen = at_speed(inputs, speed)?;
        let n = frozen.parameters.len();
        // Of each two speeds other points; of two corners the one in the mean with the other's weights is inside.
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
            let off = missing(inputs, &frozen, model, (&point, share))?;
            out.push(scaled(&inputs.vehicle.actuators, off));
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

    /// Other speeds, corners and points than those that made the balls lie inside them.
    #[test]
    fn the_balls_contain_the_vehicle_where_they_were_not_measured() {
        for name in ["squid", "remus100"] {
            let inputs = shipped(name, "design");
            let fit = Model::new(&inputs.vehicle, &inputs.design).unwrap();
            let model = over_range(&inputs, &fit, Fidelity::FINE).unwrap();
            let sampled = differences(&inputs, &model, 1.0, (SPEEDS, CORNERS, INSIDE, 7)).unwrap();
            let fresh = differences(&inputs, &model, 1.0, (37, 90, 30, 12345)).unwrap();
            for (row, reach) in reaches(&sampled).into_iter().enumerate() {
                let Some(axes) = reach else { continue };
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
