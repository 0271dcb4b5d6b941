//! Thinning of curves without visible change.

/// Omits points within `tolerance` of the line through the kept points; the first and the last are kept.
///
/// Both coordinates are in units of their axis. Source: D. Douglas, T. Peucker, Cartographica 10(2), 1973.
pub fn thin(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let mut keep = vec![false; points.len()];
    let mut open = Vec::new();
    if let Some(last) = points.len().checked_sub(1) {
        (keep[0], keep[last]) = (true, true);
        open.push((0, last));
    }
    while let Some((from, to)) = open.pop() {
        let between = (from + 1..to).map(|i| (i, distance(points[i], points[from], points[to])));
        if let Some((at, farthest)) = between.max_by(|a, b| a.1.total_cmp(&b.1))
            && farthest > tolerance
        {
            keep[at] = true;
            open.extend([(from, at), (at, to)]);
        }
    }
    points.iter().zip(keep).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// Returns the distance of a point from a line segment.
fn distance(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let along = (b.0 - a.0, b.1 - a.1);
    let square = along.0 * along.0 + along.1 * along.1;
    let part = if square > 0.0 { ((p.0 - a.0) * along.0 + (p.1 - a.1) * along.1) / square } else { 0.0 };
    let part = part.clamp(0.0, 1.0);
    (p.0 - a.0 - part * along.0).hypot(p.1 - a.1 - part * along.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every omitted point is within the tolerance of the drawn lines, and far fewer points are kept.
    #[test]
    fn thinning_stays_within_tolerance() {
        let step = |t: f64| 1.0 - (-t).exp() * (3.0 * t).cos();
        let points: Vec<(f64, f64)> = (0..3000)
            .map(|i| f64::from(i) / 3000.0)
            .map(|x| (x, if x < 0.3 { 0.0 } else { step(10.0 * (x - 0.3)) }))
            .collect();
        let kept = thin(&points, 3e-4);
        assert!(kept.len() < 200, "{}", kept.len());
        for p in &points {
            let nearest = kept.windows(2).map(|w| distance(*p, w[0], w[1])).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 3e-4, "{p:?} is {nearest} off");
        }
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[2999]));
    }

    #[test]
    fn keeps_curves_of_few_points() {
        assert_eq!(thin(&[], 1.0), vec![]);
        assert_eq!(thin(&[(0.0, 0.0)], 1.0), vec![(0.0, 0.0)]);
        assert_eq!(thin(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)], 0.0).len(), 2);
    }
}
