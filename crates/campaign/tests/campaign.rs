//! Campaigns of the committed design of Squid.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use rayon::ThreadPoolBuilder;
use squid_auv::longitudinal::SIGNALS;
use squid_campaign::bound::gains;
use squid_campaign::error::Error;
use squid_campaign::flight::Outcome;
use squid_campaign::plan::{Drawn, Plan, Points};
use squid_campaign::run::{BATCH, missing, results, run};
use squid_campaign::starts::Starts;
use squid_design::inputs::Inputs;
use squid_design::store::{Stored, load};
use squid_flight::whole::SixDofFlight;
use std::collections::BTreeMap;
use std::path::Path;

const FLIGHTS: u64 = 2 * BATCH + 3;

fn squid() -> (Inputs, Stored) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid");
    let inputs = Inputs::read(&folder, "design").unwrap();
    let stored = load(&folder.join("frozen"), &inputs).unwrap();
    (inputs, stored)
}

fn fly(plan: &Plan<'_>, flights: u64, cores: usize, directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let pool = ThreadPoolBuilder::new().num_threads(cores).build().unwrap();
    let parts = missing(plan, 0..flights, directory).unwrap();
    pool.install(|| run(plan, &parts, directory, &|flight| plan.row(flight), &|_| ())).unwrap();
    let all = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    all.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(&path).unwrap()))
        .collect()
}

/// Files are identical byte for byte with one core or two, and after a file was lost.
#[test]
fn results_do_not_depend_on_cores_or_interruptions() {
    let (inputs, stored) = squid();
    let plan = Plan::new(&inputs, &stored, None, 7, Points::Uniform).unwrap();
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let by_one = fly(&plan, FLIGHTS, 1, one.path());
    let by_two = fly(&plan, FLIGHTS, 2, two.path());
    assert_eq!(by_one.len(), 3);
    assert!(by_one == by_two);
    let lost = by_two.keys().nth(1).unwrap();
    std::fs::remove_file(two.path().join(lost)).unwrap();
    assert!(by_one == fly(&plan, FLIGHTS, 2, two.path()));

    let rows = results(&plan, one.path()).unwrap();
    assert!(rows.iter().map(|row| row.flight).eq(0..FLIGHTS));
    assert!(rows.iter().all(|row| row.outcome == Outcome::Flown), "{rows:?}");
    for row in &rows {
        let repeated = plan.fly(row.flight).unwrap().0;
        let bits = |figures: &[f64]| figures.iter().map(|figure| figure.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&repeated.figures), bits(&row.figures));
        assert_eq!((&repeated.drawn, repeated.flight), (&row.drawn, row.flight));
    }

    // More flights: only the missing ones are simulated.
    let files = fly(&plan, FLIGHTS + 1, 2, two.path());
    assert_eq!(files.len(), 4);
    assert_eq!(results(&plan, two.path()).unwrap().len() as u64, FLIGHTS + 1);
}

/// Drawn numbers lie in their ranges, at the ends for [`Points::Corners`], and depend on the seed.
#[test]
fn drawn_numbers_lie_in_their_ranges() {
    let (inputs, stored) = squid();
    let draws = |points, seed| {
        let plan = Plan::new(&inputs, &stored, None, seed, points).unwrap();
        (0..200).map(|flight| plan.draw(flight)).collect::<Vec<_>>()
    };
    let uniform = draws(Points::Uniform, 1);
    let all = || uniform.iter().flat_map(|drawn| &drawn.delta);
    assert!(all().all(|d| d.abs() <= 1.0));
    let mean = all().sum::<f64>() / all().count() as f64;
    let square = all().map(|d| d * d).sum::<f64>() / all().count() as f64;
    assert!(mean.abs() < 0.05 && (square - 1.0 / 3.0).abs() < 0.03, "{mean} {square}");
    assert!(draws(Points::Corners, 1).iter().flat_map(|drawn| &drawn.delta).all(|d| d.abs() == 1.0));
    assert!(uniform == draws(Points::Uniform, 1) && uniform != draws(Points::Uniform, 2));
    let range = stored.manoeuvre.speed_from..=stored.manoeuvre.speed_to;
    for drawn in &uniform {
        assert!(range.contains(&drawn.manoeuvre.speed_from) && range.contains(&drawn.manoeuvre.speed_to));
        assert_eq!(drawn.manoeuvre.step("pitch").abs(), stored.manoeuvre.step("pitch"));
    }
    let up = uniform.iter().filter(|drawn| drawn.manoeuvre.step("pitch") > 0.0).count();
    assert!((70..130).contains(&up), "{up}");
}

