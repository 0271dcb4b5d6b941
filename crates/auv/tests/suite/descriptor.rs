//! M, C and D against the linearisation, and their derivatives against their values elsewhere.

use crate::common::{remus100, squid};
use auv::{Descriptor, Parameter, Speed, Trim, Vehicle, linearise_with, trim};
use nalgebra::DMatrix;

fn trimmed() -> Vec<(Vehicle, Trim)> {
    [(squid(), 0.5, 50.0), (squid(), 2.0, 50.0), (remus100(), 1.5, 20.0)]
        .map(|(vehicle, speed, depth)| {
            let level = trim(&vehicle, Speed::Path(speed), depth).unwrap();
            (vehicle, level)
        })
        .into()
}

fn close(found: &DMatrix<f64>, wanted: &DMatrix<f64>, scale: f64, what: &str) {
    assert!((found - wanted).amax() <= 1e-12 * scale, "{what}: {found} instead of {wanted}");
}

#[test]
fn the_linearisation_follows() {
    for ((vehicle, level), depth) in trimmed().into_iter().flat_map(|one| [(one.clone(), false), (one, true)])
    {
        let found = Descriptor::at(&vehicle, &level, depth);
        let linear = linearise_with(&vehicle, &level, depth).unwrap();
        assert_eq!((linear.has_depth(), linear.a.nrows()), (depth, 4 + usize::from(depth)));
        let inverse = found.mass.clone().try_inverse().unwrap();
        close(&(&inverse * &found.state), &linear.a, linear.a.amax(), "A");
        close(&(&inverse * &found.input), &linear.b, linear.b.amax(), "B");
    }
}

/// One coefficient at a time, M, C and D are affine: the derivative gives the value anywhere, exactly. But for three.
#[test]
fn affine_in_all_but_length_viscosity_and_direction() {
    for (vehicle, level) in trimmed() {
        let here = Descriptor::at(&vehicle, &level, false).stacked();
        for parameter in Parameter::all(&vehicle) {
            let derivative = Descriptor::derivative(&vehicle, &level, false, parameter).stacked();
            let value = parameter.coefficient(&vehicle).unwrap();
            let mut off: f64 = 0.0;
            for step in [-0.7 * value, 0.3 * value + 0.01, 2.0 * value - 0.05] {
                let there = parameter.with_value(&vehicle, value + step);
                let change = Descriptor::at(&there, &level, false).stacked() - &here;
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
    for (vehicle, level) in trimmed() {
        let here = Descriptor::at(&vehicle, &level, false).stacked();
        let mut pairs = 0;
        let all = Parameter::all(&vehicle);
        for (i, p) in all.iter().enumerate() {
            for q in &all[i + 1..] {
                let [dp, dq] = [p, q].map(|r| 0.3 * r.coefficient(&vehicle).unwrap() + 0.01);
                let both = Descriptor::second_derivative(&vehicle, &level, false, [*p, *q]).stacked();
                let there = p.with_value(&vehicle, p.coefficient(&vehicle).unwrap() + dp);
                let there = q.with_value(&there, q.coefficient(&vehicle).unwrap() + dq);
                let first = |r: &Parameter| Descriptor::derivative(&vehicle, &level, false, *r).stacked();
                let change =
                    Descriptor::at(&there, &level, false).stacked() - &here - first(p) * dp - first(q) * dq;
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
        // At least mass with the centre of gravity, weight with it, buoyancy with its centre.
        assert!(pairs >= 6, "{pairs}");
    }
}

#[test]
fn derivatives_by_the_trim_are_limits_of_differences() {
    for (vehicle, level) in trimmed() {
        let moved = |step: f64, parameter: Parameter| {
            let mut there = level.clone();
            match parameter {
                Parameter::Output(i) => there.actuators[i] += step,
                _ => there.incidence += step,
            }
            Descriptor::at(&vehicle, &there, true).stacked()
        };
        for parameter in [Parameter::Incidence, Parameter::Output(0), Parameter::Output(1)] {
            let exact = Descriptor::derivative(&vehicle, &level, true, parameter).stacked();
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
    assert!(message.contains("no coefficient 'M_qdot' (did you mean 'M_q_dot'?)"), "{message}");
    let message = Parameter::named(&vehicle, "sternplanes.M_uu_delta").unwrap_err().to_string();
    assert!(message.contains("did you mean 'stern_planes.M_uu_delta'?"), "{message}");
}
