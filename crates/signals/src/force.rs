//! Effect of a positive command, as text.

/// Share of the largest force or moment of an actuator below which another is rounding.
const LEAST_SHARE: f64 = 1e-6;

/// Force and moment per unit of actuator output, at zero output \[N, N, N m\]: X, Z and M in the vertical plane, or Y,
/// K and N across it; for a control surface at a surge velocity of 1 m/s.
pub type Force = [f64; 3];

/// Returns the effect of a positive output as text, from the signs of its force in the vertical plane, \[X Z M\], and
/// across it, \[Y K N\] (SNAME: y to starboard, z down, so that a positive pitch moment turns the bow up); `None` if it
/// has none.
///
/// `unit` is that of the output: `N` for a thrust, `rad` for a deflection, whose force reverses when going astern.
///
/// ```
/// let stern_planes = [0.0, -9.64, -6.15];
/// let text = "positive deflection (moving ahead) pushes up and turns the bow down";
/// assert_eq!(squid_signals::effect_of_sign(stern_planes, [0.0; 3], "rad").as_deref(), Some(text));
/// ```
pub fn effect_of_sign(plane: Force, across: Force, unit: &str) -> Option<String> {
    let largest = plane.iter().chain(&across).fold(0.0, |largest: f64, part| largest.max(part.abs()));
    let word = |part: f64, positive: &'static str, negative: &'static str| {
        (part.abs() > LEAST_SHARE * largest).then_some(if part > 0.0 { positive } else { negative })
    };
    let ([surge, heave, pitch], [sway, roll, yaw]) = (plane, across);
    let phrase = |verb: &str, parts: &[Option<&str>]| {
        let parts: Vec<&str> = parts.iter().copied().flatten().collect();
        (!parts.is_empty()).then(|| format!("{verb} {}", parts.join(" and ")))
    };
    let (starboard, port) = ("to starboard", "to port");
    let push = [word(surge, "forward", "astern"), word(sway, starboard, port), word(heave, "down", "up")];
    let effects: Vec<String> = [
        phrase("pushes", &push),
        phrase("turns the bow", &[word(pitch, "up", "down"), word(yaw, starboard, port)]),
        phrase("rolls", &[word(roll, starboard, port)]),
    ]
    .into_iter()
    .flatten()
    .collect();
    let output = if unit == "rad" { "deflection (moving ahead)" } else { "thrust" };
    (!effects.is_empty()).then(|| format!("positive {output} {}", effects.join(" and ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_follows_the_signs_of_the_force() {
        for (plane, across, unit, text) in [
            ([1.0, 0.0, 0.2], [0.0; 3], "N", "thrust pushes forward and turns the bow up"),
            ([1.0, 1e-17, 0.0], [0.0; 3], "N", "thrust pushes forward"),
            ([-0.6, 0.8, -0.1], [0.0; 3], "N", "thrust pushes astern and down and turns the bow down"),
            ([0.0, 0.0, 1.4], [0.0; 3], "N", "thrust turns the bow up"),
            ([0.0, -5.0, 7.0], [0.0; 3], "rad", "deflection (moving ahead) pushes up and turns the bow up"),
            (
                [0.0; 3],
                [9.6, 0.0, -6.1],
                "rad",
                "deflection (moving ahead) pushes to starboard and turns the bow to port",
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
            assert_eq!(effect_of_sign(plane, across, unit), Some(format!("positive {text}")));
        }
        assert_eq!(effect_of_sign([0.0; 3], [0.0; 3], "N"), None);
    }
}
