//! The command `squid`.

use clap::Parser;
use serde_json::json;
use squid::cli::{Cli, TunedController, Verb};
use squid::error::Error;
use squid::output::{all_said, answer, answer_in_json, printed, set};
use squid::verbs::{
    campaign, design, doctor, export, lpv, new, package, plot, prove, report, shell, show, simulate, tune,
    verify,
};
use std::any::Any;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

/// A tenth faster than glibc's on a design: matrices of some 100 kB come and go, and glibc returns their pages each
/// time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Exit code when the command line is wrong: `EX_USAGE` of BSD's sysexits.h. Clap's own is 2, which means infeasible
/// here.
const WRONG_USAGE: u8 = 64;

/// Exit code when a design misses what is required, and that was to be said by one. 2, 3 and 4 are taken by `lpv
/// synth`.
const MISSED: u8 = 5;

fn main() -> ExitCode {
    squid_lpv::lmi::keep_caught_panics_quiet();
    let outcome = match Cli::try_parse() {
        Ok(cli) => {
            if cli.json {
                answer_in_json();
            }
            // A panic is a defect, and is told as one: also to a program that waits for an object.
            catch_unwind(AssertUnwindSafe(|| run(cli.verb))).unwrap_or_else(|panic| Err(defect(&*panic)))
        }
        Err(usage) if usage.use_stderr() => {
            if std::env::args_os().any(|word| word == "--json") {
                answer_in_json();
                let _ = answer(&json!({ "status": "error", "key": "usage", "reason": usage.to_string() }));
            }
            let _ = usage.print();
            return WRONG_USAGE.into();
        }
        Err(help_or_version) => {
            printed(help_or_version.print());
            Ok(ExitCode::SUCCESS)
        }
    };
    match outcome.and_then(|code| all_said().map(|()| code).map_err(Error::from)) {
        Ok(code) => code,
        Err(error) => {
            let _ = answer(&error.answer());
            // Not `eprintln`, which panics where nothing can be written.
            let _ = writeln!(io::stderr(), "{}", set(&format!("squid: {error}"), 0));
            match error {
                _ if error.is_usage() => WRONG_USAGE.into(),
                Error::Missed { .. } => MISSED.into(),
                _ => ExitCode::FAILURE,
            }
        }
    }
}

/// What a panic says.
fn defect(panic: &(dyn Any + Send)) -> Error {
    let words = panic.downcast_ref::<&str>().map(ToString::to_string);
    let message = words.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    Error::Defect { message }
}

fn run(verb: Verb) -> Result<ExitCode, Error> {
    match verb {
        Verb::Design { which, asked } => design::run(&which, &asked),
        Verb::Prove(asked) => prove::run(&asked),
        Verb::Gains(verb) => prove::gains::run(&verb),
        Verb::Tune { vehicle, design, axis, to, controller: Some(TunedController::Pid), degree, .. } => {
            tune::pid((&vehicle, &design, axis.as_deref()), to.as_deref(), degree.into())
        }
        Verb::Tune { vehicle, design, axis, track, to, designs, .. } => {
            tune::run((&vehicle, &design, axis.as_deref()), track, to.as_deref(), designs)
        }
        Verb::Package { which, asked } => package::run(&which, asked),
        Verb::Export { which, asked } => export::run(&which, asked),
        Verb::Simulate { which, sea, turn, current } => {
            simulate::run(&which, turn, (current, sea.as_deref()))
        }
        Verb::Campaign { which, asked } => campaign::run(&which, &asked),
        Verb::Replay { results, flight } => campaign::replay(&results, flight),
        Verb::Report { which, paper, sea, beside } => report::run(&which, paper, sea.as_deref(), &beside),
        Verb::Show { which, asked } => show::run(&which, &asked),
        Verb::Verify(asked) => verify::run(&asked),
        Verb::Plot { record, vehicle, out } => plot::run(&record, vehicle.as_deref(), out),
        Verb::New { directory, like } => new::run(&directory, like),
        Verb::Doctor => doctor::run(),
        Verb::Completions { shell } => shell::completions(shell),
        Verb::Man { directory } => shell::man(&directory),
        Verb::Lpv(verb) => return lpv::run(&verb),
    }
    .map(|()| ExitCode::SUCCESS)
}
