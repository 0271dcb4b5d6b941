//! Reads the sea that a controller is made for: the table `[sea]`.

use auv::toml_file::Table;
use auv::{Linearisation, RegularWaves};
use lpv::matrix::Mat;
use squid_flight::sea::Swell;
use squid_sea::ShapingFilter;

use crate::inputs::design_file::Range;
use crate::inputs::design_file::values::within;

/// By how much waves count more than they are.
const WEIGHT: Range = Range { least: 1e-3, most: 1e3, words: "from 0.001 to 1000" };

/// The sea that a controller is made for.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkingSea {
    /// The depth at which it works \[m\].
    pub depth: f64,
    /// The waves there.
    pub waves: Swell,
    /// By how much they count more than they are.
    pub weight: f64,
}

impl WorkingSea {
    /// For a range of speed \[m/s\], where that could be read.
    pub(super) fn of(table: &Table<'_>, speeds: Option<(f64, f64)>) -> Option<Self> {
        let waves = Swell::of(table, &["depth", "weight"]);
        let depth =
            table.number("depth", |depth| depth > 0.0, "above 0 (m): where the vehicle works in waves");
        let weight = match table.has("weight") {
            true => within(table, "weight", WEIGHT),
            false => Some(1.0),
        };
        let sea = Self { waves: waves?, depth: depth?, weight: weight? };
        if let Some((low, high)) = speeds
            && [low, high].iter().any(|speed| sea.filter(*speed).is_none())
        {
            let words = "such that the vehicle is not carried along by the waves, at any of its speeds: these must be \
                         below half of the speed of the waves on its way";
            table.not_allowed("heading", auv::number(sea.waves.heading.to_degrees()), words);
            return None;
        }
        Some(sea)
    }

    fn filter(&self, speed: f64) -> Option<ShapingFilter> {
        ShapingFilter::met(&self.waves.spectrum, self.waves.heading, speed)
    }

    /// The waves of the peak, as the vehicle knows them.
    pub fn regular(&self) -> RegularWaves {
        let (frequency, heading) = (self.waves.spectrum.peak(), self.waves.heading);
        RegularWaves { frequency, heading, depth: self.depth }
    }

    /// What they add to the linear motion about a trim: `[G 0; A_w B_w]`, (n + 2) x 3; see
    /// [`lpv::tracking::TrackingProblem::waves`]. Noise of 1 at the peak is a wave whose amplitude is half the
    /// significant height.
    pub fn acting(&self, l: &Linearisation) -> Option<Mat> {
        let (by_waves, filter) = (l.by_waves.as_ref()?, self.filter(l.trim.speed)?);
        let (n, height) = (by_waves.nrows(), self.waves.spectrum.height());
        let rates = filter.rates();
        let mut acting = Mat::from_fn(n + 2, 3, |i, j| i.checked_sub(n).map_or(0.0, |row| rates[row][j]));
        acting.view_mut((0, 0), by_waves.shape()).copy_from(&(by_waves * (0.5 * height * self.weight)));
        Some(acting)
    }
}
