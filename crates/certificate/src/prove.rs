//! The proof, step by step.

use crate::bounded_rate::SlowInequality;
use crate::certificate::{AnyRate, BoundedRate, Certificate, Energy, Limits, Residual, Rows, Slow};
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
    gamma: Dyadic,
    lambda: Option<f64>,
    x: Lyapunov<'a>,
    s: &'a Rows,
    t: &'a Rows,
}

/// A Lyapunov matrix as in the file.
enum Lyapunov<'a> {
    /// X.
    Itself(&'a Rows),
    /// V with `X = V'V`.
    Factor(&'a Rows),
}

impl AnyRate {
    fn lyapunov(&self) -> Lyapunov<'_> {
        if self.v.is_empty() { Lyapunov::Itself(&self.x) } else { Lyapunov::Factor(&self.v) }
    }
}

impl Lyapunov<'_> {
    /// X, without rounding.
    fn matrix(&self, claim: Claim) -> Result<Matrix, Failure> {
        match self {
            Self::Itself(x) => symmetric(claim, Proved::X, x).map(|()| Matrix::square(x)),
            Self::Factor(v) => {
                let v = Matrix::square(v);
                Ok(v.transpose().times(&v))
            }
        }
    }
}

impl Certificate {
    /// Proves every claim of the certificate in exact arithmetic.
    ///
    /// # Errors
    /// [`Failure`], the first condition that is violated. The claim may still be true, with other X, S, T.
    pub fn prove(&self) -> Result<Theorem, Failure> {
        self.check()?;
        if let Some(any_rate) = &self.any_rate {
            let nominal = Claimed {
                claim: Claim::Nominal,
                gamma: Dyadic::from_f64(any_rate.gamma),
                lambda: None,
                x: any_rate.lyapunov(),
                s: &any_rate.s,
                t: &any_rate.t,
            };
            nominal.prove(&ClosedLoop::new(self, None)?)?;
        }
        if let Some(r) = &self.residual {
            let robust = Claimed {
                claim: Claim::WithModelError,
                gamma: Dyadic::from_f64(r.gamma),
                lambda: Some(r.lambda),
                x: Lyapunov::Itself(&r.x),
                s: &r.s,
                t: &r.t,
            };
            robust.prove(&ClosedLoop::new(self, Some(r))?)?;
        }
        if let Some(bounded) = &self.bounded_rate {
            self.prove_bounded(bounded)?;
        }
        if let Some((limits, error)) = self.limits.as_ref().zip(self.residual.as_ref()) {
            self.prove_limits(limits, error)?;
        }
        self.energy.as_ref().map_or(Ok(()), |energy| self.prove_energy(energy))?;
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

    /// The claim with limits: a step leaves x within `x'Xx < beta`, taken back within `4 beta`; there H x leaves half
    /// of each limit, or all of it; and x'Xx decreases.
    fn prove_limits(&self, l: &Limits, error: &Residual) -> Result<(), Failure> {
        let claim = Claim::WithLimits;
        for (name, found) in [("size", l.size), ("decay", l.decay), ("beta", l.beta)] {
            positive(claim, name, found)?;
        }
        l.limits.iter().try_for_each(|limit| positive(claim, "a limit", *limit))?;
        let [size, decay, beta] = [l.size, l.decay, l.beta].map(Dyadic::from_f64);
        let closed = ClosedLoop::limited(self, l, error)?;
        let with_limits = Claimed {
            claim,
            gamma: &decay * &beta,
            lambda: Some(l.lambda),
            x: Lyapunov::Itself(&l.x),
            s: &beside(&l.s, &l.u),
            t: &beside(&l.t, &vec![0.0; l.u.len()]),
        };
        with_limits.prove(&closed)?;
        let too_large = |beyond: String| Failure::TooLarge { size: l.size, beyond };
        let x = Matrix::from_rows(&l.x, closed.states);
        let held = Matrix::from_rows(&vec![l.x_held.clone()], closed.states).scaled(&size);
        let level = &held.times(&x).times(&held.transpose())[(0, 0)];
        if !(&beta + &-level).is_positive() {
            return Err(too_large("takes x'Xx to beta, or above it".into()));
        }
        for (j, (limit, u)) in l.limits.iter().zip(&l.u_held).enumerate() {
            let used = (&size * &Dyadic::from_f64(*u)).abs().shifted(1);
            if (&used + &-&Dyadic::from_f64(*limit)).is_positive() {
                return Err(too_large(format!("takes more than half of limit {j}")));
            }
        }
        out_of_reach(claim, (&x, &l.h, &l.limits), (&beta.shifted(2), Proved::Limit))
    }

    /// The claims of bounded energy: x leaves `x'Xx <= gamma beta` for no w of the energy beta, there H x leaves each
    /// limit out of reach, and the inequality is that of the gain.
    fn prove_energy(&self, energy: &Energy) -> Result<(), Failure> {
        for (claim, c) in (0..).map(Claim::OfEnergy).zip(&energy.claims) {
            positive(claim, "beta", c.beta)?;
            energy.limits.iter().try_for_each(|limit| positive(claim, "a limit", *limit))?;
            let closed = ClosedLoop::with_energy(self, &energy.e, &c.h)?;
            let gamma = Dyadic::from_f64(c.gamma);
            let level = &gamma * &Dyadic::from_f64(c.beta);
            let with_limits = Claimed {
                claim,
                gamma,
                lambda: None,
                x: Lyapunov::Itself(&c.x),
                s: &beside(&c.s, &c.u),
                t: &beside(&c.t, &vec![0.0; c.u.len()]),
            };
            with_limits.prove(&closed)?;
            let x = Matrix::from_rows(&c.x, closed.states);
            out_of_reach(claim, (&x, &c.h, &energy.limits), (&level, Proved::LimitOfEnergy))?;
        }
        Ok(())
    }
}

/// `[X h_j'; h_j limit_j^2/level]` is positive definite for each command: |h_j x| is below its limit where x'Xx is at
/// most the level.
fn out_of_reach(
    claim: Claim,
    (x, h, limits): (&Matrix, &Rows, &[f64]),
    (level, name): (&Dyadic, fn(usize) -> Proved),
) -> Result<(), Failure> {
    let n = x.rows;
    for (command, (limit, h)) in limits.iter().zip(h).enumerate() {
        // The last row and column times the level.
        let limit = Dyadic::from_f64(*limit);
        let row = Matrix::from_rows(&vec![h.clone()], n).scaled(level);
        let mut whole = Matrix::scalar(n + 1, &(level * &(&limit * &limit)));
        whole.place(0, 0, x);
        whole.place(n, 0, &row);
        whole.place(0, n, &row.transpose());
        let blocks = vec![("x", n), ("limit", 1)];
        let whole = Blocked { matrix: whole, blocks, scale: Dyadic::from_f64(1.0) };
        definite(claim, name(command), "positive", &whole)?;
    }
    Ok(())
}

/// `blkdiag(m, diag(more))`.
fn beside(m: &Rows, more: &[f64]) -> Rows {
    let (n, all) = (m.len(), m.len() + more.len());
    let entry = |i: usize, j: usize| match (i < n, j < n) {
        (true, true) => m[i][j],
        (false, false) if i == j => more[i - n],
        _ => 0.0,
    };
    (0..all).map(|i| (0..all).map(|j| entry(i, j)).collect()).collect()
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
        definite(self.claim, Proved::Coefficient(0), "positive", &whole("x", &middle))?;
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
        positive(self.claim, "gamma", self.gamma.to_f64())?;
        self.lambda.map_or(Ok(()), |lambda| positive(self.claim, "lambda", lambda))?;
        let x = self.x.matrix(self.claim)?;
        symmetric(self.claim, Proved::S, self.s)?;
        skew(self.claim, Proved::T, self.t)?;
        commuting(self.claim, Proved::S, self.s, &closed.parameters)?;
        commuting(self.claim, Proved::T, self.t, &closed.parameters)?;
        let proof = Proof {
            gamma: self.gamma.clone(),
            lambda: Dyadic::from_f64(self.lambda.unwrap_or(0.0)),
            x,
            s: Matrix::square(self.s),
            t: Matrix::square(self.t),
        };
        definite(self.claim, Proved::X, "positive", &whole("x", &proof.x))?;
        definite(self.claim, Proved::S, "positive", &whole("zt", &proof.s))?;
        definite(self.claim, Proved::Inequality, "negative", &inequality(closed, &proof))
    }
}

pub(crate) fn positive(claim: Claim, name: &'static str, found: f64) -> Result<(), Failure> {
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
