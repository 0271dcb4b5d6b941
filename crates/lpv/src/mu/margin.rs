//! Small real parameters that destabilise a loop, found by search.
//!
//! A power iteration at one frequency fails for real scalars only. Here the frequency is free: along a direction delta
//! in the box a pole of the loop is followed until it reaches the axis, each delta_i is moved to the end of its range
//! that the pole's sensitivity indicates, and so on until nothing changes; then single scalars are reversed. The
//! migration of poles: G. Ferreres, J.-M. Biannic, "Reliable computation of the robustness margin for a flexible
//! aircraft", Control Engineering Practice 9, 2001.
//! aircraft", Control Engineering Practice 9, 2001.

use super::CMat;
use super::coordinates::balanced;
use super::lower::{LowerBound, Sequence, checked};
use super::structure::Structure;
use crate::matrix::{Mat, diagonal, eigenvalues, least_singular_vectors, solve};
use crate::system::StateSpace;
use nalgebra::Complex;

/// The number of starting directions.
const MARGIN_STARTS: usize = 24;

/// The largest number of steps from one start, and of rounds of reversing single scalars.
const MARGIN_STEPS: usize = 12;

/// The factor between trial sizes of delta.
const SIZE_STRIDE: f64 = 1.25;

/// The largest size of delta, relative to the smallest tried.
const LARGEST_SIZE_RATIO: f64 = 1e6;

/// Finds a small real perturbation that moves a pole of the loop to the axis. `None` if a block is not a real scalar,
/// or none is found.
pub fn real_lower_bound(system: &StateSpace, structure: &Structure) -> Option<LowerBound> {
    if !structure.is_real() {
        return None;
    }
    let system = &balanced(system, structure);
    if system.a.is_empty() {
        return None;
    }
    let sizes = structure.blocks().iter().map(|b| b.rows()).collect();
    let harmless = 1.0 / system.hinf_norm().value.max(f64::MIN_POSITIVE);
    let (smallest, harmless) = (0.1 * harmless, (1.0 - 1e-6) * harmless);
    let search = MarginSearch { system, structure, sizes, smallest, harmless };
    let count = search.sizes.len();
    let mut random = Sequence(0x2545_F491_4F6C_DD1D);
    let mut best: Option<Crossing> = None;
    for start in 0..MARGIN_STARTS {
        let direction: Vec<f64> = match start {
            0 => vec![1.0; count],
            1 => vec![-1.0; count],
            _ => (0..count).map(|_| random.sign()).collect(),
        };
        let reach = best.as_ref().map_or(LARGEST_SIZE_RATIO * search.smallest, |b| b.size);
        if let Some(found) = search.descend(direction, reach)
            && best.as_ref().is_none_or(|known| found.size < known.size)
        {
            best = Some(found);
        }
    }
    let mut best = best?;
    search.turn_single(&mut best);
    search.bound(&best)
}

/// A direction, and the size along it at which the first pole reaches the axis.
struct Crossing {
    direction: Vec<f64>,
    size: f64,
    /// The pole, on the axis to rounding.
    pole: Complex<f64>,
}

struct MarginSearch<'a> {
    system: &'a StateSpace,
    structure: &'a Structure,
    sizes: Vec<usize>,
    /// The smallest size of delta.
    smallest: f64,
    /// A size that cannot destabilise: below the inverse of the largest gain from wd to zd.
    harmless: f64,
}

