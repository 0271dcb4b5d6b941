//! Anti-windup gains, and the regions for which they are proved.

use nalgebra::{DMatrix, DVector, dmatrix};
use squid_lpv::anti_windup::follow::following_gain;
use squid_lpv::anti_windup::{Aim, LimitedLoop, anti_windup, smallest_gains};
use squid_lpv::matrix::Mat;
use squid_lpv::system::StateSpace;

/// The largest distance from zero at which limits of 1 can stabilise the unstable mode of [`plant`].
const CONTROLLABLE: f64 = 51.975;

/// The rate of the controller below, 1/s.
const FAST: f64 = 1e3;

/// Returns an unstable plant with limits of 1 and a controller of second order: Y. Y. Cao, Z. Lin, D. G. Ward, "An
/// antiwindup approach to enlarging domain of attraction for linear systems subject to actuator saturation", IEEE
/// Trans. Automatic Control 47(1), 2002. The region is a disc of the plant's states.
fn example() -> LimitedLoop {
    let b = dmatrix![5.0, 0.0; 0.0, 1.0; 0.0, 0.0; 0.0, 0.0];
    let k = dmatrix![0.0, 0.0, 0.146, 0.088; 0.0, 0.0, -6.821, -5.67];
    let open = dmatrix![
        0.1, -0.1, 0.0, 0.0;
        0.1, -3.0, 0.0, 0.0;
        -598.2, 5.539, -171.2, 27.2;
        -4.567, 149.8, -68.0, -626.8
    ];
    let region = dmatrix![1.0, 0.0; 0.0, 1.0; 0.0, 0.0; 0.0, 0.0];
    LimitedLoop { a: open + &b * &k, b, c: region.transpose(), k, limits: vec![1.0; 2], region }
}

/// Returns `true` if the loop converges from a state.
fn settles(each: &LimitedLoop, gain: &DMatrix<f64>, from: DVector<f64>) -> bool {
    let LimitedLoop { a, b, k, limits, .. } = each;
    let n = a.nrows();
    let mut into = DMatrix::zeros(n, gain.nrows());
    into.view_mut((n - gain.nrows(), 0), (gain.nrows(), gain.nrows())).fill_with_identity();
    let rate = |x: &DVector<f64>| {
        let u = k * x;
        let phi = DVector::from_fn(u.len(), |j, _| u[j] - u[j].clamp(-limits[j], limits[j]));
        a * x + (&into * gain - b) * phi
    };
    let (mut x, step) = (from, 2e-4);
    for _ in 0..400_000 {
        let half = &x + rate(&x) * (0.5 * step);
        x += rate(&half) * step;
        if !(1.0..100.0).contains(&x.rows(0, 2).norm()) {
            break;
        }
    }
    x.rows(0, 2).norm() < 1.0
}

#[test]
fn the_region_contains_the_published_disc_and_no_uncontrollable_state() {
    let each = example();
    let none = DMatrix::zeros(2, 2);
    let without = anti_windup(std::slice::from_ref(&each), 2, FAST, Aim::RegionOf(&none)).unwrap();
    let with = anti_windup(std::slice::from_ref(&each), 2, FAST, Aim::Region).unwrap();
    // Published: 49.4 and 51.3.
    assert!(without.region > 49.4, "{}", without.region);
    assert!(with.region > 51.3_f64.max(without.region), "{}", with.region);
    assert!(with.region < CONTROLLABLE, "{}", with.region);
    for angle in 0..6 {
        let angle = f64::from(angle) * std::f64::consts::FRAC_PI_3;
        let from =
            |radius: f64| DVector::from_vec(vec![radius * angle.cos(), radius * angle.sin(), 0.0, 0.0]);
        assert!(settles(&each, &with.gain, from(0.99 * with.region)), "{angle}");
        assert!(settles(&each, &none, from(0.99 * without.region)), "{angle}");
    }
    assert!(!settles(&each, &with.gain, DVector::from_vec(vec![52.2, 0.0, 0.0, 0.0])));
}

/// Returns two uncoupled loops, each an integrating controller of a plant of first order.
fn two_axes() -> LimitedLoop {
    let (zero, one) = (0.0, 1.0);
    // States [x1, x2, k1, k2]: x' = -p x + u, k' = -x, u = g k - x.
    let k = dmatrix![-1.0, zero, 0.5, zero; zero, -2.0, zero, 3.0];
    let open = dmatrix![
        -0.2, zero, zero, zero;
        zero, -1.0, zero, zero;
        -1.0, zero, zero, zero;
        zero, -1.0, zero, zero
    ];
    let b = dmatrix![one, zero; zero, one; zero, zero; zero, zero];
    let c = dmatrix![one, zero, zero, zero; zero, 0.05, zero, zero];
    let region = dmatrix![0.3, zero; zero, 0.3; zero, zero; zero, zero];
    LimitedLoop { a: open + &b * &k, b, k, c, limits: vec![1.0, 2.0], region }
}

/// A command beyond its limit does not move the integral of the other axis.
#[test]
fn independent_loops_are_not_coupled() {
    let loops = [two_axes()];
    let least = anti_windup(&loops, 2, FAST, Aim::Recovery).unwrap().gamma;
    let found = smallest_gains(&loops, 2, FAST, &[0.05, 0.01]).unwrap();
    for (found, slack) in found.iter().zip([0.05, 0.01]) {
        let (gain, most) = (&found.gain, found.gain.amax());
        assert!(gain[(0, 1)].abs() < 1e-3 * most && gain[(1, 0)].abs() < 1e-3 * most, "{gain}");
        assert!(found.gamma <= (1.0 + 1.01 * slack) * least, "{} {least}", found.gamma);
    }
    assert!(found[0].gain.abs().sum() < found[1].gain.abs().sum());
}

/// The following gain does not depend on the coordinates of the state, brings the command to the applied one, and
/// leaves the rest of the state stable.
#[test]
fn the_following_gain_does_not_depend_on_coordinates() {
    let tick = 0.02;
    let k = StateSpace {
        a: dmatrix![-0.001, 0.0, 0.3; 0.0, -4.0, 1.0; 0.0, -2.0, -9.0],
        b: dmatrix![1.0, 0.0; 2.0, -1.0; 0.5, 3.0],
        c: dmatrix![1.0, 0.3, -0.2; 0.1, 2.0, 1.0],
        d: Mat::zeros(2, 2),
    };
    let gain = following_gain(&k, tick).unwrap();
    let one = Mat::identity(3, 3);
    let implicit = (&one - &k.a * (0.5 * tick)).try_inverse().unwrap();
    let (a, c) = (&implicit * (&one + &k.a * (0.5 * tick)), &k.c * &implicit);
    let left = (Mat::identity(2, 2) - &c * &gain).norm();
    assert!(left < 1e-3, "{left:e} of the difference remains");
    let rest = spectral_radius(&((&one - &gain * &c) * a));
    assert!(rest < 1.0, "{rest}");
    let t = dmatrix![1.0, 0.2, 0.0; -0.5, 2.0, 0.1; 3.0, 0.0, 0.4];
    let back = t.clone().try_inverse().unwrap();
    let moved = StateSpace { a: &t * &k.a * &back, b: &t * &k.b, c: &k.c * &back, d: k.d.clone() };
    let other = following_gain(&moved, tick).unwrap();
    assert!((other - t * &gain).norm() < 1e-6 * gain.norm());
    // No gain exists if no state affects the command.
    assert!(following_gain(&StateSpace { b: Mat::zeros(3, 2), ..k }, tick).is_none());
}

fn spectral_radius(a: &Mat) -> f64 {
    a.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}
