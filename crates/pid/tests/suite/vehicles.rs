//! Vehicles and signals of the tests.

use squid_auv::Vehicle;
use squid_auv::toml_file::{FileError, Mistake};
use squid_pid::{Layout, Port, Structure};

/// Centre and half range of the speeds, m/s.
pub const SCHEDULING: (f64, f64) = (1.8, 0.4);

pub fn vehicle(name: &str) -> Vehicle {
    let path = format!("{}/../../vehicles/{name}/vehicle.toml", env!("CARGO_MANIFEST_DIR"));
    Vehicle::parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap().in_plane()
}

/// References of an output and of speed; measurements of pitch, speed, pitch rate and depth, each in its own unit.
pub fn layout(tracked: &'static str) -> Layout {
    let port = |signal, scale| Port { signal, scale };
    Layout {
        references: vec![port(tracked, 0.1), port("speed", 0.3)],
        measurements: vec![
            port("pitch", 0.2),
            port("speed", 0.5),
            port("pitch_rate", 0.25),
            port("depth", 2.0),
        ],
    }
}

/// Returns the line and the key of the only mistake in a file.
pub fn mistake(error: &FileError) -> (usize, String) {
    assert_eq!(error.mistakes.len(), 1, "{error}");
    let Mistake { line, problem } = &error.mistakes[0];
    (*line, problem.key().unwrap_or_default().to_owned())
}

/// Returns the cascade of a controller's text for a vehicle.
pub fn made(name: &str, layout: &Layout, text: &str) -> Result<Structure, FileError> {
    let file = squid_pid::read_file(text, "mine.toml")?;
    let vehicle = vehicle(name);
    let of = squid_pid::Vehicle {
        actuators: &vehicle.actuators,
        speed_given: false,
        layout,
        scheduling: SCHEDULING,
        design: "design.toml",
    };
    Structure::new(&file, of)
}
