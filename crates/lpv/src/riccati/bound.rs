//! The gain of a closed loop without parameters, and a Lyapunov matrix that proves it.
//!
//! X is the stabilising solution of the bounded-real Riccati equation of a loop that is slightly less stable and has a
//! small multiple of each state as an output, so that the inequality of the given loop holds strictly. It is returned
//! as `X = V'V`: V in 16 digits often proves what X in 16 digits cannot. Source of the equation: K. Zhou, J. C. Doyle,
//! K. Glover, "Robust and Optimal Control", 1996, corollary 13.24.

use crate::analysis::gain_bound::GainBound;
use crate::matrix::{Mat, eigenvalues};
use crate::riccati::equations::{WideController, stabilising};
use crate::riccati::inverse::inverse;
use crate::riccati::wide::{
    Quad, Wide, cholesky, four, gramian, is_stable, narrow, scalar, stacked, symmetric, wide,
};
use crate::system::{GeneralisedPlant, StateSpace};

/// A closed loop without parameters.
pub(crate) struct WideLoop {
    a: Wide,
    b: Wide,
    c: Wide,
    d: Wide,
    /// The magnitude of the real part of the slowest mode, rad/s.
    slowest: f64,
}

impl WideLoop {
    /// Returns the loop of a plant and a controller; `None` if it is not stable.
    pub(crate) fn new(plant: &GeneralisedPlant, k: &WideController) -> Option<Self> {
        let [a, b1, b2, c1, c2] =
            [plant.a(), plant.b1(), plant.b2(), plant.c1(), plant.c2()].map(|m| wide(&m));
        let [d11, d12, d21] = [plant.d11(), plant.d12(), plant.d21()].map(|m| wide(&m));
        let WideController { a: ak, b: bk, c: ck, d: dk } = k;
        let (n, nk) = (a.nrows(), ak.nrows());
        let through = &b2 * dk;
        let a = four(&(a + &through * &c2), &(&b2 * ck), &(bk * &c2), ak);
        let slowest = eigenvalues(&narrow(&a)).iter().map(|v| v.re.abs()).fold(f64::INFINITY, f64::min);
        let direct = &d12 * dk;
        let looped = Self {
            b: stacked(&(b1 + &through * &d21), &(bk * &d21)),
            c: four(&(c1 + &direct * c2), &(d12 * ck), &Wide::zeros(0, n), &Wide::zeros(0, nk)),
            d: d11 + direct * d21,
            a,
            slowest,
        };
        is_stable(&looped.a).then_some(looped)
    }

    /// Returns the Hamiltonian matrix at a gain, for the loop with `A + s I` and the weights q on the states; `None` if
    /// the direct term alone reaches that gain.
    fn hamiltonian(&self, gain: f64, shift: f64, weights: &[Quad]) -> Option<Wide> {
        let Self { b, c, d, .. } = self;
        let gain = Quad::from_f64(gain);
        let (n, w) = (self.a.nrows(), b.ncols());
        let a = &self.a + scalar(n, Quad::from_f64(shift));
        let r = scalar(w, gain * gain) - d.transpose() * d;
        cholesky(&r)?;
        let r = inverse(&r)?.0;
        let direct = &r * d.transpose() * c;
        let left = a + b * &direct;
        let mut lower = c.transpose() * c + (d.transpose() * c).transpose() * &direct;
        weights.iter().enumerate().for_each(|(i, q)| lower[(i, i)] += *q);
        Some(four(&left, &(b * r * b.transpose()), &-lower, &-left.transpose()))
    }

    /// Returns the H2 norm `sqrt(trace(C P C'))`, `A P + P A' + B B' = 0`, of a loop without a direct term.
    pub(crate) fn h2_norm(&self) -> Option<f64> {
        let p = gramian(&self.a, &(&self.b * self.b.transpose()))?;
        Some((&self.c * p * self.c.transpose()).trace().0.max(0.0).sqrt())
    }

    fn is_below(&self, gain: f64) -> bool {
        self.hamiltonian(gain, 0.0, &[]).is_some_and(|h| stabilising(&h).is_some())
    }

    /// Returns an estimate of the H-infinity norm in 16 digits.
    pub(crate) fn guess(&self) -> f64 {
        let rounded =
            StateSpace { a: narrow(&self.a), b: narrow(&self.b), c: narrow(&self.c), d: narrow(&self.d) };
        let guess = rounded.hinf_norm().value;
        if guess.is_finite() && guess > 0.0 { guess } else { 1.0 }
    }

    /// Returns an upper bound of the H-infinity norm, within a relative 1e-5.
    pub(crate) fn norm(&self) -> Option<f64> {
        let guess = self.guess();
        let (mut low, mut high) =
            ((1.0 - 0.5 * NORM_RESOLUTION) * guess, (1.0 + 0.5 * NORM_RESOLUTION) * guess);
        let (mut above, mut below) = (self.is_below(high), !self.is_below(low));
        for _ in 0..MOST_STRIDES {
            match (above, below) {
                (true, true) => break,
                (true, false) => {
                    (low, high) = (low / STRIDE, low);
                    below = !self.is_below(low);
                }
                (false, _) => {
                    (low, high, below) = (high, high * STRIDE, true);
                    above = self.is_below(high);
                }
            }
        }
        while high > (1.0 + NORM_RESOLUTION) * low {
            let middle = (low * high).sqrt();
            if self.is_below(middle) { high = middle } else { low = middle }
        }
        above.then_some(high)
    }

