//! Controls without a weight and measurements without noise.
//!
//! If D12 lacks full column rank, a direction of the control costs nothing; if D21 lacks full row rank, a combination
//! of measurements can be differentiated at no cost. The synthesis inequalities remain feasible, but their least gamma
//! is an infimum approached with unbounded gains, at which the numerics fail. Source of the conditions: J. C. Doyle,
//! K. Glover, P. P. Khargonekar, B. A. Francis, IEEE Trans. Automatic Control 34(8), 1989, section III.A; of LMIs
//! without them: P. Gahinet, P. Apkarian, Int. J. Robust and Nonlinear Control 4, 1994.
//!
//! A parameter channel also helps: through Dt2 the gain between the channels, which must stay below 1, bounds a
//! control, and through D2t the parameter disturbs a measurement. The conditions are therefore on `[D12; Dt2]` and
//! `[D21 D2t]`.

use crate::matrix::{Mat, block, eigenvalues, largest_singular_value, svd};
use crate::synthesis::balance::Coordinates;
use crate::system::GeneralisedPlant;
use crate::system::Group::{T, U, W, X, Y, Z};
use squid_finding::Finding;
use std::fmt;

/// The singular value up to which it is taken as zero, with each column of weights (row of noises) scaled to norm 1:
/// the inequalities contain its square, and 1e-12 is lost at their accuracy of 1e-8. A column below the square of it,
/// relative to the control's effect through the states, is rounding.
pub const RANK_TOLERANCE: f64 = 1e-6;

/// A control or measurement without a cost.
#[derive(Debug, Clone, PartialEq)]
pub enum Irregularity {
    /// A direction of the control without direct effect on any performance output or parameter channel.
    UnweightedControl {
        /// The direction, in the units of u, its largest component 1.
        direction: Vec<f64>,
        /// The size of its direct effect on z and zt, each control in its own unit; at most [`RANK_TOLERANCE`].
        weight: f64,
    },
    /// A combination `c'y` of the measurements that no disturbance and no parameter channel enters directly.
    NoiselessMeasurement {
        /// The coefficients c, in units of 1/y, the largest 1.
        combination: Vec<f64>,
        /// The size of the direct effect of w and wt on it, each measurement in its own unit; at most
        /// [`RANK_TOLERANCE`].
        noise: f64,
    },
}

/// Returns all irregularities of a plant, controls first; none if `[D12; Dt2]` and `[D21 D2t]'` have full column rank.
///
/// The rank is determined for the given plant, each control and measurement in units of its own weight or noise:
/// neither units nor modes far slower than the others matter.
pub fn irregularities(plant: &GeneralisedPlant) -> Vec<Irregularity> {
    let (weighted, units) = in_own_units(plant);
    let controls = free_directions(&weighted, RANK_TOLERANCE).into_iter().map(|(direction, weight)| {
        Irregularity::UnweightedControl { direction: in_users_units(&direction, &units), weight }
    });
    let (disturbed, units) = in_own_units(&plant.dual());
    let measurements = free_directions(&disturbed, RANK_TOLERANCE).into_iter().map(|(combination, noise)| {
        Irregularity::NoiselessMeasurement { combination: in_users_units(&combination, &units), noise }
    });
    controls.chain(measurements).collect()
}

/// Returns the plant in diagonally balanced coordinates with z and w scaled so that the rows of z and the columns of w
/// have norm 1; the coordinates, and the units of z and 1/w, in the user's units.
pub(crate) fn normalised(plant: &GeneralisedPlant) -> (GeneralisedPlant, Coordinates, (f64, f64)) {
    let mut plant = plant.clone();
    let mut coordinates = Coordinates::diagonal(&plant);
    let mut units = (1.0, 1.0);
    // Each round halves the remaining exponent, as the balancing splits a factor between both sides of the states.
    for _ in 0..8 {
        let scaled = coordinates.apply(&plant);
        let z = size(&scaled.parts.join(&[Z], &[X, T, U]));
        let w = size(&scaled.parts.join(&[X, T, Y], &[W]));
        plant.parts.rows_mut(Z).unscale_mut(z);
        plant.parts.columns_mut(W).unscale_mut(w);
        units = (units.0 * z, units.1 * w);
        coordinates = Coordinates::diagonal(&plant);
    }
    (coordinates.apply(&plant), coordinates, units)
}

