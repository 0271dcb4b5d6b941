//! Evaluating a sea at every step allocates nothing, as counted by the allocator.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use squid_sea::{GaussMarkov, Layers, Position, Sensor, SensorErrors, Spectrum, Spheroid, Wandering, Waves};

#[test]
fn evaluating_a_sea_allocates_nothing() {
    let waves = Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3).unwrap(), 2.0, 100, 7).unwrap();
    let hull = Spheroid::new(1.0, 0.125, 1025.0, [[0.0; 6]; 6]).unwrap();
    let layers = Layers::new(&[[0.0, 1.0], [10.0, 0.0]]).unwrap();
    let parameters = Wandering { mu: 0.1, noise: 0.1, min: -1.0, max: 1.0 };
    let mut process = GaussMarkov::new(parameters, 7).unwrap();
    let errors = SensorErrors { noise: 0.1, delay: 0.5, rate: 10.0, ..SensorErrors::NONE };
    let mut sensor = Sensor::new(errors, 0.02, 7, 0).unwrap();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut sum = 0.0;
    let found = measure(|| {
        for i in 0..100 {
            let position = Position { time: f64::from(i), north: 0.0, east: 2.0, depth: 3.0 };
            process.advance(0.02);
            sum += hull.in_waves(&waves, position, &axes).1[2] + waves.elevation(position.time, [1.0, 2.0]);
            sum += hull.slopes_in_waves(&waves, position, &axes)[6][5];
            sum += layers.at(position.depth).0 + process.value() + sensor.read(sum);
        }
    });
    assert_eq!(found.count_total, 0);
    assert!(sum != 0.0);
}
