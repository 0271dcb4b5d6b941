//! Checks that the sizes of a certificate's matrices agree.

use crate::certificate::{Certificate, ModelError, Rows};
use crate::error::Failure;

/// A number of rows or columns, and their signal.
pub(crate) type Size = (usize, &'static str);

/// The sizes of the partition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sizes {
    /// States of the plant.
    pub(crate) x: usize,
    /// States of the controller.
    pub(crate) xk: usize,
    /// Channels of the plant.
    pub(crate) t: usize,
    /// Channels of the controller.
    pub(crate) tk: usize,
    /// Inputs.
    pub(crate) w: usize,
    /// Outputs.
    pub(crate) z: usize,
    /// Controls.
    pub(crate) u: usize,
    /// Measurements.
    pub(crate) y: usize,
}

/// Rows of the inequality, at most: ten times those of the largest loops designed so far, and as many as fit into
/// memory.
const MOST_ROWS: usize = 1000;

impl Sizes {
    /// States of plant and controller.
    pub(crate) fn states(self) -> Size {
        (self.x + self.xk, "states of plant and controller")
    }

    /// Channels of plant and controller.
    pub(crate) fn channels(self) -> Size {
        (self.t + self.tk, "channels of plant and controller")
    }

    /// Controls.
    pub(crate) fn controls(self) -> Size {
        (self.u, "controls u")
    }
}

/// The number of columns; 0 without rows.
pub(crate) fn columns(rows: &Rows) -> usize {
    rows.first().map_or(0, Vec::len)
}

