//! The proof, step by step.

use crate::certificate::{Certificate, Rows};
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
        Ok(Theorem::of(self))
    }
}

impl Claimed<'_> {
    fn prove(&self, closed: &ClosedLoop) -> Result<(), Failure> {
        self.positive("gamma", self.gamma)?;
        self.lambda.map_or(Ok(()), |lambda| self.positive("lambda", lambda))?;
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
        self.definite(Proved::X, "positive", &whole("x", &proof.x))?;
        self.definite(Proved::S, "positive", &whole("zt", &proof.s))?;
        self.definite(Proved::Inequality, "negative", &inequality(closed, &proof))
    }

    fn positive(&self, name: &'static str, found: f64) -> Result<(), Failure> {
        if found > 0.0 { Ok(()) } else { Err(Failure::NotPositive { claim: self.claim, name, found }) }
    }

    /// The rows are eliminated from the last block, -gamma I, upwards: its entries and those of S have few
    /// digits, which keeps the minors short.
    fn definite(&self, matrix: Proved, sign: &'static str, blocked: &Blocked) -> Result<(), Failure> {
        let negative = sign == "negative";
        let m = if negative { &blocked.matrix.negated() } else { &blocked.matrix };
        let order: Vec<usize> = (0..m.rows).rev().collect();
        positive_definite(m, &order).map_err(|wrong| {
            let (block, row_in_block) = blocked.locate(wrong.row);
            let value = wrong.value / blocked.scale.to_f64();
            let pivot = if negative { -value } else { value };
            let exactly_zero = wrong.exactly_zero;
            let (claim, row) = (self.claim, wrong.row);
            Failure::NotDefinite { claim, matrix, sign, row, block, row_in_block, pivot, exactly_zero }
        })
    }
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
