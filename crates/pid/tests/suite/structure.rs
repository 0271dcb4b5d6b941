//! The controller of a cascade against its equations.

use crate::vehicles::{SCHEDULING, layout, made, vehicle};
use nalgebra::Complex;
use squid_lpv::matrix::Mat;

pub const SPEED: &str =
    "[controller.speed]\nkp = { value = 30.0, unit = \"N.s/m\" }\nki = { value = 10.0, unit = \"N/m\" }\n";

/// Returns the response of the controller frozen at rho, from y in SI to the actuator outputs in SI.
pub fn response(
    name: &str,
    tracked: &'static str,
    text: &str,
    rho: f64,
    omega: f64,
) -> Vec<Vec<Complex<f64>>> {
    let layout = layout(tracked);
    let controller = made(name, &layout, text).unwrap().controller();
    let g = controller.frozen(&[rho]).unwrap().response(Complex::new(0.0, omega)).unwrap();
    let scales: Vec<f64> = layout.references.iter().chain(&layout.measurements).map(|p| p.scale).collect();
    let reach: Vec<f64> = vehicle(name).actuators.iter().map(squid_auv::Actuator::reach).collect();
    (0..reach.len()).map(|i| (0..scales.len()).map(|j| g[(i, j)] * reach[i] / scales[j]).collect()).collect()
}

pub fn close(found: Complex<f64>, expected: Complex<f64>) {
    assert!((found - expected).norm() < 1e-9 * (1.0 + expected.norm()), "{found} instead of {expected}");
}

/// REMUS 100: a positive deflection turns the bow down, so the planes get the negative command.
#[test]
fn scheduled_gains_match_equations() {
    let text = format!(
        "[controller]\nkind = \"pid\"\n[controller.pitch]\n\
         kp = {{ value = [5.0, -1.0, 0.3], unit = \"deg/deg\" }}\nki = {{ value = [0.4, 0.1], unit = \"1/s\" }}\n\
         kd = {{ value = 2.0, unit = \"s\" }}\nreference_weight = 0.7\nrolloff = 0.05\n{SPEED}"
    );
    for rho in [-1.0, 0.3, 1.0] {
        for omega in [0.02, 0.8, 9.0] {
            let s = Complex::new(0.0, omega);
            let g = response("remus100", "pitch", &text, rho, omega);
            let (kp, ki, kd) = (5.0 - rho + 0.3 * rho * rho, 0.4 + 0.1 * rho, 2.0);
            let [propeller, planes] = [&g[0], &g[1]];
            close(planes[0], -(s.inv() * ki + 0.7 * kp));
            close(planes[2], s.inv() * ki + kp);
            close(planes[4], (s * 0.05 + 1.0).inv() * kd);
            close(propeller[3], -(s.inv() * 10.0 + 30.0));
            for other in [planes[1], planes[3], propeller[0], propeller[1], propeller[2], propeller[4]] {
                close(other, Complex::new(0.0, 0.0));
            }
        }
    }
}

/// Squid: three thrusters produce a moment without force, and a force without moment.
#[test]
fn follows_reference_model_with_thrusters() {
    let text = "[controller]\nkind = \"pid\"\n[controller.pitch]\n\
        kp = { value = 2.0, unit = \"N.m/deg\" }\nki = { value = 20.0, unit = \"N.m/(rad.s)\" }\n\
        kd = { value = [80.0, 30.0], unit = \"N.m.s/rad\" }\nfeedforward = { value = 50.0, unit = \"N.m.s2/rad\" }\n\
        model = { frequency = 1.3, damping = 0.9 }\n[controller.speed]\n\
        kp = { value = 120.0, unit = \"N.s/m\" }\nreference_weight = 0.5\nrolloff = 0.1\n";
    let (rho, omega) = (0.6, 1.1);
    let s = Complex::new(0.0, omega);
    let g = response("squid", "pitch", text, rho, omega);
    let follow = (s * s + s * (2.0 * 0.9 * 1.3) + 1.3 * 1.3).inv() * (1.3 * 1.3);
    let (kp, kd) = (2.0 * 180.0 / std::f64::consts::PI, 80.0 + 30.0 * rho);
    let pid = s.inv() * 20.0 + kp;
    // z of the thrusters: 0.2, -0.1 and -0.1 m.
    let moment = |column: usize| g[0][column] * 0.2 - (g[1][column] + g[2][column]) * 0.1;
    let force = |column: usize| g[0][column] + g[1][column] + g[2][column];
    close(moment(0), follow * (pid + s * kd + s * s * 50.0));
    close(moment(2), -pid);
    close(moment(4), Complex::new(-kd, 0.0));
    close(force(1), Complex::new(60.0, 0.0));
    close(force(3), (s * 0.1 + 1.0).inv() * -120.0);
    for none in [moment(1), moment(3), force(0), force(2), force(4)] {
        close(none, Complex::new(0.0, 0.0));
    }
    close(g[1][2] / g[0][2], Complex::new(-0.5, 0.0));
}

