//! Checks that the sizes of a certificate's matrices agree.

use crate::certificate::{BoundedRate, Certificate, Energy, Limits, Residual, Rows, Slow};
use crate::error::ReadError;

/// A number of rows or columns, and their signal.
type Size = (usize, &'static str);

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

/// Claims of bounded energy, at most: each is proved.
const MOST_CLAIMS: usize = 100;

impl Sizes {
    /// Rows of the inequality: x, wt, w_Delta, w, x+, zt, z_Delta and z.
    fn rows(self, residual: Option<&Residual>, discrete: bool) -> usize {
        let error = residual.map_or(0, |r| columns(&r.e).saturating_add(r.f.len()));
        let next = if discrete { self.x.saturating_add(self.xk) } else { 0 };
        [self.x, self.xk, next, self.t, self.t, self.tk, self.tk, self.w, self.z, error]
            .into_iter()
            .fold(0, usize::saturating_add)
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

    /// Checks that all numbers are finite and all sizes agree.
    ///
    /// # Errors
    /// The first field that does not fit.
    pub fn check(&self) -> Result<(), ReadError> {
        let s = self.sizes();
        if s.z == 0 {
            return Err(ReadError::Empty { field: "plant.D11", part: "rows", meaning: "outputs z" });
        }
        if s.w == 0 {
            return Err(ReadError::Empty { field: "plant.D11", part: "columns", meaning: "inputs w" });
        }
        let rows = s.rows(self.residual.as_ref(), self.discrete);
        if rows > MOST_ROWS {
            return Err(ReadError::Large { rows, most: MOST_ROWS });
        }
        let sections = [
            ("residual", self.residual.is_some()),
            ("bounded_rate", self.bounded_rate.is_some()),
            ("limits", self.limits.is_some()),
            ("energy", self.energy.is_some()),
        ];
        if let Some((field, _)) = sections.into_iter().find(|(_, given)| self.discrete && *given) {
            return Err(ReadError::Discrete { field });
        }
        check_blocks("blocks", &self.blocks, "plant.Ct", s.t)?;
        check_blocks("controller_blocks", &self.controller_blocks, "controller.Ct", s.tk)?;
        self.check_parameters()?;
        self.check_plant(s)?;
        self.check_controller(s)?;
        self.check_any_rate(s)?;
        self.residual.as_ref().map_or(Ok(()), |r| check_residual(r, s))?;
        self.bounded_rate.as_ref().map_or(Ok(()), |bounded| self.check_bounded_rate(bounded, s))?;
        self.limits.as_ref().map_or(Ok(()), |limits| self.check_limits(limits, s))?;
        self.energy.as_ref().map_or(Ok(()), |energy| self.check_energy(energy, s))
    }

    /// Checks the sizes of the matrices of the claim for parameters that move however fast; where there is none, that
    /// there is one of a bounded rate, and none that is built on the other.
    fn check_any_rate(&self, s: Sizes) -> Result<(), ReadError> {
        if let Some(claim) = &self.any_rate {
            check_number("gamma", claim.gamma)?;
            if !claim.x.is_empty() && !claim.v.is_empty() {
                return Err(ReadError::kind("X", "given beside V".into(), "left out where V is given"));
            }
            let lyapunov = if claim.v.is_empty() { ("X", &claim.x) } else { ("V", &claim.v) };
            return check_proof("", s, lyapunov, [&claim.s, &claim.t]);
        }
        let built_on_it = [
            ("residual", self.residual.is_some()),
            ("limits", self.limits.is_some()),
            ("energy", self.energy.is_some()),
        ];
        match built_on_it.into_iter().find(|(_, given)| *given) {
            Some((field, _)) => Err(ReadError::NoAnyRate { field }),
            None if self.bounded_rate.is_none() => Err(ReadError::NoClaim),
            None => Ok(()),
        }
    }

    /// Checks the sizes of the matrices of claims for w of bounded energy.
    fn check_energy(&self, energy: &Energy, s: Sizes) -> Result<(), ReadError> {
        if self.plant.direct_path().is_some() {
            return Err(ReadError::DirectPath { field: "energy" });
        }
        if energy.claims.is_empty() {
            return Err(ReadError::Empty { field: "energy.claims", part: "entries", meaning: "claims" });
        }
        if energy.claims.len() > MOST_CLAIMS {
            let (field, found) = ("energy.claims".into(), energy.claims.len());
            return Err(ReadError::Length { field, found, expected: format!("at most {MOST_CLAIMS}") });
        }
        let u = (s.u, "controls u");
        check_list("energy.limits", &energy.limits, u)?;
        check_matrix("energy.E", &energy.e, (s.xk, "controller's states"), u)?;
        energy.claims.iter().enumerate().try_for_each(|(k, claim)| {
            let field = |name: &str| format!("energy.claims[{k}].{name}");
            check_number(&field("gamma"), claim.gamma)?;
            check_number(&field("beta"), claim.beta)?;
            check_proof(&field(""), s, ("X", &claim.x), [&claim.s, &claim.t])?;
            check_list(&field("U"), &claim.u, u)?;
            check_matrix(&field("H"), &claim.h, u, (s.x + s.xk, "states of plant and controller"))
        })
    }

    /// Checks the sizes of the matrices of a loop with limits.
    fn check_limits(&self, l: &Limits, s: Sizes) -> Result<(), ReadError> {
        let Some(error) = &self.residual else {
            return Err(ReadError::NoModelError { field: "limits" });
        };
        if let Some(found) = l.delta_rows.filter(|rows| !(1..=columns(&error.e)).contains(rows)) {
            let allowed = "from 1 to the number of columns of residual.E";
            return Err(ReadError::kind("limits.delta_rows", found.to_string(), allowed));
        }
        if self.plant.direct_path().is_some() {
            return Err(ReadError::DirectPath { field: "limits" });
        }
        if l.input >= s.w {
            return Err(ReadError::NoInput { found: l.input, inputs: s.w });
        }
        if self.jumping_measurement(l.input).is_none() {
            let allowed = "an input w whose step is a jump by as much of one measurement y, and reaches the loop \
                           nowhere else, also not through filters (size would not count all that arrives)";
            return Err(ReadError::kind("limits.input", l.input.to_string(), allowed));
        }
        let states = (self.moving_states().len() + s.xk, "states of the loop with limits");
        let channels = (s.t + s.tk, "channels of plant and controller");
        let u = (s.u, "controls u");
        let limited = (s.u + self.check_rates(l, error)?, "controls u and rates");
        for (field, m, rows, columns) in [
            ("limits.E", &l.e, (s.xk, "controller's states"), u),
            ("limits.X", &l.x, states, states),
            ("limits.S", &l.s, channels, channels),
            ("limits.T", &l.t, channels, channels),
            ("limits.H", &l.h, limited, states),
        ] {
            check_matrix(field, m, rows, columns)?;
        }
        let numbers = [("size", l.size), ("decay", l.decay), ("beta", l.beta), ("lambda", l.lambda)];
        numbers.iter().try_for_each(|(name, x)| check_number(&format!("limits.{name}"), *x))?;
        [
            ("limits", &l.limits, limited),
            ("x_held", &l.x_held, states),
            ("u_held", &l.u_held, limited),
            ("U", &l.u, limited),
        ]
        .into_iter()
        .try_for_each(|(name, list, size)| check_list(&format!("limits.{name}"), list, size))
    }

    /// The number of states whose rates are cut off: different ones that the loop consists of, and that Delta does not
    /// move.
    fn check_rates(&self, l: &Limits, error: &Residual) -> Result<usize, ReadError> {
        let moving = self.moving_states();
        let rows = l.delta_rows.unwrap_or(usize::MAX);
        for (i, state) in l.rates.iter().enumerate() {
            let by_delta = |row: &Vec<f64>| row.iter().take(rows).any(|entry| *entry != 0.0);
            if !moving.contains(state)
                || l.rates[..i].contains(state)
                || error.e.get(*state).is_some_and(by_delta)
            {
                let allowed = "a state of the plant that the loop moves and Delta does not, each once";
                return Err(ReadError::kind(&format!("limits.rates[{i}]"), state.to_string(), allowed));
            }
        }
        Ok(l.rates.len())
    }

    /// Checks the sizes of a bounded rate's matrices: X as X of the certificate, N channels x all inputs of the loop.
    fn check_bounded_rate(&self, bounded: &BoundedRate, s: Sizes) -> Result<(), ReadError> {
        let found = self.blocks.len().max(self.controller_blocks.len());
        if found != 1 {
            return Err(ReadError::NotOneParameter { found });
        }
        check_number("bounded_rate.rate", bounded.rate)?;
        check_slow("bounded_rate.", &bounded.slow, s, None)?;
        let Some(r) = &bounded.residual else { return Ok(()) };
        let error =
            self.residual.as_ref().ok_or(ReadError::NoModelError { field: "bounded_rate.residual" })?;
        check_number("bounded_rate.residual.lambda", r.lambda)?;
        check_slow("bounded_rate.residual.", &r.slow, s, Some(error))
    }

    /// Checks that each parameter has a channel, so that the claim counts no parameter that does not occur.
    fn check_parameters(&self) -> Result<(), ReadError> {
        let (plant, controller) = (&self.blocks, &self.controller_blocks);
        let repetitions = |blocks: &[usize], i: usize| blocks.get(i).copied().unwrap_or(0);
        let unused = |&i: &usize| repetitions(plant, i) == 0 && repetitions(controller, i) == 0;
        match (0..plant.len().max(controller.len())).find(unused) {
            Some(index) => {
                let field = if index < plant.len() { "blocks" } else { "controller_blocks" };
                Err(ReadError::NoChannel { field, index })
            }
            None => Ok(()),
        }
    }

    fn check_plant(&self, s: Sizes) -> Result<(), ReadError> {
        let p = &self.plant;
        let x = (s.x, "plant's states");
        let t = (s.t, "plant's channels");
        let (w, z) = ((s.w, "inputs w"), (s.z, "outputs z"));
        let (u, y) = ((s.u, "controls u"), (s.y, "measurements y"));
        check_matrices("plant", &p.named(), &[x, t, z, y], &[x, t, w, u])?;
        if p.d22.is_empty() { Ok(()) } else { check_matrix("plant.D22", &p.d22, y, u) }
    }

    fn check_controller(&self, s: Sizes) -> Result<(), ReadError> {
        let xk = (s.xk, "controller's states");
        let tk = (s.tk, "controller's channels");
        let (u, y) = ((s.u, "controls u"), (s.y, "measurements y"));
        check_matrices("controller", &self.controller.named(), &[xk, u, tk], &[xk, y, tk])
    }
}

/// Checks matrices that are named row by row.
fn check_matrices(
    of: &str,
    matrices: &[(&str, &Rows)],
    rows: &[Size],
    columns: &[Size],
) -> Result<(), ReadError> {
    let shapes = rows.iter().flat_map(|row| columns.iter().map(move |column| (*row, *column)));
    matrices
        .iter()
        .zip(shapes)
        .try_for_each(|((key, m), (row, column))| check_matrix(&format!("{of}.{key}"), m, row, column))
}

fn check_residual(r: &Residual, s: Sizes) -> Result<(), ReadError> {
    let (ne, nf) = (columns(&r.e), r.f.len());
    if ne == 0 {
        return Err(ReadError::Empty { field: "residual.E", part: "columns", meaning: "rows of Delta" });
    }
    if nf == 0 {
        return Err(ReadError::Empty { field: "residual.F", part: "rows", meaning: "columns of Delta" });
    }
    let x = (s.x, "plant's states");
    let nf = (nf, "columns of Delta");
    check_matrix("residual.E", &r.e, x, (ne, "rows of Delta"))?;
    check_matrix("residual.F", &r.f, nf, x)?;
    if !r.fw.is_empty() {
        check_matrix("residual.Fw", &r.fw, nf, (s.w, "inputs w"))?;
    }
    check_matrix("residual.Fu", &r.fu, nf, (s.u, "controls u"))?;
    check_number("residual.lambda", r.lambda)?;
    check_number("residual.gamma", r.gamma)?;
    check_proof("residual.", s, ("X", &r.x), [&r.s, &r.t])
}

fn check_proof(
    prefix: &str,
    s: Sizes,
    (name, x): (&str, &Rows),
    [sym, skew]: [&Rows; 2],
) -> Result<(), ReadError> {
    let states = (s.x + s.xk, "states of plant and controller");
    let channels = (s.t + s.tk, "channels of plant and controller");
    check_matrix(&format!("{prefix}{name}"), x, states, states)?;
    check_matrix(&format!("{prefix}S"), sym, channels, channels)?;
    check_matrix(&format!("{prefix}T"), skew, channels, channels)
}

/// The order of X(theta), at most: higher ones are of no use, and their binomial coefficients would not be exact.
const MOST_ORDER: usize = 8;

fn check_slow(prefix: &str, slow: &Slow, s: Sizes, error: Option<&Residual>) -> Result<(), ReadError> {
    let field = |name: &str| format!("{prefix}{name}");
    check_number(&field("gamma"), slow.gamma)?;
    let length = |name: &str, found: usize, expected: String| ReadError::Length {
        field: field(name),
        found,
        expected,
    };
    if slow.x.is_empty() || slow.x.len() > MOST_ORDER + 1 {
        return Err(length("X", slow.x.len(), format!("1 to {}", MOST_ORDER + 1)));
    }
    let states = (s.x + s.xk, "states of plant and controller");
    for (k, x) in slow.x.iter().enumerate() {
        check_matrix(&format!("{prefix}X[{k}]"), x, states, states)?;
    }
    let at = &slow.breakpoints;
    let ascending = at.windows(2).all(|ends| ends[0] < ends[1]);
    if at.first() != Some(&-1.0) || at.last() != Some(&1.0) || !ascending {
        return Err(ReadError::Breakpoints { field: field("breakpoints") });
    }
    if slow.n.len() + 1 != at.len() {
        return Err(length("N", slow.n.len(), format!("{}, one for each interval", at.len() - 1)));
    }
    let channels = (s.t + s.tk, "channels of plant and controller");
    let inner = states.0 + channels.0;
    let all = if slow.inverse {
        (inner + error.map_or(0, |r| r.f.len()) + s.z, "states, channels, columns of Delta and outputs z")
    } else {
        (inner + error.map_or(0, |r| columns(&r.e)) + s.w, "states, channels, rows of Delta and inputs w")
    };
    slow.n
        .iter()
        .enumerate()
        .try_for_each(|(i, n)| check_matrix(&format!("{prefix}N[{i}]"), n, channels, all))
}

fn check_blocks(
    field: &'static str,
    blocks: &[usize],
    matrix: &'static str,
    expected: usize,
) -> Result<(), ReadError> {
    let found = blocks.iter().fold(0, |sum: usize, &b| sum.saturating_add(b));
    if found == expected { Ok(()) } else { Err(ReadError::Blocks { field, found, matrix, expected }) }
}

pub(crate) fn check_number(field: &str, x: f64) -> Result<(), ReadError> {
    if x.is_finite() {
        return Ok(());
    }
    Err(ReadError::kind(field, x.to_string(), "a finite number"))
}

fn check_list(field: &str, list: &[f64], (expected, meaning): Size) -> Result<(), ReadError> {
    if list.len() != expected {
        let expected = format!("{expected} ({meaning})");
        return Err(ReadError::Length { field: field.into(), found: list.len(), expected });
    }
    list.iter().enumerate().try_for_each(|(i, x)| check_number(&format!("{field}[{i}]"), *x))
}

pub(crate) fn check_matrix(field: &str, m: &Rows, rows: Size, cols: Size) -> Result<(), ReadError> {
    let (expected, meaning) = rows;
    if m.len() != expected {
        return Err(ReadError::Rows { field: field.into(), found: m.len(), expected, meaning });
    }
    let (expected, meaning) = cols;
    for (i, row) in m.iter().enumerate() {
        if row.len() != expected {
            let (field, found) = (field.into(), row.len());
            return Err(ReadError::Columns { field, row: i, found, expected, meaning });
        }
        row.iter().enumerate().try_for_each(|(j, &x)| check_number(&format!("{field}[{i}][{j}]"), x))?;
    }
    Ok(())
}
