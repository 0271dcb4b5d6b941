//! A plant with measured and unknown parameters.

use crate::matrix::{Mat, symmetric_function};
use crate::system::Group::{T, U, W, X, Y, Z};
use crate::system::{GeneralisedPlant, Sizes};

/// A plant with measured and unknown parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainPlant {
    /// The plant; its parameters are those of Theta, then those of Delta.
    pub plant: GeneralisedPlant,
    /// The number of parameters of Theta.
    pub scheduled: usize,
}

impl UncertainPlant {
    /// Returns the number of channels of Theta.
    pub fn scheduled_channels(&self) -> usize {
        self.plant.blocks.iter().take(self.scheduled).sum()
    }

    /// Returns the number of channels of Delta.
    pub fn unknown_channels(&self) -> usize {
        self.plant.blocks.iter().skip(self.scheduled).sum()
    }

    /// Returns the plant with `|delta_i| <= size`, normalised to 1.
    pub fn sized(&self, size: f64) -> GeneralisedPlant {
        let (r, k) = (self.scheduled_channels(), self.unknown_channels());
        let mut out = self.plant.clone();
        out.parts.rows_mut(T).rows_mut(r, k).scale_mut(size);
        out
    }

    /// Returns the plant at Delta = 0.
    pub fn nominal(&self) -> GeneralisedPlant {
        let r = self.scheduled_channels();
        let parts = self.plant.parts.resized(T, r);
        GeneralisedPlant { parts, blocks: self.plant.blocks[..self.scheduled].to_vec() }
    }

    /// Returns the plant, scheduled on Theta only, whose gain is below 1 if the multipliers S and T of Delta, channels
    /// of Delta square, prove a gain below `gamma` for every Delta up to `size`.
    pub fn weighted(&self, size: f64, gamma: f64, s: &Mat, t: &Mat) -> GeneralisedPlant {
        let (r, k) = (self.scheduled_channels(), self.unknown_channels());
        let sized = self.sized(size).in_units_of(gamma);
        let root = symmetric_function(s, |v| v.max(0.0).sqrt());
        let inverse = symmetric_function(s, |v| 1.0 / v.max(f64::MIN_POSITIVE));
        let inverse_root = symmetric_function(s, |v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
        let other = s + t * inverse * t.transpose();
        let other = symmetric_function(&other, |v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
        let mut parts = sized.parts;
        for column in [X, T, W, U] {
            let zd = &root * parts.block(T, column).rows(r, k);
            parts.block_mut(T, column).rows_mut(r, k).copy_from(&zd);
        }
        for row in [X, T, Z, Y] {
            let of_wd = parts.block(row, T).columns(r, k) * &other;
            parts.block_mut(row, T).columns_mut(r, k).copy_from(&of_wd);
        }
        let mut direct = parts.block_mut(T, T);
        let mut direct = direct.view_mut((r, r), (k, k));
        direct += inverse_root * t.transpose() * &other;
        // Delta's channels come last: repartitioning moves them to w and z.
        let sizes = parts.sizes();
        let parts = parts.repartitioned(Sizes { t: r, w: k + sizes.w, z: k + sizes.z, ..sizes });
        GeneralisedPlant { parts, blocks: self.plant.blocks[..self.scheduled].to_vec() }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::matrix::{block, largest_singular_value};
    use nalgebra::dmatrix;

    /// Returns a lightly damped oscillator whose stiffness depends on theta and on a delta that also acts on the input.
    pub(crate) fn plant() -> UncertainPlant {
        let blocks = [
            (X, X, dmatrix![0.0, 1.0; -1.0, -0.02]),
            (X, T, dmatrix![0.0, 0.0, 0.0; 0.1, 1.0, 0.3]),
            (X, W, dmatrix![0.0, 0.0; 0.3, 0.0]),
            (X, U, dmatrix![0.0; 1.0]),
            (T, X, dmatrix![1.0, 0.0; 1.0, 0.0; 0.0, 0.0]),
            (T, T, dmatrix![0.0, 0.0, 0.0; 0.0, 0.1, 0.0; 0.0, 0.0, 0.0]),
            (T, U, dmatrix![0.0; 0.0; 1.0]),
            (Z, X, dmatrix![1.0, 0.0; 0.0, 0.0]),
            (Z, U, dmatrix![0.0; 0.3]),
            (Y, X, dmatrix![1.0, 0.0]),
            (Y, W, dmatrix![0.0, 0.1]),
        ];
        let plant = GeneralisedPlant::new(vec![1, 2], &blocks).unwrap();
        UncertainPlant { plant, scheduled: 1 }
    }

    /// The quadratic form of the weighted channels is the one that S and T define.
    #[test]
    fn weighting_completes_the_square() {
        let uncertain = plant();
        let (s, t) = (dmatrix![2.0, 0.3; 0.3, 1.0], dmatrix![0.0, 0.7; -0.7, 0.0]);
        let (size, gamma) = (0.8, 1.7);
        let weighted = uncertain.weighted(size, gamma, &s, &t);
        weighted.check().unwrap();
        // A state, wt, wd, w and u of the plant, and their equivalents in the weighted plant.
        let (x, wt, wd, w, u) = (dmatrix![0.4; -0.8], -0.3, dmatrix![0.9; -1.1], dmatrix![0.2; 0.7], -0.6);
        let sized = uncertain.sized(size);
        let all = block(&[&[&dmatrix![wt]], &[&wd]]);
        let zd = (&sized.ct() * &x + &sized.dtt() * all + &sized.dt1() * &w + &sized.dt2() * u)
            .rows(1, 2)
            .into_owned();
        let form = |a: &Mat, m: &Mat, b: &Mat| (a.transpose() * m * b)[(0, 0)];
        let expected = form(&zd, &s, &zd) + 2.0 * form(&wd, &t, &zd) - form(&wd, &s, &wd);
        let other =
            symmetric_function(&(&s + &t * s.clone().try_inverse().unwrap() * t.transpose()), f64::sqrt);
        let all = block(&[&[&(&other * &wd)], &[&(&w * gamma.sqrt())]]);
        let z = &weighted.c1() * &x + &weighted.d1t() * wt + &weighted.d11() * &all + &weighted.d12() * u;
        let found = z.rows(0, 2).norm_squared() - all.rows(0, 2).norm_squared();
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        let moved = &weighted.a() * &x + &weighted.bt() * wt + &weighted.b1() * &all + &weighted.b2() * u;
        let channels = block(&[&[&dmatrix![wt]], &[&wd]]);
        let truth = &sized.a() * &x + &sized.bt() * channels + &sized.b1() * &w + &sized.b2() * u;
        assert!(largest_singular_value(&(moved - truth)) < 1e-12);
    }
}
