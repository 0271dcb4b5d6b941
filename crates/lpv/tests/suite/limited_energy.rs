//! The gain with limits on loops of published demonstrations, with their controllers, and simulations.

use lpv::anti_windup::energy::{Bounds, Limited, of_gain, with_anti_windup};
use lpv::controller::Controller;
use lpv::matrix::Mat;
use lpv::partition::Group::{U, W, X, Y, Z};
use lpv::plant::GeneralisedPlant;
use lpv::state_space::StateSpace;
use nalgebra::{DVector, dmatrix};

/// A plant `x' = A x + B sat(u)`, `y = C x` and the controller of r - y with its limits; the gain is from r to r - y.
struct Case {
    plant: [Mat; 3],
    controller: StateSpace,
    limits: Vec<f64>,
}

impl Case {
    fn loop_(&self) -> (GeneralisedPlant, Controller) {
        let ([a, b, c], k) = (&self.plant, &self.controller);
        let y = c.nrows();
        let one = Mat::identity(y, y);
        let parts = [
            (X, X, a.clone()),
            (X, W, Mat::zeros(a.nrows(), y)),
            (X, U, b.clone()),
            (Z, X, -c),
            (Z, W, one.clone()),
            (Y, X, -c),
            (Y, W, one),
        ];
        let parts_of_k = [(X, X, k.a.clone()), (X, Y, k.b.clone()), (U, X, k.c.clone()), (U, Y, k.d.clone())];
        (GeneralisedPlant::new(vec![], &parts).unwrap(), Controller::new(vec![], &parts_of_k).unwrap())
    }

    fn bounds(&self, gain: Option<&Mat>) -> (f64, Bounds) {
        let (plant, controller) = self.loop_();
        let gamma = 1.01 * plant.close(&controller).frozen(&[]).unwrap().hinf_norm().value;
        let units = Mat::zeros(0, 0);
        let limited =
            Limited { plant: &plant, controller: &controller, gamma, units: &units, limits: &self.limits };
        let found = match gain {
            Some(gain) => of_gain(limited, gain),
            None => with_anti_windup(limited),
        };
        (gamma, found.unwrap())
    }

    /// The energies of r and of r - y, the latter also after `late`, and the largest saturated part of u.
    fn fly(&self, gain: &Mat, seconds: f64, late: f64, r: impl Fn(f64) -> DVector<f64>) -> [f64; 4] {
        let ([a, b, c], k) = (&self.plant, &self.controller);
        let tick = 1e-5 * seconds;
        let (mut x, mut xk) = (DVector::zeros(a.nrows()), DVector::zeros(k.a.nrows()));
        let rates = |x: &DVector<f64>, xk: &DVector<f64>, r: &DVector<f64>| {
            let e = r - c * x;
            let u = &k.c * xk + &k.d * &e;
            let sat = DVector::from_fn(u.len(), |j, _| u[j].clamp(-self.limits[j], self.limits[j]));
            let phi = &u - &sat;
            (a * x + b * sat, &k.a * xk + &k.b * &e + gain * &phi, e, phi.amax())
        };
        let mut sums = [0.0; 4];
        for i in 0..100_000 {
            let now = f64::from(i) * tick;
            let r = r(now);
            let (xd, xkd, ..) = rates(&x, &xk, &r);
            let (xd, xkd, e, phi) = rates(&(&x + xd * (0.5 * tick)), &(&xk + xkd * (0.5 * tick)), &r);
            x += xd * tick;
            xk += xkd * tick;
            sums[0] += r.norm_squared() * tick;
            sums[1] += e.norm_squared() * tick;
            sums[2] += if now > late { e.norm_squared() * tick } else { 0.0 };
            sums[3] = phi.max(sums[3]);
        }
        sums
    }

    fn none(&self) -> Mat {
        Mat::zeros(self.controller.a.nrows(), self.limits.len())
    }
}

/// `10/(100 s + 1) [4 -5; -3 4]` under integrators: demonstration 10 of IQClab (J. Veenman, 2021), with its limits; the
/// plant: A. Bemporad, M. Morari, V. Dua, E. Pistikopoulos, Automatica 38(1), 2002.
fn tanks() -> Case {
    let b = dmatrix![0.4, -0.5; -0.3, 0.4];
    let d = dmatrix![2.0, 2.5; 1.5, 2.0];
    Case {
        plant: [Mat::identity(2, 2) * -0.01, b, Mat::identity(2, 2)],
        controller: StateSpace { a: Mat::zeros(2, 2), b: Mat::identity(2, 2), c: &d / 100.0, d },
        limits: vec![1.0; 2],
    }
}

/// A missile in roll and yaw, with its controller and limits: M. C. Turner, I. Postlethwaite, "A new perspective on
/// static and low order anti-windup synthesis", Int. J. Control 77(1), 2004; the demonstration of AWtools (F. D.
/// Bianchi, 2021).
fn missile() -> Case {
    let a = dmatrix![-0.818, -0.999, 0.349; 80.29, -0.579, 0.009; -2734.0, 0.05621, -2.1];
    let b = dmatrix![0.147, 0.012; -194.4, 37.61; -2716.0, -1093.0];
    let c = dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0];
    let inner = dmatrix![
        -0.29, -107.8, 6.67, -2.58, -0.4, 2.28, 0.48;
        107.68, -97.81, 63.95, -4.52, -5.35, -40.75, 2.13;
        -6.72, 64.82, -54.19, -40.79, 5.11, 18.47, -0.22;
        3.21, 2.1, 29.56, -631.15, 429.89, -2.07, -44.68;
        0.36, -3.39, 3.09, -460.03, -0.74, -0.98, -1.18;
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ];
    let into = Mat::from_fn(7, 2, |i, j| f64::from(u8::from(i == 5 + j)));
    let out = dmatrix![
        0.86, 8.54, -1.71, 43.91, 1.12, 0.0, 0.0;
        2.17, 39.91, -18.39, -8.51, 1.03, 0.0, 0.0
    ];
    Case {
        plant: [a, b, c],
        controller: StateSpace { a: inner, b: into, c: out, d: Mat::zeros(2, 2) },
        limits: vec![8.0; 2],
    }
}

