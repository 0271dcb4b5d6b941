//! Gains in files of autopilots: import, conversion, errors and export.

use crate::structure::{SPEED, close, response};
use crate::vehicles::mistake;
use nalgebra::Complex;
use proptest::prelude::*;
use squid_auv::toml_file::FileError;
use squid_pid::autopilots::{Autopilot, Import, Missing, export, import};
use squid_pid::{Angle, Drive};

/// Gains for LAUV, as in etc/auv/control.ini of DUNE.
const DUNE: &str = "[Control.AUV.Speed]\nMPS PID Gains                           = 0.0, 25.0, 0.0\n\n\
    [Control.AUV.Attitude]\nEnabled = Always\nDepth PID Gains        = 0.6, 0.0, 0.7\n\
    Pitch PID Gains                         = 1.5, 0.0, 1.1 ; of LAUV\n; Pitch PID Gains = 9, 9, 9\n\
    Error Attitude Compensation             = false\n\n\
    [Control.AUV.Allocator]\r\nFin effect M                            = 0.5\r\n";

/// Defaults of ArduSub, in the three line formats.
const ARDUSUB: &str = "# Vehicle 1\nATC_ANG_PIT_P,6.000000\nATC_RAT_PIT_P   0.135 # per rad/s\n\
    1\t1\tATC_RAT_PIT_I\t0.09\t9\nATC_RAT_PIT_D,0.0036\nATC_RAT_PIT_FF,0\nATC_RAT_RLL_P,0.2\nATC_RAT_PIT_IMAX,0.444\n";

/// Gains of the mode `flight` in config/modes.yaml of mvp, and a mode as block mapping.
const MVP: &str = "\
enabled: true
control_modes: # α
  flight:
    pitch:    {p: 5.0,    i: 1.0,   d: 2.0,   i_max: 10, i_min: -10}
    # pitch:    {p: 7.0,    i: 1.0,   d: 2.0}
    surge:    {p: 10.0,   i: 3.0,   d: 5.0,   i_max: 10, i_min: -10}
  hold:
    pitch:
      p: 6.0
      i: 0
      d: 3.5   # damping
    x: {p: 2.0}
  kill: false
";

/// Names of SIMremus100.m, with the values of its expressions; one line is from the Python Vehicle Simulator.
const MSS: &str = "%{\nKp_theta = 1.0;\n%}\nKp_z = 0.1;  % depth\nKp_theta = 5.33; Ki_theta = 0.43; % pitch\n\
    self.Kd_theta = 10.7  # rate\ndelta_s = -Kp_theta * ssa(theta - theta_d) - Kd_theta * q;\n";

/// Returns the data that the file of an autopilot lacks.
fn missing(autopilot: Autopilot) -> Missing {
    match autopilot {
        Autopilot::ArduSub => Missing { full_output: Some(40.0), ..Missing::default() },
        Autopilot::Mvp => {
            Missing { drive: Some(Drive::Moment), mode: Some("flight".into()), ..Missing::default() }
        }
        _ => Missing::default(),
    }
}

const ALL: [(Autopilot, &str); 4] =
    [(Autopilot::Dune, DUNE), (Autopilot::ArduSub, ARDUSUB), (Autopilot::Mvp, MVP), (Autopilot::Mss, MSS)];

fn read(autopilot: Autopilot, text: &str) -> Result<Import, FileError> {
    import(autopilot, Angle::Pitch, text, "theirs", &missing(autopilot))
}

/// Returns the keys of a file that have no counterpart, with their lines.
fn left_out(found: &Import) -> Vec<(usize, &str)> {
    found.left_out.iter().map(|one| (one.line, one.key.as_str())).collect()
}

/// Returns name (such as `pitch.kp`), value and unit of each gain.
fn gains(found: &Import) -> Vec<(String, f64, &'static str)> {
    let gain = |gain: &squid_pid::autopilots::Imported| {
        (format!("{}.{}", gain.table, gain.key), gain.value, gain.unit.unwrap_or_default())
    };
    found.gains.iter().map(gain).collect()
}

fn written(autopilot: Autopilot, controller: &str, text: &str) -> Result<String, FileError> {
    let pid = squid_pid::read_file(controller, "mine.toml")?;
    Ok(export(autopilot, &pid, text, "theirs", &missing(autopilot))?.text)
}

