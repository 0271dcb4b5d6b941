//! M, C and D against the linearisation, and their derivatives against their values elsewhere.

use crate::common::{remus100, squid, whole};
use nalgebra::DMatrix;
use squid_auv::{
    Descriptor, LATERAL, Lateral, Parameter, Pitch, Speed, Trim, Vehicle, View, lateral, linearise_with,
    longitudinal, trim,
};
use squid_signals::States;

/// Vehicles in the vertical plane, and one that yaws, each with its trim and its states.
fn trimmed() -> Vec<(Vehicle, Trim, States)> {
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
        all.push((LATERAL.vehicle(&whole("remus100")), level, lateral::states(roll)));
    }
    all
}

fn close(found: &DMatrix<f64>, wanted: &DMatrix<f64>, scale: f64, what: &str) {
    assert!((found - wanted).amax() <= 1e-12 * scale, "{what}: {found} instead of {wanted}");
}

#[test]
fn the_linearisation_follows() {
    for (vehicle, level, states) in trimmed() {
        let found = Descriptor::at(&vehicle, &level, states);
        let linear = linearise_with(&vehicle, &level, states).unwrap();
        assert_eq!((linear.states, linear.a.nrows()), (states, states.len()));
        let inverse = found.mass.clone().try_inverse().unwrap();
        close(&(&inverse * &found.state), &linear.a, linear.a.amax(), "A");
        close(&(&inverse * &found.input), &linear.b, linear.b.amax(), "B");
    }
}

