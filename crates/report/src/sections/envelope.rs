//! Limits of the references over speed, and the commands of the default flight.

use crate::error::Error;
use crate::page::{Chart, Curve, Figure, Key, Part, Table, known, percent, tidy};
use crate::subject::Subject;
use squid_auv::longitudinal::{DEPTH, PITCH, SIGNALS, SPEED};
use squid_scheduled::{Autopilot, OverSpeed, Trim};

/// Indices of the keys of the figure.
const END: usize = 0;
const LEVEL: usize = 1;
const COMMANDED: usize = 2;

/// Ratio of the rate of the speed reference to its limits from which it belongs to a step and is not plotted.
const STEP: f64 = 8.0;

/// Largest relative reduction of a step that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Returns the section on the limits of the references; empty for a controller that limits only the speed to its range.
///
/// # Errors
/// Errors of the trims.
pub fn envelope(subject: &Subject) -> Result<Vec<Part>, Error> {
    let envelope = Envelope::new(subject)?;
    let charts = [envelope.pitch(), envelope.rate(DEPTH), envelope.rate(SPEED)];
    let charts: Vec<Chart> = charts.into_iter().flatten().collect();
    if charts.is_empty() {
        return Ok(vec![]);
    }
    let mut keys = vec![
        Key::coloured(0, "limits"),
        Key::reference("level flight"),
        Key::coloured(1, "default manoeuvre"),
    ];
    for (index, key) in keys.iter_mut().enumerate() {
        if charts.iter().flat_map(|chart| &chart.curves).all(|curve| curve.key != index) {
            key.name.clear();
        }
    }
    let caption = format!(
        "Limits of the references of {}, and the references of the default manoeuvre.",
        subject.name()
    );
    let figure = Figure { name: "envelope-over-speed".into(), caption, keys, charts };
    let tables = [PITCH, DEPTH].into_iter().filter(|index| envelope.limits(*index).is_some());
    let tables =
        tables.map(|index| ends(subject, index).map(Part::Table)).collect::<Result<Vec<_>, Error>>()?;
    Ok([Part::Text(envelope.text()), Part::Figure(figure)].into_iter().chain(tables).collect())
}

/// Limits of the references of a controller.
pub struct Envelope<'a> {
    subject: &'a Subject<'a>,
    trims: Trim,
}

impl<'a> Envelope<'a> {
    /// Returns the limits of the stored controller.
    ///
    /// # Errors
    /// [`Error::Design`] for an invalid controller.
    pub fn new(subject: &'a Subject<'a>) -> Result<Self, Error> {
        Ok(Self { subject, trims: Autopilot::new(&subject.stored.controller)?.trim().clone() })
    }

    /// Returns the limits of pitch, or of the rate of depth or speed, over the trim table.
    fn limits(&self, index: usize) -> Option<&[OverSpeed; 2]> {
        let limits = self.subject.stored.controller.envelope.get(SIGNALS[index].name)?;
        if index == PITCH { limits.range.as_ref() } else { limits.rate.as_ref() }
    }

    /// Returns the pitch in level flight, and the distances from it to the limits of its reference (rad), at a speed
    /// (m/s).
    fn distances(&self, speed: f64) -> Option<(f64, [f64; 2])> {
        let forward = self.trims.forward_speed(speed);
        let level = self.trims.signal(forward, PITCH, 0.0);
        let [least, most] = self.limits(PITCH)?;
        Some((level, [least, most].map(|end| self.trims.over(forward, end) - level)))
    }

    /// Returns the step of the stepped output that the controller follows when a step of a height (rad or m) is
    /// commanded in level flight at a speed (m/s). Depth is limited in rate only.
    pub fn used(&self, speed: f64, height: f64) -> f64 {
        let steps_in_pitch = self.subject.step().index == PITCH;
        let Some((_, [down, up])) = self.distances(speed).filter(|_| steps_in_pitch) else { return height };
        let used = height.max(down).min(up);
        if (used - height).abs() > ROUNDING * height.abs() { used } else { height }
    }