fn controller(pitch: &str, more: &str) -> String {
    format!("[controller]\nkind = \"pid\"\n[controller.pitch]\n{pitch}\n{more}")
}

#[test]
fn converts_dune_gains_to_fin_angles() {
    let found = read(Autopilot::Dune, DUNE).unwrap();
    let expected = [("pitch.kp".into(), 1.5, "rad/rad"), ("pitch.kd".into(), 1.1, "rad.s/rad")];
    assert_eq!(gains(&found), expected);
    assert_eq!(
        left_out(&found),
        [(6, "[Control.AUV.Attitude] Depth PID Gains"), (2, "[Control.AUV.Speed] MPS PID Gains")]
    );
    insta::assert_snapshot!(found.toml("control.ini"));
    // A fin of half the effect is deflected twice as far: 0.5/0.25.
    let found = read(Autopilot::Dune, &DUNE.replace("= 0.5\r", "= 0.25\r")).unwrap();
    assert_eq!(gains(&found)[0].1, 3.0);
    // A task enabled on hardware only is accepted, and altitude control gets a note.
    let text = DUNE.replace("= Always", "= Hardware\nAltitude Control -- Enabled = true");
    let found = read(Autopilot::Dune, &text).unwrap();
    insta::assert_snapshot!("altitude", found.further.join("\n"));
    // Without the section of the allocator DUNE's default applies.
    let short = DUNE.split("[Control.AUV.Allocator]").next().unwrap();
    let found = read(Autopilot::Dune, short).unwrap();
    insta::assert_snapshot!("default_fin_effect", &found.gains[0].source);
}

#[test]
fn reads_dune_depth_loop_without_derivative() {
    let text = DUNE.replace("0.6, 0.0, 0.7", "0.6,\n       0.02, 0.0");
    let found = read(Autopilot::Dune, &text).unwrap();
    let depth: Vec<_> = gains(&found).into_iter().skip(2).collect();
    assert_eq!(depth, [("depth.kp".into(), 0.6, "rad/m"), ("depth.ki".into(), 0.02, "rad/(m.s)")]);
    let back = written(Autopilot::Dune, &found.toml("a").replace("0.02", "0.03"), &text).unwrap();
    assert_eq!(back, text.replace("0.02", "0.03"));
    // A loop with derivative is neither read nor written.
    let error = written(Autopilot::Dune, &found.toml("a"), DUNE).unwrap_err();
    assert_eq!(mistake(&error), (6, "[Control.AUV.Attitude] Depth PID Gains".into()));
    insta::assert_snapshot!(error);
}

#[test]
fn imports_mvp_gains_in_given_unit() {
    let found = read(Autopilot::Mvp, MVP).unwrap();
    let expected = [
        ("pitch.kp".into(), 5.0, "N.m/rad"),
        ("pitch.ki".into(), 1.0, "N.m/(rad.s)"),
        ("pitch.kd".into(), 2.0, "N.m.s/rad"),
        ("speed.kp".into(), 10.0, "N.s/m"),
        ("speed.ki".into(), 3.0, "N/m"),
    ];
    assert_eq!(gains(&found), expected);
    assert!(left_out(&found).contains(&(6, "control_modes.flight.surge.d")));
    let alone = read(Autopilot::Mvp, &MVP.replace("{p: 10.0,", "{p: 0.0,")).unwrap();
    assert!(left_out(&alone).contains(&(6, "control_modes.flight.surge.i")));
    let hold = Missing { drive: Some(Drive::Deflection), mode: Some("hold".into()), ..Missing::default() };
    let found = import(Autopilot::Mvp, Angle::Pitch, MVP, "theirs", &hold).unwrap();
    assert_eq!(gains(&found), [("pitch.kp".into(), 6.0, "rad/rad"), ("pitch.kd".into(), 3.5, "rad.s/rad")]);
}

#[test]
fn imports_script_gains_unchanged() {
    let found = read(Autopilot::Mss, MSS).unwrap();
    let values: Vec<f64> = found.gains.iter().map(|gain| gain.value).collect();
    assert_eq!(values, [5.33, 0.43, 10.7]);
    let heave = read(Autopilot::Mss, &format!("{MSS}self.K_w = 5.0\n")).unwrap();
    assert!(left_out(&heave).iter().any(|(_, key)| *key == "K_w"));
    insta::assert_snapshot!(heave.notes().join("\n"));
}