impl MarginSearch<'_> {
    fn diagonal(&self, direction: &[f64], size: f64) -> Mat {
        let entries = direction.iter().zip(&self.sizes).flat_map(|(d, r)| std::iter::repeat_n(d * size, *r));
        diagonal(entries)
    }

    /// Returns A of the perturbed loop.
    fn perturbed(&self, direction: &[f64], size: f64) -> Option<Mat> {
        let s = self.system;
        let delta = self.diagonal(direction, size);
        let n = delta.nrows();
        let inner = solve(&(Mat::identity(n, n) - &delta * &s.d), &(&delta * &s.c))?;
        Some(&s.a + &s.b * inner)
    }

    fn rightmost(&self, direction: &[f64], size: f64) -> Option<Complex<f64>> {
        let values = eigenvalues(&self.perturbed(direction, size)?);
        values.into_iter().max_by(|a, b| a.re.total_cmp(&b.re))
    }

    /// Returns the first crossing along a direction, up to a size.
    fn crossing(&self, direction: &[f64], farthest: f64) -> Option<Crossing> {
        let mut low = self.smallest.min(farthest / SIZE_STRIDE);
        let mut high = low;
        loop {
            high = (high * SIZE_STRIDE).min(farthest);
            if high > self.harmless && self.rightmost(direction, high)?.re >= 0.0 {
                break;
            }
            low = high;
            if high >= farthest {
                return None;
            }
        }
        let pole = self.narrow(direction, &mut low, &mut high)?;
        Some(Crossing { direction: direction.to_vec(), size: high, pole })
    }

    /// Locates the size at which the rightmost pole reaches the axis, between one at which it is left of the axis and
    /// one at which it is not, by false position with the Illinois rule (M. Dowell, P. Jarratt, BIT 11, 1971), and by
    /// bisection if that is slow. Returns the pole at the larger size.
    fn narrow(&self, direction: &[f64], low: &mut f64, high: &mut f64) -> Option<Complex<f64>> {
        let mut pole = self.rightmost(direction, *high)?;
        let (mut at_low, mut at_high) = (self.rightmost(direction, *low)?.re, pole.re);
        let mut kept = 0;
        for step in 1..200 {
            let width = *high - *low;
            if width <= 2.0 * f64::EPSILON * *high {
                break;
            }
            let part = at_low / (at_low - at_high);
            let halve = step % 4 == 0 || !(part > 0.0 && part < 1.0);
            let next = (*low + if halve { 0.5 } else { part } * width)
                .clamp(*low + f64::EPSILON * *high, *high - f64::EPSILON * *high);
            let rightmost = self.rightmost(direction, next)?;
            let value = rightmost.re;
            if value >= 0.0 {
                (*high, at_high, pole) = (next, value, rightmost);
                at_low *= if kept == -1 { 0.5 } else { 1.0 };
                kept = -1;
            } else {
                (*low, at_low) = (next, value);
                at_high *= if kept == 1 { 0.5 } else { 1.0 };
                kept = 1;
            }
        }
        Some(pole)
    }

    /// Returns the end of the range of each scalar that moves the pole to the right.
    fn towards_instability(&self, at: &Crossing) -> Option<Vec<f64>> {
        let a = self.perturbed(&at.direction, at.size)?;
        let n = a.nrows();
        let shifted = a.map(|v| Complex::new(v, 0.0)) - CMat::identity(n, n) * at.pole;
        let (u, v) = least_singular_vectors(&shifted)?;
        let product = u.dotc(&v);
        if product.norm() < 1e-12 {
            return None;
        }
        let delta = self.diagonal(&at.direction, at.size);
        let s = self.system;
        let m = delta.nrows();
        // dA = B (I - Delta D)^-1 dDelta (I - D Delta)^-1 C
        let left = s.b.clone() * solve(&(Mat::identity(m, m) - &delta * &s.d), &Mat::identity(m, m))?;
        let right = solve(&(Mat::identity(m, m) - &s.d * &delta), &s.c)?;
        let complex = |m: &Mat| m.map(|v| Complex::new(v, 0.0));
        let (row, column) = (u.adjoint() * complex(&left), complex(&right) * v);
        let mut top = 0;
        let slopes = self.sizes.iter().zip(&at.direction).map(|(r, old)| {
            let sum: Complex<f64> = (top..top + r).map(|k| row[k] * column[k]).sum();
            top += r;
            let slope = (sum / product).re;
            if slope == 0.0 { *old } else { slope.signum() }
        });
        Some(slopes.collect())
    }

    /// Returns the smallest crossing found from a direction; `reach` is the best known size.
    fn descend(&self, direction: Vec<f64>, reach: f64) -> Option<Crossing> {
        // A first direction may need a larger size than the best known.
        let mut best = self.crossing(&direction, (reach * 8.0).min(LARGEST_SIZE_RATIO * self.smallest))?;
        for _ in 0..MARGIN_STEPS {
            let next = self.towards_instability(&best)?;
            if next == best.direction {
                break;
            }
            match self.crossing(&next, best.size * (1.0 - 1e-9)) {
                Some(found) => best = found,
                None => break,
            }
        }
        Some(best)
    }

    /// Reverses single scalars, and sets them to zero, as long as that reduces the size.
    fn turn_single(&self, best: &mut Crossing) {
        for _ in 0..MARGIN_STEPS {
            let before = best.size;
            for k in 0..self.sizes.len() {
                for value in [-best.direction[k], 0.0] {
                    let mut direction = best.direction.clone();
                    direction[k] = value;
                    if let Some(found) = self.crossing(&direction, best.size * (1.0 - 1e-9)) {
                        *best = found;
                    }
                }
            }
            if best.size == before {
                return;
            }
        }
    }

    /// Returns the perturbation, with the singular matrix verified.
    fn bound(&self, at: &Crossing) -> Option<LowerBound> {
        let omega = at.pole.im.abs();
        let m = self.system.response(Complex::new(0.0, omega))?;
        let delta = self.diagonal(&at.direction, at.size).map(|v| Complex::new(v, 0.0));
        let bound = checked(&m, self.structure, delta)?;
        Some(LowerBound { frequency: Some(omega), ..bound })
    }
}
