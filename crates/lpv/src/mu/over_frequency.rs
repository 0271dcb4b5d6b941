//! Upper and lower bounds on mu over all frequencies, component by component.

use super::components::of_system;
use super::coordinates::balanced;
use super::lower::LowerBound;
use super::margin::real_lower_bound;
use super::peaks::lower_at_peaks;
use super::structure::Structure;
use super::sweep::{CLOSEST, FrequencyBound, SweepError, check_stable, swept};
use crate::system::StateSpace;

/// Both bounds over all frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyMu {
    /// The upper bound.
    pub upper: FrequencyBound,
    /// The perturbation found, with its lower bound; `None` if none was found.
    pub lower: Option<LowerBound>,
}

/// Computes upper and lower bounds of mu over all frequencies.
///
/// ```text
/// upper >= sup over omega of mu(M(j omega)) >= lower,   M(s) = C (s I - A)^-1 B + D
/// ```
///
/// # Errors
/// Returns [`SweepError`] if the upper bound fails.
pub fn mu_over_frequency(system: &StateSpace, structure: &Structure) -> Result<FrequencyMu, SweepError> {
    check_stable(system, structure)?;
    let (mut upper, mut lower) = (FrequencyBound::default(), None);
    for part in of_system(system, structure) {
        let balanced = balanced(&part.system(system), &part.structure);
        let first = real_lower_bound(&balanced, &part.structure);
        let known = larger(lower.clone(), first.clone());
        let found = swept(&balanced, &part.structure, known.as_ref(), CLOSEST)?;
        let peaks = found.peaks();
        let shown = lower_at_peaks(&balanced, &part.structure, &peaks, found.upper, first)?;
        let full = shown.map(|shown| LowerBound { delta: part.embedded(&shown.delta, structure), ..shown });
        lower = larger(lower, full);
        upper.add(found);
    }
    Ok(FrequencyMu { upper, lower })
}

