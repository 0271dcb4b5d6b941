//! The gains with which a controller follows commands that are not its own: before it is engaged, or while another
//! design flies. They do not belong to the loop whose gain is proved.

use crate::error::Error;
use crate::inputs::design_file::DesignFile;
use squid_lpv::anti_windup::follow::following_gain;
use squid_lpv::controller::Controller;
use squid_lpv::matrix::to_rows;
use squid_scheduled::Rows;

/// The number of values of rho, evenly spaced from -1 to 1; in between a gain is interpolated.
const VALUES: usize = 5;

/// A gain for each value of rho, n x m, in units of the actuators' reach; one for a controller that does not depend on
/// rho. None if the controller cannot follow: its command does not depend on its state.
///
/// # Errors
/// Of a controller that is not well posed.
pub fn follow(design: &DesignFile, controller: &Controller) -> Result<Vec<Rows>, Error> {
    let values = if controller.blocks.is_empty() { 1 } else { VALUES };
    let gain = |index: usize| {
        let rho = -1.0 + 2.0 * index as f64 / (values.max(2) - 1) as f64;
        let frozen = controller.frozen(&vec![rho; controller.blocks.len()])?;
        Ok(following_gain(&frozen, design.sample_time).map(|gain| to_rows(&gain)))
    };
    let gains: Option<Vec<Rows>> = (0..values).map(gain).collect::<Result<_, Error>>()?;
    Ok(gains.unwrap_or_default())
}