    /// Returns a sentence, with a leading space, on how the controller limits steps of the stepped output, each at a
    /// speed (m/s) and of a height (rad or m); empty if it does not limit them.
    pub fn remark(&self, steps: impl Iterator<Item = (f64, f64)>) -> String {
        let step = self.subject.step();
        if step.index == DEPTH && self.limits(DEPTH).is_some() {
            return " The autopilot converts a depth step to a ramp that the vehicle can follow.".into();
        }
        let shown = |height: f64| tidy(step.factor * height, 1);
        let limited = steps.filter_map(|(speed, height)| {
            let used = self.used(speed, height);
            let (requested, used, unit) = (shown(height), (used != height).then(|| shown(used))?, step.unit);
            Some(format!("at {speed:.2} m/s {used} {unit} instead of {requested} {unit}"))
        });
        let limited: Vec<String> = limited.collect();
        if limited.is_empty() {
            return String::new();
        }
        format!(" The autopilot limits the reference to the envelope: {}.", limited.join(", "))
    }

    /// Returns the times (s) of the ticks of the default flight, and its speed V along the path at each, m/s.
    fn flight(&self) -> impl Iterator<Item = (f64, f64)> {
        let (manoeuvre, tick) = (&self.subject.stored.manoeuvre, self.subject.inputs.design.sample_time);
        let ticks = (manoeuvre.duration / tick).round() as u32;
        (0..=ticks).map(move |k| f64::from(k) * tick).map(|time| (time, manoeuvre.speed_reference(time)))
    }

    /// Returns the pitch step that the default flight commands at a time (s), rad.
    fn commanded(&self, time: f64) -> f64 {
        self.subject.stored.manoeuvre.above_trim(time, SIGNALS[PITCH].name)
    }

    fn ends(&self, index: usize, factor: f64) -> Option<Vec<Curve>> {
        let speeds = &self.subject.stored.controller.trim.speed;
        let point = |(row, speed): (usize, &f64), end: &OverSpeed| (*speed, factor * end.at(row));
        let curve = |end: &OverSpeed| Curve {
            key: END,
            points: speeds.iter().enumerate().map(|index| point(index, end)).collect(),
        };
        self.limits(index).map(|limits| limits.iter().map(curve).collect())
    }

    fn pitch(&self) -> Option<Chart> {
        let factor = 1f64.to_degrees();
        let mut curves = self.ends(PITCH, factor)?;
        let controller = &self.subject.stored.controller;
        let level =
            |speed: &f64| (*speed, factor * self.distances(*speed).map_or(f64::NAN, |(level, _)| level));
        curves.push(Curve { key: LEVEL, points: controller.trim.speed.iter().map(level).collect() });
        let requested = self.flight().filter_map(|(time, speed)| {
            Some((speed, factor * (self.distances(speed)?.0 + self.commanded(time))))
        });
        curves.push(Curve { key: COMMANDED, points: requested.collect() });
        Some(Chart::over_speed("pitch (deg)", curves))
    }

    fn rate(&self, index: usize) -> Option<Chart> {
        let mut curves = self.ends(index, 1.0)?;
        if index == DEPTH {
            return Some(Chart::over_speed("rate of depth (m/s)", curves));
        }
        let most = curves.iter().flat_map(|curve| &curve.points).map(|p| p.1.abs()).fold(0.0, f64::max);
        let (speeds, tick): (Vec<f64>, f64) =
            (self.flight().map(|(_, speed)| speed).collect(), self.subject.inputs.design.sample_time);
        let forward = |speed: f64| self.trims.forward_speed(speed);
        let rates = speeds.windows(2).map(|pair| (pair[1], (forward(pair[1]) - forward(pair[0])) / tick));
        let points: Vec<(f64, f64)> = rates.filter(|(_, rate)| rate.abs() < STEP * most).collect();
        curves.push(Curve { key: COMMANDED, points });
        Some(Chart::over_speed("rate of speed (m/s^2)", curves))
    }

    fn text(&self) -> String {
        let limits = &self.subject.inputs.design.envelope;
        let part = |(time, speed): (f64, f64)| {
            let (_, [down, up]) = self.distances(speed)?;
            let step = self.commanded(time);
            Some((if step < 0.0 { step / down } else { step / up }, speed)).filter(|_| step != 0.0)
        };
        let most = self.flight().filter_map(part).max_by(|a, b| a.0.total_cmp(&b.0));
        let margin = most.map_or_else(String::new, |(part, speed)| {
            let beyond = if part > 1.0 { ", where the reference is limited" } else { "" };
            format!(
                " The default manoeuvre uses up to {} of the pitch range between level trim and the limit, at \
                     {speed:.2} m/s{beyond}.",
                percent(part, 0)
            )
        });
        let authority = percent(limits.authority, 0);
        let degrees = |angle: f64| tidy(angle.to_degrees(), 1);
        let [least, largest] = limits.pitch.map(degrees);
        let of = [
            (
                PITCH,
                format!(
                    "pitch to the steepest steady climb and dive that require at most {authority} of the limits of \
                     each actuator, and to {least} to {largest} deg"
                ),
            ),
            (
                DEPTH,
                format!(
                    "the depth rate to that of the steepest steady climb and dive that require at most {authority} \
                     of the limits of each actuator, on a path of at most {} deg",
                    degrees(limits.path_angle)
                ),
            ),
            (
                SPEED,
                "the acceleration to that available in level motion without pitching, the least over the speeds"
                    .into(),
            ),
        ];
        let of = of.into_iter().filter(|(index, _)| self.limits(*index).is_some()).map(|(_, text)| text);
        format!(
            "The autopilot limits references to an envelope: {}. All claims apply to the references as they are \
             used.{margin}",
            of.collect::<Vec<_>>().join("; ")
        )
    }
}

