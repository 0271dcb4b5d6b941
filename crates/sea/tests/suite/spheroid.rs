//! Loads on a spheroid against published figures, the pressure integrated over the hull, and a panel method.

use proptest::prelude::*;
use squid_sea::{Axes, Component, GRAVITY, Position, SeaError, Spectrum, Spheroid, Waves};
use std::f64::consts::{PI, TAU};

const DENSITY: f64 = 1025.0;
const NONE: [[f64; 6]; 6] = [[0.0; 6]; 6];

fn sea(heading: f64, seed: u64) -> Waves {
    Waves::new(&Spectrum::jonswap(0.2, 2.0, 3.3).unwrap(), heading, 20, seed).unwrap()
}

/// Returns the axes of a hull turned to a heading, then pitched, then rolled.
fn axes([roll, pitch, heading]: [f64; 3]) -> Axes {
    let rotated = |angle: f64, one: [f64; 3], other: [f64; 3]| {
        let (sin, cos) = angle.sin_cos();
        let mix = |a: f64, b: f64| std::array::from_fn(|i| a * one[i] + b * other[i]);
        (mix(cos, sin), mix(-sin, cos))
    };
    let (ahead, starboard) = rotated(heading, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let (down, ahead) = rotated(pitch, [0.0, 0.0, 1.0], ahead);
    let (starboard, down) = rotated(roll, starboard, down);
    [ahead, starboard, down]
}

fn load(hull: &Spheroid, waves: &Waves, centre: Position, attitude: [f64; 3]) -> [f64; 6] {
    hull.in_waves(waves, centre, &axes(attitude)).1
}

const POSITION: Position = Position { time: 7.0, north: 3.0, east: 0.0, depth: 1.5 };

/// Returns k1, k2 and k' of a prolate spheroid: Lamb (1932), arts. 114 and 115.
fn lamb(a: f64, b: f64) -> [f64; 3] {
    let e2 = 1.0 - (b / a).powi(2);
    let e = e2.sqrt();
    let half_log = 0.5 * ((1.0 + e) / (1.0 - e)).ln();
    let alpha = 2.0 * (1.0 - e2) / (e2 * e) * (half_log - e);
    let beta = 1.0 / e2 - (1.0 - e2) / (e2 * e) * half_log;
    let turn = e2 * e2 * (beta - alpha) / ((2.0 - e2) * (2.0 * e2 - (2.0 - e2) * (beta - alpha)));
    [alpha / (2.0 - alpha), beta / (2.0 - beta), turn]
}

/// Returns a spheroid with the added mass of Lamb.
fn with_added_mass(a: f64, b: f64) -> Spheroid {
    let mass = Spheroid::new(a, b, DENSITY, NONE).unwrap().displacement();
    let [k1, k2, turn] = lamb(a, b);
    let turn = turn * mass * (a * a + b * b) / 5.0;
    let diagonal = [k1 * mass, k2 * mass, k2 * mass, 0.0, turn, turn];
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 }));
    Spheroid::new(a, b, DENSITY, matrix).unwrap()
}

