//! Cross-flow drag over the sections of a hull: closed forms of simple hulls, and its entries in a file.

use crate::common::{json_message, message, squid};
use proptest::prelude::*;
use squid_auv::{Coefficients, Dynamics, Hull, Motion, Parameter, Vehicle};

const SQUID: &str = include_str!("../../../../vehicles/squid/vehicle.toml");
const DENSITY: f64 = 1000.0;
const C_D: f64 = 0.8;

/// Returns Z and M of a hull that moves with w and q, with cross-flow drag only; its inertia is 1.
fn drag(stations: &[[f64; 2]], w: f64, q: f64) -> [f64; 2] {
    let c = Coefficients {
        mass: 1.0,
        weight: 1e-300,
        buoyancy: 1e-300,
        I_yy: 1.0,
        density: DENSITY,
        C_d: C_D,
        hull: Hull::new(stations).unwrap(),
        ..Coefficients::default()
    };
    let [_, z, m] = Dynamics::new(&c).unwrap().acceleration(&Motion::in_plane(0.0, w, q, 0.0), 0.0, [0.0; 3]);
    [z, m]
}

fn close(found: [f64; 2], expected: [f64; 2]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{found} instead of {expected}");
    }
}

/// Closed form for a box from x_1 to x_2 of breadth b: `Z_ww = -k (x_2 - x_1)`, `M_ww = k (x_2^2 - x_1^2)/2`, `Z_qq = k
/// int x|x| dx`, and `M_qq = -k int x^2 |x| dx`, with `k = rho/2 C_d b`.
#[test]
fn box_matches_the_closed_form() {
    let (aft, fore, breadth) = (-1.2, 0.8, 0.3);
    let k = 0.5 * DENSITY * C_D * breadth;
    let (z_ww, m_ww) = (-k * (fore - aft), k * (fore * fore - aft * aft) / 2.0);
    let (z_qq, m_qq) = (k * (fore.powi(3) + aft.powi(3)) / 3.0, -k * (fore.powi(4) + aft.powi(4)) / 4.0);
    for stations in [
        vec![[aft, breadth], [fore, breadth]],
        vec![[aft, breadth], [-0.7, breadth], [0.1, breadth], [fore, breadth]],
    ] {
        for rate in [0.4, -0.4] {
            let square = rate * f64::abs(rate);
            close(drag(&stations, rate, 0.0), [z_ww * square, m_ww * square]);
            close(drag(&stations, 0.0, rate), [z_qq * square, m_qq * square]);
        }
    }
    close(drag(&[[aft, breadth], [fore, breadth]], 0.0, 0.0), [0.0, 0.0]);
}

