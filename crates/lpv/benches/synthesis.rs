//! Synthesis of known plants, by criterion: the least gamma alone, and the whole design with its gain bound.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::{Options, ScalingClass, least_gamma, synthesise};
use std::hint::black_box;

/// Name in the table, and where the plant comes from.
fn plants() -> Vec<(&'static str, GeneralisedPlant)> {
    vec![
        ("squid", common::certified_plant("squid_surrogate")),
        ("lpv01", common::plant(&common::case("lpv01_lpvtools_lft_tutorial"))),
        ("lpv03", common::plant(&common::case("lpv03_lpvtools_grid2lft"))),
        ("HE4", common::plant(&common::case("compleib/compleib_HE4"))),
    ]
}

fn synthesis(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("synthesis");
    group.sample_size(10);
    for (name, plant) in plants() {
        group.bench_function(format!("least_gamma/{name}"), |bencher| {
            bencher.iter(|| least_gamma(black_box(&plant), ScalingClass::SymmetricAndSkew).unwrap());
        });
        group.bench_function(format!("synthesise/{name}"), |bencher| {
            bencher.iter(|| synthesise(black_box(&plant), Options::default()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, synthesis);
criterion_main!(benches);
