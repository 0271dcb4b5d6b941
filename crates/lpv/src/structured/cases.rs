//! A scheduled loop for tests, and slopes by finite differences.

use crate::matrix::Mat;
use crate::structured::structure::Structure;
use crate::system::Group::{U, X, Y};
use crate::system::{CONTROLLER, Controller, GeneralisedPlant, PLANT, Partitioned, Sizes};
use nalgebra::DVector;

/// Returns entries without a pattern, the same at each call.
fn entries(rows: usize, columns: usize, phase: f64) -> Mat {
    Mat::from_fn(rows, columns, |i, j| (7.3 * (i as f64 + 1.3 * phase) + 3.1 * (j * j) as f64 + phase).sin())
}

/// Returns a plant and a controller with states and channels; each of three gains changes every group of its matrix.
pub(crate) fn scheduled() -> (GeneralisedPlant, Structure) {
    let sizes = Sizes { x: 3, t: 2, w: 2, z: 2, u: 2, y: 2 };
    let mut parts = Partitioned::of(entries(9, 9, 0.4) * 0.3, PLANT, sizes);
    parts.block_mut(X, X).copy_from(&(entries(3, 3, 0.9) * 0.3 - Mat::identity(3, 3)));
    parts.block_mut(Y, U).fill(0.0);
    let plant = GeneralisedPlant { parts, blocks: vec![2] };
    let own = Sizes { x: 1, t: 1, u: 2, y: 2, ..Sizes::default() };
    let part = |phase| Partitioned::of(entries(4, 4, phase) * 0.2, CONTROLLER, own);
    let mut base = part(2.2);
    base.block_mut(X, X).fill(-0.8);
    let base = Controller { parts: base, blocks: vec![1] };
    let part = |phase| part(phase).matrix().clone();
    (plant, Structure::new(base, vec![part(0.1), part(1.7), part(3.3)]).unwrap())
}

pub(crate) fn differences(value: impl Fn(&[f64]) -> f64, at: &[f64]) -> DVector<f64> {
    let step = 1e-5;
    DVector::from_fn(at.len(), |i, _| {
        let moved = |by: f64| {
            let mut gains = at.to_vec();
            gains[i] += by;
            value(&gains)
        };
        (moved(step) - moved(-step)) / (2.0 * step)
    })
}
