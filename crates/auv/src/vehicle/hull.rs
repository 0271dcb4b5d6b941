//! Sections of a hull, over which its cross-flow drag is integrated.

use std::sync::Arc;

use crate::scalar::Scalar;

/// Nodes and weights of the Gauss-Legendre rule with three points on \[-1, 1\], exact for polynomials of degree 5.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Breadth of a hull at stations along it, linear between them; without stations the hull has no sections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hull {
    /// Position forward of the origin, increasing \[m\], and breadth \[m\].
    stations: Arc<[[f64; 2]]>,
}

impl Hull {
    /// Condition on the stations, for messages.
    pub(crate) const ALLOWED: &str =
        "at least two pairs [x, breadth] from stern to bow, with increasing x and no negative breadth";

    /// Returns a hull with these stations; `None` if they are not `Hull::ALLOWED`.
    pub fn new(stations: &[[f64; 2]]) -> Option<Self> {
        let valid = stations.len() > 1
            && stations.iter().all(|[x, breadth]| x.is_finite() && breadth.is_finite() && *breadth >= 0.0)
            && stations.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        valid.then(|| Self { stations: stations.into() })
    }

    /// Returns the stations: position forward of the origin and breadth \[m\].
    pub fn stations(&self) -> &[[f64; 2]] {
        &self.stations
    }

    /// Returns `∫ b v|v| dx` and `∫ x b v|v| dx` with `v = w - x q`, b the breadth at x.
    ///
    /// Between two stations the integrands are polynomials of degree 3 and 4 while v keeps its sign, so that three
    /// Gauss points are exact. An interval in which v changes sign, at `x = w/q`, is divided there.
    pub(crate) fn cross_flow<D: Scalar>(&self, w: D, q: D) -> [D; 2] {
        let mut sums = [D::from(0.0); 2];
        for pair in self.stations.windows(2) {
            let ([aft, from], [fore, to]) = (pair[0], pair[1]);
            let slope = (to - from) / (fore - aft);
            let mut add = |start: D, end: D| {
                let (middle, half) = ((end + start) * 0.5, (end - start) * 0.5);
                for (node, weight) in GAUSS {
                    let x = middle + half * node;
                    let v = w - x * q;
                    let drag = ((x - aft) * slope + from) * v * v.abs() * half * weight;
                    sums[0] += drag;
                    sums[1] += x * drag;
                }
            };
            let (start, end) = (D::from(aft), D::from(fore));
            if (w - start * q).re() * (w - end * q).re() < 0.0 {
                let zero = w / q;
                add(start, zero);
                add(zero, end);
            } else {
                add(start, end);
            }
        }
        sums
    }
}
