//! Random designs that vary everything that the source depends on.

#[path = "../../../scheduled/tests/example/mod.rs"]
pub mod example;

use example::input;
use squid_scheduled::{
    Actuator, ControllerDesign, ControllerInput, Failsafe, Kind, LftMatrices, OverSpeed, Port,
    ReferenceLimits, Rows, Sensor, Source, TrimTable,
};
use squid_signals::Curve;
use std::collections::BTreeMap;

/// Pseudo-random numbers from a seed (G. Marsaglia, Xorshift RNGs, 2003).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(0x9e37_79b9_7f4a_7c15 ^ (seed << 32 | 1))
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count
    }

    pub fn one_of(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn rows(&mut self, rows: usize, columns: usize, size: f64) -> Rows {
        (0..rows).map(|_| (0..columns).map(|_| self.between(-size, size)).collect()).collect()
    }
}

/// Returns the controller inputs, errors only or with measurements; without a speed reference if the speed is imposed.
fn inputs(random: &mut Random, errors: bool, speed_given: bool) -> Vec<ControllerInput> {
    use Kind::{Error, Measurement, Reference};
    let all = if errors {
        vec![("pitch", Error), ("speed", Error)]
    } else {
        vec![
            ("pitch", Reference),
            ("speed", Reference),
            ("pitch", Measurement),
            ("speed", Measurement),
            ("pitch_rate", Measurement),
            ("heave", Measurement),
        ]
    };
    let mut all = all;
    if !errors && random.one_of(2) {
        all.insert(0, ("depth", Reference));
        all.insert(3, ("depth", Measurement));
    }
    // Either of the two alone is covered, too.
    if !errors && random.one_of(4) {
        all.retain(|(signal, kind)| *signal != "depth" || *kind == Reference);
    } else if !errors && random.one_of(4) {
        all.retain(|(signal, kind)| *signal != "depth" || *kind == Measurement);
    }
    let fits =
        |(signal, kind): &(&str, Kind)| !speed_given || *signal != "speed" || *kind == Kind::Measurement;
    let mut kept: Vec<ControllerInput> = all
        .into_iter()
        .filter(fits)
        .map(|(signal, kind)| input(signal, kind, random.between(0.1, 0.4)))
        .collect();
    if !errors && random.one_of(3) {
        kept.pop();
    }
    kept
}

fn actuator(random: &mut Random, index: usize) -> Actuator {
    let points = match random.below(3) {
        0 => vec![[-1.0, -70.0], [-0.2, 0.0], [0.1, 0.0], [0.6, 40.0], [0.8, 40.0], [2.0, 130.0]],
        1 => vec![[-5.0, -80.0], [0.0, 0.0], [5.0, 120.0]],
        _ => vec![[-5.0, -80.0], [5.0, 120.0]],
    };
    let curve = match random.below(3) {
        0 => None,
        1 => Some(Curve::square(random.between(1e-3, 2.0), "rpm").unwrap()),
        _ => Some(Curve::through(points, "1").unwrap()),
    };
    Actuator {
        name: format!("thruster_{index}"),
        unit: "N".to_owned(),
        scale: 100.0,
        minimum: -60.0,
        maximum: 100.0,
        curve,
        steers: [&["pitch"][..], &["pitch", "depth"], &[], &["depth"]][index % 4]
            .iter()
            .map(|one| one.to_string())
            .collect(),
        force: Some([1.0, 0.0, index as f64 - 0.5]),
        lateral_force: None,
    }
}

fn trim(random: &mut Random, actuators: usize) -> TrimTable {
    let rows = 2 + random.below(40);
    let speed: Vec<f64> = (0..rows).map(|row| 0.5 + 2.5 * row as f64 / (rows - 1) as f64).collect();
    TrimTable {
        forward_speed: speed.iter().map(|v| v - random.between(0.0, 1e-3)).collect(),
        signals: ["pitch", "heave"]
            .map(|name| (name.to_owned(), speed.iter().map(|_| random.between(-0.1, 0.0)).collect()))
            .into(),
        actuators: random.rows(rows, actuators, 30.0),
        speed,
    }
}