fn size(m: &Mat) -> f64 {
    let size = largest_singular_value(m);
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}

/// Returns `[D12; Dt2]` with each column divided by its norm, and these norms. A column at rounding level, relative to
/// its control's effect through the states, is divided by a larger number.
fn in_own_units(plant: &GeneralisedPlant) -> (Mat, Vec<f64>) {
    let (weights, channels) = (plant.d12(), plant.dt2());
    // A parameter channel has a unit of its own.
    let ratio = |one: f64, other: f64| if one > 0.0 && other > 0.0 { one / other } else { 1.0 };
    let direct = block(&[&[&weights], &[&(&channels * ratio(weights.amax(), channels.amax()))]]);
    let through = through_states(plant);
    let unit = |(j, column): (usize, nalgebra::DVectorView<'_, f64>)| {
        let least = RANK_TOLERANCE * through[j];
        let unit = column.norm().max(least);
        if unit > 0.0 { unit } else { 1.0 }
    };
    let units: Vec<f64> = direct.column_iter().enumerate().map(unit).collect();
    let scaled = Mat::from_fn(direct.nrows(), direct.ncols(), |i, j| direct[(i, j)] / units[j]);
    (scaled, units)
}

/// Returns `|C1 b|/rate` for each control, with the rate of the fastest mode: its effect on z through the states within
/// the time of that mode. 0 if no mode moves.
fn through_states(plant: &GeneralisedPlant) -> Vec<f64> {
    let rate = eigenvalues(&plant.a()).iter().map(|v| v.norm()).fold(0.0, f64::max);
    let seen = plant.c1() * plant.b2();
    let usable = rate > 0.0 && rate.is_finite();
    seen.column_iter().map(|column| if usable { column.norm() / rate } else { 0.0 }).collect()
}

/// Returns directions v of norm 1 with `|M v|` within the tolerance, each with that norm: coordinate axes first, then
/// combinations of the others.
pub(crate) fn free_directions(m: &Mat, tolerance: f64) -> Vec<(Vec<f64>, f64)> {
    let count = m.ncols();
    let (free, rest): (Vec<usize>, Vec<usize>) = (0..count).partition(|&j| m.column(j).norm() <= tolerance);
    let axis = |j: usize| (0..count).map(|i| if i == j { 1.0 } else { 0.0 }).collect();
    let mut out: Vec<(Vec<f64>, f64)> = free.into_iter().map(|j| (axis(j), m.column(j).norm())).collect();
    let decomposition = svd(&m.select_columns(&rest));
    for (k, v) in decomposition.v.column_iter().enumerate() {
        let value = decomposition.s.get(k).copied().unwrap_or(0.0);
        if value <= tolerance {
            let mut direction = vec![0.0; count];
            for (&j, component) in rest.iter().zip(v.iter()) {
                direction[j] = *component;
            }
            out.push((direction, value));
        }
    }
    out
}

/// Returns a direction in the user's units, the largest component 1; components at rounding level, in their own units,
/// are set to 0.
fn in_users_units(direction: &[f64], units: &[f64]) -> Vec<f64> {
    let kept = direction.iter().map(|v| if v.abs() > RANK_TOLERANCE { *v } else { 0.0 });
    let converted: Vec<f64> = kept.zip(units).map(|(v, unit)| v / unit).collect();
    let largest =
        converted.iter().copied().fold(0.0, |most: f64, v| if v.abs() > most.abs() { v } else { most });
    converted.into_iter().map(|v| v / largest).collect()
}

impl From<&Irregularity> for Finding {
    /// The key is the control or measurement of the largest component, `u2` or `y1`.
    fn from(irregularity: &Irregularity) -> Self {
        let (kind, letter, direction, size) = match irregularity {
            Irregularity::UnweightedControl { direction, weight } => {
                ("unweighted_control", 'u', direction, weight)
            }
            Irregularity::NoiselessMeasurement { combination, noise } => {
                ("noiseless_measurement", 'y', combination, noise)
            }
        };
        let largest = direction.iter().position(|v| v.abs() == 1.0).unwrap_or_default();
        let found = Finding::new(kind, &format!("{letter}{}", largest + 1), irregularity.to_string());
        found.value(*size, "").limit(RANK_TOLERANCE)
    }
}

