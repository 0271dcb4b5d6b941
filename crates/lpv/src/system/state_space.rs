//! Linear time-invariant systems `x' = A x + B u, y = C x + D u` and their H-infinity norm.
//!
//! Source of the norm: S. Boyd, V. Balakrishnan, "A regularity result for the singular values of a transfer
//! matrix and a quadratically convergent algorithm for computing its L-infinity norm", Systems & Control
//! Letters 15, 1990; N. A. Bruinsma, M. Steinbuch, Systems & Control Letters 14, 1990.

use crate::matrix::{
    Mat, block, diagonal_blocks, eigenvalues, largest_complex_singular_value, largest_singular_value, solve,
    spectral_abscissa,
};
use crate::stop;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::SQRT_2;
use std::ops::Range;

/// A linear time-invariant system.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// State matrix A, n x n.
    pub a: Mat,
    /// Input matrix B, n x m.
    pub b: Mat,
    /// Output matrix C, p x n.
    pub c: Mat,
    /// Direct term D, p x m.
    pub d: Mat,
}

/// The H-infinity norm and its frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HinfNorm {
    /// The largest singular value of the frequency response, over all frequencies.
    pub value: f64,
    /// The frequency of the peak in rad/s (infinity when the direct term is the largest).
    pub frequency: f64,
}

impl StateSpace {
    /// Returns the system `y = D u`, without states.
    pub fn constant(d: Mat) -> Self {
        let (p, m) = d.shape();
        Self { a: Mat::zeros(0, 0), b: Mat::zeros(0, m), c: Mat::zeros(p, 0), d }
    }

    /// Returns the block-diagonal connection of systems, each with its own inputs and outputs.
    pub fn side_by_side(systems: &[Self]) -> Self {
        let of = |part: fn(&Self) -> &Mat| diagonal_blocks(&systems.iter().map(part).collect::<Vec<_>>());
        Self { a: of(|s| &s.a), b: of(|s| &s.b), c: of(|s| &s.c), d: of(|s| &s.d) }
    }

