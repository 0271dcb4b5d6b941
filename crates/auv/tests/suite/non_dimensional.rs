//! Vehicle files with non-dimensional numbers, against published dimensional ones.

use crate::common::{message, places};
use squid_auv::toml_file::FileError;
use squid_auv::{Effect, Vehicle};

/// Returns the file of NPS AUV II, prime-I with L = 5.3 m, with the coefficients of A. J. Healey, D. Lienard, IEEE J.
/// Oceanic Engineering 18(3), 1993, as listed in MSS (github.com/cybergalactic/MSS, npsauv.m). Z and M of the stern
/// planes are Z_ds and M_ds.
fn nps() -> String {
    let prime = |key: &str, value: &str| {
        format!("{key} = {{ value = {value}, unit = \"prime\", source = \"Healey and Lienard (1993)\" }}\n")
    };
    let si = |key: &str, value: &str, unit: &str| {
        format!("{key} = {{ value = {value}, unit = \"{unit}\", source = \"Healey and Lienard (1993)\" }}\n")
    };
    [
        "[vehicle]\nname = \"nps\"\nstatus = \"published\"\ndescription = \"NPS AUV II\"\n".to_owned(),
        "[non_dimensional]\nsystem = \"prime-I\"\n".to_owned(),
        si("length", "5.3", "m") + &si("density", "1000.0", "kg/m3"),
        "[mass]\n".to_owned() + &si("mass", "5454.54", "kg") + &si("weight", "53400.0", "N"),
        si("z_G", "0.061", "m") + &si("I_yy", "13587.0", "kg.m2"),
        "[buoyancy]\n".to_owned() + &si("buoyancy", "53400.0", "N"),
        "[water]\n".to_owned() + &si("density", "1000.0", "kg/m3"),
        "[added_mass]\n".to_owned() + &prime("X_u_dot", "-7.6e-3") + &prime("Z_w_dot", "-2.4e-1"),
        prime("Z_q_dot", "-6.8e-3") + &prime("M_w_dot", "-6.8e-3") + &prime("M_q_dot", "-1.7e-2"),
        "[lift]\nconvention = \"combined\"\n".to_owned() + &prime("Z_uw", "-3.0e-1"),
        prime("Z_uq", "-1.4e-1") + &prime("M_uw", "1.0e-1") + &prime("M_uq", "-6.8e-2"),
        "[[control_surface]]\nname = \"planes\"\n".to_owned() + &prime("Z_uu_delta", "-7.3e-2"),
        prime("M_uu_delta", "-4.1e-2"),
        si("min", "-20.0", "deg") + &si("max", "20.0", "deg") + &si("lag", "0.1", "s"),
    ]
    .concat()
}

/// Mass matrix printed by SIMURV for this vehicle, in SI units and four digits.
///
/// Source: G. Antonelli, SIMURV 4.0 (2013), `InverseDynamics_vehicle_d.m`. Its M_11 and M_15 are off by 2e-4 and 7e-4,
/// since it uses another mass there.
#[test]
fn mass_matrix_of_nps_auv_ii_matches_the_published_one() {
    let vehicle = Vehicle::parse(&nps(), "nps.toml").unwrap();
    let mass = vehicle.coefficients.mass_matrix();
    for (row, column, printed) in
        [(0, 0, 6.019e3), (0, 2, 3.325e2), (1, 1, 2.332e4), (1, 2, 2.683e3), (2, 1, 2.683e3), (2, 2, 4.913e4)]
    {
        let found = mass[(row, column)];
        assert!((found - printed).abs() < 1e-3 * printed, "M[{row},{column}]: {found} and {printed}");
    }
}

