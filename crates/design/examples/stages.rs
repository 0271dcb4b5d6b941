//! Times the stages.
#![allow(clippy::print_stdout)]
use base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::run::run;
use std::time::Instant;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let inputs = Inputs::read(a[0].as_ref(), &a[1])?;
    let t = Instant::now();
    let last = std::sync::Mutex::new(t);
    let print = |e: base::progress::Event| {
        if let base::progress::Event::Done { stage, figures } = e {
            let mut l = last.lock().unwrap();
            println!("{:7.2} {stage}: {}", l.elapsed().as_secs_f64(), figures.lines().next().unwrap_or(""));
            *l = Instant::now();
        }
    };
    let f = run(&inputs, &Progress::new(&print))?;
    let s = f.design.controller.parts.sizes();
    println!("{} states {} channels gamma {} {}", s.x, s.t, f.design.certified.gamma, f.verdict);
    println!("{:.2}", t.elapsed().as_secs_f64());
    Ok(())
}