    /// Returns the series connection of `first` and this system; the states of `first` come first.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let zero = Mat::zeros(first.a.nrows(), self.a.nrows());
        Self {
            a: block(&[&[&first.a, &zero], &[&(&self.b * &first.c), &self.a]]),
            b: block(&[&[&first.b], &[&(&self.b * &first.d)]]),
            c: block(&[&[&(&self.d * &first.c), &self.c]]),
            d: &self.d * &first.d,
        }
    }

    /// Returns the eigenvalues of A, rad/s.
    pub fn poles(&self) -> Vec<Complex<f64>> {
        eigenvalues(&self.a)
    }

    /// Returns the same transfer function without states that are structurally unreachable or unobservable: no path of
    /// nonzero entries from an input, or to an output.
    #[must_use]
    pub fn without_idle_states(&self) -> Self {
        let n = self.a.nrows();
        let spread = |mut reached: Vec<bool>, goes: &dyn Fn(usize, usize) -> bool| {
            let mut next: Vec<usize> = (0..n).filter(|i| reached[*i]).collect();
            while let Some(from) = next.pop() {
                for to in (0..n).filter(|to| goes(from, *to)) {
                    if !std::mem::replace(&mut reached[to], true) {
                        next.push(to);
                    }
                }
            }
            reached
        };
        let driven = (0..n).map(|i| self.b.row(i).iter().any(|v| *v != 0.0)).collect();
        let driven = spread(driven, &|from, to| self.a[(to, from)] != 0.0);
        let seen = (0..n).map(|i| self.c.column(i).iter().any(|v| *v != 0.0)).collect();
        let seen = spread(seen, &|from, to| self.a[(from, to)] != 0.0);
        let kept: Vec<usize> = (0..n).filter(|i| driven[*i] && seen[*i]).collect();
        Self {
            a: self.a.select_rows(&kept).select_columns(&kept),
            b: self.b.select_rows(&kept),
            c: self.c.select_columns(&kept),
            d: self.d.clone(),
        }
    }

    /// Returns `true` if every pole has a negative real part.
    pub fn is_stable(&self) -> bool {
        spectral_abscissa(&self.a) < 0.0
    }

    /// Converts this sampled system to continuous time by `z = (1 + s)/(1 - s)`: the unit circle becomes the imaginary
    /// axis and norms are kept. `None` with a mode at -1.
    pub fn from_circle_to_axis(&self) -> Option<Self> {
        let Self { a, b, c, d } = self;
        let one = Mat::identity(a.nrows(), a.nrows());
        let p = solve(&(a + &one), &one)?;
        Some(Self { a: &p * (a - one), d: d - c * &p * b, b: &p * b * SQRT_2, c: c * p * SQRT_2 })
    }

    /// Returns this sampled system with its outputs delayed by `ticks` samples; the states of the delay come last.
    #[must_use]
    pub fn delayed(self, ticks: usize) -> Self {
        let (p, m) = self.d.shape();
        (0..ticks).fold(self, |Self { a, b, c, d }, _| Self {
            a: block(&[&[&a, &Mat::zeros(a.nrows(), p)], &[&c, &Mat::zeros(p, p)]]),
            b: block(&[&[&b], &[&d]]),
            c: block(&[&[&Mat::zeros(p, a.nrows()), &Mat::identity(p, p)]]),
            d: Mat::zeros(p, m),
        })
    }

    /// Returns the subsystem from one input to one output.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn part(&self, output: usize, input: usize) -> Self {
        self.parts(output..output + 1, input..input + 1)
    }

    /// Returns the subsystem from some inputs to some outputs.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn parts(&self, outputs: Range<usize>, inputs: Range<usize>) -> Self {
        Self {
            a: self.a.clone(),
            b: self.b.columns_range(inputs.clone()).into_owned(),
            c: self.c.rows_range(outputs.clone()).into_owned(),
            d: self.d.rows_range(outputs).columns_range(inputs).into_owned(),
        }
    }

    /// Returns `C (s I - A)^-1 B + D` at the complex frequency s; `None` at a pole. p x m.
    pub fn response(&self, s: Complex<f64>) -> Option<DMatrix<Complex<f64>>> {
        let n = self.a.nrows();
        let complex = |m: &Mat| m.map(|v| Complex::new(v, 0.0));
        let resolvent = DMatrix::from_diagonal_element(n, n, s) - complex(&self.a);
        if n == 0 {
            return Some(complex(&self.d));
        }
        let inner = resolvent.lu().solve(&complex(&self.b))?;
        Some(complex(&self.c) * inner + complex(&self.d))
    }

    /// Returns the largest singular value of the response at frequency omega (rad/s); infinity at a pole.
    pub fn gain_at(&self, omega: f64) -> f64 {
        self.response(Complex::new(0.0, omega)).map_or(f64::INFINITY, |g| largest_complex_singular_value(&g))
    }

    /// Returns the H-infinity norm to a relative accuracy of 1e-9; infinite for an unstable system. Source: see the
    /// module.
    pub fn hinf_norm(&self) -> HinfNorm {
        // One of two conjugate poles.
        self.peak_from(|poles| poles.iter().filter(|pole| pole.im >= 0.0).map(|pole| pole.norm()).collect())
    }

    /// Returns the H-infinity norm, searched from the peak frequency (rad/s) of a similar system.
    pub(crate) fn hinf_norm_near(&self, frequency: f64) -> HinfNorm {
        self.peak_from(|_| vec![frequency])
    }

    /// Returns the H-infinity norm, searched from the frequencies (rad/s) that `start` derives from the poles.
    fn peak_from(&self, start: impl Fn(&[Complex<f64>]) -> Vec<f64>) -> HinfNorm {
        let poles = self.poles();
        if !poles.iter().all(|pole| pole.re < 0.0) {
            return HinfNorm { value: f64::INFINITY, frequency: 0.0 };
        }
        let feedthrough = largest_singular_value(&self.d);
        let mut best = HinfNorm { value: feedthrough, frequency: f64::INFINITY };
        self.raise(&mut best, 0.0);
        for omega in start(&poles) {
            self.raise(&mut best, omega);
        }
        // Each round either proves the level an upper bound or finds higher points between crossings.
        for _ in 0..60 {
            stop::check();
            if best.value == 0.0 {
                break;
            }
            let level = best.value * (1.0 + 1e-10);
            let before = best.value;
            let crossings = if level < feedthrough * (1.0 + NEAR) {
                let all = self.crossings_near_feedthrough(level, &poles);
                // The gain may be above the level up to any frequency.
                all.first().into_iter().for_each(|first| self.raise(&mut best, 0.5 * first));
                all.last().into_iter().for_each(|last| self.raise(&mut best, 2.0 * last));
                all
            } else {
                self.crossings(level)
            };
            for pair in crossings.windows(2) {
                self.raise(&mut best, (pair[0] * pair[1]).sqrt());
                self.raise(&mut best, 0.5 * (pair[0] + pair[1]));
            }
            if best.value <= before * (1.0 + 1e-10) {
                break;
            }
        }
        best
    }

    /// Returns the output and the input (from 1) that dominate the peak of the response, and its frequency (rad/s).
    /// `None` if there is no finite peak.
    pub fn dominant_channel(&self) -> Option<(usize, usize, f64)> {
        let omega = self.hinf_norm().frequency;
        let response = if omega.is_finite() {
            self.response(Complex::new(0.0, omega))?
        } else {
            self.d.map(|v| Complex::new(v, 0.0))
        };
        let (output, input) = response.map(|v| v.norm()).iamax_full();
        (!response.is_empty()).then_some((output + 1, input + 1, omega))
    }

    fn raise(&self, best: &mut HinfNorm, omega: f64) {
        let value = self.gain_at(omega);
        if value > best.value {
            *best = HinfNorm { value, frequency: omega };
        }
    }

    /// Returns the frequencies at which a singular value of the response equals `level`: the imaginary eigenvalues of
    /// the Hamiltonian matrix. The level must exceed the largest singular value of D.
    fn crossings(&self, level: f64) -> Vec<f64> {
        let (a, b, c, d) = (&self.a, &self.b, &self.c, &self.d);
        let m = b.ncols();
        let r = Mat::identity(m, m) * (level * level) - d.transpose() * d;
        let Some(r_inverse) = r.try_inverse() else { return Vec::new() };
        let left = a + b * &r_inverse * d.transpose() * c;
        let upper = b * &r_inverse * b.transpose();
        let p = c.nrows();
        let lower = -(c.transpose() * (Mat::identity(p, p) + d * &r_inverse * d.transpose()) * c);
        let hamiltonian = block(&[&[&left, &upper], &[&lower, &-left.transpose()]]);
        let size = hamiltonian.amax().max(1.0);
        let mut frequencies: Vec<f64> = eigenvalues(&hamiltonian)
            .iter()
            .filter(|v| v.im >= 0.0 && v.re.abs() <= 1e-8 * (size.sqrt() + v.norm()))
            .map(|v| v.im)
            .collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies
    }

    /// Returns the crossings of a level so close to the largest singular value of D that the Hamiltonian matrix grows
    /// without bound: the finite eigenvalues s on the imaginary axis of
    ///
    /// ```text
    /// [ A      0    B             ]       [ I  0  0 ]
    /// [ -C'C  -A'  -C'D           ] - s   [ 0  I  0 ]
    /// [ D'C    B'   D'D - level^2 ]       [ 0  0  0 ]
    /// ```
    ///
    /// computed as `s = sigma + 1/mu` from the eigenvalues mu of the shifted inverse, with shifts of the size of the
    /// poles. Some of the returned values may lie off the axis.
    fn crossings_near_feedthrough(&self, level: f64, poles: &[Complex<f64>]) -> Vec<f64> {
        let (a, b, c, d) = (&self.a, &self.b, &self.c, &self.d);
        let (n, m) = b.shape();
        let none = Mat::zeros(n, n);
        let corner = d.transpose() * d - Mat::identity(m, m) * (level * level);
        let pencil = block(&[
            &[a, &none, b],
            &[&-(c.transpose() * c), &-a.transpose(), &-(c.transpose() * d)],
            &[&(d.transpose() * c), &b.transpose(), &corner],
        ]);
        let mut finite = Mat::identity(2 * n + m, 2 * n + m);
        (2 * n..2 * n + m).for_each(|i| finite[(i, i)] = 0.0);
        let mut frequencies = vec![];
        for shift in poles.iter().map(|pole| pole.norm()) {
            let Some(inverse) = (&pencil - &finite * shift).try_inverse() else { continue };
            let finite_ones = eigenvalues(&(inverse * &finite)).into_iter().map(|mu| mu.inv() + shift);
            let near =
                finite_ones.filter(|s| s.im > 0.0 && s.im.is_finite() && s.re.abs() < NEAR.sqrt() * s.norm());
            frequencies.extend(near.map(|s| s.im));
        }
        frequencies.sort_by(f64::total_cmp);
        frequencies
    }
}