/// Returns the amplitudes of force and moment per metre of wave at a frequency \[rad/s\], from the loads a quarter of a
/// period apart.
fn amplitudes(hull: &Spheroid, heading: f64, depth: f64, frequency: f64) -> [f64; 3] {
    let one = Component { amplitude: 1.0, frequency, number: frequency * frequency / GRAVITY, phase: 0.0 };
    let waves = Waves::of(vec![one], heading);
    let quarter = TAU / frequency / 4.0;
    let position = |time: f64| Position { time, north: 0.0, east: 0.0, depth };
    let loads = [0.0, quarter].map(|time| load(hull, &waves, position(time), [0.0; 3]));
    [0, 2, 4].map(|i| loads[0][i].hypot(loads[1][i]))
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// Head sea of 1.2 rad/s: the published amplitudes per metre, to their digits. Surge and heave are equal there.
#[test]
fn froude_krylov_loads_match_published_values() {
    for (a, b, depth, force, moment, digits) in
        [(2.0, 1.0, 5.0, 5897.21, 520.35, 5e-3), (0.8077, 0.0959, 2.0, 34.1949, 0.645938, 5e-5)]
    {
        let hull = Spheroid::new(a, b, DENSITY, NONE).unwrap();
        let [surge, heave, pitch] = amplitudes(&hull, PI, depth, 1.2);
        close(heave, force, digits);
        close(surge, force, digits);
        close(pitch, moment, digits.min(5e-3));
    }
}

/// The force in long waves is that on water of the same volume; the deviation vanishes with the wave number.
#[test]
fn long_waves_load_the_hull_like_displaced_water() {
    let hull = Spheroid::new(0.8077, 0.0959, DENSITY, NONE).unwrap();
    for frequency in [0.3, 0.1, 0.03] {
        let number = frequency * frequency / GRAVITY;
        let [surge, heave, pitch] = amplitudes(&hull, PI, 2.0, frequency);
        let water = hull.displacement() * GRAVITY * number * (-2.0 * number).exp();
        close(heave / water, 1.0, number);
        close(surge / water, 1.0, number);
        assert!(pitch / water < number);
    }
}

/// Reference: Capytaine 3.0.0, exciting force and moment per metre of wave, deep water, 60 by 90 panels. The panels lie
/// inside the hull: from 24 by 36 over 36 by 60 to 60 by 90 panels the loads converge to within 1.3 %.
#[test]
fn loads_with_diffraction_match_a_panel_method() {
    for (a, b, depth, heading, frequency, expected) in [
        (2.0, 1.0, 5.0, PI, 1.2, [7155.5, 10164.5, 874.65]),
        (1.0, 0.125, 2.0, 0.75 * PI, 2.0, [85.615, 230.584, 12.758]),
    ] {
        let found = amplitudes(&with_added_mass(a, b), heading, depth, frequency);
        for (found, expected) in found.into_iter().zip(expected) {
            close(found / expected, 1.0, 0.02);
        }
    }
}

/// Diffraction multiplies force and moment by `1 + k1`, `1 + k2`, `1 + k' ((a^2 + b^2)/(a^2 - b^2))^2`.
#[test]
fn diffraction_multiplies_the_load() {
    let (a, b) = (1.5, 0.4);
    let [k1, k2, turn] = lamb(a, b);
    let slender = ((a * a + b * b) / (a * a - b * b)).powi(2);
    let bare = amplitudes(&Spheroid::new(a, b, DENSITY, NONE).unwrap(), 2.0, 3.0, 1.5);
    let full = amplitudes(&with_added_mass(a, b), 2.0, 3.0, 1.5);
    for (i, factor) in [1.0 + k1, 1.0 + k2, 1.0 + turn * slender].into_iter().enumerate() {
        close(full[i] / bare[i], factor, 1e-12);
    }
    // Table of Lamb, p. 155, to one unit of its last digit.
    for (ratio, printed) in [(8.01, [0.029, 0.945, 0.840]), (9.97, [0.021, 0.960, 0.883])] {
        lamb(ratio, 1.0).into_iter().zip(printed).for_each(|(found, printed)| close(found, printed, 1e-3));
    }
}

/// Returns force and moment of the pressure on the hull, by the midpoint rule along it and around it.
fn integrated(
    waves: &Waves,
    centre: Position,
    axes: &Axes,
    heading: f64,
    [a, b]: [f64; 2],
    [rings, parts]: [i32; 2],
) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for ring in 0..rings {
        let polar = PI * (f64::from(ring) + 0.5) / f64::from(rings);
        for part in 0..parts {
            let around = TAU * (f64::from(part) + 0.5) / f64::from(parts);
            let unit = [polar.cos(), polar.sin() * around.sin(), polar.sin() * around.cos()];
            let r = [a * unit[0], b * unit[1], b * unit[2]];
            let [north, east, down]: [f64; 3] =
                std::array::from_fn(|j| (0..3).map(|i| r[i] * axes[i][j]).sum::<f64>());
            let crest = (centre.north + north) * heading.cos() + (centre.east + east) * heading.sin();
            let pressure = |wave: &Component| {
                let angle = wave.number * crest - wave.frequency * centre.time + wave.phase;
                let depth = centre.depth + down;
                DENSITY * GRAVITY * wave.amplitude * (-wave.number * depth).exp() * angle.cos()
            };
            let pressure: f64 = waves.components().iter().map(pressure).sum();
            let area = a * b * b * polar.sin() * (PI / f64::from(rings)) * (TAU / f64::from(parts));
            let [x, y, z] = [-unit[0] / a, -unit[1] / b, -unit[2] / b].map(|one| one * area * pressure);
            let load_part = [x, y, z, r[1] * z - r[2] * y, r[2] * x - r[0] * z, r[0] * y - r[1] * x];
            sums.iter_mut().zip(load_part).for_each(|(sum, one)| *sum += one);
        }
    }
    sums
}

fn size(load: &[f64]) -> f64 {
    load.iter().fold(0.0f64, |most, one| most.max(one.abs()))
}

