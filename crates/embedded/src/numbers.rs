//! The numbers of the autopilot as written to a source: matrices and columns.

use crate::error::ExportError;
use crate::real::Real;
use squid_scheduled::{Autopilot, ControllerDesign, Lft, Matrix, Sizes};

/// Number of matrix rows summed at a time.
const HEIGHT: usize = 4;

/// The numbers of a source that are derived from the design.
#[derive(Debug)]
pub(crate) struct Numbers {
    pub(crate) autopilot: Autopilot,
    pub(crate) real: Real,
}

impl Numbers {
    /// Checks that the design can be written with numbers of the given type.
    pub(crate) fn of(design: &ControllerDesign, real: Real) -> Result<Self, ExportError> {
        let numbers = Self { autopilot: Autopilot::new(design)?, real };
        let sizes = numbers.sizes();
        if sizes.states == 0 {
            return Err(ExportError::NoStates);
        }
        if sizes.channels > 0 && !numbers.autopilot.controller().is_triangular() {
            return Err(ExportError::NoSchurForm);
        }
        let speeds = &design.trim.forward_speed;
        if speeds.windows(2).any(|pair| real.nearest(pair[0]) >= real.nearest(pair[1])) {
            return Err(ExportError::Float { what: "the difference between two rows of the trim table" });
        }
        Ok(numbers)
    }

    fn lft(&self) -> &Lft {
        self.autopilot.controller().lft()
    }

    pub(crate) fn sizes(&self) -> Sizes {
        self.lft().sizes()
    }

    /// Writes the matrices `[Ct Dty]`, T, `[Cu Duy Dut]`, `[A By Bt]`, `E` of the anti-windup, and the gains F of
    /// following, stacked by rows.
    pub(crate) fn matrices(&self) -> String {
        let k = self.lft();
        // C has no arrays of length 0.
        let none = vec![vec![0.0; self.sizes().outputs]];
        let follow: Vec<_> = self.autopilot.follow_gains().iter().flat_map(rows).collect();
        let channels = [("INTO_LOOP", panels(&[&k.ct, &k.dty])), ("LOOP", rows(&k.dtt))];
        let others = [
            ("OUTPUT", panels(&[&k.cu, &k.duy, &k.dut])),
            ("UPDATE", panels(&[&k.a, &k.by, &k.bt])),
            ("ANTI_WINDUP", self.autopilot.anti_windup().map_or_else(|| none.clone(), rows)),
            ("FOLLOW", if follow.is_empty() { none.clone() } else { follow }),
        ];
        let all = channels.into_iter().chain(others).filter(|(_, rows)| !rows.is_empty());
        all.map(|(name, rows)| self.table(name, &rows)).collect()
    }

    /// Writes a constant table of rows.
    pub(crate) fn table(&self, name: &str, rows: &[Vec<f64>]) -> String {
        let width = rows.first().map_or(0, Vec::len);
        let lines: Vec<String> =
            rows.iter().map(|row| format!("    {{{}}}", self.real.list(row.iter().copied()))).collect();
        format!("static const real {name}[{}][{width}] = {{\n{}\n}};\n", rows.len(), lines.join(",\n"))
    }

    /// Writes a constant column, one number per line.
    pub(crate) fn column(&self, name: &str, values: &[f64]) -> String {
        let lines: Vec<String> =
            values.iter().map(|value| format!("    {}", self.real.literal(*value))).collect();
        format!("static const real {name}[{}] = {{\n{}\n}};\n", values.len(), lines.join(",\n"))
    }
}

fn rows(matrix: &Matrix) -> Vec<Vec<f64>> {
    (0..matrix.rows()).map(|row| matrix.row(row).to_vec()).collect()
}

/// Concatenates matrices horizontally, by columns within panels of four rows; the last panel is padded with zeros.
fn panels(matrices: &[&Matrix]) -> Vec<Vec<f64>> {
    let all: Vec<Vec<f64>> = matrices
        .first()
        .map_or(0..0, |matrix| 0..matrix.rows())
        .map(|row| matrices.iter().flat_map(|matrix| matrix.row(row).iter().copied()).collect())
        .collect();
    let columns = all.first().map_or(0, Vec::len);
    let column = |panel: &[Vec<f64>], k: usize| {
        (0..HEIGHT).map(|row| panel.get(row).map_or(0.0, |row| row[k])).collect::<Vec<_>>()
    };
    all.chunks(HEIGHT).flat_map(|panel| (0..columns).map(|k| column(panel, k)).collect::<Vec<_>>()).collect()
}
