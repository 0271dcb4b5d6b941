//! Writes the loop of a stored design, frozen at each of the report's six speeds, as problems for `squid lpv mu`.
//!
//! ```text
//! cargo run --release -p squid --example mu_problems -- VEHICLE_DIR DESIGN_DIR OUTPUT_DIR
//! ```
//!
//! The blocks are the uncertain parameters of the design file, real and repeated. The paths of the files are printed,
//! lowest speed first.

use serde_json::json;
use squid_base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::store;
use squid_design::uncertain::closed_loop::uncertain_loop;
use squid_design::uncertain::frozen::at_speed;
use squid_lpv::matrix::to_rows;
use squid_report::subject::Subject;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [vehicle, design, output] = arguments.as_slice() else {
        return Err("usage: mu_problems VEHICLE_DIR DESIGN_DIR OUTPUT_DIR".into());
    };
    let inputs = Inputs::read(Path::new(vehicle), "design")?;
    let stored = store::load(Path::new(design), &inputs)?;
    let progress = Progress::default();
    let subject = Subject::new(&inputs, &stored, &progress)?;
    for &speed in &subject.speeds {
        let frozen = at_speed(&inputs, speed)?;
        let system = uncertain_loop(&inputs, &frozen, &subject.controller)?.stability();
        let blocks: Vec<(i64, i64)> =
            frozen.model.blocks.iter().map(|b| (-(b.repetitions as i64), 0)).collect();
        let [a, b, c, d] = [&system.a, &system.b, &system.c, &system.d].map(to_rows);
        let plant = json!({ "A": a, "B": b, "C": c, "D": d });
        let problem = json!({ "kind": "mu", "data": { "P": plant, "blocks": blocks } });
        let path = Path::new(output).join(format!("{speed:.2}.json"));
        std::fs::write(&path, format!("{problem}\n"))?;
        println!("{}", path.display());
    }
    Ok(())
}