    /// Returns V with `X = V'V` that proves, by elimination with 32 digits, a bound of the gain at most `slack` above
    /// the norm, relative to it, and at most `most`: the first that holds with a margin.
    pub(crate) fn bound(&self, norm: f64, most: f64, slack: f64) -> Option<GainBound> {
        let reached = self.reached()?;
        let others = RAISES.iter().flat_map(|raise| MARGINS.map(|margin| (*raise, margin)));
        TIGHTEST.into_iter().chain(others).find_map(|(raise, margin)| {
            crate::stop::check();
            let gain = (1.0 + raise * slack) * norm;
            if gain <= most { self.shown(gain, margin, &reached) } else { None }
        })
    }

    /// Returns the diagonal of the reachability gramian.
    fn reached(&self) -> Option<Vec<Quad>> {
        let gramian = gramian(&self.a, &(&self.b * self.b.transpose()))?;
        let sizes: Vec<f64> = gramian.diagonal().iter().map(|v| v.0).collect();
        let most = sizes.iter().copied().fold(0.0, f64::max);
        let floor = if most > 0.0 { UNREACHED * most } else { 1.0 };
        Some(sizes.iter().map(|v| Quad::from_f64(v.max(floor))).collect())
    }

    /// Returns the coordinates T of the states after the first n in which their block of X at a gain is the identity.
    pub(crate) fn balanced_coordinates(&self, gain: f64, n: usize) -> Option<Wide> {
        let x = self.lyapunov(gain, MARGINS[0], &self.reached()?)?;
        let rest = self.a.nrows() - n;
        Some(cholesky(&x.view((n, n), (rest, rest)).into_owned())?.transpose())
    }

    /// Returns X times the gain.
    fn lyapunov(&self, gain: f64, margin: Margin, reached: &[Quad]) -> Option<Wide> {
        let Margin { shift, share } = margin;
        let weight = Quad::from_f64(2.0 * self.slowest * (share * gain).powi(2));
        let weights: Vec<Quad> = reached.iter().map(|p| weight / *p).collect();
        stabilising(&self.hamiltonian(gain, shift * self.slowest, &weights)?)
    }

    fn shown(&self, gain: f64, margin: Margin, reached: &[Quad]) -> Option<GainBound> {
        let x = self.lyapunov(gain, margin, reached)?;
        let v = narrow(&cholesky(&(x * Quad::from_f64(1.0 / gain)))?.transpose());
        let shown = self.shows(gain, &v);
        let x = symmetric(&(wide(&v.transpose()) * wide(&v)));
        let none = Mat::zeros(0, 0);
        shown.then(|| GainBound {
            gamma: gain,
            x: narrow(&x),
            factor: Some(v),
            s: none.clone(),
            t: none,
            lambda: 0.0,
            largest_eigenvalue: -f64::MIN_POSITIVE,
        })
    }

    /// Returns `true` if `X = V'V` satisfies the bounded-real inequality at a gain, by elimination with 32 digits and
    /// with a margin over their rounding.
    fn shows(&self, gain: f64, v: &Mat) -> bool {
        let v = wide(v);
        let x = v.transpose() * v;
        let lyapunov = &x * &self.a;
        let (n, w, z) = (self.a.nrows(), self.b.ncols(), self.c.nrows());
        let gamma = Quad::from_f64(gain);
        let inner = four(&scalar(w, gamma), &-self.d.transpose(), &-self.d.clone(), &scalar(z, gamma));
        let lower = four(&-(&x * &self.b), &-self.c.transpose(), &Wide::zeros(0, w), &Wide::zeros(0, z));
        let mut full = four(&inner, &lower.transpose(), &lower, &-(lyapunov.transpose() + lyapunov));
        (0..full.nrows()).for_each(|i| full[(i, i)] *= Quad::ONE - Quad::from_f64(CLEAR));
        debug_assert_eq!(full.nrows(), n + w + z);
        cholesky(&full).is_some()
    }
}

/// The fraction by which the diagonal of an inequality is reduced before it is checked.
const CLEAR: f64 = 1e-22;

/// The increases of the bound over the norm, relative to the slack.
const RAISES: [f64; 6] = [0.1, 0.2, 0.3, 0.05, 0.5, 1.0];

/// The margin that makes the inequality of the given loop strict.
#[derive(Clone, Copy)]
struct Margin {
    /// The shift of the modes, relative to the slowest.
    shift: f64,
    /// The weight of the states as outputs, as a fraction of the gain.
    share: f64,
}

const fn margin(shift: f64, share: f64) -> Margin {
    Margin { shift, share }
}

/// Increases and margins of tight bounds, tried first.
const TIGHTEST: [(f64, Margin); 2] = [(3e-3, margin(1e-3, 3e-3)), (2e-2, margin(1e-3, 1e-2))];

const MARGINS: [Margin; 4] = [margin(1e-2, 0.1), margin(1e-3, 0.1), margin(1e-2, 1e-2), margin(1e-3, 1e-2)];

/// A state's gramian entry, relative to the largest, below which the state is taken as not reachable.
const UNREACHED: f64 = 1e-20;

/// The relative width of the bracket of the norm.
pub(crate) const NORM_RESOLUTION: f64 = 1e-5;
const STRIDE: f64 = 2.0;
const MOST_STRIDES: usize = 60;
