//! Grids of the parameter box `|theta_i| <= 1`, for checks at points, which prove nothing between them.
//!
//! | parameters | points per parameter | points in total |
//! |---|---|---|
//! | 0 | | 1 |
//! | 1, 2 | 11 | 11, 121 |
//! | 3 | 7 | 343 |
//! | 4 | 5 | 625 |
//! | 5, 6 | 3 | 243, 729 |
//! | 7 to 10 | 2, the vertices | 128 to 1024 |
//! | more | 2 | 1024 vertices, spread as a fractional factorial design |
//!
//! Source of the last row: G. E. P. Box, J. S. Hunter, Technometrics 3(3), 1961.

/// The largest number of parameters for which all vertices are taken.
const ALL_VERTICES: usize = 10;

/// Returns the points of the table above, the same at each call; every grid contains vertices.
pub fn parameter_grid(parameters: usize) -> Vec<Vec<f64>> {
    evenly(parameters, [1, 11, 11, 7, 5, 3, 3].get(parameters).copied().unwrap_or(2))
}

/// Returns a grid of at most three points per parameter, for checks that are repeated often.
pub(crate) fn coarse_grid(parameters: usize) -> Vec<Vec<f64>> {
    evenly(parameters, if parameters <= 4 { 3 } else { 2 })
}

/// Returns `count` values of one parameter, evenly spaced over [-1, 1]; at least two.
pub(crate) fn evenly_spread(count: usize) -> impl Iterator<Item = f64> {
    let last = count.max(2) - 1;
    (0..=last).map(move |i| 2.0 * i as f64 / last as f64 - 1.0)
}

fn evenly(parameters: usize, each: usize) -> Vec<Vec<f64>> {
    if parameters > ALL_VERTICES {
        return some_vertices(parameters);
    }
    let value = |step: usize| if each > 1 { 2.0 * step as f64 / (each - 1) as f64 - 1.0 } else { 0.0 };
    let digit = |index: usize, p: usize| (index / each.pow(p as u32)) % each;
    (0..each.pow(parameters as u32))
        .map(|index| (0..parameters).map(|p| value(digit(index, p))).collect())
        .collect()
}

/// Returns 1024 vertices: the first ten parameters take all signs, each further one the product of some of theirs.
fn some_vertices(parameters: usize) -> Vec<Vec<f64>> {
    let products = (1..1usize << ALL_VERTICES).filter(|mask| !mask.is_power_of_two());
    let masks: Vec<usize> =
        (0..ALL_VERTICES).map(|p| 1 << p).chain(products).cycle().take(parameters).collect();
    let sign = |ones: u32| if ones % 2 == 1 { 1.0 } else { -1.0 };
    (0..1usize << ALL_VERTICES)
        .map(|index| masks.iter().map(|mask| sign((index & mask).count_ones())).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counts_are_those_documented() {
        let counts: Vec<usize> = (0..12).map(|p| parameter_grid(p).len()).collect();
        assert_eq!(counts, [1, 11, 121, 343, 625, 243, 729, 128, 256, 512, 1024, 1024]);
    }

    #[test]
    fn points_lie_in_the_box_and_differ() {
        for parameters in 1..15 {
            let mut grid = parameter_grid(parameters);
            assert!(grid.iter().flatten().all(|v| (-1.0..=1.0).contains(v)));
            assert!(grid.iter().all(|theta| theta.len() == parameters));
            let count = grid.len();
            grid.sort_by(|a, b| a.partial_cmp(b).unwrap());
            grid.dedup();
            assert_eq!(grid.len(), count);
        }
    }

    /// Any two parameters take all four pairs of signs equally often.
    #[test]
    fn vertices_of_many_parameters_are_spread() {
        let grid = parameter_grid(13);
        for p in 0..13 {
            for q in 0..p {
                let alike = grid.iter().filter(|theta| theta[p] == theta[q]).count();
                assert_eq!(alike, 512, "parameters {p} and {q}");
            }
        }
    }
}
