//! A perturbation with a large gain, found and evaluated: the lower bound of the worst-case gain.
//!
//! With u and v the singular vectors of the largest gain, `a* = u* M21 (I - Delta M11)^-1` and
//! `b = (I - M11 Delta)^-1 M12 v`, the gain changes by `Re(a* dDelta b)`: each block is moved to where that is largest,
//! as far as the gain grows. The frequencies are those of large gain; with real scalars only, the peak of the perturbed
//! loop is followed.

use super::CMat;
use super::lower::Sequence;
use super::perturbable::Perturbable;
use super::structure::Block;
use super::sweep::response;
use super::upper::product::product;
use crate::matrix::{ComplexVector, largest_complex_singular_value, largest_singular_vectors};
use crate::stop;
use nalgebra::Complex;

/// A perturbation with its gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Perturbed {
    /// The gain at the frequency.
    pub gain: f64,
    /// The frequency, rad/s; may be infinite.
    pub frequency: f64,
    /// The perturbation.
    pub delta: CMat,
}

/// The number of starting frequencies, and of perturbations at each.
const GAIN_FREQUENCIES: usize = 6;
const GAIN_STARTS: usize = 4;

/// The largest number of steps from one start, and of rounds that follow the peak.
const GAIN_STEPS: usize = 60;
const PEAK_ROUNDS: usize = 4;

/// Returns the worst perturbation found; zero if none is worse.
pub fn worst_perturbation(loop_: &Perturbable) -> Perturbed {
    let search = GainSearch { loop_, k: loop_.structure.cols(), w: loop_.structure.rows() };
    let nominal = loop_.closed(&CMat::zeros(search.w, search.k));
    let peak = nominal.as_ref().map_or(0.0, |system| system.hinf_norm().frequency);
    let mut best = Perturbed { gain: 0.0, frequency: peak, delta: CMat::zeros(search.w, search.k) };
    search.keep(&mut best, peak, &CMat::zeros(search.w, search.k));
    for omega in search.frequencies(peak) {
        for start in 0..GAIN_STARTS {
            search.search_from(&mut best, omega, start);
        }
    }
    if loop_.structure.is_real() {
        for _ in 0..PEAK_ROUNDS {
            let Some(system) = loop_.closed(&best.delta) else { break };
            let before = best.gain;
            let peak = system.hinf_norm().frequency;
            let delta = best.delta.clone();
            search.keep(&mut best, peak, &delta);
            search.improve(&mut best, peak, delta);
            if best.gain <= before * (1.0 + 1e-9) {
                break;
            }
        }
    }
    best
}

/// Returns the known perturbation, or a worse one found near another frequency or by moving the frequency.
pub(super) fn refined(loop_: &Perturbable, known: Perturbed, near: f64) -> Perturbed {
    let search = GainSearch { loop_, k: loop_.structure.cols(), w: loop_.structure.rows() };
    let mut best = known;
    for start in 0..GAIN_STARTS {
        search.search_from(&mut best, near, start);
    }
    let mut stride = STEP_STRIDE;
    for _ in 0..MOST_MOVES {
        stop::check();
        let before = best.gain;
        for omega in [best.frequency * stride, best.frequency / stride] {
            if omega.is_finite() && omega > 0.0 {
                let delta = best.delta.clone();
                search.improve(&mut best, omega, delta);
            }
        }
        if best.gain <= before * (1.0 + 1e-9) {
            stride = stride.sqrt();
        }
    }
    best
}

/// The ratio by which the frequency is moved, and the largest number of moves.
const STEP_STRIDE: f64 = 1.2;
const MOST_MOVES: usize = 16;

struct GainSearch<'a> {
    loop_: &'a Perturbable,
    /// The numbers of entries of zd and of wd.
    k: usize,
    w: usize,
}

/// The four parts of M at a frequency.
struct Parts {
    m11: CMat,
    m12: CMat,
    m21: CMat,
    m22: CMat,
}

