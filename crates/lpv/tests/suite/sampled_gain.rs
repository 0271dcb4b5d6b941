//! The gain of sampled loops: published bounds, and worst-case inputs found by brute force.

use crate::common;

use nalgebra::dmatrix;
use squid_lpv::analysis::Exogenous::{Any, Held};
use squid_lpv::analysis::{SampledGain, sampled_gain};
use squid_lpv::error::SystemError;
use squid_lpv::matrix::{Mat, block, symmetric_function};
use squid_lpv::partition::Group::{U, W, X, Y, Z};
use squid_lpv::plant::GeneralisedPlant;
use squid_lpv::state_space::StateSpace;

/// The bounds agree with the published ones in all their digits.
#[test]
fn bounds_agree_with_published_ones() {
    for name in ["sd01_sdhinfnorm", "sd02_sdhinfnorm_faster"] {
        let case = common::case(name);
        let (plant, k, time) = common::sampled(&case);
        let SampledGain { lower, upper } = sampled_gain(&plant, &k, time, Any).unwrap();
        let expected = |key: &str| case["expected"][key].as_f64().unwrap();
        println!(
            "{name}: {lower:.6} to {upper:.6}, published {} to {}",
            expected("lower"),
            expected("upper")
        );
        assert!(lower <= upper && upper <= lower * (1.0 + 1e-5));
        assert!(expected("lower") - 5e-5 <= lower && upper <= expected("upper") + 5e-5, "{name}");
    }
}

/// Returns the gain from inputs that are constant on each of `parts` equal parts of a sample, with the exact energy of
/// z between them: a lower bound that converges as the parts become small.
fn from_below(plant: &GeneralisedPlant, k: &StateSpace, time: f64, parts: usize) -> f64 {
    let h = time / parts as f64;
    let sizes = plant.sizes();
    let (x, u, w) = (sizes.x, sizes.u, sizes.w);
    let (n, zero) = (x + u + w, Mat::zeros);
    let generator = block(&[
        &[&plant.a(), &plant.b2(), &plant.b1()],
        &[&zero(u + w, x), &zero(u + w, u), &zero(u + w, w)],
    ]);
    let output = block(&[&[&plant.c1(), &plant.d12(), &plant.d11()]]);
    // C. F. Van Loan, IEEE Trans. Automatic Control 23(3), 1978: int e^(A't) Q e^(A t) dt.
    let energy = output.transpose() * &output;
    let e = (block(&[&[&-generator.transpose(), &energy], &[&zero(n, n), &generator]]) * h).exp();
    let step = e.view((n, n), (n, n)).into_owned();
    let energy = step.transpose() * e.view((0, n), (n, n));
    let seen = symmetric_function(&energy, |v| v.max(0.0).sqrt());
    // All signals are functions of (x, xk, w of each part).
    let states = x + k.a.nrows();
    let all = Mat::identity(states + parts * w, states + parts * w);
    let mut now = all.rows(0, x).into_owned();
    let y = plant.c2() * &now;
    let xk = all.rows(x, k.a.nrows()).into_owned();
    let commands = &k.c * &xk + &k.d * &y;
    let mut z = Vec::new();
    for part in 0..parts {
        let acts = all.rows(states + part * w, w) / h.sqrt();
        let whole = block(&[&[&now], &[&commands], &[&acts]]);
        z.push(&seen * &whole);
        now = step.rows(0, x) * whole;
    }
    let next = block(&[&[&now], &[&(&k.a * xk + &k.b * y)]]);
    let z =
        block(&z.iter().map(|z| vec![z]).collect::<Vec<_>>().iter().map(Vec::as_slice).collect::<Vec<_>>());
    let [inside, entering] = [0..states, states..states + parts * w];
    let cut = |m: &Mat, range: &std::ops::Range<usize>| m.columns_range(range.clone()).into_owned();
    let system = StateSpace {
        a: cut(&next, &inside),
        b: cut(&next, &entering),
        c: cut(&z, &inside),
        d: cut(&z, &entering),
    };
    system.from_circle_to_axis().unwrap().hinf_norm().value
}

/// Returns an unstable plant behind a lag a hundredth of the sample time, with a weight on the command and a direct
/// path from the disturbance to z.
fn stiff() -> (GeneralisedPlant, StateSpace, f64) {
    let (time, lag) = (0.1, 1e-3);
    let blocks = [
        (X, X, dmatrix![0.5, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, -1.0 / lag]),
        (X, W, dmatrix![0.3, 0.0; 0.0, 1.0; 0.0, 0.0]),
        (X, U, dmatrix![0.0; 0.0; 1.0 / lag]),
        (Z, X, dmatrix![1.0, 0.2, 0.0; 0.0, 0.0, 0.1]),
        (Z, W, dmatrix![0.4, 0.0; 0.0, 0.0]),
        (Z, U, dmatrix![0.0; 0.2]),
        (Y, X, dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0]),
    ];
    let k =
        StateSpace { a: dmatrix![0.2], b: dmatrix![0.5, 0.1], c: dmatrix![-0.4], d: dmatrix![-3.0, -2.5] };
    (GeneralisedPlant::new(vec![], &blocks).unwrap(), k, time)
}

