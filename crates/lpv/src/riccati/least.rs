//! A bracket of the least gain that a controller achieves.

use crate::matrix::{eigenvalues, kernel, largest_singular_value};
use crate::riccati::equations::WidePlant;
use crate::riccati::inverse::inverse;
use crate::riccati::wide::{Quad, Wide, concatenated, scalar, stacked};
use crate::synthesis::regularity::Regularisation;
use crate::system::{GeneralisedPlant, coarse_grid};

/// A bracket of the least gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bracket {
    /// A gain at which a controller exists, according to the equations.
    pub(crate) upper: f64,
    /// A gain at which none exists.
    pub(crate) lower: f64,
}

/// The relative width of the bracket.
const RESOLUTION: f64 = 5e-7;

/// The factor between gains until a bracket is found.
const STRIDE: f64 = 8.0;

/// The largest number of strides from the first guess.
const MOST_STRIDES: usize = 16;

/// Returns the least gain of a plant without parameters; `None` if no bracket is found.
///
/// The upper bound is that of a plant with a slightly larger half plane, the lower bound that of one with a slightly
/// smaller one, or the gain at infinite frequency that no controller changes, `|P D11|` and `|D11 N|`. If the two leave
/// a gap, smaller shifts are tried.
///
/// If there are more measurements than disturbances that reach them, or more controls than outputs that they reach, the
/// upper bound is that of the plant with a small noise or weight added, the lower bound that of one equation alone.
pub(crate) fn least_gain(plant: &GeneralisedPlant) -> Option<Bracket> {
    let half_plane = HalfPlane::of(plant);
    let mut best = Bracket { upper: f64::INFINITY, lower: half_plane.direct };
    let mut last = None;
    for shift in SHIFTS {
        let guess = if best.upper.is_finite() { best.upper } else { 1.0 };
        // A smaller half plane has no larger gain, except by rounding: its own bracket is then not computed.
        let enlarged =
            half_plane.enlarged(shift).filter(|p| best.upper.is_infinite() || p.is_solved(best.upper));
        let reached = enlarged.and_then(|p| p.bracket(guess, WidePlant::is_solved));
        let Some(found) = reached.or(last) else { continue };
        last = Some(found);
        best.upper = best.upper.min(found.upper);
        let none = |gain: &f64| half_plane.is_none_within(*gain, shift);
        let near = [found.lower, (1.0 - NEAR) * found.lower].into_iter().find(none);
        let smaller = half_plane.moved(-shift);
        let lower_by = |part: &Part| Some(smaller.as_ref()?.bracket(found.lower, *part)?.lower).filter(none);
        let lower = near.or_else(|| half_plane.parts().iter().filter_map(lower_by).reduce(f64::max));
        best.lower = best.lower.max(lower.unwrap_or(0.0));
        if best.lower >= (1.0 - NARROW) * best.upper {
            break;
        }
    }
    // Rounding may put the lower bound above the upper one.
    best.lower = best.lower.min(best.upper);
    best.upper.is_finite().then_some(best)
}

/// Returns `true` if it is shown, in floating point, that no controller has a smaller gain even for one of a few
/// constant parameter values.
pub(crate) fn is_none_below(plant: &GeneralisedPlant, gain: f64) -> bool {
    let at =
        |theta: &Vec<f64>| plant.frozen(theta).is_ok_and(|frozen| HalfPlane::of(&frozen).is_none_below(gain));
    coarse_grid(plant.blocks.len()).iter().any(at)
}

/// Returns `true` if the 16 digits of the numbers of a plant without parameters determine its least gain to a relative
/// `part`: that of plants with every number perturbed in the last digit is the same.
pub(crate) fn is_determined(plant: &GeneralisedPlant, gain: f64, part: f64) -> bool {
    let (below, above) = ((1.0 - part) * gain, (1.0 + part) * gain);
    (1..=ROUNDED_OTHERWISE).all(|seed| {
        let mut state = seed;
        let other = plant.changed(|parts| parts.map(|v| v * (1.0 + f64::EPSILON * random(&mut state))));
        let half_plane = HalfPlane::of(&other);
        let reached = |shift: &f64| half_plane.enlarged(*shift).is_some_and(|p| p.is_solved(above));
        SHIFTS.iter().any(reached) && half_plane.is_none_below(below)
    })
}

