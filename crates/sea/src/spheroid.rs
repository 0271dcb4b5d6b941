//! The load of waves on a prolate spheroid.

use crate::GRAVITY;
use crate::error::{SeaError, check};
use crate::waves::{Place, WaterMotion, Waves};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the series of f and g about 0: below |s| = 1 the next one is less than rounding.
const TERMS: usize = 10;

/// A submerged prolate spheroid, with the masses of water that its acceleration moves.
///
/// The pressure of a component in the water that the hull displaces is `density g E exp(i K r)`, r from the centre,
/// with the complex wave vector `K1 = k (cos(heading) cos(pitch) - i sin(pitch))`, `K3 = k (cos(heading) sin(pitch) + i
/// cos(pitch))` along the body. With V the volume, a and b the half axes and `s^2 = (a^2 - b^2) K1^2`, integrated over
/// the hull without approximation:
///
/// ```text
/// X = -density g V Re(i K1 f E)        f = 3 (sin s - s cos s)/s^3
/// Z = -density g V Re(i K3 f E)        g = f'(s)/s
/// M =  density g V (a^2 - b^2) Re(K1 K3 g E)
/// ```
///
/// That is the Froude-Krylov load. In waves that are long beside the hull, diffraction adds `A alpha`, with the added
/// mass A and the water's mean acceleration along the hull: `X/(density V)`, `Z/(density V)` and, for the rate of turn
/// whose flow about the hull is the one that a strain of the water makes, `5 M (a^2 + b^2)/(density V (a^2 - b^2)^2)`.
/// For the spheroid alone these are the factors `1 + k1`, `1 + k2` and `1 + k' ((a^2 + b^2)/(a^2 - b^2))^2`.
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
    added_mass: [[f64; 3]; 3],
}

impl Spheroid {
    /// A spheroid of half axes a and b \[m\] in water of a density \[kg/m3\], with the added mass \[kg, kg m, kg m2\]
    /// of surge, heave and pitch about its centre: `[[-X_u', 0, 0], [0, -Z_w', -Z_q'], [0, -M_w', -M_q']]`.
    ///
    /// # Errors
    /// [`SeaError::NotAllowed`]: a hull that is not slender, an added mass that is not finite.
    pub fn new(
        half_length: f64,
        radius: f64,
        density: f64,
        added_mass: [[f64; 3]; 3],
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

    /// Returns the water's motion at the centre, and the load \[X Z M\] about it \[N, N m\], along the body.
    pub fn in_waves(&self, waves: &Waves, centre: Place, pitch: f64) -> (WaterMotion, [f64; 3]) {
        let (along, across) = self.wave_vector(waves, pitch);
        let focal = self.focal();
        let (mut motion, mut load) = (WaterMotion::default(), [0.0; 3]);
        for (wave, value) in waves.at(centre) {
            motion.add(wave, value, waves.cos_heading());
            let (k1, k3) = (along * wave.number, across * wave.number);
            let (f, g) = form(k1 * k1 * focal);
            let pushed = Complex64::I * f * value;
            load[0] -= (k1 * pushed).re;
            load[1] -= (k3 * pushed).re;
            load[2] += focal * (k1 * k3 * g * value).re;
        }
        (motion, self.with_diffraction(load))
    }

    /// Returns the derivatives of the load by time \[N/s, N m/s\], x and depth \[N/m, N\], and pitch \[N/rad, N
    /// m/rad\].
    ///
    /// E grows by `-i w` in time, by `i k cos(heading)` in x and by `-k` in depth. In pitch `dK1 = -K3` and `dK3 =
    /// K1`, so that `df = -c K1 K3 g` and `dg = -c K1 K3 h`, with `c = a^2 - b^2` and `h = g'(s)/s`.
    pub fn slopes_in_waves(&self, waves: &Waves, centre: Place, pitch: f64) -> [[f64; 3]; 4] {
        let (along, across) = self.wave_vector(waves, pitch);
        let focal = self.focal();
        let mut slopes = [[0.0; 3]; 4];
        for (wave, value) in waves.at(centre) {
            let (k1, k3) = (along * wave.number, across * wave.number);
            let square = k1 * k1 * focal;
            let (f, g) = form(square);
            let turned = -k1 * k3 * focal;
            let (df, dg) = (turned * g, turned * next_form(square, f, g));
            let by_time = -Complex64::I * wave.frequency * value;
            let by_x = Complex64::I * (wave.number * waves.cos_heading()) * value;
            for (slope, value) in slopes.iter_mut().zip([by_time, by_x, -wave.number * value]) {
                let pushed = Complex64::I * f * value;
                slope[0] -= (k1 * pushed).re;
                slope[1] -= (k3 * pushed).re;
                slope[2] += focal * (k1 * k3 * g * value).re;
            }
            let pushed = Complex64::I * value;
            slopes[3][0] -= ((k1 * df - k3 * f) * pushed).re;
            slopes[3][1] -= ((k3 * df + k1 * f) * pushed).re;
            slopes[3][2] += focal * (((k1 * k1 - k3 * k3) * g + k1 * k3 * dg) * value).re;
        }
        slopes.map(|slope| self.with_diffraction(slope))
    }

    /// The complex wave vector along the body, of a wave number of 1.
    fn wave_vector(&self, waves: &Waves, pitch: f64) -> (Complex64, Complex64) {
        let (sin, cos) = pitch.sin_cos();
        let heading = waves.cos_heading();
        (Complex64::new(heading * cos, -sin), Complex64::new(heading * sin, cos))
    }

    /// a^2 - b^2.
    fn focal(&self) -> f64 {
        self.half_length * self.half_length - self.radius * self.radius
    }

    /// The load of the pressure, in units of that on the mass of a unit of water, with the scattered waves, in N and N
    /// m.
    fn with_diffraction(&self, load: [f64; 3]) -> [f64; 3] {
        let (displaced, focal) = (self.displacement(), self.focal());
        let sum = self.half_length * self.half_length + self.radius * self.radius;
        let mean = [load[0], load[1], load[2] * 5.0 * sum / (focal * focal)].map(|one| one * GRAVITY);
        let total = |i: usize| {
            let row = self.added_mass[i];
            displaced * GRAVITY * load[i] + row[0] * mean[0] + row[1] * mean[1] + row[2] * mean[2]
        };
        [total(0), total(1), total(2)]
    }
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
