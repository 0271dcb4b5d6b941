//! Another anti-windup gain, where references beyond the envelope miss a requirement.

use crate::designs::committed;
use proof::claim::{Proof, parse};
use squid_design::augment::augment;
use squid_design::certify::controller_of;
use squid_design::certify::limits::{ClaimedStep, check_autopilot};
use squid_design::fit::Model;
use squid_design::inputs::design_file::DesignFile;
use squid_design::verdict::Verdict;
use squid_design::verdict::found::{Effort, Found};
use squid_design::verdict::other_gain::{Judged, OtherGain};
use squid_design::verdict::row::Outcome;

/// The committed design of Squid keeps its gain. Where it is to lose a tenth less speed than it does, it gets another
/// one, which is proved for the default flight as well.
#[test]
fn another_proved_gain_is_flown_where_the_first_one_misses() {
    let (mut inputs, stored) = committed();
    let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
    let plant = augment(&inputs.vehicle.actuators, &inputs.design, model.linear()).unwrap();
    let certificate = parse(stored.certificate.as_ref().unwrap(), "certificate.json").unwrap();
    let theorem = certificate.prove().unwrap();
    let proof = Proof { certificate, theorem, model_error: None };
    let controller = controller_of(&stored.controller.lft).unwrap();
    let frozen = &stored.controller;
    let effort = Effort { frozen: 2, sampled: false, flown: Effort::FULL.flown, mu: 0 };
    let found = Found::of(&inputs, frozen, effort).unwrap();
    let lost = found.beyond.iter().map(|b| b.lost_speed).fold(0.0, f64::max);
    let verdict = Verdict::judge(&inputs, frozen.gamma.bound, found.clone());
    let judged = Judged { plant: &plant, controller: &controller, proof: &proof, frozen, verdict: &verdict };
    assert!(OtherGain::of(&inputs, judged).unwrap().is_none(), "{verdict}");

    let text = std::fs::read_to_string(inputs.directory.join("design.toml")).unwrap();
    let text = format!("{text}\n[require]\nbeyond_speed = {}\n", 90.0 * lost);
    inputs.design.require = DesignFile::parse(&text, "design.toml", "design").unwrap().require;
    let verdict = Verdict::judge(&inputs, frozen.gamma.bound, found);
    assert_eq!(verdict.missed().map(|row| row.key).collect::<Vec<_>>(), ["beyond_speed"]);
    let other = OtherGain::of(&inputs, Judged { verdict: &verdict, ..judged }).unwrap().unwrap();
    let row = other.verdict.rows.iter().find(|row| row.key == "beyond_speed").unwrap();
    assert_eq!(row.outcome, Outcome::Met, "{}", other.verdict);
    assert_ne!(other.frozen.anti_windup, frozen.anti_windup);
    let theorem = other.proof.certificate.prove().unwrap();
    check_autopilot(&other.frozen, &other.proof.certificate).unwrap();
    let step = ClaimedStep::of(&other.frozen, &theorem).unwrap();
    assert_eq!(step.exceeded_by(&inputs.design.manoeuvre), None, "{step}");
}
