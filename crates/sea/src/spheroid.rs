//! The load of waves on a prolate spheroid.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use crate::waves::{Orbits, Place, WaterMotion, Waves};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the series of f and g about 0: below |s| = 1 the next one is less than rounding.
const TERMS: usize = 10;

/// The axes of a body, forward, to starboard and down: each as a unit vector \[north, east, down\].
pub type Axes = [[f64; 3]; 3];

/// \[X Y Z K M N\] along the body.
type Load = [f64; 6];

/// A submerged prolate spheroid, with the masses of water that its acceleration moves.
///
/// The pressure of a component in the water that the hull displaces is `density g E exp(i K r)`, r from the centre,
/// with the complex wave vector K, `k [cos(heading), sin(heading), i]` north, east and down, along the body. `K K = 0`.
/// With V the volume, a and b the half axes and `s^2 = (a^2 - b^2) K1^2`, integrated over the hull without
/// approximation:
///
/// ```text
/// [X, Y, Z] = -density g V Re(i K f E)          f = 3 (sin s - s cos s)/s^3
/// M =  density g V (a^2 - b^2) Re(K1 K3 g E)    g = f'(s)/s
/// N = -density g V (a^2 - b^2) Re(K1 K2 g E)    K = 0
/// ```
///
/// That is the Froude-Krylov load. In waves that are long beside the hull, diffraction adds `A alpha`, with the added
/// mass A and the water's mean acceleration along the hull: `[X, Y, Z]/(density V)` and, for the rate of turn whose
/// flow about the hull is the one that a strain of the water makes, `5 [0, M, N] (a^2 + b^2)/(density V (a^2 -
/// b^2)^2)`. For the spheroid alone these are the factors `1 + k1`, `1 + k2` and `1 + k' ((a^2 + b^2)/(a^2 - b^2))^2`.
///
/// Sources: Newman, Marine Hydrodynamics (1977), chapter 4 (a body in accelerated water); Lamb,
/// Hydrodynamics (1932), arts. 114 and 115 (k1, k2, k').
#[derive(Clone, Debug, PartialEq)]
pub struct Spheroid {
    /// Half the length a \[m\].
    half_length: f64,
    /// Half the diameter b \[m\].
    radius: f64,
    density: f64,
    added_mass: [[f64; 6]; 6],
}

impl Spheroid {
    /// A spheroid of half axes a and b \[m\] in water of a density \[kg/m3\], with its added mass about its centre
    /// \[kg, kg m, kg m2\]: the load \[X Y Z K M N\] by each acceleration, positive on the diagonal.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`]: a hull that is not slender, an added mass that is not finite.
    pub fn new(
        half_length: f64,
        radius: f64,
        density: f64,
        added_mass: [[f64; 6]; 6],
    ) -> Result<Self, SeaError> {
        check("density", density, density > 0.0, "above 0 (kg/m3)")?;
        check("diameter", 2.0 * radius, radius > 0.0, "above 0 (m)")?;
        check("length", 2.0 * half_length, half_length > radius, "above the diameter")?;
        for entry in added_mass.as_flattened() {
            check("added_mass", *entry, true, "a finite number")?;
        }
        Ok(Self { half_length, radius, density, added_mass })
    }

    /// The mass of the water that it displaces \[kg\].
    pub fn displacement(&self) -> f64 {
        4.0 / 3.0 * PI * self.half_length * self.radius * self.radius * self.density
    }

    /// Returns the top of the hull at a station from -1, the stern, to 1, the bow: how far it lies ahead of the centre,
    /// and above it \[m\].
    pub fn top(&self, station: f64, pitch: f64) -> [f64; 2] {
        let (sin, cos) = pitch.sin_cos();
        let (along, up) = (self.half_length * station, self.radius * (1.0 - station * station).sqrt());
        [along * cos - up * sin, along * sin + up * cos]
    }

    /// Returns the water's motion at the centre, and the load \[X Y Z K M N\] about it \[N, N m\], along the body.
    pub fn in_waves(&self, waves: &Waves, centre: Place, axes: &Axes) -> (WaterMotion, Load) {
        let unit = wave_vector(waves, axes);
        let square = unit[0] * unit[0] * self.focal();
        let (mut orbits, mut pushed, mut turned) = (Orbits::default(), Complex64::ZERO, Complex64::ZERO);
        for (wave, value) in waves.at(centre) {
            let k = wave.number;
            let (f, g) = form(square * (k * k));
            orbits.add(wave, value);
            pushed += f * value * k;
            turned += g * value * (k * k);
        }
        (orbits.motion(waves), self.load(unit, pushed, turned))
    }

    /// Returns the derivatives of the load by time \[N/s, N m/s\], by the way north, that east and depth \[N/m, N\],
    /// and by a turn about each axis of the body \[N/rad, N m/rad\].
    ///
    /// E grows by `-i w` in time and by `i K` over the place. A turn about an axis e changes the wave vector by `dK = K
    /// x e`, so that `df = c K1 dK1 g` and `dg = c K1 dK1 h`, with `c = a^2 - b^2` and `h = g'(s)/s`.
    pub fn slopes_in_waves(&self, waves: &Waves, centre: Place, axes: &Axes) -> [Load; 7] {
        let unit @ [k1, k2, k3] = wave_vector(waves, axes);
        let square = k1 * k1 * self.focal();
        let mut sums = [Complex64::ZERO; 7];
        for (wave, value) in waves.at(centre) {
            let (w, k) = (wave.frequency, wave.number);
            let square = square * (k * k);
            let (f, g) = form(square);
            let h = next_form(square, f, g) * value * k.powi(4);
            let (f, g) = (f * value * k, g * value * (k * k));
            let parts = [f, g, w * f, w * g, k * f, k * g, h];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        }
        let [pushed, turned, later, later_turned, along, along_turned, h] = sums;
        let grown = |by: Complex64, pushed, turned| self.load(unit, by * pushed, by * turned);
        let [north, east, down] = waves.gradient().map(|way| grown(Complex64::I * way, along, along_turned));
        let turns = [[Complex64::ZERO, k3, -k2], [-k3, Complex64::ZERO, k1], [k2, -k1, Complex64::ZERO]];
        let [ahead, starboard, below] = turns.map(|dk| {
            let grown = self.focal() * k1 * dk[0];
            let force = |j: usize| dk[j] * pushed + unit[j] * grown * along_turned;
            let moment = |j: usize| (dk[0] * unit[j] + k1 * dk[j]) * turned + k1 * unit[j] * grown * h;
            self.with_diffraction([0, 1, 2].map(force), [2, 1].map(moment))
        });
        [grown(-Complex64::I, later, later_turned), north, east, down, ahead, starboard, below]
    }