/// The cascades of ArduSub and of squid have the same response to the reference and to pitch, whose rate is s times
/// pitch.
#[test]
fn ardusub_cascade_equals_squid_cascade() {
    let found = read(Autopilot::ArduSub, ARDUSUB).unwrap();
    let (ka, kp, ki, full) = (6.0, 0.135, 0.09, 40.0);
    for omega in [0.03, 0.7, 2.0, 15.0] {
        let s = Complex::new(0.0, omega);
        let g = response("squid", "pitch", &(found.toml("a") + SPEED), 0.2, omega);
        // z of the thrusters: 0.2, -0.1 and -0.1 m.
        let moment = |column: usize| g[0][column] * 0.2 - (g[1][column] + g[2][column]) * 0.1;
        // out = (kp + ki/s) (q_t - q), q_t = ka (r - theta)
        let of_rate = (s.inv() * ki + kp) * full;
        close(moment(0), of_rate * ka);
        close(moment(2) + s * moment(4), -(of_rate * (s + ka)));
    }
    assert_eq!(gains(&found)[3].1, 0.9);
    let without = read(Autopilot::ArduSub, &ARDUSUB.replace("0.09", "0")).unwrap();
    let names: Vec<String> = gains(&without).into_iter().map(|gain| gain.0).collect();
    assert_eq!(names, ["pitch.kp", "pitch.kd"]);
}

/// The reference weight selects one of two cascades with the same feedback.
#[test]
fn refuses_reference_weight_without_ardusub_cascade() {
    let with = |weight: &str, ki: &str| {
        let pitch = format!(
            "kp = {{ value = 36, unit = \"N.m/rad\" }}\nki = {{ value = {ki}, unit = \"N.m/(rad.s)\" }}\n\
             kd = {{ value = 5.4, unit = \"N.m.s/rad\" }}\nreference_weight = {weight}"
        );
        written(Autopilot::ArduSub, &controller(&pitch, SPEED), ARDUSUB)
    };
    assert_eq!(with("0.9", "21.6").unwrap(), ARDUSUB);
    let other = read(Autopilot::ArduSub, &with("0.1", "21.6").unwrap()).unwrap();
    assert!(
        gains(&other).iter().zip([36.0, 21.6, 5.4, 0.1]).all(|(gain, value)| (gain.1 - value).abs() < 1e-9)
    );
    // Weights near 1 and 0 keep their digits.
    let weight = 0.5 * (1.0 + (1.0 - 4.0 * 5.4 * 2e-6 / 36f64.powi(2)).sqrt());
    for weight in [weight, 1.0 - weight] {
        let read = read(Autopilot::ArduSub, &with(&weight.to_string(), "0.000002").unwrap()).unwrap();
        assert!((gains(&read)[1].1 / 2e-6 - 1.0).abs() < 1e-9, "{:?}", gains(&read));
        assert!((gains(&read)[0].1 / 36.0 - 1.0).abs() < 1e-9, "{:?}", gains(&read));
    }
    let (weight, integral) = (with("1.0", "21.6").unwrap_err(), with("0.9", "61").unwrap_err());
    assert_eq!(mistake(&weight), (3, "controller.pitch.reference_weight".into()));
    assert_eq!(mistake(&integral), (5, "controller.pitch.ki".into()));
    insta::assert_snapshot!(format!("{weight}\n{integral}"));
}

/// Files of autopilots with gains of heading and of roll.
const TURNS: [(Autopilot, Angle, &str); 6] = [
    (
        Autopilot::Dune,
        Angle::Heading,
        "[Control.AUV.Attitude]\nHeading PID Gains = 1.5, 0.0, 0.0\nHeading Rate PID Gains = 1.2, 0.3, 0.0\n\
         Maximum Heading Rate = 30\n[Control.AUV.Allocator]\nFin effect N = 0.4\n",
    ),
    (
        Autopilot::Dune,
        Angle::Roll,
        "[Control.AUV.Attitude]\nEnable roll controller = true\nRoll PID Gains = 2.1, 0.1, 0.4\n\
         [Control.AUV.Allocator]\nFin effect K = 0.25\n",
    ),
    (Autopilot::ArduSub, Angle::Heading, "ATC_ANG_YAW_P,6.0\nATC_RAT_YAW_P,0.18\nATC_RAT_YAW_I,0.018\n"),
    (Autopilot::ArduSub, Angle::Roll, "ATC_ANG_RLL_P,6.0\nATC_RAT_RLL_P,0.135\nATC_RAT_RLL_I,0.09\n"),
    (
        Autopilot::Mvp,
        Angle::Heading,
        "control_modes:\n  flight:\n    pitch: {p: 1.0}\n    yaw: {p: 5.0, i: 1.0, d: 2.0, i_max: 5, i_min: -5}\n",
    ),
    (Autopilot::Mvp, Angle::Roll, "control_modes:\n  flight:\n    roll: {p: 5.0, d: 2.0}\n"),
];

