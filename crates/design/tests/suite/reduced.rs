//! Fewer controller states and channels.

use crate::designs::{committed, inputs};
use squid_base::progress::Progress;
use squid_design::inputs::design_file::DesignFile;
use squid_design::run::{Finished, run};
use squid_design::verdict::Verdict;
use squid_design::verdict::found::Effort;

fn sizes(finished: &Finished) -> (usize, usize) {
    let sizes = finished.design.controller.parts.sizes();
    (sizes.x, sizes.t)
}

/// REMUS 100 needs fewer states and channels than full order; everything is proved again, and no requirement is lost.
#[test]
fn smaller_controller_is_proved_and_meets_same_requirements() {
    let mut inputs = inputs("remus100");
    assert_eq!(inputs.design.reduce, Some(0.03));
    let smaller = run(&inputs, &Progress::default()).unwrap();
    inputs.design.reduce = None;
    let full = run(&inputs, &Progress::default()).unwrap();
    let ((states, channels), before) = (sizes(&smaller), sizes(&full));
    assert!(states <= 6 && channels <= 2 && before == (16, 7), "{states}, {channels} instead of {before:?}");
    let gamma = |finished: &Finished| finished.proof.as_ref().unwrap().theorem.gamma.unwrap();
    assert!(gamma(&smaller) <= 1.03 * gamma(&full), "{} {}", gamma(&smaller), gamma(&full));
    assert!(smaller.sampled.is_ok() && smaller.frozen.controller.gamma.certified);
    assert!(smaller.verdict.meets_all_of(&full.verdict), "{}", smaller.verdict);
    assert_eq!(smaller.frozen.controller.lft.a.len(), states);
}

/// A requirement that only one verdict meets is a loss, in one direction.
#[test]
fn detects_lost_requirement() {
    let (mut inputs, stored) = committed();
    let of = |inputs: &_| {
        let effort = Effort { frozen: 2, sampled: false, flown: 2, mu: 0 };
        Verdict::of(inputs, &stored.controller, effort).unwrap()
    };
    let before = of(&inputs);
    assert!(before.meets_all_of(&before));
    let text = std::fs::read_to_string(inputs.directory.join("design.toml")).unwrap();
    let strict =
        DesignFile::parse(&(text + "\n[require]\ndelay_margin = 9.0\n"), "design.toml", "design").unwrap();
    inputs.design.require = strict.require;
    let after = of(&inputs);
    assert!(!after.meets_all_of(&before) && before.meets_all_of(&after), "{after}");
}
