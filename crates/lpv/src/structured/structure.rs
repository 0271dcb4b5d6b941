//! Controllers of a fixed structure.

use crate::error::SystemError;
use crate::matrix::Mat;
use crate::system::{CONTROLLER, ClosedLoop, Controller, GeneralisedPlant, LOOP, Partitioned, Sizes};

/// A controller whose matrices are affine in a vector of gains: `K(g) = K0 + sum_i g_i K_i`.
///
/// Shapes: K0 and every K_i have the same states, channels, measurements and controls.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// K0, with the repetitions of the parameters.
    base: Controller,
    /// K_i, one for each gain: rows xk', u, zk, columns xk, y, wk.
    directions: Vec<Mat>,
}

impl Structure {
    /// Builds the structure with the base K0 and a direction K_i for each gain.
    ///
    /// # Errors
    /// Returns an error for the first direction whose shape differs from that of the base.
    pub fn new(base: Controller, directions: Vec<Mat>) -> Result<Self, SystemError> {
        let expected = base.matrix().shape();
        match directions.iter().find(|of| of.shape() != expected) {
            Some(of) => Err(SystemError::Shape { name: "a direction", found: of.shape(), expected }),
            None => Ok(Self { base, directions }),
        }
    }

    /// Returns the structure of all controllers with constant matrices and `states` states: all entries are gains,
    /// except those of A below its first subdiagonal, which are zero in some coordinates of any state. Without states
    /// it is static output feedback, `u = Duy y`.
    pub fn full(plant: &GeneralisedPlant, states: usize) -> Self {
        let s = plant.sizes();
        let blocks = vec![0; plant.blocks.len()];
        let zero = Partitioned::zeros(CONTROLLER, Sizes { x: states, y: s.y, u: s.u, ..Sizes::default() });
        let (rows, columns) = zero.matrix().shape();
        let entry = |(i, j)| {
            let mut m = Mat::zeros(rows, columns);
            m[(i, j)] = 1.0;
            m
        };
        let entries = (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j)));
        let free = entries.filter(|(i, j)| *i >= states || *j >= states || j + 1 >= *i);
        let directions = free.map(entry).collect();
        Self { base: Controller { parts: zero, blocks }, directions }
    }

    /// Returns the number of gains.
    pub fn gains(&self) -> usize {
        self.directions.len()
    }

    /// Returns K(g).
    ///
    /// # Panics
    /// If the number of gains is not the number of directions.
    pub fn controller(&self, gains: &[f64]) -> Controller {
        assert_eq!(gains.len(), self.gains(), "gains and directions");
        let sum = self
            .directions
            .iter()
            .zip(gains)
            .fold(self.base.matrix().clone(), |sum, (direction, gain)| sum + direction * *gain);
        Controller {
            parts: Partitioned::of(sum, CONTROLLER, self.base.parts.sizes()),
            blocks: self.base.blocks.clone(),
        }
    }

    /// Checks that controller and plant have the same parameters, measurements and controls.
    pub(crate) fn check(&self, plant: &GeneralisedPlant) -> Result<(), SystemError> {
        let (k, p) = (self.base.parts.sizes(), plant.sizes());
        let (found, expected) = ((k.u, k.y), (p.u, p.y));
        if found != expected {
            return Err(SystemError::Shape { name: "Duy", found, expected });
        }
        let (found, expected) = (self.base.blocks.len(), plant.blocks.len());
        if found != expected {
            let name = "Theta of the controller (its parameters)";
            return Err(SystemError::Shape { name, found: (found, found), expected: (expected, expected) });
        }
        Ok(())
    }
}

/// The closed loop of a plant and a structure, which is affine in the gains too, as the direct path of the plant from u
/// to y is zero: `M(g) = M0 + sum_i g_i M_i`.
pub(crate) struct Loop {
    base: ClosedLoop,
    /// The directions M_i.
    pub(crate) directions: Vec<Partitioned>,
}

impl Loop {
    pub(crate) fn new(plant: &GeneralisedPlant, structure: &Structure) -> Self {
        let closed = |parts: &Partitioned| plant.parts.closed_by(parts);
        let zero = Partitioned::zeros(CONTROLLER, structure.base.parts.sizes());
        let without = closed(&zero);
        let direction = |of: &Mat| {
            let parts = closed(&Partitioned::of(of.clone(), CONTROLLER, structure.base.parts.sizes()));
            Partitioned::of(parts.matrix() - without.matrix(), LOOP, without.sizes())
        };
        let directions = structure.directions.iter().map(direction).collect();
        Self { base: plant.close(&structure.base), directions }
    }

    /// Returns M(g).
    pub(crate) fn at(&self, gains: &[f64]) -> ClosedLoop {
        let parts = &self.base.parts;
        let sum = self
            .directions
            .iter()
            .zip(gains)
            .fold(parts.matrix().clone(), |sum, (m, g)| sum + m.matrix() * *g);
        let parts = Partitioned::of(sum, LOOP, parts.sizes());
        ClosedLoop { parts, channels: self.base.channels.clone() }
    }
}
