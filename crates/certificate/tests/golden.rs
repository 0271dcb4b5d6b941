//! The golden certificates prove, their claims agree with an independent check, and small lies are refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
#[path = "common/independent.rs"]
mod independent;

use certificate::{Certificate, Failure};
use common::{GOLDEN, golden};
use independent::{Loop, claims};

#[test]
fn each_proves_and_is_confirmed() {
    for name in GOLDEN {
        let c = golden(name);
        let start = std::time::Instant::now();
        println!("{name}: {}", c.prove().unwrap());
        println!("  in {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
        let closed = Loop::new(&c);
        for claim in claims(&c) {
            assert!(closed.inequality(&claim) < 0.0, "{name}: {}", closed.inequality(&claim));
            assert_eq!(closed.contradiction(&claim), None, "{name}");
        }
    }
}

#[test]
fn a_smaller_gamma_is_refused() {
    for name in GOLDEN {
        let mut c = golden(name);
        c.gamma *= 0.5;
        let failure = c.prove().unwrap_err();
        println!("{name}: {failure}");
        assert!(matches!(failure, Failure::NotDefinite { pivot, .. } if pivot >= 0.0), "{failure}");
    }
}

/// Every entry off the diagonal of X and S, and every entry of T, moved to the next f64.
#[test]
fn one_ulp_off_the_structure_is_always_refused() {
    for name in GOLDEN {
        let c = golden(name);
        let mut tried = 0;
        for which in 0..6 {
            let size = if which % 3 == 0 { c.x.len() } else { c.s.len() };
            for (i, j) in (0..size * size).map(|k| (k / size, k % size)) {
                let mut lie = c.clone();
                let Some(entry) = entry(&mut lie, which, i, j) else { continue };
                if which % 3 != 2 && i == j {
                    continue;
                }
                *entry = entry.next_up();
                tried += 1;
                assert!(matches!(lie.prove(), Err(Failure::NotMirrored { .. })), "{name} {which} {i} {j}");
            }
        }
        println!("{name}: {tried} refused");
    }
}

fn entry(c: &mut Certificate, which: usize, i: usize, j: usize) -> Option<&mut f64> {
    let rows = match which {
        0 => &mut c.x,
        1 => &mut c.s,
        2 => &mut c.t,
        3 => &mut c.residual.as_mut()?.x,
        4 => &mut c.residual.as_mut()?.s,
        _ => &mut c.residual.as_mut()?.t,
    };
    Some(&mut rows[i][j])
}