/// Gains computed by hand from the laws of the autopilots are imported, and exported to the same bytes.
#[test]
fn imports_and_exports_heading_and_roll_gains() {
    // DUNE: 1.2 (1.5 e - psi') + 0.3 int over 2 x 0.4 N m/rad; 4 fins of 0.25 N m/rad. ArduSub: times 40 N m.
    let expected: [&[f64]; 6] = [
        &[(1.2 * 1.5 + 0.3) / 0.8, 0.3 * 1.5 / 0.8, 1.2 / 0.8, 1.8 / 2.1],
        &[2.1, 0.1, 0.4],
        &[40.0 * (0.18 * 6.0 + 0.018), 40.0 * 0.018 * 6.0, 40.0 * 0.18, 1.08 / 1.098],
        &[40.0 * (0.135 * 6.0 + 0.09), 40.0 * 0.09 * 6.0, 40.0 * 0.135, 0.9],
        &[5.0, 1.0, 2.0],
        &[5.0, 2.0],
    ];
    for ((autopilot, angle, text), expected) in TURNS.into_iter().zip(expected) {
        let found = import(autopilot, angle, text, "theirs", &missing(autopilot)).unwrap();
        assert!(found.gains.iter().all(|gain| gain.table == angle.name()), "{:?}", found.gains);
        assert_eq!(found.gains.len(), expected.len());
        for (gain, expected) in found.gains.iter().zip(expected) {
            assert!((gain.value - expected).abs() < 1e-9 * expected, "{gain:?} {expected}");
        }
        let toml = found.toml("theirs");
        assert!(!toml.contains("[controller.speed]"), "{toml}");
        assert!(toml.lines().all(|line| line.chars().count() <= 100), "{toml}");
        assert_eq!(written(autopilot, &toml, text).unwrap(), text);
    }
}

/// Rejects laws of heading and roll that are not a PID, and gains that are not in use.
#[test]
fn refuses_other_heading_and_roll_laws() {
    let cases = [
        (0, "1.5, 0.0, 0.0", "1.5, 0.1, 0.0", 2, "[Control.AUV.Attitude] Heading PID Gains"),
        (
            0,
            "Maximum Heading Rate = 30",
            "Heading Rate Open Loop = true",
            4,
            "[Control.AUV.Attitude] Heading Rate Open Loop",
        ),
        (1, "controller = true", "controller = false", 2, "[Control.AUV.Attitude] Enable roll controller"),
        (
            1,
            "Enable",
            "Roll Compensation -- Use Speed = true\nEnable",
            2,
            "[Control.AUV.Attitude] Roll Compensation -- Use Speed",
        ),
        (2, "YAW_I", "YAW_FF", 1, "ATC_RAT_YAW_I"),
        (4, "yaw", "x", 1, "control_modes.MODE.yaw"),
    ];
    let mut messages = vec![];
    for (case, from, to, line, key) in cases {
        let (autopilot, angle, text) = TURNS[case];
        assert!(text.contains(from), "{from}");
        let missing = Missing { mode: None, ..missing(autopilot) };
        let error = import(autopilot, angle, &text.replace(from, to), "theirs", &missing).unwrap_err();
        assert_eq!(mistake(&error), (line, key.to_owned()), "{error}");
        messages.push(format!("{autopilot:?}, {angle}, {from:?} -> {to:?}:\n{error}"));
    }
    let error = import(Autopilot::Mss, Angle::Heading, MSS, "theirs", &Missing::default()).unwrap_err();
    assert_eq!(mistake(&error), (1, "--axis".into()));
    messages.push(error.to_string());
    let heading = controller("kp = { value = 3.0, unit = \"rad/rad\" }\n", "").replace("pitch", "heading");
    let error = written(Autopilot::Mss, &heading, MSS).unwrap_err();
    assert_eq!(mistake(&error), (3, "controller.heading".into()));
    messages.push(error.to_string());
    insta::assert_snapshot!(messages.join("\n\n"));
}

