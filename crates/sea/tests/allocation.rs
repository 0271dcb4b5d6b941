//! No evaluation of a sea allocates: counted by the allocator itself.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use squid_sea::{Place, Spectrum, Spheroid, Waves};

#[test]
fn a_sea_is_evaluated_without_allocating() {
    let waves = Waves::new(&Spectrum::jonswap(1.0, 6.0, 3.3).unwrap(), 2.0, 100, 7).unwrap();
    let hull = Spheroid::new(1.0, 0.125, 1025.0, [[0.0; 3]; 3]).unwrap();
    let mut sum = 0.0;
    let found = measure(|| {
        for i in 0..100 {
            let place = Place { time: f64::from(i), x: 0.0, depth: 3.0 };
            sum += hull.in_waves(&waves, place, 0.1).1[2] + waves.elevation(place.time, 1.0);
        }
    });
    assert_eq!(found.count_total, 0);
    assert!(sum != 0.0);
}
