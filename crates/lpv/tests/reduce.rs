//! Removing controller states, with and without a limit on the fastest mode.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use lpv::parameter_grid::parameter_grid;
use lpv::reduce::reduce;
use lpv::synthesis::{Design, Options, synthesise};

#[test]
fn a_reduced_controller_keeps_the_limit_on_its_fastest_mode() {
    let plant = common::plant(&common::case("compleib/compleib_AC15"));
    let thetas = parameter_grid(plant.blocks.len());
    let fastest = |design: &Design| design.controller.fastest_mode(&thetas);
    let design = synthesise(&plant, Options::default()).unwrap();
    let free = reduce(&plant, &design, None);
    assert!(free.controller.a().nrows() < design.controller.a().nrows(), "something can be removed");
    assert!(fastest(&free) > 0.0);

    let allowed = 1.001 * fastest(&free);
    assert_eq!(reduce(&plant, &design, Some(allowed)), free);

    // Nothing between the full controller and the smallest one is slower: the full one is handed back as it is.
    let refused = reduce(&plant, &design, Some(0.5 * fastest(&free)));
    assert!(refused == design || fastest(&refused) <= 0.5 * fastest(&free));
    assert_ne!(refused, free);
}
