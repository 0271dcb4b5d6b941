//! External load, and ballast that changes in operation.

use crate::common::{remus100, squid};
use squid_auv::{
    Ballast, CoefficientError, Instant, LpvModel, Motion, Plant, Rates, Slopes, Speed, State, Vehicle, index,
    linearise, trim,
};

/// Returns Squid without trim moments: neutral, centres at the origin, and no coupling of heave and pitch.
fn neutral() -> Vehicle {
    let mut vehicle = squid();
    let c = &mut vehicle.coefficients;
    (c.buoyancy, c.buoyancy_gradient) = (c.weight, 0.0);
    (c.x_G, c.x_B, c.z_G, c.z_B) = (0.0, 0.0, 0.0, 0.0);
    (c.Z_q_dot, c.M_w_dot) = (0.0, 0.0);
    vehicle
}

fn at_rest(vehicle: &Vehicle) -> Plant {
    let mut plant = Plant::new(vehicle).unwrap();
    plant.set_state(&State::in_plane(Motion::in_plane(0.0, 0.0, 0.0, 0.0), 0.0, 10.0));
    plant
}

fn rates(plant: &Plant) -> Rates {
    plant.rates(&plant.instant(), |index| plant.outputs()[index])
}

/// A force down accelerates mass and added mass in heave, a force ahead those in surge, a moment the inertia.
#[test]
fn load_at_rest_accelerates_mass_and_added_mass() {
    let vehicle = neutral();
    let c = &vehicle.coefficients;
    let [ahead, down, moment] = [0.3, 0.2, -0.1];
    let mut plant = at_rest(&vehicle);
    plant.set_load([ahead, 0.0, down, 0.0, moment, 0.0]).unwrap();
    let expected = [ahead / (c.mass - c.X_u_dot), down / (c.mass - c.Z_w_dot), moment / (c.I_yy - c.M_q_dot)];
    let found = rates(&plant);
    for (found, expected) in [index::SURGE, index::HEAVE, index::Q].map(|one| found[one]).iter().zip(expected)
    {
        assert!((found - expected).abs() < 1e-15 + 1e-13 * expected.abs(), "{found} and {expected}");
    }
    let mut sinks = at_rest(&vehicle);
    sinks.set_load([0.0, 0.0, 1e-6, 0.0, 0.0, 0.0]).unwrap();
    sinks.advance(2.0).unwrap();
    // At rest all damping is quadratic except Z_w.
    let linear = |t: f64| {
        let (mass, damping) = (c.mass - c.Z_w_dot, -c.Z_w);
        if damping > 0.0 { 1e-6 / damping * -(-damping / mass * t).exp_m1() } else { 1e-6 * t / mass }
    };
    let w = sinks.state().motion.w;
    assert!((w - linear(2.0)).abs() < 1e-5 * w, "{w} and {}", linear(2.0));
}

/// A load in the equations of motion equals the force and the moment of a weight, level and at rest.
#[test]
fn extra_weight_equals_a_load_down() {
    for vehicle in [squid(), remus100()] {
        let extra = 0.05 * vehicle.coefficients.weight;
        let (mut loaded, mut heavier) = (at_rest(&vehicle), at_rest(&vehicle));
        let ballast = heavier.ballast();
        loaded.set_load([0.0, 0.0, extra, 0.0, -ballast.x_G * extra, 0.0]).unwrap();
        // The weight is added without its mass, which would differ.
        heavier.set_ballast(&Ballast { weight: ballast.weight + extra, ..ballast }).unwrap();
        let (one, other) = (rates(&loaded), rates(&heavier));
        for (one, other) in one.into_iter().zip(other) {
            assert!((one - other).abs() < 1e-13, "{one} and {other}");
        }
        assert!(one[index::HEAVE] - rates(&at_rest(&vehicle))[index::HEAVE] > 0.1);
        let mass = ballast.mass * (1.0 + extra / ballast.weight);
        heavier.set_ballast(&Ballast { mass, weight: ballast.weight + extra, ..ballast }).unwrap();
        assert!(rates(&heavier)[index::HEAVE] < one[index::HEAVE]);
    }
}