    /// The load by the sums of `k f E` and `k^2 g E`, and the wave vector of a wave number of 1.
    fn load(&self, unit: [Complex64; 3], pushed: Complex64, turned: Complex64) -> Load {
        let [k1, k2, k3] = unit;
        self.with_diffraction(unit.map(|one| one * pushed), [k1 * k3 * turned, k1 * k2 * turned])
    }

    /// a^2 - b^2.
    fn focal(&self) -> f64 {
        self.half_length * self.half_length - self.radius * self.radius
    }

    /// The load of the pressure by `K f E`, `K1 K3 g E` and `K1 K2 g E`, with that of the scattered waves.
    fn with_diffraction(&self, [x, y, z]: [Complex64; 3], [pitch, yaw]: [Complex64; 2]) -> Load {
        let (displaced, focal) = (self.displacement(), self.focal());
        // In units of that on the mass of a unit of water.
        let load = [x.im, y.im, z.im, 0.0, focal * pitch.re, -focal * yaw.re];
        let sum = self.half_length * self.half_length + self.radius * self.radius;
        let [surge, sway, heave, roll, pitch, yaw] = load;
        let [pitching, yawing] = [pitch, yaw].map(|one| one * 5.0 * sum / (focal * focal));
        let mean = [surge, sway, heave, roll, pitching, yawing].map(|one| one * GRAVITY);
        std::array::from_fn(|i| {
            let row = self.added_mass[i].iter().zip(mean);
            row.fold(displaced * GRAVITY * load[i], |sum, (mass, mean)| sum + mass * mean)
        })
    }
}

/// The complex wave vector of a wave number of 1 along a body.
fn wave_vector(waves: &Waves, axes: &Axes) -> [Complex64; 3] {
    let [north, east, down] = waves.gradient();
    axes.map(|axis| north * axis[0] + east * axis[1] + down * axis[2])
}

/// Returns `f = 3 (sin s - s cos s)/s^3` and `g = f'(s)/s = 3 ((s^2 - 3) sin s + 3 s cos s)/s^5` by the square of s: by
/// `f = 3 sum (-1)^n (2n + 2)/(2n + 3)! s^2n` near 0.
fn form(square: Complex64) -> (Complex64, Complex64) {
    if square.norm_sqr() < 1.0 {
        let (mut f, mut g, mut power, mut factor) = (Complex64::ZERO, Complex64::ZERO, Complex64::ONE, 1.0);
        for n in 0..TERMS {
            let (order, next) = (2.0 * n as f64, power * square);
            // `factor` is (-1)^n 3 (2n + 2)/(2n + 3)!, and that of the next order follows.
            f += power * factor;
            let after = -factor / ((order + 2.0) * (order + 5.0));
            g += power * (after * (order + 2.0));
            (power, factor) = (next, after);
        }
        return (f, g);
    }
    let s = square.sqrt();
    let (sin, cos) = (s.sin(), s.cos());
    let f = 3.0 * (sin - s * cos) / (square * s);
    let g = 3.0 * ((square - 3.0) * sin + 3.0 * s * cos) / (square * square * s);
    (f, g)
}

/// Returns `h = g'(s)/s = -(f + 5 g)/s^2`, as the spherical Bessel functions `f = 3 j1/s`, `g = -3 j2/s^2`, `h = 3
/// j3/s^3` follow from each other; near 0 by its series.
fn next_form(square: Complex64, f: Complex64, g: Complex64) -> Complex64 {
    if square.norm_sqr() < 1.0 {
        // 3 sum (-1)^n (2n + 2)(2n + 4)(2n + 6)/(2n + 7)! s^2n.
        let (mut h, mut term) = (Complex64::ZERO, Complex64::new(3.0 * 48.0 / 5040.0, 0.0));
        for n in 0..TERMS {
            h += term;
            let order = 2.0 * n as f64;
            term *= -square / ((order + 2.0) * (order + 9.0));
        }
        return h;
    }
    -(f + 5.0 * g) / square
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series and closed form meet where one takes over from the other, on the whole circle.
    #[test]
    fn series_and_closed_form_agree() {
        for i in 0..16 {
            let unit = Complex64::from_polar(1.0, f64::from(i) * PI / 8.0);
            let (inside, outside) = (form(unit * (1.0 - 1e-13)), form(unit * (1.0 + 1e-13)));
            assert!((inside.0 - outside.0).norm() < 1e-12 && (inside.1 - outside.1).norm() < 1e-12);
            let next = |part: f64, (f, g)| next_form(unit * part, f, g);
            assert!((next(1.0 - 1e-13, inside) - next(1.0 + 1e-13, outside)).norm() < 1e-12);
        }
        let (f, g) = form(Complex64::ZERO);
        assert_eq!((f.re, g.re), (1.0, -0.2));
    }
}
