//! M, C and D against the linearisation, and their derivatives against their values elsewhere.

use crate::common::{remus100, six_dof, squid};
use nalgebra::DMatrix;
use squid_auv::{
    Descriptor, LATERAL, Lateral, Parameter, Pitch, Speed, Trim, Vehicle, View, lateral, linearise_with,
    longitudinal, trim,
};
use squid_signals::States;

/// Returns vehicles in the vertical plane, and one that yaws, each with its trim and its states.
fn vehicles_with_trim() -> Vec<(Vehicle, Trim, States)> {
    let vertical = [(squid(), 0.5, 50.0), (squid(), 2.0, 50.0), (remus100(), 1.5, 20.0)].into_iter();
    let mut all: Vec<(Vehicle, Trim, States)> = vertical
        .flat_map(|(vehicle, speed, depth)| {
            let vehicle = vehicle.in_plane();
            let level = trim(&vehicle, Speed::Path(speed), depth).unwrap();
            [false, true].map(|depth| (vehicle.clone(), level.clone(), longitudinal::states(false, depth)))
        })
        .collect();
    for roll in [false, true] {
        let level = trim(&remus100().in_plane(), Speed::Path(1.5), 20.0).unwrap();
        let level = Trim { actuators: vec![0.0], ..level };
        all.push((LATERAL.vehicle(&six_dof("remus100")), level, lateral::states(roll)));
    }
    all
}

fn close(found: &DMatrix<f64>, expected: &DMatrix<f64>, scale: f64, what: &str) {
    assert!((found - expected).amax() <= 1e-12 * scale, "{what}: {found} instead of {expected}");
}

#[test]
fn linearisation_follows_from_the_descriptor() {
    for (vehicle, level, states) in vehicles_with_trim() {
        let found = Descriptor::at(&vehicle, &level, states);
        let linear = linearise_with(&vehicle, &level, states).unwrap();
        assert_eq!((linear.states, linear.a.nrows()), (states, states.len()));
        let inverse = found.mass.clone().try_inverse().unwrap();
        close(&(&inverse * &found.state), &linear.a, linear.a.amax(), "A");
        close(&(&inverse * &found.input), &linear.b, linear.b.amax(), "B");
    }
}