/// `x' = a x + sat(u) + w`, `u = -x`, `|u| <= 1`, z = x, whose gain without limits is `1/(1 - a)`.
fn first_order(a: f64) -> Bounds {
    let one = dmatrix![1.0];
    let parts =
        [(X, X, dmatrix![a]), (X, W, one.clone()), (X, U, one.clone()), (Z, X, one.clone()), (Y, X, -&one)];
    let plant = GeneralisedPlant::new(vec![], &parts).unwrap();
    let controller = Controller::new(vec![], &[(U, Y, one)]).unwrap();
    let units = Mat::zeros(0, 0);
    let gamma = 1.0 / (1.0 - a);
    with_anti_windup(Limited { plant: &plant, controller: &controller, gamma, units: &units, limits: &[1.0] })
        .unwrap()
}

/// With `H = -g` the form in (x, phi, w) is negative where `4 U D > (X + 2 U (1 - g))^2`, `D = 2 X - (1 + X^2)/gamma`.
/// The best U leaves `g = (1 + X^2)/(2 gamma X)`, the best X of `beta = X/(gamma g^2)` is the root of 3: there it is
/// `3 3^1/2 gamma/4`.
#[test]
fn the_largest_energy_of_an_integrator_is_that_in_closed_form() {
    let found = first_order(0.0);
    assert_eq!(found.bounds.iter().map(|bound| bound.gamma).collect::<Vec<_>>(), [1.25, 2.0, 5.0]);
    for bound in &found.bounds {
        let best = 0.75 * 3f64.sqrt() * bound.gamma;
        assert!((0.97 * best..best).contains(&bound.beta), "{} {best}", bound.beta);
    }
}

/// With a = -1 and H = 0 the least gain is 1, that of the plant alone: the sector includes it.
#[test]
fn the_least_gain_for_any_w_is_that_of_the_plant_alone() {
    let found = first_order(-1.0);
    let last = found.bounds.last().unwrap();
    assert!(last.beta.is_infinite() && last.h.amax() == 0.0);
    assert!((1.0..1.03).contains(&last.gamma), "{}", last.gamma);
    assert!(found.bounds.windows(2).all(|pair| pair[0].gamma < pair[1].gamma && pair[0].beta < pair[1].beta));
    let unstable = first_order(0.5);
    assert!(unstable.bounds.iter().all(|bound| bound.beta.is_finite()));
}

/// The demonstration's pulse of 4.2 has an energy of 141: within a claim at 1.25 times the gain without limits. Without
/// anti-windup the error is twenty times as large, and no bound for any w is found.
#[test]
fn the_missile_flies_as_claimed() {
    let case = missile();
    let (gamma, found) = case.bounds(None);
    let pulse = |t: f64| DVector::from_vec(vec![4.2, -4.2]) * f64::from(u8::from((1.0..5.0).contains(&t)));
    let [energy, error, _, beyond] = case.fly(&found.gain, 10.0, 6.0, pulse);
    let first = &found.bounds[0];
    assert!((first.gamma / gamma - 1.25).abs() < 1e-9 && first.beta > energy, "{} {energy}", first.beta);
    assert!(error < first.gamma * first.gamma * energy && beyond > 0.5, "{error} {beyond}");
    let last = found.bounds.last().unwrap();
    assert!(last.beta.is_infinite() && last.gamma < 2.5 * gamma, "{} {gamma}", last.gamma);
    let none = case.none();
    let (_, without) = case.bounds(Some(&none));
    assert!(without.bounds.iter().all(|bound| bound.beta < 0.1 * first.beta));
    let [_, worse, ..] = case.fly(&none, 10.0, 6.0, pulse);
    assert!(worse > 15.0 * error, "{worse} {error}");
}

/// The demonstration's step of [0.63 0.79]: the error after 20 s is a seventh of that without anti-windup. The step is
/// permanent, so no energy bounds it.
#[test]
fn the_tanks_recover() {
    let case = tanks();
    let (_, found) = case.bounds(None);
    let step = |_: f64| DVector::from_vec(vec![0.63, 0.79]);
    let [_, _, with, beyond] = case.fly(&found.gain, 200.0, 20.0, step);
    let [_, _, without, _] = case.fly(&case.none(), 200.0, 20.0, step);
    assert!(with < 0.2 * without && beyond > 2.0, "{with} {without} {beyond}");
}

#[test]
fn a_limit_of_the_wrong_sign_is_refused() {
    let (plant, controller) = tanks().loop_();
    let units = Mat::zeros(0, 0);
    let limited =
        Limited { plant: &plant, controller: &controller, gamma: 1.0, units: &units, limits: &[1.0, -2.0] };
    let words = with_anti_windup(limited).unwrap_err().to_string();
    assert!(words.contains("the limit of command 1 is -2, must be above 0"), "{words}");
}