impl fmt::Display for Irregularity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Irregularity::UnweightedControl { direction, .. } => match single_index(direction) {
                Some(j) => write!(
                    f,
                    "no performance output weights u{j}, so that its gain may grow without limit: add a weight on \
                     u{j} (column {j} of D12)"
                ),
                None => write!(
                    f,
                    "no performance output weights the combination {} of controls, so that its gain may grow without \
                     limit: add a separate weight on each of {} (columns of D12)",
                    direction_text(direction, "u"),
                    names(direction, "u")
                ),
            },
            Irregularity::NoiselessMeasurement { combination, .. } => match single_index(combination) {
                Some(i) => write!(
                    f,
                    "the measurement y{i} is free of noise, so that the gain from it may grow without limit: \
                     add noise to y{i} (row {i} of D21)"
                ),
                None => write!(
                    f,
                    "the combination {} of measurements is free of noise, so that the gain from it may grow without \
                     limit: add independent noise to each of {} (rows of D21)",
                    sum_text(combination, "y"),
                    names(combination, "y")
                ),
            },
        }
    }
}

/// Returns the index, from 1, of the only nonzero component.
fn single_index(direction: &[f64]) -> Option<usize> {
    let mut parts = parts(direction);
    match (parts.next(), parts.next()) {
        (Some((i, _)), None) => Some(i),
        _ => None,
    }
}

pub(crate) fn parts(direction: &[f64]) -> impl Iterator<Item = (usize, f64)> {
    direction.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(i, v)| (i + 1, *v))
}

fn names(direction: &[f64], letter: &str) -> String {
    parts(direction).map(|(i, _)| format!("{letter}{i}")).collect::<Vec<_>>().join(", ")
}

/// Formats a direction, `(u1, u3) = (1, -0.5)`.
fn direction_text(direction: &[f64], letter: &str) -> String {
    let values: Vec<String> = parts(direction).map(|(_, v)| number(v)).collect();
    format!("({}) = ({})", names(direction, letter), values.join(", "))
}

/// Formats a combination, `y1 - 0.5 y3`.
pub(crate) fn sum_text(combination: &[f64], letter: &str) -> String {
    let mut out = String::new();
    for (i, v) in parts(combination) {
        let sign = match (v < 0.0, out.is_empty()) {
            (true, true) => "-",
            (true, false) => " - ",
            (false, true) => "",
            (false, false) => " + ",
        };
        let factor = if v.abs() == 1.0 { String::new() } else { format!("{} ", number(v.abs())) };
        out += &format!("{sign}{factor}{letter}{i}");
    }
    out
}

/// Formats a number to four digits without trailing zeros.
pub(crate) fn number(v: f64) -> String {
    let text = format!("{v:.3e}");
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}

/// The additions to a plant for the design of its controller; the bound is that of the plant without them.
#[derive(Debug, Clone, PartialEq)]
pub struct Regularisation {
    /// Rows of coefficients of u, in units of z/u: one output each.
    pub weights: Vec<Vec<f64>>,
    /// Columns of coefficients in y, in units of y/w: one disturbance each.
    pub noises: Vec<Vec<f64>>,
}

impl Regularisation {
    /// Returns the outputs and disturbances that give every direction of the controls at least the weight `size`, and
    /// every combination of measurements that noise, in balanced coordinates in which z and w are scaled to about 1.
    pub(crate) fn new(plant: &GeneralisedPlant, size: f64) -> Self {
        let (scaled, coordinates, units) = normalised(plant);
        let weighted = scaled.parts.join(&[Z, T], &[U]);
        let disturbed = scaled.parts.join(&[Y], &[W, T]).transpose();
        let added = |m: &Mat, convert: &dyn Fn(usize, f64) -> f64| -> Vec<Vec<f64>> {
            let directions = free_directions(m, size).into_iter();
            let scaled =
                |(v, _): (Vec<f64>, f64)| v.iter().enumerate().map(|(i, v)| convert(i, size * v)).collect();
            directions.map(scaled).collect()
        };
        let (u, y) = (&coordinates.control, &coordinates.measurement);
        Self {
            weights: added(&weighted, &|j, v| v * units.0 / u[j]),
            noises: added(&disturbed, &|i, v| v * units.1 * y[i]),
        }
    }

