//! Certificate of the gain for constant parameters. See [`squid_lpv::robust::constant`] for the inequality.

use crate::claim::without_claims;
use crate::error::ProofError;
use squid_certificate::{Certificate, Claim, Constant, Filter};
use squid_lpv::controller::Controller;
use squid_lpv::matrix::{from_rows, to_rows};
use squid_lpv::model_error::ModelError;
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::robust::constant::{ConstantBound, Filters};

/// Relative tolerance between the balls of a certificate and the recomputed ones, for rounding on another processor.
const SAME_BALL: f64 = 1e-6;

/// Returns the certificate of a bound.
pub fn certificate(
    plant: &GeneralisedPlant,
    controller: &Controller,
    filters: &[Option<Filters>],
    bound: &ConstantBound,
    balls: &[ModelError],
) -> Certificate {
    let of_parameter = |(parameter, filters): (usize, &Option<Filters>)| -> Vec<Filter> {
        let each =
            |f: &Filters| f.poles.iter().map(|&pole| Filter { parameter, pole, rate: f.rate }).collect();
        filters.as_ref().map(each).unwrap_or_default()
    };
    let error = |ball: &ModelError| squid_certificate::ModelError {
        e: to_rows(&ball.e),
        f: to_rows(&ball.f),
        fw: vec![],
        fu: to_rows(&ball.fu),
    };
    let claim = Constant {
        gamma: bound.gamma,
        x: to_rows(&bound.x),
        s: to_rows(&bound.s),
        t: to_rows(&bound.t),
        lyapunov: to_rows(&bound.lyapunov),
        filters: filters.iter().enumerate().flat_map(of_parameter).collect(),
        lambdas: bound.lambdas.clone(),
    };
    Certificate {
        errors: balls.iter().map(error).collect(),
        claims: vec![Claim::Constant(claim)],
        ..without_claims(plant, controller)
    }
}

/// Checks that the balls of a certificate are the given recomputed ones.
///
/// # Errors
/// [`ProofError::WrongPlant`].
pub fn check_balls(certificate: &Certificate, balls: &[ModelError]) -> Result<(), ProofError> {
    let same = |(ball, found): (&ModelError, &squid_certificate::ModelError)| {
        let pairs = [(&ball.e, &found.e), (&ball.f, &found.f), (&ball.fu, &found.fu)];
        let without_w = found.fw.iter().flatten().all(|entry| *entry == 0.0);
        without_w
            && pairs.into_iter().all(|(expected, rows)| {
                from_rows(rows, expected.ncols()).is_some_and(|m| {
                    m.shape() == expected.shape() && (m - expected).amax() <= SAME_BALL * expected.amax()
                })
            })
    };
    if balls.len() == certificate.errors.len() && balls.iter().zip(&certificate.errors).all(same) {
        return Ok(());
    }
    Err(ProofError::WrongPlant { what: "a ball of model errors".to_owned() })
}