/// The number of perturbed plants.
const ROUNDED_OTHERWISE: u64 = 2;

/// Returns a number from -1 to 1. Source of the constants: D. E. Knuth, "The Art of Computer Programming" 2, MMIX.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A plant and the rates, rad/s, relative to which its half plane's boundary is shifted.
struct HalfPlane {
    plant: WidePlant,
    slowest: f64,
    fastest: f64,
    /// The larger of `|P D11|` and `|D11 N|`, a lower bound of the gain.
    direct: f64,
    /// The plant as given, if at no frequency all controls are weighted and all measurements disturbed.
    deficient: Option<GeneralisedPlant>,
}

/// A condition on a plant and a gain that is necessary for a controller.
type Part = fn(&WidePlant, f64) -> bool;

impl HalfPlane {
    fn of(plant: &GeneralisedPlant) -> Self {
        let rates: Vec<f64> =
            eigenvalues(&plant.a()).iter().map(|v| v.norm()).filter(|v| v.is_finite() && *v > 0.0).collect();
        let fastest = rates.iter().copied().reduce(f64::max).unwrap_or(1.0);
        let moving = rates.iter().copied().filter(|v| *v > ROUNDING_RATIO * fastest);
        let slowest = moving.fold(fastest, f64::min);
        let past = |p: &GeneralisedPlant| {
            largest_singular_value(&(kernel(&p.d12().transpose()).transpose() * p.d11()))
        };
        let direct = past(plant).max(past(&plant.dual()));
        let mut out = Self { plant: WidePlant::new(plant), slowest, fastest, direct, deficient: None };
        if !out.moved(SHIFTS[0]).is_some_and(|p| p.is_regular()) {
            out.deficient = Some(plant.clone());
        }
        out
    }

    /// Returns the plant with a larger half plane, and with the weights and noises that it lacks at every frequency.
    fn enlarged(&self, shift: f64) -> Option<WidePlant> {
        let Some(given) = &self.deficient else { return self.moved(shift) };
        let plant = WidePlant::new(&Regularisation::new(given, shift.sqrt()).apply(given));
        Self { plant, deficient: None, ..*self }.moved(shift)
    }

    /// Returns the necessary conditions that decide on a lower bound.
    fn parts(&self) -> &[Part] {
        if self.deficient.is_none() {
            &[WidePlant::is_solved]
        } else {
            &[WidePlant::is_first_solved, WidePlant::is_second_solved]
        }
    }

    fn moved(&self, shift: f64) -> Option<WidePlant> {
        self.plant.shifted(shift * self.slowest, shift / self.fastest)
    }

    fn is_none_below(&self, gain: f64) -> bool {
        self.direct > gain || SHIFTS.iter().any(|shift| self.is_none_within(gain, *shift))
    }

    /// Returns `true` if a shift and a smaller one both show that none exists; rounding would not let them agree. If
    /// the equations have no solution at a larger gain either, they do not apply.
    fn is_none_within(&self, gain: f64, shift: f64) -> bool {
        self.parts().iter().any(|part| {
            let fits = |p: &WidePlant| (1..=LARGER_GAINS).any(|k| part(p, gain * STRIDE.powi(k)));
            let none = |shift: f64| self.moved(-shift).is_some_and(|p| !part(&p, gain) && fits(&p));
            none(shift) && none(SMALLER * shift)
        })
    }
}

/// Modes slower than this, relative to the fastest, are taken as constant.
const ROUNDING_RATIO: f64 = 1e-14;

/// The shifts of the boundary of the half plane, relative to the slowest mode, and at infinity to the fastest.
const SHIFTS: [f64; 3] = [1e-9, 1e-12, 1e-14];