/// A perturbed system at a frequency.
struct Evaluated {
    gain: f64,
    /// The response from w to z.
    response: CMat,
    /// The response `(I - M11 Delta)^-1 M12`.
    through: CMat,
}
impl GainSearch<'_> {
    /// Returns the peak without perturbation, and frequencies of large gain of the complete system.
    fn frequencies(&self, peak: f64) -> Vec<f64> {
        let system = &self.loop_.system;
        let mut all: Vec<(f64, f64)> = system
            .poles()
            .iter()
            .map(|p| p.norm())
            .chain([0.0])
            .filter_map(|omega| Some((largest_complex_singular_value(&response(system, omega)?), omega)))
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.dedup_by(|a, b| (a.1 - b.1).abs() <= 0.05 * b.1);
        [peak].into_iter().chain(all.into_iter().map(|(_, omega)| omega)).take(GAIN_FREQUENCIES).collect()
    }

    fn parts(&self, omega: f64) -> Option<Parts> {
        let m = response(&self.loop_.system, omega)?;
        let (k, w) = (self.k, self.w);
        let (rows, cols) = (m.nrows() - k, m.ncols() - w);
        let part = |r, c, rows, cols| m.view((r, c), (rows, cols)).into_owned();
        Some(Parts {
            m11: part(0, 0, k, w),
            m12: part(0, w, k, cols),
            m21: part(k, 0, rows, w),
            m22: part(k, w, rows, cols),
        })
    }

    /// Keeps a perturbation if it is worse than the worst so far.
    fn keep(&self, best: &mut Perturbed, omega: f64, delta: &CMat) {
        if let Some(parts) = self.parts(omega)
            && let Some(Evaluated { gain, .. }) = parts.evaluated(delta)
            && gain > best.gain
        {
            *best = Perturbed { gain, frequency: omega, delta: delta.clone() };
        }
    }

    fn search_from(&self, best: &mut Perturbed, omega: f64, start: usize) {
        let mut random = Sequence(0x9E37_79B9_7F4A_7C15 ^ (start as u64).wrapping_mul(0x2545_F491_4F6C_DD1D));
        let mut delta = CMat::zeros(self.w, self.k);
        if start > 0 {
            for (_, rows, cols) in self.loop_.structure.places() {
                let value = Complex::new(0.5 * self.loop_.size * random.sign(), 0.0);
                rows.zip(cols).for_each(|(i, j)| delta[(i, j)] = value);
            }
        }
        self.improve(best, omega, delta);
    }

    /// Increases the gain of a perturbation at a frequency as far as possible.
    fn improve(&self, best: &mut Perturbed, omega: f64, mut delta: CMat) {
        let Some(parts) = self.parts(omega) else { return };
        let Some(mut at) = parts.evaluated(&delta) else { return };
        for _ in 0..GAIN_STEPS {
            let Some((a, b)) = parts.slopes(&delta, &at) else { break };
            let aimed = self.aimed(&delta, &a, &b);
            // Try a full step, shorter ones, or one block only.
            let shorter =
                (0..4).map(|halvings| &delta + (&aimed - &delta) * Complex::new(0.5f64.powi(halvings), 0.0));
            let single = self.loop_.structure.places().into_iter().map(|(_, rows, cols)| {
                let mut one = delta.clone();
                let region = ((rows.start, cols.start), (rows.len(), cols.len()));
                one.view_mut(region.0, region.1).copy_from(&aimed.view(region.0, region.1));
                one
            });
            let better = shorter.chain(single).find_map(|next| {
                let found = parts.evaluated(&next)?;
                (found.gain > at.gain * (1.0 + 1e-10)).then_some((next, found))
            });
            let Some((next, found)) = better else { break };
            (delta, at) = (next, found);
        }
        if at.gain > best.gain {
            *best = Perturbed { gain: at.gain, frequency: omega, delta };
        }
    }

    /// Returns Delta with each block moved to where the gain grows most.
    fn aimed(&self, delta: &CMat, a: &ComplexVector, b: &ComplexVector) -> CMat {
        let size = self.loop_.size;
        self.loop_.structure.replaced(delta.clone(), |block, rows, cols| {
            let (a, b) = (a.rows(rows.start, rows.len()), b.rows(cols.start, cols.len()));
            let slope = || a.dotc(&b);
            let unit = |r: usize, value: Complex<f64>| CMat::identity(r, r) * value;
            Some(match block {
                Block::Real(r) if slope().re != 0.0 => unit(r, Complex::new(size * slope().re.signum(), 0.0)),
                Block::Complex(r) if slope().norm() > 0.0 => {
                    unit(r, slope().conj() * (size / slope().norm()))
                }
                Block::Full { .. } if a.norm() > 0.0 && b.norm() > 0.0 => {
                    a.unscale(a.norm()) * b.unscale(b.norm()).adjoint() * Complex::new(size, 0.0)
                }
                _ => return None,
            })
        })
    }
}

impl Parts {
    /// Evaluates the perturbed system.
    fn evaluated(&self, delta: &CMat) -> Option<Evaluated> {
        let k = self.m11.nrows();
        let through = (CMat::identity(k, k) - product(&self.m11, delta)).lu().solve(&self.m12)?;
        let response = &self.m22 + product(&self.m21, &product(delta, &through));
        let gain = largest_complex_singular_value(&response);
        gain.is_finite().then_some(Evaluated { gain, response, through })
    }

    /// Returns a and b of the first-order change of the gain.
    fn slopes(&self, delta: &CMat, at: &Evaluated) -> Option<(ComplexVector, ComplexVector)> {
        let w = self.m11.ncols();
        let (u, v) = largest_singular_vectors(&at.response)?;
        let back = (CMat::identity(w, w) - product(delta, &self.m11)).adjoint().lu();
        Some((back.solve(&(self.m21.adjoint() * u))?, &at.through * v))
    }
}
