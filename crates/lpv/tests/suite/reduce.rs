//! Removal of controller states, with and without a limit on the fastest mode.

use crate::common;

use lpv::parameter_grid::parameter_grid;
use lpv::reduce::{reduce, without_fast_modes};
use lpv::synthesis::{Design, Options, synthesise};
use nalgebra::Complex;

#[test]
fn a_reduced_controller_keeps_the_limit_on_its_fastest_mode() {
    let plant = common::plant(&common::case("compleib/compleib_HE4"));
    let thetas = parameter_grid(plant.blocks.len());
    let fastest = |design: &Design| design.controller.fastest_mode(&thetas);
    let design = synthesise(&plant, Options::default()).unwrap();
    let free = reduce(&plant, &design, None);
    assert!(free.controller.a().nrows() < design.controller.a().nrows(), "something can be removed");
    assert!(fastest(&free) > 0.0);

    let allowed = 1.001 * fastest(&free);
    assert_eq!(reduce(&plant, &design, Some(allowed)), free);

    // No controller between the full and the smallest one is slower: the full one is returned unchanged.
    let refused = reduce(&plant, &design, Some(0.5 * fastest(&free)));
    assert!(refused == design || fastest(&refused) <= 0.5 * fastest(&free));
    assert_ne!(refused, free);
}

#[test]
fn fast_modes_give_way_to_their_gain_at_rest() {
    let plant = common::plant(&common::case("compleib/compleib_AC15"));
    let design = synthesise(&plant, Options::default()).unwrap();
    let mut modes: Vec<f64> = design.controller.frozen(&[]).unwrap().poles().iter().map(|p| -p.re).collect();
    modes.sort_by(f64::total_cmp);
    let [.., second, fastest] = modes[..] else { panic!("{modes:?}") };
    let without = |limit: f64| without_fast_modes(&plant, &design, limit, 0.2);
    assert!(without(4.0 * fastest).is_none(), "there are none");
    let slowest = 0.5 * modes[0];
    assert!(without(slowest).is_none_or(|d| d.controller.fastest_mode(&[vec![]]) <= slowest));

    let slower = without((second * fastest).sqrt()).unwrap();
    let frozen = |design: &Design| design.controller.frozen(&[]).unwrap();
    assert_eq!(frozen(&slower).a.nrows(), modes.len() - 1);
    assert!(slower.controller.fastest_mode(&[vec![]]) < 1.001 * second);
    let gains = [&design, &slower].map(|d| frozen(d).response(Complex::new(0.0, 0.0)).unwrap());
    assert!((&gains[0] - &gains[1]).norm() < 1e-9 * gains[0].norm());
    let norm = plant.close(&slower.controller).frozen(&[]).unwrap().hinf_norm().value;
    assert!(norm <= slower.certified.gamma && slower.certified.gamma < 1.2 * design.certified.gamma);
}