/// Exporting imported gains reproduces every file byte for byte.
#[test]
fn exports_imported_gains_unchanged() {
    for (autopilot, text) in ALL {
        let found = read(autopilot, text).unwrap();
        let toml = found.toml("theirs");
        assert_eq!(written(autopilot, &toml, text).unwrap(), text);
        assert!(toml.lines().all(|line| line.chars().count() <= 100), "{toml}");
    }
}

/// Returns the text without the numbers of the gains.
fn frame(
    text: &str,
    changes: &[squid_pid::autopilots::Change],
    of: fn(&squid_pid::autopilots::Change) -> &str,
) -> String {
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    for change in changes.iter().rev() {
        let line = &mut lines[change.line - 1];
        let after = line.rfind(of(change)).unwrap();
        line.replace_range(after..after + of(change).len(), "#");
    }
    lines.join("\n")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Exported and re-imported gains are equal, and nothing else in the file changes.
    #[test]
    fn gains_survive_export_and_import(
        kp in 0.01..50.0_f64, ki in 0.001..1.0_f64, kd in 0.01..50.0_f64,
        surge in 0.1..90.0_f64, effect in 0.1..2.0_f64,
    ) {
        for (autopilot, text) in ALL {
            let text = text.replace("= 0.5\r", &format!("= {effect}\r"));
            // The integral of an ArduSub cascade is bounded, and its reference weight is determined by the gains.
            let ki = if autopilot == Autopilot::ArduSub { ki * kp * kp / (4.0 * kd) } else { ki };
            let weight = 0.5 * (1.0 + (1.0 - 4.0 * kd * ki / (kp * kp)).max(0.0).sqrt());
            let moment = matches!(autopilot, Autopilot::ArduSub | Autopilot::Mvp);
            let units = if moment { ["N.m/rad", "N.m/(rad.s)", "N.m.s/rad"] } else { ["rad/rad", "1/s", "s"] };
            let mut pitch: String = ["kp", "ki", "kd"].iter().zip([kp, ki, kd]).zip(units)
                .map(|((key, value), unit)| format!("{key} = {{ value = {value}, unit = \"{unit}\" }}\n")).collect();
            if autopilot == Autopilot::ArduSub {
                pitch += &format!("reference_weight = {weight}\n");
            }
            let speed = SPEED.replace("30.0", &surge.to_string());
            let pid = squid_pid::read_file(&controller(&pitch, &speed), "mine.toml").unwrap();
            let done = export(autopilot, &pid, &text, "theirs", &missing(autopilot)).unwrap();
            let found = gains(&read(autopilot, &done.text).unwrap());
            let mut expected = vec![kp, ki, kd];
            expected.extend((autopilot == Autopilot::ArduSub).then_some(weight));
            expected.extend((autopilot == Autopilot::Mvp).then_some([surge, 10.0]).into_iter().flatten());
            prop_assert_eq!(found.len(), expected.len());
            for ((name, value, _), expected) in found.iter().zip(&expected) {
                prop_assert!((value - expected).abs() <= 1e-9 * expected, "{} {} {}", name, value, expected);
            }
            prop_assert!(!done.changes.is_empty());
            let (before, after) = (
                frame(&text, &done.changes, |change| &change.from),
                frame(&done.text, &done.changes, |change| &change.to),
            );
            prop_assert_eq!(before, after);
        }
    }
}

