//! scratch
use lpv::matrix::Mat;
use lpv::plant::GeneralisedPlant;
use lpv::synthesis::*;

fn load(name: &str) -> GeneralisedPlant {
    let text = std::fs::read_to_string(format!("/work/shared/cases/{name}.json")).unwrap();
    let v: serde_json::Value = serde_json::from_str(&text).unwrap();
    let lft = v["data"].get("P").is_some();
    let p = if lft { v["data"]["P"].clone() } else { v["data"].clone() };
    let m = |k: &str| -> Mat {
        let rows: Vec<Vec<f64>> = serde_json::from_value(p[k].clone()).unwrap();
        Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    };
    let (a, b1, b2, c1, c2) = (m("A"), m("B1"), m("B2"), m("C1"), m("C2"));
    let (n, w, u, z, y) = (a.nrows(), b1.ncols(), b2.ncols(), c1.nrows(), c2.nrows());
    let o = |k: &str, r: usize, c: usize| if lft { m(k) } else { Mat::zeros(r, c) };
    GeneralisedPlant {
        bt: o("Bt", n, 0),
        ct: o("Ct", 0, n),
        dtt: o("Dtt", 0, 0),
        dt1: o("Dt1", 0, w),
        dt2: o("Dt2", 0, u),
        d1t: o("D1t", z, 0),
        d2t: o("D2t", y, 0),
        d11: m("D11"),
        d12: m("D12"),
        d21: m("D21"),
        a,
        b1,
        b2,
        c1,
        c2,
        blocks: if lft { serde_json::from_value(v["data"]["blocks"].clone()).unwrap() } else { vec![] },
    }
}

#[test]
fn scratch() {
    for name in [
        "hs02_gamma_sqrt065",
        "lpv01_lpvtools_lft_tutorial",
        "lpv03_lpvtools_grid2lft",
        "lpv05_one_param_lossless",
        "hs04_active_suspension",
    ] {
        let p = load(name);
        for scalings in [Scalings::SymmetricAndSkew, Scalings::Symmetric] {
            let t = std::time::Instant::now();
            match least_gamma(&p, scalings) {
                Ok((_, e)) => println!(
                    "{name} {scalings:?} gamma {:.6} margin {:.1e} in {:?}",
                    e.gamma,
                    e.margin,
                    t.elapsed()
                ),
                Err(e) => println!("{name} {e}"),
            }
        }
        let t = std::time::Instant::now();
        match synthesise(&p, Options::default()) {
            Ok(d) => println!(
                "  opt {:.5} design {:.5} certified {:.5} eig {:.1e} poles {:.3?} in {:?}",
                d.gamma_optimum,
                d.gamma_design,
                d.certified.gamma,
                d.certified.largest_eigenvalue,
                d.controller.frozen(&vec![0.0; p.blocks.len()]).unwrap().poles(),
                t.elapsed()
            ),
            Err(e) => println!("  {e}"),
        }
    }
}