/// A vehicle below its depth reference raises its bow.
#[test]
fn depth_commands_pitch() {
    let text = format!(
        "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = {{ value = 3.0, unit = \"rad/rad\" }}\n\
         kd = {{ value = 2.0, unit = \"s\" }}\n[controller.depth]\nkp = {{ value = 10.0, unit = \"deg/m\" }}\n\
         ki = {{ value = 0.02, unit = \"rad/(m.s)\" }}\n{SPEED}"
    );
    let (s, g) = (Complex::new(0.0, 0.4), response("remus100", "depth", &text, 0.0, 0.4));
    let pitch_per_depth = s.inv() * 0.02 + 10f64.to_radians();
    close(g[1][0], pitch_per_depth * 3.0);
    close(g[1][5], pitch_per_depth * -3.0);
    close(g[1][2], Complex::new(3.0, 0.0));
}

/// The matrices are affine in each coefficient, as a search over gains requires.
#[test]
fn controller_is_affine_in_gains() {
    let text = format!(
        "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = {{ value = [5.0, -1.0, 0.3], unit = \"rad/rad\" }}\n\
         ki = {{ value = 0.4, unit = \"1/s\" }}\n{SPEED}"
    );
    let structure = made("remus100", &layout("pitch"), &text).unwrap();
    let affine = structure.affine();
    let names: Vec<(&str, usize, f64)> =
        affine.directions.iter().map(|one| (one.name.as_str(), one.power, one.value)).collect();
    assert_eq!(
        names,
        [
            ("pitch.kp", 0, 5.0),
            ("pitch.kp", 1, -1.0),
            ("pitch.kp", 2, 0.3),
            ("pitch.ki", 0, 0.4),
            ("speed.kp", 0, 30.0),
            ("speed.ki", 0, 10.0)
        ]
    );
    assert_eq!((affine.blocks.as_slice(), affine.sizes), (&[2][..], [2, 6, 2]));
    let other = text.replace("[5.0, -1.0, 0.3]", "[4.0, 2.0, -0.5]").replace("value = 0.4", "value = 0.9");
    let values = [4.0, 2.0, -0.5, 0.9, 30.0, 10.0];
    let expected = made("remus100", &layout("pitch"), &other).unwrap().controller();
    assert!((affine.at(&values) - expected.matrix()).amax() < 1e-12);
    // The parameter loop is nilpotent, hence well posed for every rho.
    let dtt = expected.dtt();
    assert_eq!(&dtt * &dtt, Mat::zeros(2, 2));
}

/// A parabola through three points overshoots the lines between them.
#[test]
fn fits_table_and_reports_misfit() {
    let with = |gain: &str| {
        let text = format!(
            "[controller]\nkind = \"pid\"\n[controller.pitch]\nkp = {{ {gain}, unit = \"rad/rad\" }}\n{SPEED}"
        );
        made("remus100", &layout("pitch"), &text).unwrap()
    };
    let bent = with("table = [[1.4, 8.0], [1.8, 4.0], [2.2, 4.0]]");
    let coefficients = &bent.gains[0].coefficients;
    for (speed, gain) in [(1.4, 8.0), (1.8, 4.0), (2.2, 4.0)] {
        let rho: f64 = (speed - SCHEDULING.0) / SCHEDULING.1;
        let found = coefficients[0] + coefficients[1] * rho + coefficients[2] * rho * rho;
        assert!((found - gain).abs() < 1e-12, "{found} {gain}");
    }
    // 2 (rho^2 - rho) against its chord, at rho = 1/2: an eighth of 4 off the largest gain of 8, in either half.
    let misfit = &bent.misfits[0];
    assert!((misfit.relative - 0.0625).abs() < 1e-3, "{misfit:?}");
    let straight = with("table = [[1.4, 8.0], [1.8, 6.0], [2.2, 4.0]], degree = 1");
    assert!(straight.misfits[0].relative < 1e-12 && straight.gains[0].coefficients.len() == 2);
}

/// The integral term of a saturated command decays with the tracking time: `ki I' = -(v - sat v)/Tt`.
#[test]
fn anti_windup_is_back_calculation() {
    let text = format!(
        "[controller]\nkind = \"pid\"\ntracking_time = 0.5\n[controller.pitch]\n\
         kp = {{ value = 5.0, unit = \"rad/rad\" }}\nki = {{ value = [0.4, 0.1], unit = \"1/s\" }}\n{SPEED}"
    );
    let structure = made("remus100", &layout("pitch"), &text).unwrap();
    let gain = structure.anti_windup();
    let reach: Vec<f64> = vehicle("remus100").actuators.iter().map(squid_auv::Actuator::reach).collect();
    // States are in units of the pitch and speed measurements, 0.1 and 0.5; the planes act with the sign -1.
    for (state, actuator, unit, ki, sign) in [(0, 1, 0.1, 0.4, -1.0), (1, 0, 0.5, 10.0, 1.0)] {
        let fall = ki * unit * gain[(state, actuator)] / (sign * reach[actuator]);
        assert!((fall + 2.0).abs() < 1e-12, "{fall}");
        assert!(gain[(state, 1 - actuator)].abs() < 1e-12);
    }
    // The default of the tracking time is kp/ki.
    let without = text.replace("tracking_time = 0.5\n", "");
    let own = made("remus100", &layout("pitch"), &without).unwrap().anti_windup();
    for (state, actuator, time) in [(0, 1, 5.0 / 0.4), (1, 0, 3.0)] {
        let ratio = own[(state, actuator)] / gain[(state, actuator)];
        assert!((ratio - 0.5 / time).abs() < 1e-12, "{ratio}");
    }
}