/// Oblique waves on a hull at a large attitude: force and moment, yaw included, with a fine rule.
#[test]
fn oblique_wave_load_is_the_pressure_integral() {
    let heading = 1.1;
    let (waves, attitude) = (sea(heading, 4), [0.7, -0.3, 2.4]);
    let found = load(&Spheroid::new(1.0, 0.2, DENSITY, NONE).unwrap(), &waves, POSITION, attitude);
    let expected = integrated(&waves, POSITION, &axes(attitude), heading, [1.0, 0.2], [4000, 48]);
    let (force, moment) = (size(&expected[..3]), size(&expected[3..]));
    for i in 0..6 {
        close(found[i], expected[i], 1e-6 * if i < 3 { force } else { moment });
    }
    assert!(found[3] == 0.0 && found[5].abs() > 0.1 * moment);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// Short waves, any heading, any attitude: the closed form equals the integral.
    #[test]
    fn froude_krylov_load_is_the_pressure_integral(
        heading in -PI..PI, seed in 0u64..100, time in 0.0..100.0, radius in 0.1..0.9,
        roll in -3.0..3.0, pitch in -1.2..1.2, hull_heading in -3.0..3.0,
    ) {
        let (waves, attitude) = (sea(heading, seed), [roll, pitch, hull_heading]);
        let centre = Position { time, north: 3.0, east: -2.0, depth: 1.5 };
        let found = load(&Spheroid::new(1.0, radius, DENSITY, NONE).unwrap(), &waves, centre, attitude);
        let expected = integrated(&waves, centre, &axes(attitude), heading, [1.0, radius], [200, 120]);
        for i in 0..6 {
            close(found[i], expected[i], 2e-3 * size(&expected));
        }
    }

    /// The motion returned with the load is that of the water at the centre.
    #[test]
    fn motion_is_that_of_the_waves(time in 0.0..100.0, depth in 1.0..10.0) {
        let waves = sea(1.0, 5);
        let position = Position { time, north: -2.0, east: 1.0, depth };
        let hull = Spheroid::new(1.0, 0.1, DENSITY, NONE).unwrap();
        prop_assert_eq!(hull.in_waves(&waves, position, &axes([0.1, 0.3, 0.2])).0, waves.motion(position));
    }

    /// The load depends on the difference of the headings of hull and waves only.
    #[test]
    fn load_depends_on_the_relative_heading(
        heading in -PI..PI, hull_heading in -3.0..3.0, roll in -3.0..3.0, pitch in -1.2..1.2, distance in -10.0..10.0,
    ) {
        let hull = with_added_mass(0.8, 0.1);
        let (sin, cos) = f64::sin_cos(hull_heading);
        let there = Position { north: distance * cos, east: distance * sin, ..POSITION };
        let rotated = load(&hull, &sea(heading, 3), there, [roll, pitch, hull_heading]);
        let relative = sea(heading - hull_heading, 3);
        let ahead = load(&hull, &relative, Position { north: distance, ..POSITION }, [roll, pitch, 0.0]);
        (0..6).for_each(|i| close(rotated[i], ahead[i], 1e-10 * size(&ahead)));
    }

    /// Reflection at the vertical plane reverses sway, roll and yaw.
    #[test]
    fn load_is_symmetric_to_port_and_starboard(
        heading in -PI..PI, hull_heading in -3.0..3.0, roll in -3.0..3.0, pitch in -1.2..1.2, east in -10.0..10.0,
    ) {
        let hull = with_added_mass(0.8, 0.1);
        let one = load(&hull, &sea(heading, 3), Position { east, ..POSITION }, [roll, pitch, hull_heading]);
        let other = load(&hull, &sea(-heading, 3), Position { east: -east, ..POSITION }, [-roll, pitch, -hull_heading]);
        let sides = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        (0..6).for_each(|i| close(other[i], sides[i] * one[i], 1e-10 * size(&one)));
    }

    /// A roll of 90 degrees turns starboard down and down to port: for an axisymmetric hull and added mass, `[X Y Z K M
    /// N]` becomes `[X Z -Y K N -M]`.
    #[test]
    fn quarter_turn_of_roll_turns_heave_into_sway(
        heading in -PI..PI, hull_heading in -3.0..3.0, roll in -3.0..3.0, pitch in -1.2..1.2,
    ) {
        let (hull, waves) = (with_added_mass(0.8, 0.1), sea(heading, 3));
        let [x, y, z, k, m, n] = load(&hull, &waves, POSITION, [roll, pitch, hull_heading]);
        let rolled = load(&hull, &waves, POSITION, [roll + PI / 2.0, pitch, hull_heading]);
        for (found, expected) in rolled.into_iter().zip([x, z, -y, k, n, -m]) {
            close(found, expected, 1e-10 * size(&rolled));
        }
    }
}