/// With roll the model of heading is that of straight flight in six degrees of freedom, whose r is cos(theta) times
/// the rate of heading; without roll it is what is left when roll is held.
#[test]
fn heading_is_the_lateral_motion_of_straight_flight() {
    let whole = whole("remus100");
    let level = trim(&whole.in_plane(), Speed::Path(1.5), 20.0).unwrap();
    let six = Lateral::at(&whole, 1.5, 20.0, &Pitch::Free).unwrap();
    let rudder = whole.actuators.iter().position(|one| one.name == "rudder").unwrap();
    let of_axis = |roll: bool| {
        let trim = Trim { actuators: vec![0.0], ..level.clone() };
        linearise_with(&LATERAL.vehicle(&whole), &trim, lateral::states(roll)).unwrap()
    };
    let (rolling, held) = (of_axis(true), of_axis(false));
    let cos = level.pitch.cos();
    // p, phi, v, r among v, p, r, phi.
    let places = [1, 3, 0, 2];
    let unit = |index: usize| if index == 2 { cos } else { 1.0 };
    for (i, row) in places.into_iter().enumerate() {
        for (j, column) in places.into_iter().enumerate() {
            let expected = six.a[(row, column)] * unit(column) / unit(row);
            assert!((rolling.a[(i, j)] - expected).abs() < 1e-9, "{i} {j}");
        }
        assert!((rolling.b[(i, 0)] - six.b[(row, rudder)] / unit(row)).abs() < 1e-9, "{i}");
    }
    assert_eq!(rolling.a.row(4).iter().copied().collect::<Vec<_>>(), [0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(held.a.row(2).iter().copied().collect::<Vec<_>>(), [0.0, 1.0, 0.0]);
    let poles = held.a.view((0, 0), (2, 2)).into_owned().complex_eigenvalues();
    for pole in poles.iter() {
        let near = six.eigenvalues().iter().map(|other| (other - pole).norm()).fold(f64::INFINITY, f64::min);
        assert!(near < 0.05 * pole.norm(), "the roll that turns bring moves them little: {pole}");
    }
}

/// One coefficient at a time, M, C and D are affine: the derivative gives the value anywhere, exactly. But for three.
#[test]
fn affine_in_all_but_length_viscosity_and_direction() {
    for (vehicle, level, states) in trimmed() {
        let here = Descriptor::at(&vehicle, &level, states).stacked();
        for parameter in Parameter::all(&vehicle) {
            let derivative = Descriptor::derivative(&vehicle, &level, states, parameter).stacked();
            let value = parameter.coefficient(&vehicle).unwrap();
            let mut off: f64 = 0.0;
            for step in [-0.7 * value, 0.3 * value + 0.01, 2.0 * value - 0.05] {
                let there = parameter.with_value(&vehicle, value + step);
                let change = Descriptor::at(&there, &level, states).stacked() - &here;
                off = off.max((change - &derivative * step).amax() / here.amax());
            }
            let name = parameter.name(&vehicle);
            let bent = ["length", "kinematic_viscosity"].contains(&name.as_str());
            let bent = bent && vehicle.coefficients.wetted_area > 0.0 || name.ends_with(".direction");
            assert_eq!(off > 1e-12, bent, "{name}: {off:e}");
        }
    }
}

/// Where two coefficients multiply, the second derivative holds all that is beyond the two first ones.
#[test]
fn second_derivatives_hold_what_two_coefficients_do_together() {
    for (vehicle, level, states) in trimmed() {
        let here = Descriptor::at(&vehicle, &level, states).stacked();
        let mut pairs = 0;
        let all = Parameter::all(&vehicle);
        for (i, p) in all.iter().enumerate() {
            for q in &all[i + 1..] {
                let [dp, dq] = [p, q].map(|r| 0.3 * r.coefficient(&vehicle).unwrap() + 0.01);
                let both = Descriptor::second_derivative(&vehicle, &level, states, [*p, *q]).stacked();
                let there = p.with_value(&vehicle, p.coefficient(&vehicle).unwrap() + dp);
                let there = q.with_value(&there, q.coefficient(&vehicle).unwrap() + dq);
                let first = |r: &Parameter| Descriptor::derivative(&vehicle, &level, states, *r).stacked();
                let change =
                    Descriptor::at(&there, &level, states).stacked() - &here - first(p) * dp - first(q) * dq;
                let bent = |r: &Parameter| {
                    ["length", "kinematic_viscosity", "direction"]
                        .iter()
                        .any(|k| r.name(&vehicle).ends_with(k))
                };
                if !bent(p) && !bent(q) {
                    let what = format!("{} {}", p.name(&vehicle), q.name(&vehicle));
                    close(&(&both * (dp * dq)), &change, here.amax(), &what);
                    pairs += usize::from(both.amax() > 0.0);
                }
            }
        }
        // At least mass with the centre of gravity, weight with it, buoyancy with its centre; in sway and yaw none.
        assert!(pairs >= if View::of_states(states).is_level_held { 0 } else { 6 }, "{pairs}");
    }
}

#[test]
fn derivatives_by_the_trim_are_limits_of_differences() {
    for (vehicle, level, states) in trimmed() {
        let moved = |step: f64, parameter: Parameter| {
            let mut there = level.clone();
            match parameter {
                Parameter::Output(i) => there.actuators[i] += step,
                _ => there.incidence += step,
            }
            Descriptor::at(&vehicle, &there, states).stacked()
        };
        for parameter in
            [Parameter::Incidence].into_iter().chain((0..vehicle.actuators.len()).map(Parameter::Output))
        {
            let exact = Descriptor::derivative(&vehicle, &level, states, parameter).stacked();
            let step = 1e-5;
            let difference = (moved(step, parameter) - moved(-step, parameter)) / (2.0 * step);
            assert!((&difference - &exact).amax() < 1e-6 * (1.0 + exact.amax()), "{difference} {exact}");
        }
    }
}

#[test]
fn a_misspelt_name_is_told_the_nearest() {
    let vehicle = remus100();
    for parameter in Parameter::all(&vehicle) {
        assert_eq!(Parameter::named(&vehicle, &parameter.name(&vehicle)), Ok(parameter));
    }
    let message = Parameter::named(&vehicle, "M_qdot").unwrap_err().to_string();
    assert!(message.contains("'M_qdot' of surge, heave and pitch (did you mean 'M_q_dot'?)"), "{message}");
    let message = Parameter::named(&vehicle, "sternplanes.M_uu_delta").unwrap_err().to_string();
    assert!(message.contains("did you mean 'stern_planes.M_uu_delta'?"), "{message}");
}