/// The relative distance from the largest singular value of D within which a level is near it.
const NEAR: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// G = 1/(s^2 + 0.2 s + 1): the peak is 1/(2 zeta sqrt(1 - zeta^2)), zeta = 0.1.
    #[test]
    fn the_oscillator_peak_has_its_closed_form() {
        let g = StateSpace {
            a: dmatrix![0.0, 1.0; -1.0, -0.2],
            b: dmatrix![0.0; 1.0],
            c: dmatrix![1.0, 0.0],
            d: dmatrix![0.0],
        };
        let norm = g.hinf_norm();
        assert!((norm.value - 1.0 / (0.2 * 0.99f64.sqrt())).abs() < 1e-9);
        assert!((norm.frequency - 0.98f64.sqrt()).abs() < 1e-4);
    }

    /// A peak that is 0.14 % above the gain at infinity, which no pole's frequency shows; by a sweep over frequency.
    #[test]
    fn a_peak_little_above_the_feedthrough_is_found() {
        let g = StateSpace {
            a: dmatrix![
                -0.9479195053785315, 0.9632743596259982, -0.7540972848121538;
                -0.8052714295848731, 0.14266301593224773, 0.3962866685081658;
                0.4572607587057233, -0.610193131450027, -0.26666579685084757
            ],
            b: dmatrix![0.22859898137269088; 0.24505428138855867; 0.09386696189598855],
            c: dmatrix![
                0.7033302482390066, 0.4563101852904853, -0.9687113134748092;
                0.8165416252048243, 0.7896720902165798, -0.5389125593966659
            ],
            d: dmatrix![-0.546799482734822; -0.6383555509791737],
        };
        let norm = g.hinf_norm();
        assert!((norm.value - 0.8416835269).abs() < 1e-9, "{norm:?}");
        assert!((norm.frequency - 2.0577).abs() < 1e-3, "{norm:?}");
    }

    /// x1 is driven and observed, x2 is not driven, x3 is not observed, and x4 reaches the output through x1.
    #[test]
    fn idle_states_are_removed() {
        let g = StateSpace {
            a: dmatrix![-1.0, 0.5, 0.0, 0.7; 0.0, -2.0, 0.0, 0.0; 1.0, 0.0, -3.0, 0.0; 0.0, 0.0, 0.0, -4.0],
            b: dmatrix![1.0, 0.0; 0.0, 0.0; 0.0, 0.0; 0.0, 1.0],
            c: dmatrix![1.0, 1.0, 0.0, 0.0],
            d: dmatrix![0.0, 0.1],
        };
        let less = g.without_idle_states();
        assert_eq!(less.a, dmatrix![-1.0, 0.7; 0.0, -4.0]);
        let s = Complex::new(0.0, 0.7);
        assert!((less.response(s).unwrap() - g.response(s).unwrap()).norm() < 1e-14);
    }

    /// G(z) = 0.1/(z - 0.9) has its peak, 1, at z = 1, and 0.1/1.9 at z = -1.
    #[test]
    fn a_sampled_system_keeps_its_values_on_the_axis() {
        let g = StateSpace { a: dmatrix![0.9], b: dmatrix![1.0], c: dmatrix![0.1], d: dmatrix![0.0] };
        let axis = g.from_circle_to_axis().unwrap();
        assert!((axis.hinf_norm().value - 1.0).abs() < 1e-9);
        assert!((axis.d[0] + 0.1 / 1.9).abs() < 1e-12);
        let at = |omega: f64| {
            let s = Complex::new(0.0, omega);
            let z = (1.0 + s) / (1.0 - s);
            (g.response(z).unwrap()[0] - axis.response(s).unwrap()[0]).norm()
        };
        assert!([0.0, 0.1, 3.0].map(at).iter().all(|difference| *difference < 1e-12));
        assert!(StateSpace { a: dmatrix![-1.0], ..g }.from_circle_to_axis().is_none());
    }

    /// A delay of two samples multiplies the response by `z^-2`.
    #[test]
    fn a_delayed_output_is_a_power_of_z() {
        let g = StateSpace { a: dmatrix![0.9], b: dmatrix![1.0], c: dmatrix![0.1], d: dmatrix![0.3] };
        let z = Complex::from_polar(1.0, 0.7);
        let (now, delayed) = (g.response(z).unwrap()[0], g.delayed(2).response(z).unwrap()[0]);
        assert!((delayed - now / (z * z)).norm() < 1e-14);
    }

    #[test]
    fn unstable_systems_have_infinite_norm_and_static_ones_their_gain() {
        let unstable = StateSpace { a: dmatrix![1.0], b: dmatrix![1.0], c: dmatrix![1.0], d: dmatrix![0.0] };
        assert_eq!(unstable.hinf_norm().value, f64::INFINITY);
        let gain =
            StateSpace { a: Mat::zeros(0, 0), b: Mat::zeros(0, 1), c: Mat::zeros(1, 0), d: dmatrix![-3.0] };
        assert_eq!(gain.hinf_norm().value, 3.0);
    }
}