/// The model of heading with roll is that of straight flight in six degrees of freedom, whose r is cos(theta) times the
/// rate of heading; without roll it is the same model with roll held.
#[test]
fn heading_model_is_the_lateral_motion_of_straight_flight() {
    let six_dof = six_dof("remus100");
    let level = trim(&six_dof.in_plane(), Speed::Path(1.5), 20.0).unwrap();
    let six_dof_model = Lateral::at(&six_dof, 1.5, 20.0, &Pitch::Free).unwrap();
    let rudder = six_dof.actuators.iter().position(|one| one.name == "rudder").unwrap();
    let of_axis = |roll: bool| {
        let trim = Trim { actuators: vec![0.0], ..level.clone() };
        linearise_with(&LATERAL.vehicle(&six_dof), &trim, lateral::states(roll)).unwrap()
    };
    let (free_roll, held) = (of_axis(true), of_axis(false));
    let cos = level.pitch.cos();
    // Indices of p, phi, v, r among v, p, r, phi.
    let indices = [1, 3, 0, 2];
    let unit = |index: usize| if index == 2 { cos } else { 1.0 };
    for (i, row) in indices.into_iter().enumerate() {
        for (j, column) in indices.into_iter().enumerate() {
            let expected = six_dof_model.a[(row, column)] * unit(column) / unit(row);
            assert!((free_roll.a[(i, j)] - expected).abs() < 1e-9, "{i} {j}");
        }
        assert!((free_roll.b[(i, 0)] - six_dof_model.b[(row, rudder)] / unit(row)).abs() < 1e-9, "{i}");
    }
    assert_eq!(free_roll.a.row(4).iter().copied().collect::<Vec<_>>(), [0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(held.a.row(2).iter().copied().collect::<Vec<_>>(), [0.0, 1.0, 0.0]);
    let poles = held.a.view((0, 0), (2, 2)).into_owned().complex_eigenvalues();
    for pole in poles.iter() {
        let near = six_dof_model
            .eigenvalues()
            .iter()
            .map(|other| (other - pole).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(near < 0.05 * pole.norm(), "the roll that turns bring moves them little: {pole}");
    }
}

/// M, C and D are affine in each single coefficient except three: the derivative then gives the exact value anywhere.
#[test]
fn affine_except_in_length_viscosity_and_direction() {
    for (vehicle, level, states) in vehicles_with_trim() {
        let here = Descriptor::at(&vehicle, &level, states).stacked();
        for parameter in Parameter::all(&vehicle) {
            let derivative = Descriptor::derivative(&vehicle, &level, states, parameter).stacked();
            let value = parameter.coefficient(&vehicle).unwrap();
            let mut error: f64 = 0.0;
            for step in [-0.7 * value, 0.3 * value + 0.01, 2.0 * value - 0.05] {
                let changed = parameter.with_value(&vehicle, value + step);
                let change = Descriptor::at(&changed, &level, states).stacked() - &here;
                error = error.max((change - &derivative * step).amax() / here.amax());
            }
            let name = parameter.name(&vehicle);
            let nonlinear = ["length", "kinematic_viscosity"].contains(&name.as_str());
            let nonlinear =
                nonlinear && vehicle.coefficients.wetted_area > 0.0 || name.ends_with(".direction");
            assert_eq!(error > 1e-12, nonlinear, "{name}: {error:e}");
        }
    }
}

/// The second derivative is all that remains beyond the two first derivatives, for a product of two coefficients.
#[test]
fn second_derivatives_give_products_of_two_coefficients() {
    for (vehicle, level, states) in vehicles_with_trim() {
        let here = Descriptor::at(&vehicle, &level, states).stacked();
        let mut pairs = 0;
        let all = Parameter::all(&vehicle);
        for (i, p) in all.iter().enumerate() {
            for q in &all[i + 1..] {
                let [dp, dq] = [p, q].map(|r| 0.3 * r.coefficient(&vehicle).unwrap() + 0.01);
                let both = Descriptor::second_derivative(&vehicle, &level, states, [*p, *q]).stacked();
                let changed = p.with_value(&vehicle, p.coefficient(&vehicle).unwrap() + dp);
                let changed = q.with_value(&changed, q.coefficient(&vehicle).unwrap() + dq);
                let first = |r: &Parameter| Descriptor::derivative(&vehicle, &level, states, *r).stacked();
                let change = Descriptor::at(&changed, &level, states).stacked()
                    - &here
                    - first(p) * dp
                    - first(q) * dq;
                let nonlinear = |r: &Parameter| {
                    ["length", "kinematic_viscosity", "direction"]
                        .iter()
                        .any(|k| r.name(&vehicle).ends_with(k))
                };
                if !nonlinear(p) && !nonlinear(q) {
                    let what = format!("{} {}", p.name(&vehicle), q.name(&vehicle));
                    close(&(&both * (dp * dq)), &change, here.amax(), &what);
                    pairs += usize::from(both.amax() > 0.0);
                }
            }
        }
        // Pairs are at least mass with the centre of gravity, weight with it, buoyancy with its centre; none in sway
        // and yaw.
        assert!(pairs >= if View::of_states(states).is_level_held { 0 } else { 6 }, "{pairs}");
    }
}

#[test]
fn trim_derivatives_match_differences() {
    for (vehicle, level, states) in vehicles_with_trim() {
        let shifted = |step: f64, parameter: Parameter| {
            let mut changed = level.clone();
            match parameter {
                Parameter::Output(i) => changed.actuators[i] += step,
                _ => changed.incidence += step,
            }
            Descriptor::at(&vehicle, &changed, states).stacked()
        };
        for parameter in
            [Parameter::Incidence].into_iter().chain((0..vehicle.actuators.len()).map(Parameter::Output))
        {
            let exact = Descriptor::derivative(&vehicle, &level, states, parameter).stacked();
            let step = 1e-5;
            let difference = (shifted(step, parameter) - shifted(-step, parameter)) / (2.0 * step);
            assert!((&difference - &exact).amax() < 1e-6 * (1.0 + exact.amax()), "{difference} {exact}");
        }
    }
}

#[test]
fn suggests_the_nearest_parameter_name() {
    let vehicle = remus100();
    for parameter in Parameter::all(&vehicle) {
        assert_eq!(Parameter::named(&vehicle, &parameter.name(&vehicle)), Ok(parameter));
    }
    let messages = [("M_qdot", "M_q_dot"), ("sternplanes.M_uu_delta", "stern_planes.M_uu_delta")].map(
        |(name, nearest)| {
            let error = Parameter::named(&vehicle, name).unwrap_err();
            assert_eq!((error.name.as_str(), error.suggestion.as_deref()), (name, Some(nearest)));
            error.to_string()
        },
    );
    insta::assert_snapshot!(messages.join("\n\n"));
}