impl Certificate {
    /// The sizes, valid if [`Self::check`] succeeds.
    pub(crate) fn sizes(&self) -> Sizes {
        let (p, k) = (&self.plant, &self.controller);
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

    /// The number of parameters of plant and controller.
    pub(crate) fn parameters(&self) -> usize {
        self.blocks.len().max(self.controller_blocks.len())
    }

    /// Channels of a parameter in plant and controller.
    pub(crate) fn channels_of(&self, parameter: usize) -> usize {
        let of = |blocks: &[usize]| blocks.get(parameter).copied().unwrap_or(0);
        of(&self.blocks).saturating_add(of(&self.controller_blocks))
    }

    /// Rows of the inequality: x, wt, w_Delta, w, x+, zt, z_Delta and z.
    fn inequality_rows(&self, s: Sizes) -> usize {
        let errors = self.errors.iter().flat_map(|error| [columns(&error.e), error.f.len()]);
        let next = if self.discrete { s.x.saturating_add(s.xk) } else { 0 };
        let rows = [s.x, s.xk, next, s.t, s.t, s.tk, s.tk, s.w, s.z];
        rows.into_iter().chain(errors).fold(0, usize::saturating_add)
    }

    /// Checks that all numbers are finite, all sizes agree, and that each claim has those on which it rests.
    ///
    /// # Errors
    /// [`Failure::Malformed`] with the first field that does not fit.
    pub fn check(&self) -> Result<(), Failure> {
        let s = self.sizes();
        at_least_one("plant.D11", "rows", (s.z, "outputs z"))?;
        at_least_one("plant.D11", "columns", (s.w, "inputs w"))?;
        let rows = self.inequality_rows(s);
        if rows > MOST_ROWS {
            let reason = format!("the inequality has {rows} rows, at most {MOST_ROWS} are proved");
            return Err(Failure::malformed("plant", reason));
        }
        check_blocks("blocks", &self.blocks, "plant.Ct", s.t)?;
        check_blocks("controller_blocks", &self.controller_blocks, "controller.Ct", s.tk)?;
        self.check_parameters()?;
        let (x, t) = ((s.x, "plant's states"), (s.t, "plant's channels"));
        let (xk, tk) = ((s.xk, "controller's states"), (s.tk, "controller's channels"));
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
        self.check_claims()
    }

    /// Checks the claims: there is at least one, none twice, each about this loop; and that each model error is covered
    /// by one.
    fn check_claims(&self) -> Result<(), Failure> {
        at_least_one("claims", "entries", (self.claims.len(), "claims"))?;
        for (i, claim) in self.claims.iter().enumerate() {
            let (kind, proved) = claim.parts();
            let (path, name) = (format!("claims[{i}].{kind}"), proved.name());
            if self.claims[..i].iter().any(|other| other.parts().1.name() == name) {
                return Err(Failure::malformed(path, format_args!("{name} is made twice")));
            }
            if self.discrete && !claim.holds_in_discrete_time() {
                let reason = "is of a loop in continuous time, but `discrete` is true";
                return Err(Failure::malformed(path, reason));
            }
            proved.check(&path, self)?;
        }
        if !self.errors.is_empty() && self.robust_gain().is_none() && self.constant().is_none() {
            let reason = "no claim covers them; leave them out, or claim a gain with `lambda`";
            return Err(Failure::malformed("errors", reason));
        }
        Ok(())
    }

    /// Checks that a claim stands beside that about the gain for parameters that vary arbitrarily fast.
    pub(crate) fn check_gain(&self, path: &str) -> Result<(), Failure> {
        let reason = "needs the claim `gain` without lambda, for parameters that vary arbitrarily fast";
        self.gain().map(|_| ()).ok_or_else(|| Failure::malformed(path, reason))
    }

    /// The model error of a claim that stands beside that about the gain with it.
    pub(crate) fn check_model_error(&self, path: &str) -> Result<&ModelError, Failure> {
        let reason = "needs one model error in `errors`, and the claim `gain` with lambda, which covers it";
        self.model_error().ok_or_else(|| Failure::malformed(path, reason))
    }

    /// Checks that u reaches y through states alone.
    pub(crate) fn check_no_direct_path(&self, path: &str) -> Result<(), Failure> {
        if self.plant.direct_path().is_some() {
            let reason = "is of plants without a direct path from u to y, but plant.D22 is not 0";
            return Err(Failure::malformed(path, reason));
        }
        Ok(())
    }

    /// Checks that each parameter has a channel, so that the claim counts no parameter that does not occur.
    fn check_parameters(&self) -> Result<(), Failure> {
        let Some(i) = (0..self.parameters()).find(|i| self.channels_of(*i) == 0) else { return Ok(()) };
        let field = if i < self.blocks.len() { "blocks" } else { "controller_blocks" };
        let reason = format!(
            "is 0 or missing in blocks and controller_blocks alike, must be above 0 in one of them: no channel has \
             parameter {i}"
        );
        Err(Failure::malformed(format!("{field}[{i}]"), reason))
    }
}

/// Checks matrices that are named row by row.
fn check_matrices(
    of: &str,
    matrices: &[(&str, &Rows)],
    rows: &[Size],
    columns: &[Size],
) -> Result<(), Failure> {
    let shapes = rows.iter().flat_map(|row| columns.iter().map(move |column| (*row, *column)));
    let each = matrices.iter().zip(shapes);
    each.into_iter()
        .try_for_each(|((key, m), (row, column))| check_matrix(&format!("{of}.{key}"), m, row, column))
}

fn check_blocks(field: &str, blocks: &[usize], matrix: &str, expected: usize) -> Result<(), Failure> {
    let found = blocks.iter().fold(0, |sum: usize, &b| sum.saturating_add(b));
    if found == expected {
        return Ok(());
    }
    let reason = format!("adds up to {found}, but {matrix} has {expected} rows: one for each channel");
    Err(Failure::malformed(field, reason))
}

pub(crate) fn at_least_one(field: &str, part: &str, (found, meaning): Size) -> Result<(), Failure> {
    if found > 0 {
        return Ok(());
    }
    Err(Failure::malformed(field, format_args!("has no {part}, must have at least one ({meaning})")))
}

pub(crate) fn check_number(field: &str, x: f64) -> Result<(), Failure> {
    if x.is_finite() { Ok(()) } else { Err(Failure::found(field, x, "a finite number")) }
}

pub(crate) fn check_length(
    field: &str,
    found: usize,
    is_allowed: bool,
    allowed: &str,
) -> Result<(), Failure> {
    if is_allowed {
        return Ok(());
    }
    Err(Failure::malformed(field, format_args!("has {found} entries, must have {allowed}")))
}

pub(crate) fn check_list(field: &str, list: &[f64], (size, meaning): Size) -> Result<(), Failure> {
    check_length(field, list.len(), list.len() == size, &format!("{size} ({meaning})"))?;
    list.iter().enumerate().try_for_each(|(i, x)| check_number(&format!("{field}[{i}]"), *x))
}

pub(crate) fn check_matrix(field: &str, m: &Rows, rows: Size, cols: Size) -> Result<(), Failure> {
    let wrong = |found: String, (expected, meaning): Size| {
        Err(Failure::malformed(field, format_args!("{found}, must have {expected} ({meaning})")))
    };
    if m.len() != rows.0 {
        return wrong(format!("found {} rows", m.len()), rows);
    }
    for (i, row) in m.iter().enumerate() {
        if row.len() != cols.0 {
            return wrong(format!("row {i} has {} numbers", row.len()), cols);
        }
        row.iter().enumerate().try_for_each(|(j, &x)| check_number(&format!("{field}[{i}][{j}]"), x))?;
    }
    Ok(())
}
