//! Golden certificates: they are proved, agree with an independent check, and small violations are rejected.

use crate::common::{GOLDEN, gain, golden};
use crate::independent::{Loop, claims};
use nalgebra::DMatrix;
use squid_certificate::{Certificate, Claim, Failure, Rows};

#[test]
fn each_is_proved_and_confirmed() {
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

/// Adds a direct path from u to y and compensates it in the controller, `u = K (y - D22 u)`: the loop is the same
/// except for rounding.
#[test]
fn proves_same_loops_with_direct_path() {
    for name in GOLDEN {
        let mut c = golden(name);
        let k = &mut c.controller;
        let (n, r, y, u) = (k.a.len(), k.ct.len(), c.plant.c2.len(), k.duy.len());
        let mat = |m: &Rows, cols: usize| DMatrix::from_fn(m.len(), cols, |i, j| m[i][j]);
        let rows = |m: DMatrix<f64>| m.row_iter().map(|r| r.iter().copied().collect()).collect::<Rows>();
        let (cu, duy, dut) = (mat(&k.cu, n), mat(&k.duy, y), mat(&k.dut, r));
        let size = 0.5 / duy.norm().max(1e-3);
        let d22 = DMatrix::from_fn(y, u, |i, j| size * (1.0 + i as f64 - 0.7 * j as f64));
        let inverse = (DMatrix::identity(u, u) + &duy * &d22).try_inverse().unwrap();
        let (cu, duy, dut) = (&inverse * cu, &inverse * duy, &inverse * dut);
        let (by, dty) = (mat(&k.by, y) * &d22, mat(&k.dty, y) * &d22);
        k.a = rows(mat(&k.a, n) - &by * &cu);
        k.by = rows(mat(&k.by, y) - &by * &duy);
        k.bt = rows(mat(&k.bt, r) - &by * &dut);
        k.ct = rows(mat(&k.ct, n) - &dty * &cu);
        k.dty = rows(mat(&k.dty, y) - &dty * &duy);
        k.dtt = rows(mat(&k.dtt, r) - &dty * &dut);
        (k.cu, k.duy, k.dut) = (rows(cu), rows(duy), rows(dut));
        c.plant.d22 = rows(d22);
        assert!(c.prove().is_ok(), "{name}: {}", c.prove().unwrap_err());
        let closed = Loop::new(&c);
        for claim in claims(&c) {
            assert!(closed.inequality(&claim) < 0.0, "{name}: {}", closed.inequality(&claim));
            assert_eq!(closed.contradiction(&claim), None, "{name}");
        }
        assert_eq!(Certificate::from_json(&c.to_json().unwrap()).unwrap(), c);
    }
}

#[test]
fn rejects_smaller_gamma() {
    for name in GOLDEN {
        let mut c = golden(name);
        gain(&mut c).gamma *= 0.5;
        let failure = c.prove().unwrap_err();
        println!("{name}: {failure}");
        assert!(
            matches!(failure, Failure::NotDefinite { pivot: Some(pivot), .. } if pivot >= 0.0),
            "{failure}"
        );
    }
}

/// Moves every entry off the diagonal of X and S, and every entry of T, to the next f64.
#[test]
fn rejects_structure_off_by_one_ulp() {
    for name in GOLDEN {
        let c = golden(name);
        let mut tried = 0;
        for which in 0..6 {
            let gain = c.gain().unwrap();
            let size = if which % 3 == 0 { gain.x.as_ref().unwrap().len() } else { gain.s.len() };
            for (i, j) in (0..size * size).map(|k| (k / size, k % size)) {
                let mut lie = c.clone();
                let Some(entry) = entry(&mut lie, which, i, j) else { continue };
                if which % 3 != 2 && i == j {
                    continue;
                }
                *entry = entry.next_up();
                tried += 1;
                assert!(matches!(lie.prove(), Err(Failure::Structure { .. })), "{name} {which} {i} {j}");
            }
        }
        println!("{name}: {tried} refused");
    }
}

fn entry(c: &mut Certificate, which: usize, i: usize, j: usize) -> Option<&mut f64> {
    let mut gains =
        c.claims.iter_mut().filter_map(|claim| if let Claim::Gain(gain) = claim { Some(gain) } else { None });
    let gain = gains.nth(which / 3)?;
    let rows = match which % 3 {
        0 => gain.x.as_mut()?,
        1 => &mut gain.s,
        _ => &mut gain.t,
    };
    Some(&mut rows[i][j])
}