#[test]
fn brute_force_approaches_the_gain_from_below() {
    let (published, k, time) = common::sampled(&common::case("sd01_sdhinfnorm"));
    for (plant, k, time) in [(published, k, time), stiff()] {
        let SampledGain { lower, upper } = sampled_gain(&plant, &k, time, Any).unwrap();
        let found = [16, 32, 64].map(|parts| from_below(&plant, &k, time, parts));
        println!("{found:?} below {lower:.6} to {upper:.6}");
        assert!(found.windows(2).all(|pair| pair[0] <= pair[1] * (1.0 + 1e-9)));
        assert!(found[2] < upper && found[2] > lower * (1.0 - 1e-3), "{found:?} {lower} {upper}");
    }
}

/// A component of w that is sampled directly is held: an input of the loop that is constant between ticks.
#[test]
fn inputs_sampled_without_a_state_are_held() {
    let (plant, k, time) = stiff();
    let mut parts = plant.parts.clone();
    parts.block_mut(Y, W).copy_from(&dmatrix![0.5, -0.2; 0.1, 0.3]);
    let held = GeneralisedPlant { parts, blocks: vec![] };
    let SampledGain { lower, upper } = sampled_gain(&held, &k, time, Any).unwrap();
    // The same loop has w as additional states, which jump at the ticks and are measured through C2.
    let sizes = plant.sizes();
    let (x, w, zero) = (sizes.x, sizes.w, Mat::zeros);
    let generator =
        block(&[&[&plant.a(), &plant.b2(), &plant.b1()], &[&zero(3, x), &zero(3, 1), &zero(3, w)]]);
    let output = block(&[&[&plant.c1(), &plant.d12(), &plant.d11()]]);
    let parts = 4000;
    let step = (generator * (time / parts as f64)).exp();
    let mut now = Mat::identity(x + 1 + w, x + 1 + w);
    let mut energy = Mat::zeros(x + 1 + w, x + 1 + w);
    // Simpson's rule.
    for part in 0..=parts {
        let weight = if part == 0 || part == parts { 1.0 } else { 2.0 + 2.0 * f64::from(part % 2) };
        let z = &output * &now;
        energy += z.transpose() * z * (weight * time / f64::from(parts) / 3.0);
        if part < parts {
            now = &step * now;
        }
    }
    let seen = symmetric_function(&energy, |v| v.max(0.0).sqrt());
    let (d21, one) = (held.d21() / time.sqrt(), Mat::identity(w, w) / time.sqrt());
    let begin = block(&[
        &[&Mat::identity(x, x), &zero(x, 1), &zero(x, w)],
        &[&(&k.d * plant.c2()), &k.c, &(&k.d * &d21)],
        &[&zero(w, x), &zero(w, 1), &one],
    ]);
    let next =
        block(&[&[&(now.rows(0, x) * &begin)], &[&block(&[&[&(&k.b * plant.c2()), &k.a, &(&k.b * d21)]])]]);
    let z = seen * begin;
    let cut = |m: &Mat, from: usize, count: usize| m.columns(from, count).into_owned();
    let n = x + 1;
    let system = StateSpace { a: cut(&next, 0, n), b: cut(&next, n, w), c: cut(&z, 0, n), d: cut(&z, n, w) };
    let expected = system.from_circle_to_axis().unwrap().hinf_norm().value;
    assert!(
        lower * (1.0 - 1e-9) <= expected && expected <= upper * (1.0 + 1e-9),
        "{lower} {expected} {upper}"
    );
}