/// Rejects values that are ambiguous, missing or not a number.
#[test]
fn refuses_ambiguous_files() {
    use Autopilot::{ArduSub, Dune, Mss, Mvp};
    const GAINS: &str = "[Control.AUV.Attitude] Pitch PID Gains";
    const EFFECT: &str = "[Control.AUV.Allocator] Fin effect M";
    let cases = [
        (Dune, "1.5, 0.0, 1.1 ;", "1.5, 0.0 ;", 7, GAINS),
        (Dune, "1.5, 0.0, 1.1 ;", "nan, 0.0, 1.1 ;", 7, GAINS),
        (Dune, "1.5, 0.0, 1.1 ;", "-1.5, 0.0, 1.1 ;", 7, GAINS),
        (Dune, "1.5, 0.0, 1.1 ;", "0.0, 0.0, 1.1 ;", 7, GAINS),
        (Dune, "1.5, 0.0, 1.1 ;", "$(General, Gains), 0, 1 ;", 7, GAINS),
        (Dune, "; Pitch PID Gains", "Pitch PID Gains", 8, GAINS),
        (Dune, "; Pitch PID Gains", "Pitch PID Gains+", 8, GAINS),
        (Dune, "= false", "= true", 9, "[Control.AUV.Attitude] Error Attitude Compensation"),
        (Dune, "= Always", "= Never", 5, "[Control.AUV.Attitude] Enabled"),
        (
            Dune,
            "\r\nFin effect M",
            "\r\nFin effect Velocity dependent = true\r\nFin effect M",
            12,
            "[Control.AUV.Allocator] Fin effect Velocity dependent",
        ),
        (Dune, "[Control.AUV.Attitude]", "[Control.AUV.Other]", 1, GAINS),
        (Dune, "\r\nFin effect M", "\r\n[Require auv/basic.ini]\r\nFin ", 1, EFFECT),
        (ArduSub, "FF,0", "FF,0.1", 6, "ATC_RAT_PIT_FF"),
        (ArduSub, "IMAX,0.444", "IMAX,0", 8, "ATC_RAT_PIT_IMAX"),
        (ArduSub, "ATC_ANG_PIT_P", "ATC_ANG_RLL_P", 1, "ATC_ANG_PIT_P"),
        (ArduSub, "RLL_P,0.2", "PIT_P,0.2", 7, "ATC_RAT_PIT_P"),
        (ArduSub, "0.135", "inf", 3, "ATC_RAT_PIT_P"),
        (Mvp, "{p: 5.0, ", "{p: five, ", 4, "control_modes.flight.pitch.p"),
        (Mvp, "i_max: 10, i_min: -10}\n    #", "i_max: 10}\n    #", 4, "control_modes.flight.pitch.i"),
        (Mvp, "flight:", "surface:", 1, "control_modes"),
        (Mvp, "control_modes:", "modes:", 1, "control_modes.MODE.pitch"),
        (Mvp, "{p: 5.0, ", "{p: 5.0: ", 4, "control_modes"),
        (Mss, "= 5.33", "= Mauv(5,5) * w_theta^2", 5, "Kp_theta"),
        (Mss, "Kp_z = 0.1", "Kp_theta = 0.1", 5, "Kp_theta"),
        (Mss, "Kp_theta = 5.33", "Kp = 5.33", 1, "Kp_theta"),
    ];
    let mut messages = vec![];
    for (autopilot, from, to, line, key) in cases {
        let text = ALL.iter().find(|(one, _)| *one == autopilot).unwrap().1;
        assert!(text.contains(from), "{from}");
        let changed = text.replacen(from, to, 1);
        let error = import(autopilot, Angle::Pitch, &changed, "theirs", &missing(autopilot)).unwrap_err();
        assert_eq!(mistake(&error), (line, key.to_owned()), "{error}");
        messages.push(format!("{autopilot:?}, {from:?} -> {to:?}:\n{error}"));
    }
    insta::assert_snapshot!(messages.join("\n\n"));
}

#[test]
fn reports_missing_data() {
    let without = |autopilot, text, missing: &Missing| {
        import(autopilot, Angle::Pitch, text, "theirs", missing).unwrap_err()
    };
    let hint = Missing { hint: Some("so much".into()), ..Missing::default() };
    let moment = without(Autopilot::ArduSub, ARDUSUB, &hint);
    assert_eq!(mistake(&moment), (3, "ATC_RAT_PIT_P".into()));
    let mode = without(Autopilot::Mvp, MVP, &Missing::default());
    assert_eq!(mistake(&mode), (1, "control_modes".into()));
    let unit = without(Autopilot::Mvp, MVP, &Missing { mode: Some("hold".into()), ..Missing::default() });
    assert_eq!(mistake(&unit), (9, "control_modes.hold.pitch.p".into()));
    insta::assert_snapshot!(format!("{moment}\n{mode}\n{unit}"));
}