/// Each 64th of every range contains one of the first 64 flights of a Sobol sequence; the next sequence differs.
#[test]
fn sobol_sequence_is_even() {
    let (inputs, stored) = squid();
    let plan = Plan::new(&inputs, &stored, None, 1, Points::Sobol).unwrap();
    let drawn: Vec<_> = (0..64).map(|flight| plan.draw(flight)).collect();
    let (from, to) = (stored.manoeuvre.speed_from, stored.manoeuvre.speed_to);
    let numbers = plan.uncertain.len();
    let shares = drawn.iter().map(|d| {
        let speeds = [d.manoeuvre.speed_from, d.manoeuvre.speed_to].map(|v| (v - from) / (to - from));
        d.delta.iter().map(|delta| 0.5 * (delta + 1.0)).chain(speeds).collect::<Vec<f64>>()
    });
    let shares: Vec<Vec<f64>> = shares.collect();
    for number in 0..numbers + 2 {
        let mut cells: Vec<usize> = shares.iter().map(|share| (64.0 * share[number]) as usize).collect();
        cells.sort_unstable();
        assert_eq!(cells, (0..64).collect::<Vec<usize>>(), "number {number}");
    }
    let up = drawn.iter().filter(|d| d.manoeuvre.step("pitch") > 0.0).count();
    assert_eq!(up, 32);
    assert!(plan.draw(1 << 16) != drawn[0] && plan.draw(1 << 16) == plan.draw(1 << 16));
}

/// Flights start with the drawn deviations from trim, which do not affect the other drawn numbers.
#[test]
fn flights_start_with_deviations_from_trim() {
    let (inputs, stored) = squid();
    let plan = |points, starts: &str| {
        let plan = Plan::new(&inputs, &stored, None, 1, points).unwrap();
        if starts.is_empty() { plan } else { plan.with_starts(starts.parse::<Starts>().unwrap()) }
    };
    let list = "pitch=10deg,heave=0.1m/s";
    let limits = [10f64.to_radians(), 0.0, 0.0, 0.0, 0.1];
    for points in [Points::Uniform, Points::Sobol, Points::Corners] {
        let (off, in_trim) = (plan(points, list), plan(points, ""));
        let mut cells = Vec::new();
        for flight in 0..64 {
            let (drawn, plain) = (off.draw(flight), in_trim.draw(flight));
            assert!(drawn.off_trim.iter().zip(limits).all(|(off, limit)| off.abs() <= limit));
            assert_eq!(Drawn { off_trim: plain.off_trim, ..drawn.clone() }, plain);
            assert_eq!(plain.off_trim, [0.0; SIGNALS.len()]);
            cells.push((32.0 * (drawn.off_trim[4] / limits[4] + 1.0)) as usize);
        }
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len() == 64, points == Points::Sobol, "{points:?}: {}", cells.len());
    }
    let (off, in_trim) = (plan(Points::Uniform, list), plan(Points::Uniform, ""));
    let (row, flight) = off.fly(5).unwrap();
    let names: Vec<String> = off.drawn().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names[3..5], ["pitch_off_trim", "heave_off_trim"]);
    let initial = |flight: &Option<SixDofFlight>| flight.as_ref().unwrap().axes[0].rows[0].signals.measured;
    let trim = initial(&in_trim.fly(5).unwrap().1);
    let [pitch, speed, _, pitch_rate, heave, _] = initial(&flight);
    assert!((pitch - trim[0] - row.drawn[3]).abs() < 1e-15 && row.drawn[3].abs() > 1e-3);
    assert!((heave - trim[4] - row.drawn[4]).abs() < 1e-15 && row.drawn[4].abs() > 1e-3);
    assert_eq!([speed, pitch_rate], [trim[1], trim[3]]);
}

/// Results of another seed, and a file that is not Parquet.
#[test]
fn rejects_results_of_another_campaign() {
    let (inputs, stored) = squid();
    let directory = tempfile::tempdir().unwrap();
    let plan = |seed| Plan::new(&inputs, &stored, None, seed, Points::Uniform).unwrap();
    fly(&plan(1), 2, 1, directory.path());
    let error = missing(&plan(2), 0..2, directory.path()).unwrap_err();
    assert!(matches!(&error, Error::Other { what, .. } if what == "the seed"), "{error}");
    std::fs::write(directory.path().join("z.parquet"), b"PAR1").unwrap();
    let error = missing(&plan(1), 0..2, directory.path()).unwrap_err();
    assert!(matches!(&error, Error::Results { path, .. } if path.ends_with("z.parquet")), "{error}");
}

/// The largest drawn gain is below the guaranteed one and close to it at every speed, and the gains vary.
#[test]
fn guaranteed_gain_bounds_drawn_gains() {
    let (inputs, stored) = squid();
    let plan = Plan::new(&inputs, &stored, None, 3, Points::Corners).unwrap();
    let all = gains(&plan, &(0..40).collect::<Vec<_>>()).unwrap();
    assert_eq!(all.len(), 6);
    for at in &all {
        let (guaranteed, (_, largest)) = (at.guaranteed.unwrap(), at.largest().unwrap());
        assert!(largest <= guaranteed && largest > 0.9 * guaranteed, "{at:?}");
        assert!(at.drawn.len() + at.outside == 40 && at.outside < 4, "{at:?}");
        let least = at.drawn.iter().map(|(_, gain)| *gain).fold(f64::INFINITY, f64::min);
        assert!(largest > 1.003 * least, "{least} {largest}");
    }
}