/// Closed form for a hull that tapers to points at both ends, b = b_0 (1 - |x|/h): `Z_ww = -k h`, `M_qq = -k h^4/10`,
/// `Z_qq = M_ww = 0`.
#[test]
fn tapered_hull_matches_the_closed_form() {
    let (half, breadth) = (1.5, 0.4);
    let stations = [[-half, 0.0], [0.0, breadth], [half, 0.0]];
    let k = 0.5 * DENSITY * C_D * breadth;
    close(drag(&stations, 0.3, 0.0), [-k * half * 0.09, 0.0]);
    close(drag(&stations, 0.0, -0.3), [0.0, k * half.powi(4) / 10.0 * 0.09]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Drag of any hull in any motion: the sum over thin strips, within the error of that sum; drag dissipates energy.
    #[test]
    fn drag_matches_the_sum_over_strips(
        breadths in prop::collection::vec(0.0..0.5_f64, 4),
        w in -1.0..1.0_f64,
        q in -1.0..1.0_f64,
    ) {
        const STRIPS: usize = 3000;
        let stations: Vec<[f64; 2]> =
            breadths.iter().enumerate().map(|(i, b)| [-1.3 + 0.9 * i as f64, *b]).collect();
        let width = 0.9 / STRIPS as f64;
        let (mut z, mut m) = (0.0, 0.0);
        for (i, pair) in breadths.windows(2).enumerate() {
            for strip in 0..STRIPS {
                let fraction = (strip as f64 + 0.5) / STRIPS as f64;
                let x = -1.3 + 0.9 * (i as f64 + fraction);
                let v: f64 = w - x * q;
                let force = -0.5 * DENSITY * C_D * (pair[0] + fraction * (pair[1] - pair[0])) * v * v.abs() * width;
                z += force;
                m -= x * force;
            }
        }
        let [found_z, found_m] = drag(&stations, w, q);
        // The error of the midpoint rule is h^2/24 times the length and the second derivative, below 1e4 here.
        prop_assert!((found_z - z).abs() < 1e-2 && (found_m - m).abs() < 1e-2, "{found_z} {z} {found_m} {m}");
        prop_assert!(found_z * w + found_m * q <= 1e-12);
    }

    /// Dual numbers against central differences, also where the cross flow changes sign within the hull.
    #[test]
    fn derivatives_match_differences(w in -1.0..1.0_f64, q in -1.0..1.0_f64) {
        let stations = [[-1.0, 0.1], [-0.2, 0.3], [0.9, 0.2]];
        let hull = Hull::new(&stations).unwrap();
        let vehicle = {
            let mut vehicle = squid();
            (vehicle.coefficients.hull, vehicle.coefficients.C_d) = (hull, C_D);
            vehicle
        };
        let dynamics = Dynamics::new(&vehicle.coefficients).unwrap();
        let h = 1e-6;
        let at = |dw: f64, dq: f64| {
            dynamics.acceleration(&Motion::in_plane(1.0, w + dw, q + dq, 0.0), 50.0, [0.0; 3])
        };
        let seeded = |dw: f64, dq: f64| {
            let dual = squid_auv::Dual64::new;
            let zero = squid_auv::Dual64::from(0.0);
            let motion = Motion::in_plane(dual(1.0, 0.0), dual(w, dw), dual(q, dq), zero);
            dynamics.lifted().acceleration(&motion, squid_auv::Dual64::from(50.0), [zero; 3]).map(|d| d.eps)
        };
        for (dw, dq) in [(1.0, 0.0), (0.0, 1.0)] {
            let (above, below, exact) = (at(h * dw, h * dq), at(-h * dw, -h * dq), seeded(dw, dq));
            for i in 0..3 {
                let mean = (above[i] - below[i]) / (2.0 * h);
                prop_assert!((mean - exact[i]).abs() < 1e-5 * (1.0 + exact[i].abs()), "{mean} {}", exact[i]);
            }
        }
    }
}

const HULL: &str = "[hull]
C_d = { value = 0.6, unit = \"1\", source = \"a book\" }
stations = { value = [[-1.0, 0.0], [0.0, 0.25], [1.0, 0.0]], unit = \"m\", source = \"a drawing\" }
";

#[test]
fn reads_a_hull_and_round_trips_json() {
    let vehicle = Vehicle::parse(&format!("{HULL}\n{SQUID}"), "v.toml").unwrap();
    assert_eq!(vehicle.coefficients.hull.stations(), [[-1.0, 0.0], [0.0, 0.25], [1.0, 0.0]]);
    assert_eq!((vehicle.coefficients.C_d, vehicle.sources["stations"].as_str()), (0.6, "a drawing"));
    assert!(Parameter::named(&vehicle.in_plane(), "C_d").is_ok(), "it may be uncertain");
    let text = vehicle.to_json().unwrap();
    assert_eq!(Vehicle::from_json(&text, "v").unwrap(), vehicle);
    assert!(!squid().to_json().unwrap().contains("stations"));
    let reversed = text.replacen("-1.0", "3.0", 1);
    let error = Vehicle::from_json(&reversed, "v").unwrap_err();
    insta::assert_snapshot!(json_message("falling", &error, "stations"));
}

#[test]
fn reports_mistakes_in_a_hull() {
    let stations = "[[-1.0, 0.0], [0.0, 0.25], [1.0, 0.0]]";
    let messages = [
        (stations, "[[1.0, 0.0], [0.0, 0.25], [-1.0, 0.0]]", 3, "stations.value"),
        ("[0.0, 0.25]", "[0.0, -0.25]", 3, "stations.value"),
        ("[0.0, 0.25]", "[-1.0, 0.25]", 3, "stations.value"),
        (stations, "[[0.0, 0.25]]", 3, "stations.value"),
        ("[[-1.0", "[[\"-1\"", 3, "stations.value"),
        ("unit = \"m\"", "unit = \"mm\"", 3, "stations.unit"),
        ("C_d", "# C_d", 1, "C_d"),
        ("stations = {", "sections = {", 3, "sections"),
    ]
    .map(|(from, to, line, key)| {
        assert!(HULL.contains(from), "{from}");
        let text = format!("{}\n{SQUID}", HULL.replacen(from, to, 1));
        message(to, &Vehicle::parse(&text, "v.toml").expect_err(to), (line, &format!("hull.{key}")))
    });
    insta::assert_snapshot!(messages.join("\n\n"));
}