fn larger(one: Option<LowerBound>, other: Option<LowerBound>) -> Option<LowerBound> {
    one.into_iter().chain(other).max_by(|a, b| a.value.total_cmp(&b.value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Mat;
    use crate::mu::structure::Block;
    use nalgebra::dmatrix;

    /// Returns a loop with integral control around a mass that is actuated through a lag: mass and damping uncertain by
    /// 30 %, acting on acceleration and velocity, one of which is the derivative of the other; stiffness by 40 %,
    /// actuator by 50 %.
    fn mass(leak: f64, gain: f64) -> StateSpace {
        let (kp, ki, kd) = (2.0 * gain, 0.5 * gain, 1.5);
        StateSpace {
            a: dmatrix![
                0.0, 1.0, 0.0, 0.0;
                -0.4, -0.5, 1.0, 0.0;
                -5.0 * kp, -5.0 * kd, -5.0, -5.0 * ki;
                1.0, 0.0, 0.0, -leak
            ],
            b: Mat::from_fn(4, 4, |i, _| if i == 1 { 1.0 } else { 0.0 }),
            c: dmatrix![-0.12, -0.15, 0.3, 0.0; 0.0, 0.3, 0.0, 0.0; 0.4, 0.0, 0.0, 0.0; 0.0, 0.0, 0.5, 0.0],
            d: Mat::from_fn(4, 4, |i, _| if i == 0 { 0.3 } else { 0.0 }),
        }
    }

    /// Nearly dependent rows, towards zero or infinity: the centre of all scalings that hold at one frequency holds
    /// only in its neighbourhood, and a sweep with these would not end. The bounds agree.
    #[test]
    fn a_sweep_ends_with_nearly_dependent_rows() {
        let (two, three) =
            (vec![Block::Real(2), Block::Real(1), Block::Real(1)], vec![Block::Real(3), Block::Real(1)]);
        for (leak, gain, blocks) in [(0.02, 1.0, &three), (1e-3, 3.0, &two), (1e-3, 3.0, &three)] {
            let found =
                mu_over_frequency(&mass(leak, gain), &Structure::new(blocks.clone()).unwrap()).unwrap();
            let (upper, lower) = (found.upper.upper, found.lower.unwrap().value);
            assert!(lower <= upper && upper < 1.001 * lower, "{leak} {gain}: {lower} {upper}");
            assert!(found.upper.pieces.len() < 100, "{leak} {gain}: {}", found.upper.pieces.len());
        }
    }

    /// Returns a loop that is unstable for `(q1 - 1)^2 + (q2 - 1)^2 <= 0.01`: an isolated region, reached first at
    /// (1.1, 1), a margin of 3/11 (J. Ackermann's example; q1 = 1.4 + 1.1 delta_1, q2 = 0.85 + 0.85 delta_2).
    fn island() -> StateSpace {
        StateSpace {
            a: dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -16.89, -5.25, -3.25],
            b: dmatrix![0.0, 0.0, 0.0; 0.0, 0.0, 0.0; -1.1, -2.38, -0.85],
            c: dmatrix![7.7, 1.0, 1.0; 1.0, 0.0, 0.0; 6.0, 1.0, 1.0],
            d: dmatrix![0.0, 1.7, 0.0; 0.0, 0.0, 0.0; 0.0, 0.0, 0.0],
        }
    }

    fn both(system: &StateSpace, blocks: &[Block]) -> (f64, f64) {
        let found = mu_over_frequency(system, &Structure::new(blocks.to_vec()).unwrap()).unwrap();
        (found.lower.unwrap().value, found.upper.upper)
    }

    #[test]
    fn an_isolated_region_of_instability_is_found() {
        let (lower, upper) = both(&island(), &[Block::Real(1), Block::Real(2)]);
        let exact = 11.0 / 3.0;
        assert!(
            (lower - exact).abs() < 1e-6 * exact && exact <= upper && upper < 1.0002 * exact,
            "{lower} {upper}"
        );
    }

    /// The bounds are the same in other coordinates and units of time, and with the blocks in another order.
    #[test]
    fn bounds_do_not_depend_on_the_representation() {
        let system = island();
        let rotation = dmatrix![0.6, -0.8, 0.0; 0.8, 0.6, 0.0; 0.0, 0.0, 1.0];
        let t = &rotation * crate::matrix::diagonal([1e-2, 1.0, 1e2]) * rotation.transpose();
        let back = t.clone().try_inverse().unwrap();
        let similar = StateSpace {
            a: &t * &system.a * &back,
            b: &t * &system.b,
            c: &system.c * back,
            ..system.clone()
        };
        let faster = |rate: f64| StateSpace { a: &system.a * rate, b: &system.b * rate, ..system.clone() };
        let order = [2, 0, 1];
        let permuted = StateSpace {
            b: system.b.select_columns(&order),
            c: system.c.select_rows(&order),
            d: system.d.select_rows(&order).select_columns(&order),
            ..system.clone()
        };
        let blocks = [Block::Real(1), Block::Complex(1), Block::Complex(1)];
        let known = both(&system, &blocks);
        let others = [
            both(&similar, &blocks),
            both(&faster(1e3), &blocks),
            both(&faster(1e-6), &blocks),
            both(&permuted, &[Block::Complex(1), Block::Real(1), Block::Complex(1)]),
        ];
        for other in others {
            let near = |a: f64, b: f64| (a - b).abs() < 2e-4 * b;
            assert!(near(other.0, known.0) && near(other.1, known.1), "{other:?} {known:?}");
        }
    }

    /// Two loops connected by one path, in one repeated scalar: the gain of the path has no effect, at any frequency.
    #[test]
    fn a_path_between_components_has_no_effect() {
        for gain in [0.0, 1.0, 1e4] {
            let system = StateSpace {
                a: dmatrix![-1.0, 0.0; gain, -2.0],
                b: dmatrix![1.0, 0.0; 0.0, 1.0],
                c: dmatrix![0.5, 0.0; 0.0, 0.6],
                d: dmatrix![0.0, 0.0; gain, 0.0],
            };
            let (lower, upper) = both(&system, &[Block::Real(2)]);
            assert!((lower - 0.5).abs() < 1e-9 && (0.5..0.5001).contains(&upper), "{gain}: {lower} {upper}");
        }
    }
}