/// Rejects gains that an autopilot cannot represent.
#[test]
fn refuses_to_export_unsupported_terms() {
    use Autopilot::{ArduSub, Dune, Mss, Mvp};
    let radians = "kp = { value = 3.0, unit = \"rad/rad\" }\nkd = { value = 2.0, unit = \"s\" }\n";
    let moments = "kp = { value = 3.0, unit = \"N.m/rad\" }\nkd = { value = 2.0, unit = \"N.m.s/rad\" }\n";
    let depth = "[controller.depth]\nkp = { value = 10.0, unit = \"deg/m\" }\n";
    let speed = "[controller.speed]\nrolloff = 1.0\nkp = { value = 1.0, unit = \"N.s/m\" }\n";
    let table = moments.replace("value = 3.0", "table = [[1.0, 3.0], [2.0, 2.0]]");
    let model = format!("{radians}model = {{ frequency = 1.0, damping = 1.0 }}\n");
    let kp_alone = moments.lines().next().unwrap();
    let cases = [
        (Dune, radians.replace("3.0", "[3.0, 1.0]"), "", 4, "pitch.kp"),
        (Mvp, table, "", 4, "pitch.kp"),
        (Dune, radians.replace("3.0", "-3.0"), "", 4, "pitch.kp"),
        (Dune, format!("{radians}rolloff = 0.1\n"), "", 3, "pitch.rolloff"),
        (Mss, model, "", 3, "pitch.model"),
        (Mss, format!("{radians}reference_weight = 0.8\n"), "", 3, "pitch.reference_weight"),
        (Mss, radians.into(), depth, 7, "depth"),
        (Mvp, moments.into(), depth, 7, "depth"),
        (ArduSub, moments.into(), depth, 7, "depth"),
        (ArduSub, kp_alone.into(), "", 3, "pitch.kd"),
        (ArduSub, radians.into(), "", 4, "pitch.kp"),
        (Mvp, radians.into(), "", 4, "pitch.kp"),
        (Mss, moments.into(), "", 4, "pitch.kp"),
        (Mvp, moments.into(), speed, 7, "speed"),
        (Mvp, moments.replace("N.m/rad", "N.m"), "", 4, "pitch.kp"),
    ];
    let mut messages = vec![];
    for (autopilot, pitch, more, line, key) in cases {
        let text = ALL.iter().find(|(one, _)| *one == autopilot).unwrap().1;
        let error = written(autopilot, &controller(&pitch, more), text).unwrap_err();
        let expected = (line, format!("controller.{key}"));
        assert_eq!((error.file.as_str(), mistake(&error)), ("mine.toml", expected), "{error}");
        messages.push(format!("{autopilot:?}:\n{pitch}{more}{error}"));
    }
    // Limits in the file hold the integral at 0.
    let integral = format!("{moments}ki = {{ value = 0.5, unit = \"N.m/(rad.s)\" }}\n");
    let hold = Missing { mode: Some("hold".into()), ..missing(Mvp) };
    let pid = squid_pid::read_file(&controller(&integral, ""), "mine.toml").unwrap();
    let held = export(Mvp, &pid, MVP, "theirs", &hold).unwrap_err();
    assert_eq!(mistake(&held), (10, "control_modes.hold.pitch.i".into()));
    let limited = written(ArduSub, &controller(&integral, ""), &ARDUSUB.replace("0.444", "0")).unwrap_err();
    assert_eq!(mistake(&limited), (8, "ATC_RAT_PIT_IMAX".into()));
    // The file has no key for the gain.
    let missing = written(Mss, &controller(radians, ""), "Kp_theta = 5.0\n").unwrap_err();
    assert_eq!(mistake(&missing), (1, "Kd_theta".into()));
    messages.extend([held, limited, missing].map(|error| error.to_string()));
    insta::assert_snapshot!(messages.join("\n\n"));
    // An omitted gain is written as 0, and degrees per degree equal radians per radian.
    let found = written(Mss, &controller(&radians.replace("rad/rad", "deg/deg"), SPEED), MSS).unwrap();
    assert_eq!(found, MSS.replace("5.33", "3.0").replace("0.43", "0.0").replace("10.7", "2.0"));
}
