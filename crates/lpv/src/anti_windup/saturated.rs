//! The common part of the inequalities of loops with saturation: the scaled, transposed loop and its unknowns.
//!
//! ```text
//! (x', zt, u, outputs) = M (x, wt, phi, inputs),   wt = Theta zt,   phi = u - sat(u)
//! ```
//!
//! The condition that `2 x'X x' + zt'S zt - wt'S wt + 2 wt'T zt + 2 phi'U (u - phi - H x)` plus the terms of inputs and
//! outputs is negative is imposed on the inverse matrices and the transposed loop: it is linear in `Q = X^-1`, `Y =
//! HQ`, `U^-1`, `(G U^-1)'` and the inverse of \[S -T; T -S\] (C. Scherer, S. Weiland, "Linear matrix inequalities in
//! control", 2015, lemma 4.9).

use crate::lmi::{Affine, Program, symmetric};
use crate::matrix::{Mat, block, diagonal, diagonal_blocks, roots, skew_part, symmetric_part, unit};
use nalgebra::DVector;

/// A scaled loop, well conditioned for the search, transposed.
pub(super) struct Transposed {
    /// The columns x, wt, phi and inputs of M, as rows.
    pub(super) back: [Mat; 4],
    /// The selection of x', zt, u and outputs.
    pub(super) select: [Mat; 4],
    /// The unit of an entry of G for each state of the controller; empty for a given gain.
    reach: DVector<f64>,
    state_inverse: Mat,
    /// The square root of the units of the channels.
    root: Mat,
    /// The units of the commands.
    commands: Vec<f64>,
}

/// The units of a loop.
pub(super) struct Units<'a> {
    /// The coordinates T of x, with their inverse.
    pub(super) state: (Mat, Mat),
    /// The squares of the channels' units.
    pub(super) channels: &'a Mat,
    /// The units of u and phi.
    pub(super) commands: &'a [f64],
    pub(super) input: f64,
    pub(super) output: f64,
    /// The unit of an entry of G, as in [`Transposed`].
    pub(super) reach: DVector<f64>,
}

impl Transposed {
    /// Builds the loop of M, whose rows x', zt, u, outputs and columns x, wt, phi, inputs have the given sizes.
    pub(super) fn of(m: &Mat, rows: [usize; 4], columns: [usize; 4], units: Units<'_>) -> Self {
        let Units { state: (state, state_inverse), channels, commands, input, output, reach } = units;
        let (root, unroot) = roots(channels);
        let outputs = Mat::identity(rows[3], rows[3]) / output;
        let inputs = Mat::identity(columns[3], columns[3]) * input;
        let left =
            diagonal_blocks(&[&state_inverse, &root, &diagonal(commands.iter().map(|v| 1.0 / v)), &outputs]);
        let right = diagonal_blocks(&[&state, &unroot, &diagonal(commands.iter().copied()), &inputs]);
        let transposed = (left * m * right).transpose();
        let placed = |[a, b, c, d]: [usize; 4]| [(0, a), (a, b), (a + b, c), (a + b + c, d)];
        let back = placed(columns).map(|(at, size)| transposed.rows(at, size).into_owned());
        let select = placed(rows).map(|(at, size)| {
            Mat::from_fn(size, transposed.ncols(), |i, j| f64::from(u8::from(j == at + i)))
        });
        Self { back, select, reach, state_inverse, root, commands: commands.to_vec() }
    }
}

/// The unknowns of a loop in its units.
pub(super) struct Unknowns {
    /// The unknown `X^-1`.
    pub(super) q: Affine,
    s: Affine,
    skew: Affine,
    u: Affine,
    y: Affine,
    /// The unknown `(G U^-1)'`.
    moved: Affine,
    everywhere: bool,
}

/// The matrices of a solution, in the loop's original units.
#[allow(missing_docs, reason = "the names are those of the equations above")]
pub(super) struct Shown {
    pub(super) x: Mat,
    pub(super) s: Mat,
    pub(super) t: Mat,
    /// Half of the diagonal of U.
    pub(super) u: Vec<f64>,
    pub(super) h: Mat,
    /// The gain G.
    pub(super) gain: Mat,
}

