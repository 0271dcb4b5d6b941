//! The proof, step by step.

use crate::bounded_rate::SlowInequality;
use crate::certificate::{BoundedRate, Certificate, Rows, Slow};
use crate::closed_loop::ClosedLoop;
use crate::error::{Claim, Failure, Proved};
use crate::exact::definite::positive_definite;
use crate::exact::dyadic::Dyadic;
use crate::exact::matrix::Matrix;
use crate::inequality::{Blocked, Proof, inequality};
use crate::structure::{commuting, skew, symmetric};
use crate::theorem::Theorem;

/// The matrices of one claim, as in the file.
struct Claimed<'a> {
    claim: Claim,
    gamma: f64,
    lambda: Option<f64>,
    x: &'a Rows,
    s: &'a Rows,
    t: &'a Rows,
}

impl Certificate {
    /// Proves every claim of the certificate in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated. The claim may still be true, with other X, S, T.
    pub fn prove(&self) -> Result<Theorem, Failure> {
        self.check()?;
        let nominal = Claimed {
            claim: Claim::Nominal,
            gamma: self.gamma,
            lambda: None,
            x: &self.x,
            s: &self.s,
            t: &self.t,
        };
        nominal.prove(&ClosedLoop::new(self, None)?)?;
        if let Some(r) = &self.residual {
            let robust = Claimed {
                claim: Claim::WithModelError,
                gamma: r.gamma,
                lambda: Some(r.lambda),
                x: &r.x,
                s: &r.s,
                t: &r.t,
            };
            robust.prove(&ClosedLoop::new(self, Some(r))?)?;
        }
        if let Some(bounded) = &self.bounded_rate {
            self.prove_bounded(bounded)?;
        }
        Ok(Theorem::of(self))
    }

    fn prove_bounded(&self, bounded: &BoundedRate) -> Result<(), Failure> {
        let (claim, rate) = (Claim::BoundedRate, bounded.rate);
        if rate < 0.0 {
            return Err(Failure::NegativeRate { rate });
        }
        let nominal = Slowly { claim, rate, lambda: None, slow: &bounded.slow };
        nominal.prove(&ClosedLoop::new(self, None)?)?;
        if let Some(r) = &bounded.residual {
            let (claim, lambda) = (Claim::BoundedRateWithModelError, Some(r.lambda));
            let robust = Slowly { claim, rate, lambda, slow: &r.slow };
            robust.prove(&ClosedLoop::new(self, self.residual.as_ref())?)?;
        }
        Ok(())
    }
}

/// The matrices of a claim of a bounded rate.
struct Slowly<'a> {
    claim: Claim,
    rate: f64,
    lambda: Option<f64>,
    slow: &'a Slow,
}

impl Slowly<'_> {
    fn prove(&self, closed: &ClosedLoop) -> Result<(), Failure> {
        positive(self.claim, "gamma", self.slow.gamma)?;
        self.lambda.map_or(Ok(()), |lambda| positive(self.claim, "lambda", lambda))?;
        for (k, x) in self.slow.x.iter().enumerate() {
            symmetric(self.claim, Proved::Coefficient(k), x)?;
        }
        let middle = Matrix::from_rows(&self.slow.x[0], closed.states);
        definite(self.claim, Proved::MiddleX, "positive", &whole("x", &middle))?;
        let inequality = SlowInequality::new(closed, self.slow, self.rate, self.lambda);
        let intervals = self.slow.breakpoints.windows(2).zip(&self.slow.n);
        for (i, (ends, n)) in intervals.enumerate() {
            for coefficient in inequality.coefficients(ends[0], ends[1], n) {
                definite(self.claim, Proved::OnInterval(i), "negative", &coefficient)?;
            }
        }
        Ok(())
    }
}

impl Claimed<'_> {
    fn prove(&self, closed: &ClosedLoop) -> Result<(), Failure> {
        positive(self.claim, "gamma", self.gamma)?;
        self.lambda.map_or(Ok(()), |lambda| positive(self.claim, "lambda", lambda))?;
        symmetric(self.claim, Proved::X, self.x)?;
        symmetric(self.claim, Proved::S, self.s)?;
        skew(self.claim, Proved::T, self.t)?;
        commuting(self.claim, Proved::S, self.s, &closed.parameters)?;
        commuting(self.claim, Proved::T, self.t, &closed.parameters)?;
        let exact = |m: &Rows| Matrix::from_rows(m, m.len());
        let proof = Proof {
            gamma: Dyadic::from_f64(self.gamma),
            lambda: Dyadic::from_f64(self.lambda.unwrap_or(0.0)),
            x: exact(self.x),
            s: exact(self.s),
            t: exact(self.t),
        };
        definite(self.claim, Proved::X, "positive", &whole("x", &proof.x))?;
        definite(self.claim, Proved::S, "positive", &whole("zt", &proof.s))?;
        definite(self.claim, Proved::Inequality, "negative", &inequality(closed, &proof))
    }
}

fn positive(claim: Claim, name: &'static str, found: f64) -> Result<(), Failure> {
    if found > 0.0 { Ok(()) } else { Err(Failure::NotPositive { claim, name, found }) }
}

/// The rows are eliminated from the last block, -gamma I, upwards: its entries and those of S have few
/// digits, which keeps the minors short.
fn definite(claim: Claim, matrix: Proved, sign: &'static str, blocked: &Blocked) -> Result<(), Failure> {
    let negative = sign == "negative";
    let m = if negative { &blocked.matrix.negated() } else { &blocked.matrix };
    let order: Vec<usize> = (0..m.rows).rev().collect();
    positive_definite(m, &order).map_err(|wrong| {
        let (block, row_in_block) = blocked.locate(wrong.row);
        let value = wrong.value / blocked.scale.to_f64();
        let pivot = if negative { -value } else { value };
        let exactly_zero = wrong.exactly_zero;
        let row = wrong.row;
        Failure::NotDefinite { claim, matrix, sign, row, block, row_in_block, pivot, exactly_zero }
    })
}

fn whole(name: &'static str, m: &Matrix) -> Blocked {
    Blocked { matrix: m.clone(), blocks: vec![(name, m.rows)], scale: Dyadic::from_f64(1.0) }
}

impl Blocked {
    /// The block of a row, and the row within it.
    fn locate(&self, row: usize) -> (&'static str, usize) {
        let mut start = 0;
        for &(name, size) in &self.blocks {
            if row < start + size {
                return (name, row - start);
            }
            start += size;
        }
        ("", row)
    }
}
