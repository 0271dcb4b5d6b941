//! Loop of plant and controller, and the check of its sizes.

use crate::error::Failure;
use crate::plant::{Controller, ModelError, Plant, Rows};
use crate::shape::{Size, Sizes, at_least_one, check_matrix, columns};

/// Largest number of rows of the inequality: ten times that of the largest loops designed so far, and still within the
/// memory of a computer.
const MOST_ROWS: usize = 1000;

/// Loop of a certificate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loop<'a> {
    /// `true` in discrete time.
    pub(crate) discrete: bool,
    /// Repetitions of the parameters in the plant's channels.
    pub(crate) blocks: &'a [usize],
    /// Repetitions of the parameters in the controller's channels.
    pub(crate) controller_blocks: &'a [usize],
    /// Plant.
    pub(crate) plant: &'a Plant,
    /// Controller.
    pub(crate) controller: &'a Controller,
    /// Model errors.
    pub(crate) errors: &'a [ModelError],
}

impl Loop<'_> {
    /// Returns the sizes, valid if [`Self::check`] succeeds.
    pub(crate) fn sizes(self) -> Sizes {
        let (p, k) = (self.plant, self.controller);
        Sizes {
            x: p.a.len(),
            xk: k.a.len(),
            t: p.ct.len(),
            tk: k.ct.len(),
            w: columns(&p.d11),
            z: p.d11.len(),
            u: columns(&p.d12),
            y: p.c2.len(),
        }
    }

    /// Returns the number of parameters of plant and controller.
    pub(crate) fn parameters(self) -> usize {
        self.blocks.len().max(self.controller_blocks.len())
    }

    /// Returns the number of channels of a parameter in plant and controller.
    pub(crate) fn channels_of(self, parameter: usize) -> usize {
        let channels = |blocks: &[usize]| blocks.get(parameter).copied().unwrap_or(0);
        channels(self.blocks).saturating_add(channels(self.controller_blocks))
    }

    /// Returns the number of rows of the inequality: x, wt, w_Delta, w, x+, zt, z_Delta and z.
    fn inequality_rows(self, s: Sizes) -> usize {
        let errors = self.errors.iter().flat_map(|error| [columns(&error.e), error.f.len()]);
        let next = if self.discrete { s.x.saturating_add(s.xk) } else { 0 };
        let rows = [s.x, s.xk, next, s.t, s.t, s.tk, s.tk, s.w, s.z];
        rows.into_iter().chain(errors).fold(0, usize::saturating_add)
    }

    /// Checks that all numbers are finite and all sizes agree.
    ///
    /// # Errors
    /// [`Failure::Malformed`] with the first field that does not fit.
    pub(crate) fn check(self) -> Result<(), Failure> {
        let s = self.sizes();
        at_least_one("plant.D11", "rows", (s.z, "outputs z"))?;
        at_least_one("plant.D11", "columns", (s.w, "inputs w"))?;
        let rows = self.inequality_rows(s);
        if rows > MOST_ROWS {
            let reason = format!("the inequality has {rows} rows; at most {MOST_ROWS} are supported");
            return Err(Failure::malformed("plant", reason));
        }
        check_blocks("blocks", self.blocks, "plant.Ct", s.t)?;
        check_blocks("controller_blocks", self.controller_blocks, "controller.Ct", s.tk)?;
        self.check_parameters()?;
        let (x, t) = ((s.x, "states of the plant"), (s.t, "channels of the plant"));
        let (xk, tk) = ((s.xk, "states of the controller"), (s.tk, "channels of the controller"));
        let (w, z, u, y) = ((s.w, "inputs w"), (s.z, "outputs z"), s.controls(), (s.y, "measurements y"));
        check_matrices("plant", &self.plant.named(), &[x, t, z, y], &[x, t, w, u])?;
        if !self.plant.d22.is_empty() {
            check_matrix("plant.D22", &self.plant.d22, y, u)?;
        }
        check_matrices("controller", &self.controller.named(), &[xk, u, tk], &[xk, y, tk])?;
        for (i, error) in self.errors.iter().enumerate() {
            let at = |name: &str| format!("errors[{i}].{name}");
            let [ne, nf] = [(columns(&error.e), "rows of Delta"), (error.f.len(), "columns of Delta")];
            at_least_one(&at("E"), "columns", ne)?;
            at_least_one(&at("F"), "rows", nf)?;
            check_matrix(&at("E"), &error.e, x, ne)?;
            check_matrix(&at("F"), &error.f, nf, x)?;
            if !error.fw.is_empty() {
                check_matrix(&at("Fw"), &error.fw, nf, w)?;
            }
            check_matrix(&at("Fu"), &error.fu, nf, u)?;
        }
        Ok(())
    }

    /// Checks that the plant has no direct path from u to y.
    pub(crate) fn check_no_direct_path(self, path: &str) -> Result<(), Failure> {
        if self.plant.direct_path().is_some() {
            let reason = "requires a plant without direct path from u to y, but plant.D22 is not 0";
            return Err(Failure::malformed(path, reason));
        }
        Ok(())
    }

    /// Checks that each parameter has a channel, so that the claim does not count a parameter that does not occur.
    fn check_parameters(self) -> Result<(), Failure> {
        let Some(i) = (0..self.parameters()).find(|i| self.channels_of(*i) == 0) else { return Ok(()) };
        let field = if i < self.blocks.len() { "blocks" } else { "controller_blocks" };
        let reason = format!(
            "is 0 or missing in both blocks and controller_blocks; it must be above 0 in one of them, because \
             otherwise no channel has parameter {i}"
        );
        Err(Failure::malformed(format!("{field}[{i}]"), reason))
    }
}

/// Checks matrices that are listed row by row.
fn check_matrices(
    system: &str,
    matrices: &[(&str, &Rows)],
    rows: &[Size],
    columns: &[Size],
) -> Result<(), Failure> {
    let shapes = rows.iter().flat_map(|row| columns.iter().map(move |column| (*row, *column)));
    let each = matrices.iter().zip(shapes);
    each.into_iter()
        .try_for_each(|((key, m), (row, column))| check_matrix(&format!("{system}.{key}"), m, row, column))
}

fn check_blocks(field: &str, blocks: &[usize], matrix: &str, expected: usize) -> Result<(), Failure> {
    let found = blocks.iter().fold(0, |sum: usize, &b| sum.saturating_add(b));
    if found == expected {
        return Ok(());
    }
    let reason =
        format!("has the sum {found}, but the number of rows of {matrix}, one per channel, is {expected}");
    Err(Failure::malformed(field, reason))
}