/// Returns the table of the ends of the envelope at the speeds of the report, computed again, and their limiting cause.
fn ends(subject: &Subject, index: usize) -> Result<Table, Error> {
    let mut table = Table::new(["speed (m/s)", "", "pitch (deg)", "path (deg)", "limited by"]);
    table.head[1] = format!("limit of {}", SIGNALS[index].name);
    let found = subject.inputs.axis().ends(&subject.speeds, index == DEPTH)?;
    for (speed, ends) in subject.speeds.iter().zip(found) {
        for (end, direction) in ends.into_iter().zip(["nose down", "nose up"]) {
            let [pitch, path] = [end.pitch, end.path].map(|angle| known(angle.to_degrees(), 1));
            table.rows.push(vec![format!("{speed:.2}"), direction.into(), pitch, path, end.limited_by]);
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_base::progress::Progress;
    use squid_design::inputs::Inputs;
    use squid_design::store::load;
    use std::path::Path;

    fn text(parts: &[Part]) -> String {
        let all = parts.iter().filter_map(|part| if let Part::Text(text) = part { Some(text) } else { None });
        all.cloned().collect()
    }

    /// The figure of the committed design of Squid has the frozen limits and the step of the default flight. Limits of
    /// 5 deg from level are reported to limit its reference.
    #[test]
    fn plots_limits_and_default_flight_and_reports_limited_steps() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
        let inputs = Inputs::read(&folder, "design").unwrap();
        let mut stored = load(&folder.join("frozen"), &inputs).unwrap();
        let progress = Progress::default();
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let parts = envelope(&subject).unwrap();
        let Part::Figure(Figure { charts, .. }) = &parts[1] else { panic!("{parts:?}") };
        let largest = |key: usize| {
            let curves = charts[0].curves.iter().filter(|curve| curve.key == key);
            curves.flat_map(|curve| &curve.points).map(|p| p.1).fold(f64::NEG_INFINITY, f64::max)
        };
        let Envelope { trims, .. } = Envelope::new(&subject).unwrap();
        let level = trims.signal(trims.forward_speed(stored.manoeuvre.speed_to), PITCH, 0.0).to_degrees();
        let [_, most] = stored.controller.envelope["pitch"].range.clone().unwrap();
        assert!((largest(END) - most.at(0).to_degrees()).abs() < 1e-9, "{}", largest(END));
        assert!((largest(COMMANDED) - level - 10.0).abs() < 1e-9, "{}", largest(COMMANDED));
        let within = text(&parts);
        let Part::Table(ends) = &parts[2] else { panic!("{parts:?}") };
        assert!(
            ends.rows.len() == 12 && ends.rows.iter().all(|row| row[4] == "`envelope.pitch`"),
            "{ends:?}"
        );

        let level = stored.controller.trim.signals["pitch"].clone();
        let off = |by: f64| level.iter().map(|pitch| pitch + by).collect::<Vec<f64>>();
        let narrow = Some([-5f64, 5.0].map(|by| OverSpeed::Table(off(by.to_radians()))));
        stored.controller.envelope.get_mut("pitch").unwrap().range = narrow;
        let subject = Subject::new(&inputs, &stored, &progress).unwrap();
        let used = Envelope::new(&subject).unwrap().used(1.3, 0.2);
        assert!((used.to_degrees() - 5.0).abs() < 1e-9, "{used}");
        let limited = text(&envelope(&subject).unwrap());
        assert!(within.contains(" 33 %") && limited.contains(" 200 %"), "{within} {limited}");
        let masked = |word| if str::starts_with(word, |c: char| c.is_ascii_digit()) { "#" } else { word };
        insta::assert_snapshot!(limited.split(' ').map(masked).collect::<Vec<_>>().join(" "));
    }
}
