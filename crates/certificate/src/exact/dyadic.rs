//! Dyadic numbers `m 2^e`: they include every f64, and their sums and products are exact.

use num_bigint::{BigInt, Sign};
use std::ops::{Add, Mul, Neg};

/// Number `mantissa 2^exponent` with an odd mantissa, or zero with exponent 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    pub(crate) fn new(mantissa: BigInt, exponent: i64) -> Self {
        match mantissa.trailing_zeros() {
            None => Self::default(),
            Some(0) => Self { mantissa, exponent },
            Some(zeros) => Self { mantissa: mantissa >> zeros, exponent: exponent + zeros as i64 },
        }
    }

    /// Returns the exact value of a finite f64: sign, 11 bits of exponent, 52 bits of mantissa (IEEE 754-2019, 3.4).
    pub(crate) fn from_f64(x: f64) -> Self {
        debug_assert!(x.is_finite());
        let bits = x.to_bits();
        let (field, fraction) = ((bits >> 52 & 0x7ff) as i64, bits & ((1 << 52) - 1));
        let (mantissa, exponent) =
            if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
        let sign = if bits >> 63 == 1 { Sign::Minus } else { Sign::Plus };
        Self::new(BigInt::from_biguint(sign, mantissa.into()), exponent)
    }

    /// Returns the nearest f64 or a neighbour of it; infinity or zero beyond the range.
    pub(crate) fn to_f64(&self) -> f64 {
        let (head, exponent) = leading(&self.mantissa, self.exponent);
        scale(head, exponent)
    }

    /// Returns the exponent of the leading bit; `None` for zero.
    pub(crate) fn magnitude(&self) -> Option<i64> {
        (!self.is_zero()).then(|| self.mantissa.bits() as i64 - 1 + self.exponent)
    }

    /// Returns the exponent of the last bit; `None` for zero.
    pub(crate) fn last_bit(&self) -> Option<i64> {
        (!self.is_zero()).then_some(self.exponent)
    }

    /// Returns the number divided by `2^unit`, which must be an integer.
    pub(crate) fn in_units(&self, unit: i64) -> BigInt {
        debug_assert!(self.is_zero() || self.exponent >= unit);
        &self.mantissa << (self.exponent - unit).max(0)
    }

    /// Returns the number in units of `2^-places`, rounded down.
    pub(crate) fn rounded(&self, places: i64) -> BigInt {
        let shift = self.exponent + places;
        if shift >= 0 { &self.mantissa << shift } else { &self.mantissa >> -shift }
    }

    /// Returns the number times `2^exponent`.
    pub(crate) fn shifted(&self, exponent: i64) -> Self {
        if self.is_zero() {
            return Self::default();
        }
        Self { mantissa: self.mantissa.clone(), exponent: self.exponent + exponent }
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.mantissa.sign() == Sign::NoSign
    }

    pub(crate) fn is_positive(&self) -> bool {
        self.mantissa.sign() == Sign::Plus
    }

    pub(crate) fn abs(&self) -> Self {
        Self { mantissa: self.mantissa.magnitude().clone().into(), exponent: self.exponent }
    }
}

/// Returns head and e with `m 2^exponent` approximately `head 2^e`, the magnitude of head in `[1, 2)`; or zero.
fn leading(m: &BigInt, exponent: i64) -> (f64, i64) {
    let bits = m.bits() as i64;
    let surplus = (bits - 64).max(0);
    let top = (m.magnitude() >> surplus).iter_u64_digits().next().unwrap_or(0);
    if top == 0 {
        return (0.0, 0);
    }
    let head = top as f64 / 2f64.powi((bits - surplus - 1) as i32);
    (if m.sign() == Sign::Minus { -head } else { head }, exponent + bits - 1)
}

/// Returns `x 2^exponent` for x of moderate size, in four factors that reach the subnormal numbers.
fn scale(x: f64, exponent: i64) -> f64 {
    let exponent = exponent.clamp(-2200, 2200) as i32;
    let half = exponent / 2;
    x * 2f64.powi(half / 2)
        * 2f64.powi(half - half / 2)
        * 2f64.powi((exponent - half) / 2)
        * 2f64.powi(exponent - half - (exponent - half) / 2)
}

/// Returns `a 2^exponent / b` in floating point.
pub(crate) fn approximate_ratio(a: &BigInt, b: &BigInt, exponent: i64) -> f64 {
    let ((a, p), (b, q)) = (leading(a, exponent), leading(b, 0));
    scale(a / b, p - q)
}

impl Add for &Dyadic {
    type Output = Dyadic;

    fn add(self, other: &Dyadic) -> Dyadic {
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        let unit = self.exponent.min(other.exponent);
        Dyadic::new(self.in_units(unit) + other.in_units(unit), unit)
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;

    fn mul(self, other: &Dyadic) -> Dyadic {
        if self.is_zero() || other.is_zero() {
            return Dyadic::default();
        }
        Dyadic { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;

    fn neg(self) -> Dyadic {
        Dyadic { mantissa: -&self.mantissa, exponent: self.exponent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sums_and_products_are_not_rounded() {
        let (a, b) = (Dyadic::from_f64(0.1), Dyadic::from_f64(0.2));
        assert_ne!(&a + &b, Dyadic::from_f64(0.1 + 0.2));
        assert_eq!(&a + &a, b);
        let tiny = Dyadic::from_f64(f64::from_bits(1));
        let sum = &(&tiny + &Dyadic::from_f64(f64::MAX)) + &Dyadic::from_f64(-f64::MAX);
        assert_eq!(sum, tiny);
        assert_eq!(Dyadic::from_f64(-0.0), Dyadic::default());
        assert!((&tiny * &tiny).is_positive());
    }

    #[test]
    fn ratios_beyond_the_range_keep_their_sign() {
        let huge = BigInt::from(-3) << 4000;
        assert_eq!(approximate_ratio(&huge, &(BigInt::from(2) << 4000), 0), -1.5);
        assert_eq!(approximate_ratio(&huge, &BigInt::from(1), 0), f64::NEG_INFINITY);
    }

    proptest! {
        #[test]
        fn every_f64_round_trips(x in prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO) {
            prop_assert_eq!(Dyadic::from_f64(x).to_f64(), x);
        }

        #[test]
        fn agrees_with_integers(a in -1_000_000_000_i64..1_000_000_000, b in -1_000_000_000_i64..1_000_000_000) {
            let d = |x: i64| Dyadic::new(x.into(), 0);
            prop_assert_eq!(&d(a) + &d(b), d(a + b));
            prop_assert_eq!(&d(a) * &d(b), d(a * b));
            prop_assert_eq!(-&d(a), d(-a));
        }
    }
}