impl Unknowns {
    /// Adds the unknowns to a program, with `S > 0` and the bounds of G, which feeds back the first `fed` components of
    /// phi; with `everywhere`, H = 0.
    pub(super) fn of(
        program: &mut Program,
        loop_: &Transposed,
        channels: &[usize],
        fed: usize,
        everywhere: bool,
    ) -> Self {
        let (n, m, nk) = (loop_.select[0].nrows(), loop_.select[2].nrows(), loop_.reach.len());
        let unknowns = Self {
            q: program.symmetric(n),
            s: program.symmetric_commuting(channels),
            skew: program.skew_commuting(channels),
            u: program.symmetric_commuting(&(0..m).collect::<Vec<_>>()),
            y: if everywhere { Affine::zeros(m, n) } else { program.full(m, n) },
            moved: program.full(fed, nk),
            everywhere,
        };
        program.positive("S", unknowns.s.clone());
        for (j, i) in (0..fed).flat_map(|j| (0..nk).map(move |i| (j, i))) {
            let entry = unknowns.moved.between(&unit(fed, j).transpose(), &unit(nk, i));
            let most = unknowns.u.congruence(&unit(m, j));
            program.positive("gain", most.clone() - entry.clone());
            program.positive("gain", most + entry);
        }
        unknowns
    }

    /// Returns the form without the terms of inputs and outputs.
    pub(super) fn form(&self, loop_: &Transposed) -> Affine {
        let ([x, t, phi, _], [x_dot, zt, u, _]) = (&loop_.back, &loop_.select);
        let (n, nk) = (x_dot.nrows(), loop_.reach.len());
        let fed = u.rows(0, self.moved.shape().0).transpose();
        let into = Mat::from_fn(nk, n, |i, j| if j == n - nk + i { loop_.reach[i] } else { 0.0 });
        let half = self.q.between(&x_dot.transpose(), x) - self.y.t().between(&x_dot.transpose(), u)
            + self.skew.between(&t.transpose(), zt)
            + self.u.between(&u.transpose(), &(phi - u))
            + self.moved.between(&fed, &(into * loop_.state_inverse.transpose() * x_dot));
        half.clone() + half.t() + self.s.congruence(t) - self.s.congruence(zt)
    }

    /// Imposes that `|H x|` is below the unit of each command if `x'Xx <= 1/level`.
    pub(super) fn out_of_reach(&self, program: &mut Program, level: &Affine) {
        let m = self.u.shape().0;
        for j in 0..if self.everywhere { 0 } else { m } {
            let row = self.y.after(&unit(m, j).transpose());
            program.positive("limit", symmetric(&[vec![self.q.clone(), row.t()], vec![level.clone()]]));
        }
    }

    /// Returns the matrices at a point, with X, S, T and U times `share`; `None` if one has no inverse.
    pub(super) fn shown(
        &self,
        loop_: &Transposed,
        program: &Program,
        point: &[f64],
        share: f64,
    ) -> Option<Shown> {
        let Transposed { reach, state_inverse, root, commands, .. } = loop_;
        let value = |e: &Affine| e.value(program, point);
        let [q, s, skew, u, y, moved] =
            [&self.q, &self.s, &self.skew, &self.u, &self.y, &self.moved].map(value);
        let inner = q.try_inverse()?;
        let pair = block(&[&[&s, &-&skew], &[&skew, &-&s]]).try_inverse()?;
        let r = s.nrows();
        let unit = diagonal(commands.iter().copied());
        Some(Shown {
            h: unit * y * &inner * state_inverse,
            x: symmetric_part(&(state_inverse.transpose() * inner * state_inverse)) * share,
            s: symmetric_part(&(root * pair.view((0, 0), (r, r)) * root)) * share,
            t: skew_part(&(root * pair.view((r, 0), (r, r)) * root)) * share,
            u: (0..commands.len()).map(|j| 0.5 * share / (u[(j, j)] * commands[j] * commands[j])).collect(),
            gain: Mat::from_fn(reach.len(), moved.nrows(), |i, j| {
                reach[i] * moved[(j, i)] / u[(j, j)] / commands[j]
            }),
        })
    }
}