    /// Returns `true` if the plant needs no addition.
    pub(crate) fn is_empty(&self) -> bool {
        self.weights.is_empty() && self.noises.is_empty()
    }

    /// Returns the plant with these outputs and disturbances.
    pub(crate) fn apply(&self, plant: &GeneralisedPlant) -> GeneralisedPlant {
        let s = plant.sizes();
        let (more_z, more_w) = (self.weights.len(), self.noises.len());
        let mut out = plant.changed(|parts| parts.resized(Z, s.z + more_z).resized(W, s.w + more_w));
        let weights = Mat::from_fn(more_z, s.u, |i, j| self.weights[i][j]);
        let noises = Mat::from_fn(s.y, more_w, |i, j| self.noises[j][i]);
        out.parts.block_mut(Z, U).rows_mut(s.z, more_z).copy_from(&weights);
        out.parts.block_mut(Y, W).columns_mut(s.w, more_w).copy_from(&noises);
        out
    }
}

impl fmt::Display for Regularisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outputs = self.weights.iter().map(|row| format!("an output {} (weight)", sum_text(row, "u")));
        let disturbances = self.noises.iter().map(|column| {
            let parts: Vec<String> =
                parts(column).map(|(i, v)| format!("{} of it in y{i}", number(v))).collect();
            format!("a disturbance with {} (noise)", parts.join(", "))
        });
        write!(
            f,
            "the controller was designed for the plant with {} added; its bound holds for the original plant",
            outputs.chain(disturbances).collect::<Vec<_>>().join("; ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::partition::NamedBlock;
    use nalgebra::dmatrix;

    /// Returns two states, two controls, two measurements, all weighted and noisy, with some blocks replaced.
    fn regular_but(others: &[NamedBlock]) -> GeneralisedPlant {
        let mut blocks = [
            (X, X, dmatrix![-1.0, 0.3; 0.2, -2.0]),
            (X, T, dmatrix![0.1; 0.2]),
            (X, W, dmatrix![1.0, 0.0, 0.0; 0.5, 0.0, 0.0]),
            (X, U, dmatrix![1.0, 0.4; 0.0, 1.0]),
            (T, X, dmatrix![0.3, 0.1]),
            (Z, X, dmatrix![1.0, 0.0; 0.0, 0.0; 0.0, 0.0]),
            (Z, U, dmatrix![0.0, 0.0; 0.1, 0.0; 0.0, 0.2]),
            (Y, X, dmatrix![1.0, 0.0; 0.3, 1.0]),
            (Y, W, dmatrix![0.0, 0.1, 0.0; 0.0, 0.0, 0.2]),
        ];
        for (row, column, m) in others {
            let block = blocks.iter_mut().find(|(r, c, _)| (r, c) == (row, column)).unwrap();
            block.2.clone_from(m);
        }
        GeneralisedPlant::new(vec![1], &blocks).unwrap()
    }

    fn regular() -> GeneralisedPlant {
        regular_but(&[])
    }

    #[test]
    fn a_regular_plant_gives_no_finding() {
        assert_eq!(irregularities(&regular()), vec![]);
    }

    /// Balancing for a mode this slow makes a state's column so large that a weight of 1 seems negligible.
    #[test]
    fn slow_modes_do_not_hide_a_weight() {
        for slow in [1e-5, 1e-6, 1e-7, 0.0] {
            let mut changed = [
                (X, X, dmatrix![-1.0, 0.0; 1.0, -slow]),
                (Z, X, dmatrix![0.0, 1.0; 0.0, 0.0; 0.0, 0.0]),
                (X, U, dmatrix![1.0, 0.0; 0.0, 1.0]),
                (Y, X, dmatrix![0.0, 1.0; 0.0, 1.0]),
                (Z, U, dmatrix![0.0, 0.0; 1.0, 0.0; 0.0, 1.0]),
                (Y, W, dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0]),
            ];
            assert_eq!(irregularities(&regular_but(&changed)), vec![], "{slow}");
            // A fast, strong path and a slow one: a chain of integrators.
            changed[0].2 = dmatrix![-slow, 1.0; 0.0, -10.0 * slow];
            let chain = regular_but(&changed);
            assert_eq!(irregularities(&chain), vec![], "{slow}");
        }
    }

    #[test]
    fn a_control_without_weight_is_reported() {
        let mut plant = regular();
        plant.parts.block_mut(Z, U)[(2, 1)] = 0.0;
        let found = irregularities(&plant);
        assert_eq!(found, vec![Irregularity::UnweightedControl { direction: vec![0.0, 1.0], weight: 0.0 }]);
        insta::assert_snapshot!(found[0]);
    }

    #[test]
    fn a_measurement_without_noise_is_reported() {
        let mut plant = regular();
        plant.parts.block_mut(Y, W)[(0, 1)] = 0.0;
        let found = irregularities(&plant);
        assert_eq!(
            found,
            vec![Irregularity::NoiselessMeasurement { combination: vec![1.0, 0.0], noise: 0.0 }]
        );
        insta::assert_snapshot!(found[0]);
    }

    /// z depends only on `2 u1 + u2`, so (1, -2) costs nothing; w3 enters y1 and y2 as 3 to 1, so y1 - 3 y2 is free of
    /// it.
    #[test]
    fn directions_other_than_axes_are_in_the_users_units() {
        let mut plant = regular();
        plant.parts.block_mut(Z, U).copy_from(&dmatrix![0.0, 0.0; 0.2, 0.1; 0.0, 0.0]);
        plant.parts.block_mut(Y, W).copy_from(&dmatrix![0.0, 0.0, 0.3; 0.0, 0.0, 0.1]);
        let found = irregularities(&plant);
        let [
            Irregularity::UnweightedControl { direction, .. },
            Irregularity::NoiselessMeasurement { combination, .. },
        ] = found.as_slice()
        else {
            panic!("{found:?}");
        };
        assert!((direction[0] + 0.5).abs() < 1e-9 && direction[1] == 1.0, "{direction:?}");
        assert!((combination[0] + 1.0 / 3.0).abs() < 1e-9 && combination[1] == 1.0, "{combination:?}");
        assert!(found[0].to_string().contains("(u1, u2) = (-0.5, 1)"), "{}", found[0]);
        assert!(found[1].to_string().contains("-0.3333 y1 + y2"), "{}", found[1]);
    }

    #[test]
    fn more_controls_than_outputs_leave_one_direction_free() {
        let one = [(Z, X, dmatrix![1.0, 0.0]), (Z, U, dmatrix![1.0, 1.0])];
        let plant = regular_but(&one);
        assert_eq!(irregularities(&plant).len(), 1);
    }

    #[test]
    fn a_parameter_channel_bounds_a_control_too() {
        let mut plant = regular();
        plant.parts.block_mut(Z, U)[(2, 1)] = 0.0;
        plant.parts.block_mut(T, U)[(0, 1)] = 0.5;
        assert_eq!(irregularities(&plant), vec![]);
    }

    /// Units of u, y, z, w, time and states that differ by many orders of magnitude keep a regular plant regular and a
    /// singular one singular.
    #[test]
    fn irregularities_do_not_depend_on_units() {
        for (weight, expected) in [(0.2, 0), (0.0, 1)] {
            for exponent in [-8, -4, 4, 8] {
                let unit = 10f64.powi(exponent);
                let mut plant = regular();
                plant.parts.block_mut(Z, U)[(2, 1)] = weight;
                let in_other_units = [Z, W, U, Y, X].map(|signal| {
                    let mut plant = plant.clone();
                    match signal {
                        Z | Y | X => plant.parts.rows_mut(signal).scale_mut(unit),
                        _ => plant.parts.columns_mut(signal).scale_mut(unit),
                    }
                    plant
                });
                for (i, plant) in in_other_units.iter().enumerate() {
                    assert_eq!(
                        irregularities(plant).len(),
                        expected,
                        "units {i}, {unit:.0e}, weight {weight}"
                    );
                }
            }
        }
    }
}
