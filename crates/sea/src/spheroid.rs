//! Wave loads on a prolate spheroid.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use crate::waves::{Orbits, Position, WaterMotion, Waves};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Number of terms of the series of f and g about 0: for |s| < 1 the next term is below rounding.
const TERMS: usize = 10;

/// Body axes, forward, to starboard and down: unit vectors \[north, east, down\].
pub type Axes = [[f64; 3]; 3];

/// Load \[X Y Z K M N\] in body axes.
type Load = [f64; 6];

/// Submerged prolate spheroid with its added mass.
///
/// The pressure of a wave component over the displaced volume is `density g E exp(i K r)`, with r from the centre and
/// the complex wave vector K in body axes, `k [cos(heading), sin(heading), i]` in north, east and down; `K K = 0`. With
/// the volume V, the semi-axes a and b and `s^2 = (a^2 - b^2) K1^2`, the exact integral over the hull is:
///
/// ```text
/// [X, Y, Z] = -density g V Re(i K f E)          f = 3 (sin s - s cos s)/s^3
/// M =  density g V (a^2 - b^2) Re(K1 K3 g E)    g = f'(s)/s
/// N = -density g V (a^2 - b^2) Re(K1 K2 g E)    K = 0
/// ```
///
/// This is the Froude-Krylov load. In waves that are long compared with the hull, diffraction adds `A alpha`, with the
/// added mass A and the acceleration alpha of the water: the mean over the hull, `[X, Y, Z]/(density V)`, and the
/// angular acceleration whose flow about the hull equals that of the strain of the water, `5 [0, M, N] (a^2 +
/// b^2)/(density V (a^2 - b^2)^2)`. For the added mass of the spheroid itself the factors are `1 + k1`, `1 + k2` and `1
/// + k' ((a^2 + b^2)/(a^2 - b^2))^2`.
///
/// Sources: Newman, Marine Hydrodynamics (1977), chapter 4 (body in accelerated water); Lamb, Hydrodynamics (1932),
/// arts. 114 and 115 (k1, k2, k').
#[derive(Clone, Debug, PartialEq)]
pub struct Spheroid {
    /// Half length a \[m\].
    half_length: f64,
    /// Radius b \[m\].
    radius: f64,
    density: f64,
    added_mass: [[f64; 6]; 6],
}

impl Spheroid {
    /// Returns a spheroid of semi-axes a and b \[m\] in water of a density \[kg/m3\], with the added mass about its
    /// centre \[kg, kg m, kg m2\]: load \[X Y Z K M N\] per acceleration, positive on the diagonal.
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

    /// Returns the displaced mass of water \[kg\].
    pub fn displacement(&self) -> f64 {
        4.0 / 3.0 * PI * self.half_length * self.radius * self.radius * self.density
    }

    /// Returns the point on top of the hull at a station from -1, the stern, to 1, the bow: its distance ahead of the
    /// centre and above it \[m\].
    pub fn top(&self, station: f64, pitch: f64) -> [f64; 2] {
        let (sin, cos) = pitch.sin_cos();
        let (along, up) = (self.half_length * station, self.radius * (1.0 - station * station).sqrt());
        [along * cos - up * sin, along * sin + up * cos]
    }

    /// Returns the motion of the water at the centre, and the load \[X Y Z K M N\] about it \[N, N m\], in body axes.
    pub fn in_waves(&self, waves: &Waves, centre: Position, axes: &Axes) -> (WaterMotion, Load) {
        let unit = wave_vector(waves, axes);
        let square = unit[0] * unit[0] * self.focal_squared();
        let (mut orbits, mut force_sum, mut moment_sum) =
            (Orbits::default(), Complex64::ZERO, Complex64::ZERO);
        for (wave, value) in waves.at(centre) {
            let k = wave.number;
            let (f, g) = form_factors(square * (k * k));
            orbits.add(wave, value);
            force_sum += f * value * k;
            moment_sum += g * value * (k * k);
        }
        (orbits.motion(waves), self.load(unit, force_sum, moment_sum))
    }