/// Scales r2 to r5 = rho L^2/2 to rho L^5/2, as in MSS; the combined lift is split afterwards.
#[test]
fn coefficients_scale_with_their_power_of_the_length() {
    let vehicle = Vehicle::parse(&nps(), "nps.toml").unwrap();
    let [r2, r3, r4, r5] = [2, 3, 4, 5].map(|power| 0.5 * 1000.0 * 5.3_f64.powi(power));
    let c = &vehicle.coefficients;
    let Effect::ControlSurface { Z_uu_delta, M_uu_delta, .. } = vehicle.actuators[0].effect else { panic!() };
    for (found, expected) in [
        (c.X_u_dot, -7.6e-3 * r3),
        (c.Z_q_dot, -6.8e-3 * r4),
        (c.M_q_dot, -1.7e-2 * r5),
        (c.Z_uw, -3.0e-1 * r2),
        (c.Z_uq, (-1.4e-1 - 7.6e-3) * r3),
        (c.M_uw, (1.0e-1 - 2.4e-1 + 7.6e-3) * r3),
        (c.M_uq, (-6.8e-2 - 6.8e-3) * r4),
        (Z_uu_delta, -7.3e-2 * r2),
        (M_uu_delta, -4.1e-2 * r3),
    ] {
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} and {expected}");
    }
}

fn read(text: &str, changes: &[(&str, &str)]) -> Result<Vehicle, FileError> {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    Vehicle::parse(&text, "nps.toml")
}

/// Prime-II has rho L^2 T/2 for the mass; with T = L both systems agree. Forces, inertia and linear damping follow
/// Fossen (2011), table 7.2.
#[test]
fn scales_of_both_systems_include_the_speed() {
    let text = nps();
    let speed = "speed = { value = 1.5, unit = \"m/s\", source = \"s\" }\n";
    let linear = "[damping]\nZ_w = { value = -0.01, unit = \"prime\", source = \"s\" }\n\
        M_q = { value = -0.02, unit = \"prime\", source = \"s\" }\n[[control";
    let inertia = ("I_yy = { value = 13587.0, unit = \"kg.m2\"", "I_yy = { value = 0.0065, unit = \"prime\"");
    let buoyancy =
        ("buoyancy = { value = 53400.0, unit = \"N\"", "buoyancy = { value = 0.0017, unit = \"prime\"");
    let one = ("system = \"prime-I\"\n", &*format!("system = \"prime-I\"\n{speed}"));
    let draught = "draught = { value = 0.7, unit = \"m\", source = \"s\" }\n";
    let two = ("system = \"prime-I\"\n", &*format!("system = \"prime-II\"\n{draught}{speed}"));
    let (length, rho, u) = (5.3_f64, 1000.0, 1.5);
    for (system, second) in [(one, length), (two, 0.7)] {
        let vehicle = read(&text, &[("[[control", linear), inertia, buoyancy, system]).unwrap();
        let c = vehicle.coefficients;
        for (found, expected) in [
            (c.Z_w_dot, -0.24 * 0.5 * rho * length.powi(2) * second),
            (c.I_yy, 0.0065 * 0.5 * rho * length.powi(4) * second),
            (c.buoyancy, 0.0017 * 0.5 * rho * u * u * length * second),
            (c.Z_w, -0.01 * 0.5 * rho * u * length * second),
            (c.M_q, -0.02 * 0.5 * rho * u * length.powi(3) * second),
        ] {
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} and {expected}");
        }
    }
}

#[test]
fn reports_mistakes_in_the_system() {
    let text = nps();
    let line = |marker: &str| text.lines().position(|line| line.starts_with(marker)).unwrap() + 1;
    let (system, table) = (line("system"), line("[non_dimensional]"));
    let weight = ("weight = { value = 53400.0, unit = \"N\"", "weight = { value = 0.7, unit = \"prime\"");
    let slug = ("unit = \"prime\"", "unit = \"slug\"");
    let mut messages = vec![];
    for (change, line, key) in [
        (("prime-I", "prime"), system, "non_dimensional.system"),
        (("prime-I", "prime-II"), table, "non_dimensional.draught"),
        (weight, table, "non_dimensional.speed"),
        (slug, line("X_u_dot"), "added_mass.X_u_dot"),
    ] {
        messages.push(message(change.1, &read(&text, &[change]).unwrap_err(), (line, key)));
    }
    let section = &text[text.find("[non_dimensional]").unwrap()..text.find("[mass]").unwrap()];
    let none = read(&text, &[(section, "")]).unwrap_err();
    assert_eq!(places(&none)[0].1, "non_dimensional");
    messages.push(format!("no system:\n{}", none.mistakes[0].problem));
    insta::assert_snapshot!(messages.join("\n\n"));
}