/// A growing load is the limit of a staircase; it acts in the LPV model as in the nonlinear one.
#[test]
fn load_ramp_is_the_limit_of_a_staircase() {
    let vehicle = squid();
    let level = trim(&vehicle, Speed::Path(1.5), 30.0).unwrap();
    let linear = linearise(&vehicle, &level).unwrap();
    let model =
        LpvModel::new("squid", 30.0, (1.5, 1.0), &[linear.a], &[linear.b], std::slice::from_ref(&level))
            .unwrap();
    let mut ends = Vec::new();
    for fidelity in [squid_auv::Fidelity::Nonlinear, squid_auv::Fidelity::Lpv] {
        let plants = [1, 4000].map(|pieces| {
            let mut plant = Plant::new(&vehicle).unwrap().with_lpv(model.clone()).unwrap();
            plant.set_fidelity(fidelity).unwrap();
            plant.start(0.0, &level).unwrap();
            let (h, slope) = (1.0 / f64::from(pieces), [4.0, 0.0, -6.0, 0.0, 0.5, 0.0]);
            if pieces == 1 {
                let slopes = Slopes { load: slope, ..Slopes::held(vehicle.actuators.len()) };
                plant.set_slopes(&slopes).unwrap();
            }
            for piece in 0..pieces {
                if pieces > 1 {
                    plant.set_load(slope.map(|slope| slope * (f64::from(piece) + 0.5) * h)).unwrap();
                }
                plant.advance(f64::from(piece + 1) * h).unwrap();
            }
            plant
        });
        let [ramp, stairs] = plants.map(|plant| (plant.state(), plant.load()));
        assert_eq!(ramp.1, [4.0, 0.0, -6.0, 0.0, 0.5, 0.0]);
        for (one, other) in [
            (ramp.0.motion.u, stairs.0.motion.u),
            (ramp.0.motion.w, stairs.0.motion.w),
            (ramp.0.motion.q, stairs.0.motion.q),
        ] {
            assert!((one - other).abs() < 1e-7, "{one} and {other}");
        }
        assert!((ramp.0.motion.w - level.heave).abs() > 1e-3);
        ends.push(ramp.0.motion.w - level.heave);
    }
    assert!((ends[0] - ends[1]).abs() < 0.05 * ends[0].abs(), "{ends:?}");
}

#[test]
fn rejects_invalid_ballast_without_side_effects() {
    let vehicle = squid();
    let level = trim(&vehicle, Speed::Path(1.5), 30.0).unwrap();
    let mut plant = Plant::new(&vehicle).unwrap();
    plant.start(0.0, &level).unwrap();
    let (before, ballast) = (plant.snapshot(), plant.ballast());
    let motion: Instant = plant.instant();
    for ballast_out_of_range in [
        Ballast { weight: 0.0, ..ballast },
        Ballast { weight: f64::NAN, ..ballast },
        Ballast { mass: f64::INFINITY, ..ballast },
        Ballast { buoyancy: -1.0, ..ballast },
        Ballast { x_G: f64::INFINITY, ..ballast },
    ] {
        let error = plant.set_ballast(&ballast_out_of_range).unwrap_err();
        assert!(matches!(error, CoefficientError::NotAllowed { .. }), "{error}");
    }
    // I_yy is about the origin: with the centre of gravity this far off, none is left about itself.
    let error = plant.set_ballast(&Ballast { x_G: 10.0, ..ballast }).unwrap_err();
    assert!(matches!(error, CoefficientError::MassMatrixNotPositiveDefinite { .. }), "{error}");
    assert_eq!((plant.snapshot(), plant.instant()), (before, motion));
    plant.advance(1.0).unwrap();
    let mut other = Plant::new(&vehicle).unwrap();
    other.start(0.0, &level).unwrap();
    other.advance(1.0).unwrap();
    assert_eq!(plant.snapshot(), other.snapshot());
}