/// Figures of the first version, which covered the vertical plane only: load ahead, down and bow up, its derivatives
/// with respect to time, north, depth and pitch, and the velocity of the water.
#[test]
fn vertical_plane_matches_the_first_version() {
    let mut mass = NONE;
    (mass[0][0], mass[2][2], mass[4][4]) = (2.0, 60.0, 10.0);
    (mass[2][4], mass[4][2]) = (-3.0, -3.0);
    let hull = Spheroid::new(1.0, 0.125, DENSITY, mass).unwrap();
    let waves = sea(2.5, 7);
    let position = Position { time: 12.0, north: 3.0, east: 0.0, depth: 1.5 };
    let axes = axes([0.0, 0.3, 0.0]);
    let (motion, load) = hull.in_waves(&waves, position, &axes);
    let slopes = hull.slopes_in_waves(&waves, position, &axes);
    for (found, expected) in [load, slopes[0], slopes[1], slopes[3], slopes[5]].into_iter().zip(FIRST) {
        [0, 2, 4].into_iter().zip(expected).for_each(|(i, expected)| close(found[i], expected, 1e-12));
    }
    close(motion.velocity[0], -0.006186339834136527, 1e-14);
    close(motion.velocity[2], 0.04808523319620443, 1e-14);
}

const FIRST: [[f64; 3]; 5] = [
    [5.943763740569612, 3.8374307949908175, 1.7703807620398757],
    [2.708945797633983, -36.76745970161031, -1.7030733934100089],
    [-0.9155902917187956, -8.301526065247833, -1.3420950211278024],
    [-4.992759011042701, 4.231830166474834, -2.751045403440979],
    [-2.6174074575058563, 7.767437292736171, -0.3402134743891357],
];

#[test]
fn returns_top_of_hull() {
    let hull = Spheroid::new(1.0, 0.125, DENSITY, NONE).unwrap();
    for (station, pitch, expected) in [
        (0.0, 0.0, [0.0, 0.125]),
        (1.0, 0.0, [1.0, 0.0]),
        (1.0, PI / 2.0, [0.0, 1.0]),
        (-1.0, PI / 6.0, [-(0.75f64.sqrt()), -0.5]),
        (0.6, 0.0, [0.6, 0.1]),
    ] {
        hull.top(station, pitch).into_iter().zip(expected).for_each(|(found, one)| close(found, one, 1e-15));
    }
    close(hull.displacement(), 4.0 / 3.0 * PI * 0.125 * 0.125 * DENSITY, 1e-9);
}

#[test]
fn rejects_invalid_hulls() {
    for (a, b, density, mass, key) in [
        (1.0, 1.0, DENSITY, 0.0, "length"),
        (1.0, 0.0, DENSITY, 0.0, "diameter"),
        (1.0, 0.1, 0.0, 0.0, "density"),
        (f64::NAN, 0.1, DENSITY, 0.0, "length"),
        (1.0, 0.1, DENSITY, f64::NAN, "added_mass"),
    ] {
        let error = Spheroid::new(a, b, density, [[mass; 6]; 6]).unwrap_err();
        assert!(matches!(error, SeaError::NotAllowed { key: found, .. } if found == key), "{error}");
    }
}

proptest! {
    /// Derivatives of the load against differences: short and long waves, any attitude.
    #[test]
    fn slopes_match_differences(
        heading in -PI..PI, roll in -3.0..3.0, pitch in -1.0..1.0, hull_heading in -3.0..3.0, north in -50.0..50.0,
        east in -50.0..50.0, depth in 1.0..5.0, period in 0.6..8.0,
    ) {
        let spectrum = Spectrum::jonswap(0.01, period, 3.3).unwrap();
        let waves = Waves::new(&spectrum, heading, 20, 5).unwrap();
        let hull = with_added_mass(0.8, 0.1);
        let axes = axes([roll, pitch, hull_heading]);
        // Small rotations about each body axis.
        let at = |[time, north, east, depth, p, q, r]: [f64; 7]| {
            let rotated: Axes = std::array::from_fn(|i| std::array::from_fn(|j| {
                let turn = [[0.0, r, -q], [-r, 0.0, p], [q, -p, 0.0]];
                axes[i][j] + (0..3).map(|l| turn[i][l] * axes[l][j]).sum::<f64>()
            }));
            hull.in_waves(&waves, Position { time, north, east, depth }, &rotated).1
        };
        let here = [3.0, north, east, depth, 0.0, 0.0, 0.0];
        let exact = hull.slopes_in_waves(&waves, Position { time: 3.0, north, east, depth }, &axes);
        let size: [f64; 6] = std::array::from_fn(|i| 0.1 + exact.iter().map(|slope| slope[i].abs()).sum::<f64>());
        for (j, slope) in exact.into_iter().enumerate() {
            let h = 1e-5;
            let shifted = |by: f64| at(std::array::from_fn(|i| if i == j { here[i] + by } else { here[i] }));
            let (above, below) = (shifted(h), shifted(-h));
            for i in 0..6 {
                close((above[i] - below[i]) / (2.0 * h), slope[i], 1e-6 * size[i]);
            }
        }
    }
}