/// Returns random limits of the sensors of a design.
fn failsafe(random: &mut Random, design: &ControllerDesign) -> Failsafe {
    let sensor = |(index, port): (usize, &Port)| {
        let time = random.between(0.5, 5.0);
        let gains = design.actuators.iter().map(|_| random.between(-0.1, 0.1)).collect();
        let from = match port.name.as_str() {
            _ if random.one_of(4) => None,
            "depth" => Some(Source::Path("pitch".to_owned())),
            "pitch" => Some(Source::Rate("pitch_rate".to_owned())),
            "speed" => Some(Source::Commands { gains, time }),
            _ => None,
        };
        let period = [0.0, 0.25][random.below(2)];
        let resolution = if random.one_of(2) { 0.0 } else { random.between(0.0, 0.02) };
        let mut number = |most: f64| random.between(0.0, most) * port.nominal;
        let [error, rate, drift] = [2.0 + number(3.0), number(5.0), number(0.5)];
        let sensor = Sensor { error, rate, drift, resolution, period, from };
        design.measures(index).then(|| (port.name.clone(), sensor))
    };
    let sensors = design.signals.iter().enumerate().filter_map(sensor).collect();
    let safe = design.actuators.iter().map(|one| random.between(one.minimum, one.maximum)).collect();
    Failsafe { stale_after: [0.0, 0.1][random.below(2)], safe, sensors }
}

/// Returns random limits of some references.
fn envelope(random: &mut Random, rows: usize, speed_given: bool) -> BTreeMap<String, ReferenceLimits> {
    let mut columns = |least: [f64; 2], most: [f64; 2]| {
        [least, most].map(|[low, high]| {
            OverSpeed::from((0..rows).map(|_| random.between(low, high)).collect::<Vec<f64>>())
        })
    };
    let pitch = ReferenceLimits { range: Some(columns([-0.3, -0.1], [-0.1, 0.2])), rate: None };
    let depth = ReferenceLimits { range: None, rate: Some(columns([-1.0, 0.0], [0.0, 1.0])) };
    let speed = ReferenceLimits {
        range: Some([0.6, 2.9].map(OverSpeed::Constant)),
        rate: Some([-1.2, 0.8].map(OverSpeed::Constant)),
    };
    let all = [("pitch", pitch), ("depth", depth), ("speed", speed)];
    let kept = all.into_iter().filter(|(name, _)| !speed_given || *name != "speed");
    kept.map(|(name, limits)| (name.to_owned(), limits)).collect()
}

pub fn random(random: &mut Random, seed: u64) -> ControllerDesign {
    let speed_given = seed % 5 == 4;
    let controller_inputs = inputs(random, seed.is_multiple_of(3), speed_given);
    let controller_inputs =
        if controller_inputs.is_empty() { vec![input("pitch", Kind::Error, 0.2)] } else { controller_inputs };
    let actuators: Vec<Actuator> = (0..1 + random.below(6)).map(|index| actuator(random, index)).collect();
    let (n, p, m) = (1 + random.below(9), controller_inputs.len(), actuators.len());
    let r = if seed % 7 == 6 { 0 } else { 1 + random.below(8) };
    let mut a = random.rows(n, n, 1.0);
    a.iter_mut().enumerate().for_each(|(index, row)| row[index] -= 2.0);
    let reference_filter = (!speed_given && seed % 2 == 1).then_some(1.7);
    let mut signals = example::ports();
    signals[example::DEPTH].start = 12.5;
    let trim = trim(random, m);
    let mut design = ControllerDesign {
        signals,
        // Characters that would end a comment, or that a compiler would interpret.
        design: "a */ b /* c ??/ \\ @f@".to_owned(),
        controller_inputs,
        delay_ticks: random.below(4),
        reference_filter,
        speed_given,
        lft: LftMatrices {
            blocks: vec![r],
            a,
            by: random.rows(n, p, 0.5),
            bt: random.rows(n, r, 0.5),
            cu: random.rows(m, n, 0.5),
            duy: random.rows(m, p, 0.5),
            dut: random.rows(m, r, 0.5),
            ct: random.rows(r, n, 0.5),
            dty: random.rows(r, p, 0.5),
            dtt: random.rows(r, r, 0.6 / (r as f64).sqrt().max(1.0)),
        },
        anti_windup: (seed % 4 < 2).then(|| random.rows(n, m, 2.0)),
        follow: match seed % 3 {
            0 => vec![],
            1 => vec![random.rows(n, m, 0.1)],
            _ => (0..2 + random.below(4)).map(|_| random.rows(n, m, 0.1)).collect(),
        },
        envelope: if seed.is_multiple_of(4) {
            BTreeMap::new()
        } else {
            envelope(random, trim.speed.len(), speed_given)
        },
        trim,
        actuators,
        ..example::design()
    };
    design.signals[example::DEPTH].circular =
        [design.measures(example::DEPTH), design.follows(example::DEPTH)] == [true; 2];
    if !seed.is_multiple_of(6) {
        design.failsafe = Some(failsafe(random, &design));
    }
    design
}
