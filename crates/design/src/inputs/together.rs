//! Checks of the axes of one autopilot, which control one vehicle.

use crate::error::InputError;
use crate::inputs::design_file::DesignFile;
use squid_auv::{Pitch, Vehicle, number};

/// Key that all axes share, and its value as text.
type Shared = (&'static str, fn(&DesignFile) -> String);

/// Checks that the axes command different actuators, at one sample rate, from one level flight, and have speeds in
/// common; `file` is for messages.
///
/// # Errors
/// [`InputError::SharedActuator`], [`InputError::AxesDiffer`], [`InputError::NoCommonSpeed`].
pub(super) fn check(designs: &[DesignFile], vehicles: &[Vehicle], file: &str) -> Result<(), InputError> {
    let Some(first) = designs.first() else { return Ok(()) };
    let file = || file.to_owned();
    for (index, design) in designs.iter().enumerate() {
        let owner = |name: &str| {
            let mut before = designs.iter().zip(vehicles).take(index);
            before.find(|(_, vehicle)| vehicle.actuators.iter().any(|one| one.name == name))
        };
        for actuator in &vehicles[index].actuators {
            if let Some((other, _)) = owner(&actuator.name) {
                let (one, other) = (other.steered_signal(), design.steered_signal());
                return Err(InputError::SharedActuator {
                    file: file(),
                    actuator: actuator.name.clone(),
                    one,
                    other,
                });
            }
        }
        let shared: [Shared; 3] = [
            ("autopilot.sample_time", |one| number(one.sample_time)),
            ("model.depth", |one| number(one.depth)),
            ("trim.pitch", |one| match &one.pitch_asked {
                None => "omitted".into(),
                Some(Pitch::Held(angle)) => format!("{} deg", number(angle.to_degrees())),
                Some(_) => "\"free\"".into(),
            }),
        ];
        for (key, of) in shared {
            if of(first) != of(design) {
                let text = |axis: &DesignFile| format!("{} for {}", of(axis), axis.steered_signal());
                let values = format!("{} and {}", text(first), text(design));
                return Err(InputError::AxesDiffer { file: file(), key, values });
            }
        }
    }
    let [low, high] = common_speeds(designs);
    if low > high {
        let of =
            |one: &DesignFile| format!("{} {} to {} m/s", one.steered_signal(), one.speed_min, one.speed_max);
        let ranges = designs.iter().map(of).collect::<Vec<_>>().join(", ");
        return Err(InputError::NoCommonSpeed { file: file(), ranges });
    }
    Ok(())
}

/// Returns the least and the largest speed in the range of every axis, m/s; the first is above the second if there is
/// none.
pub fn common_speeds<'a>(designs: impl IntoIterator<Item = &'a DesignFile>) -> [f64; 2] {
    designs.into_iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], one| {
        [low.max(one.speed_min), high.min(one.speed_max)]
    })
}