/// Held inputs agree with brute force with one part; faster inputs alias to low frequencies, where this output has a
/// hundredfold weight: a measurement of a velocity disturbed by a force.
#[test]
fn inputs_faster_than_the_sampling_are_aliased() {
    let blocks = [
        (X, X, dmatrix![-0.1, 0.0; 1.0, -0.01]),
        (X, W, dmatrix![1.0; 0.0]),
        (X, U, dmatrix![1.0; 0.0]),
        (Z, X, dmatrix![0.0, 1.0]),
        (Y, X, dmatrix![1.0, 0.0]),
    ];
    let plant = GeneralisedPlant::new(vec![], &blocks).unwrap();
    // u = -10 (y + the sum of y), which takes the mean of y at the ticks to 0.
    let (time, one) = (0.1, dmatrix![1.0]);
    let k = StateSpace { a: one.clone(), b: one * time, c: dmatrix![-10.0], d: dmatrix![-10.0] };
    let held = sampled_gain(&plant, &k, time, Held).unwrap();
    let below = from_below(&plant, &k, time, 1);
    assert!(held.lower * (1.0 - 1e-9) <= below && below <= held.upper * (1.0 + 1e-9), "{held:?} {below}");
    let any = sampled_gain(&plant, &k, time, Any).unwrap();
    let (finer, finest) = (from_below(&plant, &k, time, 2), from_below(&plant, &k, time, 64));
    println!("held {held:?}, any {any:?}, in two parts {finer}");
    assert!(any.lower > 4.0 * held.upper && finer > 2.0 * held.upper && finest < any.upper);
    assert!(finest > any.lower * (1.0 - 1e-3), "{finest}");
}

/// A loop sampled fast enough has its continuous-time gain.
#[test]
fn fast_sampling_has_the_gain_in_continuous_time() {
    let blocks = [
        (X, X, dmatrix![0.0, 1.0; 0.0, -30.0]),
        (X, W, dmatrix![0.0; 30.0]),
        (X, U, dmatrix![0.0; 30.0]),
        (Z, X, dmatrix![1.0, 0.0]),
        (Y, X, dmatrix![1.0, 0.0]),
    ];
    let plant = GeneralisedPlant::new(vec![], &blocks).unwrap();
    let k = StateSpace { a: Mat::zeros(0, 0), b: Mat::zeros(0, 1), c: Mat::zeros(1, 0), d: dmatrix![-40.0] };
    let a = dmatrix![0.0, 1.0; -1200.0, -30.0];
    let closed = StateSpace { a, b: dmatrix![0.0; 30.0], c: dmatrix![1.0, 0.0], d: dmatrix![0.0] };
    let expected = closed.hinf_norm().value;
    let found = sampled_gain(&plant, &k, 1e-6, Any).unwrap();
    assert!((found.upper / expected - 1.0).abs() < 1e-4, "{found:?} {expected}");
    // The loop is unstable with 0.3 s between ticks.
    assert_eq!(sampled_gain(&plant, &k, 0.3, Any).unwrap().lower, f64::INFINITY);
}

/// The lower bound is 0, and the upper one almost 0, if nothing observable moves. A gain due to D11 only is exact.
#[test]
fn zero_and_direct_gains_are_bounded() {
    let blocks = |d: f64| {
        [
            (X, X, dmatrix![-1.0]),
            (X, W, dmatrix![1.0]),
            (X, U, dmatrix![1.0]),
            (Z, X, dmatrix![0.0]),
            (Z, W, dmatrix![d]),
            (Y, X, dmatrix![1.0]),
        ]
    };
    let k = StateSpace { a: Mat::zeros(0, 0), b: Mat::zeros(0, 1), c: Mat::zeros(1, 0), d: dmatrix![-0.5] };
    let gain =
        |d: f64| sampled_gain(&GeneralisedPlant::new(vec![], &blocks(d)).unwrap(), &k, 0.1, Any).unwrap();
    let none = gain(0.0);
    assert!(none.lower == 0.0 && none.upper < 2e-9, "{none:?}");
    let direct = gain(-3.0);
    assert!(direct.lower <= 3.0 && 3.0 <= direct.upper && direct.upper < 3.0001, "{direct:?}");
}

#[test]
fn plants_and_controllers_that_do_not_fit_are_rejected() {
    let (plant, k, time) = stiff();
    let mut messages = String::new();
    let mut refused = |plant: &GeneralisedPlant, k: &StateSpace, time| {
        let error = sampled_gain(plant, k, time, Any).unwrap_err();
        messages += &format!("{error}\n");
        error
    };
    assert_eq!(refused(&plant, &k, 0.0), SystemError::SampleTime { found: 0.0 });
    let wide = StateSpace { d: Mat::zeros(1, 3), ..k.clone() };
    let error = refused(&plant, &wide, time);
    assert!(matches!(error, SystemError::Shape { found: (1, 3), expected: (1, 2), .. }), "{error}");
    let mut parts = plant.parts.clone();
    parts.block_mut(Y, U)[0] = 0.1;
    assert_eq!(refused(&GeneralisedPlant { parts, blocks: vec![] }, &k, time), SystemError::DirectPath);
    let scheduled = common::plant(&common::case("lpv05_one_param_lossless"));
    assert_eq!(refused(&scheduled, &k, time), SystemError::Scheduled { channels: 2 });
    insta::assert_snapshot!(messages);
}
