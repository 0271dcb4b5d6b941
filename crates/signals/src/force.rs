//! What the sign of a command means, in words.

/// A force or moment this small beside the largest of its actuator comes from rounding.
const LEAST_SHARE: f64 = 1e-6;

/// Force and moment per output of an actuator about zero \[N, N, N m\]: along x and z and about y, or along y and about
/// x and z; those of a control surface at a surge velocity of 1 m/s.
pub type Force = [f64; 3];

/// Returns what a positive output does, by the signs of its force in the vertical plane, \[X Z M\], and across it,
/// \[Y K N\] (SNAME: y to starboard, z down, so that a positive pitch moment turns the bow up); `None` where it does
/// nothing.
///
/// `unit` is that of the output: `N` of a thrust, `rad` of a deflection, whose force changes its sign astern.
///
/// ```
/// let of_stern_planes = [0.0, -9.64, -6.15];
/// let words = "positive deflection, ahead, pushes up and turns the bow down";
/// assert_eq!(squid_signals::sign_in_words(of_stern_planes, [0.0; 3], "rad").as_deref(), Some(words));
/// ```
pub fn sign_in_words(plane: Force, across: Force, unit: &str) -> Option<String> {
    let largest = plane.iter().chain(&across).fold(0.0, |largest: f64, part| largest.max(part.abs()));
    let word = |part: f64, positive: &'static str, negative: &'static str| {
        (part.abs() > LEAST_SHARE * largest).then_some(if part > 0.0 { positive } else { negative })
    };
    let ([surge, heave, pitch], [sway, roll, yaw]) = (plane, across);
    let joined = |verb: &str, words: &[Option<&str>]| {
        let words: Vec<&str> = words.iter().copied().flatten().collect();
        (!words.is_empty()).then(|| format!("{verb} {}", words.join(" and ")))
    };
    let (starboard, port) = ("to starboard", "to port");
    let push = [word(surge, "forward", "astern"), word(sway, starboard, port), word(heave, "down", "up")];
    let effects: Vec<String> = [
        joined("pushes", &push),
        joined("turns the bow", &[word(pitch, "up", "down"), word(yaw, starboard, port)]),
        joined("rolls", &[word(roll, starboard, port)]),
    ]
    .into_iter()
    .flatten()
    .collect();
    let output = if unit == "rad" { "deflection, ahead," } else { "thrust" };
    (!effects.is_empty()).then(|| format!("positive {output} {}", effects.join(" and ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signs_are_those_of_the_force() {
        for (plane, across, unit, words) in [
            ([1.0, 0.0, 0.2], [0.0; 3], "N", "thrust pushes forward and turns the bow up"),
            ([1.0, 1e-17, 0.0], [0.0; 3], "N", "thrust pushes forward"),
            ([-0.6, 0.8, -0.1], [0.0; 3], "N", "thrust pushes astern and down and turns the bow down"),
            ([0.0, 0.0, 1.4], [0.0; 3], "N", "thrust turns the bow up"),
            ([0.0, -5.0, 7.0], [0.0; 3], "rad", "deflection, ahead, pushes up and turns the bow up"),
            (
                [0.0; 3],
                [9.6, 0.0, -6.1],
                "rad",
                "deflection, ahead, pushes to starboard and turns the bow to port",
            ),
            ([0.0; 3], [0.0, 0.0, 0.3], "N", "thrust turns the bow to starboard"),
            ([0.0; 3], [-1.0, 0.1, 0.0], "N", "thrust pushes to port and rolls to starboard"),
            (
                [1.0, 0.0, -0.1],
                [0.0, 0.0, 0.2],
                "N",
                "thrust pushes forward and turns the bow down and to starboard",
            ),
        ] {
            assert_eq!(sign_in_words(plane, across, unit), Some(format!("positive {words}")));
        }
        assert_eq!(sign_in_words([0.0; 3], [0.0; 3], "N"), None);
    }
}