    /// Returns the derivatives of the load with respect to time \[N/s, N m/s\], to north, east and depth \[N/m, N\],
    /// and to a rotation about each body axis \[N/rad, N m/rad\].
    ///
    /// The derivative of E is `-i w E` in time and `i K E` in position. A rotation about an axis e changes the wave
    /// vector by `dK = K x e`, so that `df = c K1 dK1 g` and `dg = c K1 dK1 h`, with `c = a^2 - b^2` and `h = g'(s)/s`.
    pub fn slopes_in_waves(&self, waves: &Waves, centre: Position, axes: &Axes) -> [Load; 7] {
        let unit @ [k1, k2, k3] = wave_vector(waves, axes);
        let square = k1 * k1 * self.focal_squared();
        let mut sums = [Complex64::ZERO; 7];
        for (wave, value) in waves.at(centre) {
            let (w, k) = (wave.frequency, wave.number);
            let square = square * (k * k);
            let (f, g) = form_factors(square);
            let h = next_form_factor(square, f, g) * value * k.powi(4);
            let (f, g) = (f * value * k, g * value * (k * k));
            let parts = [f, g, w * f, w * g, k * f, k * g, h];
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        }
        let [f, g, wf, wg, kf, kg, h] = sums;
        let scaled = |by: Complex64, f, g| self.load(unit, by * f, by * g);
        let [north, east, down] = waves.gradient().map(|n| scaled(Complex64::I * n, kf, kg));
        let turns = [[Complex64::ZERO, k3, -k2], [-k3, Complex64::ZERO, k1], [k2, -k1, Complex64::ZERO]];
        let [ahead, starboard, below] = turns.map(|dk| {
            let change = self.focal_squared() * k1 * dk[0];
            let force = |j: usize| dk[j] * f + unit[j] * change * kg;
            let moment = |j: usize| (dk[0] * unit[j] + k1 * dk[j]) * g + k1 * unit[j] * change * h;
            self.with_diffraction([0, 1, 2].map(force), [2, 1].map(moment))
        });
        [scaled(-Complex64::I, wf, wg), north, east, down, ahead, starboard, below]
    }

    /// Returns the load for the sums of `k f E` and `k^2 g E`, and the wave vector for unit wave number.
    fn load(&self, unit: [Complex64; 3], force_sum: Complex64, moment_sum: Complex64) -> Load {
        let [k1, k2, k3] = unit;
        self.with_diffraction(unit.map(|one| one * force_sum), [k1 * k3 * moment_sum, k1 * k2 * moment_sum])
    }

    /// Returns a^2 - b^2.
    fn focal_squared(&self) -> f64 {
        self.half_length * self.half_length - self.radius * self.radius
    }

    /// Returns the load of the pressure, from `K f E`, `K1 K3 g E` and `K1 K2 g E`, with diffraction.
    fn with_diffraction(&self, [x, y, z]: [Complex64; 3], [pitch, yaw]: [Complex64; 2]) -> Load {
        let (displaced_mass, focal_squared) = (self.displacement(), self.focal_squared());
        // Froude-Krylov load per displaced mass and acceleration of gravity.
        let load = [x.im, y.im, z.im, 0.0, focal_squared * pitch.re, -focal_squared * yaw.re];
        let sum = self.half_length * self.half_length + self.radius * self.radius;
        let [surge, sway, heave, roll, pitch, yaw] = load;
        let [pitching, yawing] = [pitch, yaw].map(|one| one * 5.0 * sum / (focal_squared * focal_squared));
        let acceleration = [surge, sway, heave, roll, pitching, yawing].map(|one| one * GRAVITY);
        std::array::from_fn(|i| {
            let row = self.added_mass[i].iter().zip(acceleration);
            row.fold(displaced_mass * GRAVITY * load[i], |sum, (mass, rate)| sum + mass * rate)
        })
    }
}

/// Returns the complex wave vector for unit wave number in body axes.
fn wave_vector(waves: &Waves, axes: &Axes) -> [Complex64; 3] {
    let [north, east, down] = waves.gradient();
    axes.map(|axis| north * axis[0] + east * axis[1] + down * axis[2])
}

/// Returns `f = 3 (sin s - s cos s)/s^3` and `g = f'(s)/s = 3 ((s^2 - 3) sin s + 3 s cos s)/s^5` as functions of s^2;
/// near 0 by the series `f = 3 sum (-1)^n (2n + 2)/(2n + 3)! s^2n`.
fn form_factors(square: Complex64) -> (Complex64, Complex64) {
    if square.norm_sqr() < 1.0 {
        let (mut f, mut g, mut power, mut factor) = (Complex64::ZERO, Complex64::ZERO, Complex64::ONE, 1.0);
        for n in 0..TERMS {
            let (order, next) = (2.0 * n as f64, power * square);
            // `factor` is (-1)^n 3 (2n + 2)/(2n + 3)!; `after` is the one of the next order.
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

/// Returns `h = g'(s)/s = -(f + 5 g)/s^2`, from the recurrence of the spherical Bessel functions, `f = 3 j1/s`, `g = -3
/// j2/s^2`, `h = 3 j3/s^3`; near 0 by its series.
fn next_form_factor(square: Complex64, f: Complex64, g: Complex64) -> Complex64 {
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

    /// The series and the closed form agree at |s| = 1, where one replaces the other.
    #[test]
    fn series_and_closed_form_agree() {
        for i in 0..16 {
            let unit = Complex64::from_polar(1.0, f64::from(i) * PI / 8.0);
            let (inside, outside) = (form_factors(unit * (1.0 - 1e-13)), form_factors(unit * (1.0 + 1e-13)));
            assert!((inside.0 - outside.0).norm() < 1e-12 && (inside.1 - outside.1).norm() < 1e-12);
            let next = |part: f64, (f, g)| next_form_factor(unit * part, f, g);
            assert!((next(1.0 - 1e-13, inside) - next(1.0 + 1e-13, outside)).norm() < 1e-12);
        }
        let (f, g) = form_factors(Complex64::ZERO);
        assert_eq!((f.re, g.re), (1.0, -0.2));
    }
}
