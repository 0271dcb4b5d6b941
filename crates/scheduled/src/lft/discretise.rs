//! Discretisation by the trapezoidal rule.

use nalgebra::DMatrix;

use crate::{DesignError, Lft, Matrix};

impl Lft {
    /// Returns the LFT in discrete time by the trapezoidal rule, applied to the linear time-invariant system with
    /// Theta's channels as inputs and outputs.
    ///
    /// With `v = [y; wk]`, `o = [u; zk]`, `P = (I - A T/2)^-1`:
    ///
    /// ```text
    /// Ad = P (I + A T/2),  Bd = P B T,  Cd = C P,  Dd = D + C P B T/2
    /// ```
    ///
    /// For every constant Theta, `K_d(e^{jwT}, Theta) = K_c(j (2/T) tan(wT/2), Theta)`: closing the loop through Theta
    /// and the substitution `s = (2/T) (z - 1)/(z + 1)` commute.
    ///
    /// # Errors
    /// [`DesignError::TooFast`].
    ///
    /// Source: Franklin, Powell and Workman, Digital Control of Dynamic Systems, 3rd ed., 1998, section 6.1.
    #[inline]
    pub fn discretise(&self, sample_time: f64) -> Result<Self, DesignError> {
        let (p, half) = self.implicit(sample_time)?;
        let output = |c: &Matrix| c.times(&p);
        let input = |b: &Matrix| p.times(b).scaled(sample_time);
        let through = |c: &Matrix, b: &Matrix, d: &Matrix| d.plus(0.5 * sample_time, &output(c).times(b));
        Ok(Self {
            blocks: self.blocks.clone(),
            a: p.times(&half),
            by: input(&self.by),
            bt: input(&self.bt),
            cu: output(&self.cu),
            duy: through(&self.cu, &self.by, &self.duy),
            dut: through(&self.cu, &self.bt, &self.dut),
            ct: output(&self.ct),
            dty: through(&self.ct, &self.by, &self.dty),
            dtt: through(&self.ct, &self.bt, &self.dtt),
        })
    }

    /// Returns `P E T` for the input matrix E of inputs that are constant over a tick. The trapezoidal rule itself
    /// would add a direct feedthrough, and thus an algebraic loop for inputs that depend on the outputs of the tick.
    ///
    /// # Errors
    /// [`DesignError::TooFast`].
    #[inline]
    pub(crate) fn held_input(&self, e: &Matrix, sample_time: f64) -> Result<Matrix, DesignError> {
        Ok(self.implicit(sample_time)?.0.times(e).scaled(sample_time))
    }

    /// Returns `(I - A T/2)^-1` and `I + A T/2`.
    #[inline]
    fn implicit(&self, sample_time: f64) -> Result<(Matrix, Matrix), DesignError> {
        let n = self.a.rows();
        let half = self.a.to_dense() * (0.5 * sample_time);
        let identity = DMatrix::<f64>::identity(n, n);
        let inverse = (&identity - &half).lu().try_inverse();
        let inverse = inverse.filter(|inverse| inverse.iter().all(|entry| entry.is_finite()));
        let inverse = inverse.ok_or(DesignError::TooFast { sample_time })?;
        Ok((Matrix::from_dense(&inverse), Matrix::from_dense(&(identity + half))))
    }
}
