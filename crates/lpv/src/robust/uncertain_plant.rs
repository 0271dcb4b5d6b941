//! A plant of which the controller measures some parameters and does not know the others.

use crate::matrix::{Mat, symmetric_function};
use crate::system::partition::Group::{T, U, W, X, Y, Z};
use crate::system::partition::Sizes;
use crate::system::plant::GeneralisedPlant;

/// A plant of which the controller measures some parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainPlant {
    /// The plant; its parameters are those of Theta, then those of Delta.
    pub plant: GeneralisedPlant,
    /// How many of the parameters are of Theta.
    pub scheduled: usize,
}

impl UncertainPlant {
    /// Channels of Theta.
    pub fn scheduled_channels(&self) -> usize {
        self.plant.blocks.iter().take(self.scheduled).sum()
    }

    /// Channels of Delta.
    pub fn unknown_channels(&self) -> usize {
        self.plant.blocks.iter().skip(self.scheduled).sum()
    }

    /// The plant with `|delta_i| <= size`, normalised anew.
    pub fn sized(&self, size: f64) -> GeneralisedPlant {
        let (r, k) = (self.scheduled_channels(), self.unknown_channels());
        let mut out = self.plant.clone();
        out.parts.rows_mut(T).rows_mut(r, k).scale_mut(size);
        out
    }

    /// The plant at Delta = 0.
    pub fn nominal(&self) -> GeneralisedPlant {
        let r = self.scheduled_channels();
        let parts = self.plant.parts.resized(T, r);
        GeneralisedPlant { parts, blocks: self.plant.blocks[..self.scheduled].to_vec() }
    }

    /// The plant, scheduled on Theta alone, whose gain is below 1 when the multipliers S and T of Delta, channels of
    /// Delta square, show a gain below `gamma` for every Delta up to `size`.
    pub fn weighed(&self, size: f64, gamma: f64, s: &Mat, t: &Mat) -> GeneralisedPlant {
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
        // Delta's channels stand last: what follows them takes them in.
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

    /// An oscillator, hardly damped, whose stiffness depends on theta and on a delta that also acts on the input.
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

    /// The form that the weighed channels take on is the one that S and T define.
    #[test]
    fn weighing_completes_the_square() {
        let uncertain = plant();
        let (s, t) = (dmatrix![2.0, 0.3; 0.3, 1.0], dmatrix![0.0, 0.7; -0.7, 0.0]);
        let (size, gamma) = (0.8, 1.7);
        let weighed = uncertain.weighed(size, gamma, &s, &t);
        weighed.check().unwrap();
        // A motion of the plant: state, wt, wd, w and u, and what the same is in the weighed plant.
        let (x, wt, wd, w, u) = (dmatrix![0.4; -0.8], -0.3, dmatrix![0.9; -1.1], dmatrix![0.2; 0.7], -0.6);
        let sized = uncertain.sized(size);
        let all = block(&[&[&dmatrix![wt]], &[&wd]]);
        let zd = (&sized.ct() * &x + &sized.dtt() * all + &sized.dt1() * &w + &sized.dt2() * u)
            .rows(1, 2)
            .into_owned();
        let form = |a: &Mat, m: &Mat, b: &Mat| (a.transpose() * m * b)[(0, 0)];
        let wanted = form(&zd, &s, &zd) + 2.0 * form(&wd, &t, &zd) - form(&wd, &s, &wd);
        let other =
            symmetric_function(&(&s + &t * s.clone().try_inverse().unwrap() * t.transpose()), f64::sqrt);
        let all = block(&[&[&(&other * &wd)], &[&(&w * gamma.sqrt())]]);
        let z = &weighed.c1() * &x + &weighed.d1t() * wt + &weighed.d11() * &all + &weighed.d12() * u;
        let found = z.rows(0, 2).norm_squared() - all.rows(0, 2).norm_squared();
        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        let moved = &weighed.a() * &x + &weighed.bt() * wt + &weighed.b1() * &all + &weighed.b2() * u;
        let whole = block(&[&[&dmatrix![wt]], &[&wd]]);
        let truth = &sized.a() * &x + &sized.bt() * whole + &sized.b1() * &w + &sized.b2() * u;
        assert!(largest_singular_value(&(moved - truth)) < 1e-12);
    }
}