/// The factor of the smaller shift, for lower bounds.
const SMALLER: f64 = 1e-2;

/// The relative width at which a bracket is narrow enough.
const NARROW: f64 = 5e-4;

/// The number of larger gains tried.
const LARGER_GAINS: i32 = 6;

/// The relative distance from the upper bound at which a lower one is tried first.
const NEAR: f64 = 2e-4;

impl WidePlant {
    fn is_solved(&self, gain: f64) -> bool {
        self.solve(gain).is_some()
    }

    fn is_first_solved(&self, gain: f64) -> bool {
        self.first(Quad::from_f64(gain)).is_some()
    }

    fn is_second_solved(&self, gain: f64) -> bool {
        self.dual().is_first_solved(gain)
    }

    /// Returns the bracket of the least gain at which a condition holds, searched from a guess; `None` if the condition
    /// has the same value at all gains tried.
    fn bracket(&self, guess: f64, part: Part) -> Option<Bracket> {
        let reached = |gain: f64| {
            crate::stop::check();
            part(self, gain)
        };
        let up = reached(guess);
        let (mut upper, mut lower) = (guess, guess);
        for _ in 0..MOST_STRIDES {
            let next = if up { lower / STRIDE } else { upper * STRIDE };
            if up {
                (upper, lower) = (lower, next);
            } else {
                (upper, lower) = (next, upper);
            }
            if reached(next) != up {
                while upper > (1.0 + RESOLUTION) * lower {
                    let middle = (upper * lower).sqrt();
                    if reached(middle) { upper = middle } else { lower = middle }
                }
                return Some(Bracket { upper, lower });
            }
        }
        None
    }

    /// Returns the plant at `s = (p - e)/(1 - h p)`, in p, for small e and h of one sign.
    ///
    /// ```text
    /// E = I + h A,   A_p = E^-1 (A + e I),   B_p = q E^-1 B,   C_p = q C E^-1,   q^2 = 1 - e h,   D_p = D - h C E^-1 B
    /// ```
    ///
    /// The right half plane of p contains that of s if e and h are positive, so a gain achieved here is achieved for
    /// the given plant; if both are negative it is contained in it, so a gain not achieved here is not achieved for the
    /// given plant, by the maximum principle. Zeros on the imaginary axis and at infinity leave the axis. Source: R. Y.
    /// Chiang, M. G. Safonov, "H-infinity synthesis using a bilinear pole shifting transform", J. Guidance, Control and
    /// Dynamics 15(5), 1992.
    fn shifted(&self, e: f64, h: f64) -> Option<Self> {
        let n = self.a.nrows();
        let [e, h] = [e, h].map(Quad::from_f64);
        let unit = scalar(n, Quad::ONE);
        let root = (Quad::ONE - e * h).sqrt();
        let moved = inverse(&(&unit + &self.a * h))?.0;
        let (b, c) = (concatenated(&self.b1, &self.b2), stacked(&self.c1, &self.c2));
        let inner = &c * &moved * &b * -h;
        let (w, z) = (self.b1.ncols(), self.c1.nrows());
        let (b, c) = (&moved * b * root, c * &moved * root);
        let (u, y) = (self.b2.ncols(), self.c2.nrows());
        let part = |i: usize, j: usize, rows: usize, columns: usize| {
            inner.view((i, j), (rows, columns)).into_owned()
        };
        let d = |given: &Wide, more: Wide| given + more;
        Some(Self {
            a: moved * (&self.a + unit * e),
            b1: b.columns(0, w).into_owned(),
            b2: b.columns(w, u).into_owned(),
            c1: c.rows(0, z).into_owned(),
            c2: c.rows(z, y).into_owned(),
            d11: d(&self.d11, part(0, 0, z, w)),
            d12: d(&self.d12, part(0, w, z, u)),
            d21: d(&self.d21, part(z, 0, y, w)),
        })
    }
}
