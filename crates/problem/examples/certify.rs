//! Designs a controller for a generalised plant, and writes the certificate of the closed loop.
//!
//! ```text
//! cargo run --release -p squid-problem --example certify -- PROBLEM.json CERTIFICATE.json [BALL]
//! ```
//!
//! PROBLEM.json is a problem file of `squid lpv synth`. With BALL the certificate also covers errors of `[A B2]` with
//! a largest singular value up to BALL, at a gamma found by trial.

use squid_certificate::{Certificate, Claim, Gain, ModelError};
use squid_lpv::direct_path::synthesise;
use squid_lpv::matrix::{Mat, to_rows};
use squid_lpv::synthesis::Options;
use squid_problem::problem_file::{Problem, problem as read};
use squid_problem::source::Source;
use squid_proof::claim::{direct_path_rows, nominal};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [problem, output, rest @ ..] = arguments.as_slice() else {
        return Err("usage: certify PROBLEM.json CERTIFICATE.json [BALL]".into());
    };
    let Problem { plant, d22, .. } = read(&Source::read(Path::new(problem))?)?;
    let design = synthesise(&plant, &d22, Options::default())?;
    let mut certificate = nominal(&plant, &design.controller, &design.certified);
    certificate.plant.d22 = direct_path_rows(&d22);
    if let Some(ball) = rest.first() {
        certificate = with_ball(certificate, ball.parse()?).ok_or("no gamma covers that ball")?;
    }
    let start = Instant::now();
    println!("{}", certificate.prove().map_err(|failure| failure.to_string())?);
    println!("proved in {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
    std::fs::write(output, certificate.to_json()? + "\n")?;
    Ok(())
}

/// Adds the claim for `||[dA dB2]|| <= ball`, with X, S and T of the nominal claim and the first lambda and gamma of a
/// table that prove it.
fn with_ball(certificate: Certificate, ball: f64) -> Option<Certificate> {
    let nominal = certificate.gain()?.clone();
    let (n, u) = (certificate.plant.a.len(), certificate.plant.d12.first().map_or(0, Vec::len));
    let eye = |rows: usize, cols: usize, below: usize| {
        to_rows(&Mat::from_fn(rows, cols, |i, j| if i == j + below { 1.0 } else { 0.0 }))
    };
    let trials = [1.05, 1.2, 2.0];
    let lambdas = (-12..=12).map(|k| 10f64.powi(k));
    let table = trials.into_iter().flat_map(|up| lambdas.clone().map(move |lambda| (up, lambda)));
    table
        .map(|(up, lambda)| {
            let error = ModelError {
                e: to_rows(&(Mat::identity(n, n) * ball)),
                f: eye(n + u, n, 0),
                fw: vec![],
                fu: eye(n + u, u, n),
            };
            let covered = Gain { lambda: Some(lambda), gamma: nominal.gamma * up, ..nominal.clone() };
            let mut trial = Certificate { errors: vec![error], ..certificate.clone() };
            trial.claims.push(Claim::Gain(covered));
            trial
        })
        .find(|trial| trial.prove().is_ok())
}
