//! The command `squid`.

use clap::Parser;
use serde_json::json;
use squid::cli::{Cli, TunedController, Verb};
use squid::error::Error;
use squid::output::{answer, answer_in_json, flush, printed, set};
use squid::verbs::{
    campaign, design, doctor, export, lpv, new, package, plot, prove, report, shell, show, simulate, tune,
    verify,
};
use std::any::Any;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

/// Allocator that is a tenth faster than glibc's on a design, which allocates and frees matrices of some 100 kB; glibc
/// returns their pages each time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Exit code for a wrong command line: `EX_USAGE` of BSD's sysexits.h. Clap's own is 2, which means infeasible here.
const WRONG_USAGE: u8 = 64;

/// Exit code if a requirement is missed and `--strict` was given, or by `squid tune`. 2, 3 and 4 are used by `lpv
/// synth`.
const MISSED: u8 = 5;

fn main() -> ExitCode {
    squid_lpv::lmi::keep_caught_panics_quiet();
    let outcome = match Cli::try_parse() {
        Ok(cli) => {
            if cli.json {
                answer_in_json();
            }
            // Report panics as internal errors, in JSON too.
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
    match outcome.and_then(|code| flush().map(|()| code).map_err(Error::from)) {
        Ok(code) => code,
        Err(error) => {
            let _ = answer(&error.answer());
            // `eprintln` would panic if nothing can be written.
            let _ = writeln!(io::stderr(), "{}", set(&format!("squid: {error}"), 0));
            match error {
                _ if error.is_usage() => WRONG_USAGE.into(),
                Error::Missed { .. } => MISSED.into(),
                _ => ExitCode::FAILURE,
            }
        }
    }
}

/// Returns the error for a panic.
fn defect(panic: &(dyn Any + Send)) -> Error {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let message = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    Error::Defect { message }
}

fn run(verb: Verb) -> Result<ExitCode, Error> {
    match verb {
        Verb::Design { which, options } => design::run(&which, &options),
        Verb::Prove(options) => prove::run(&options),
        Verb::Gains(verb) => prove::gains::run(&verb),
        Verb::Tune { vehicle, design, axis, to, controller: Some(TunedController::Pid), degree, .. } => {
            tune::pid((&vehicle, &design, axis.as_deref()), to.as_deref(), degree.into())
        }
        Verb::Tune { vehicle, design, axis, track, to, designs, .. } => {
            tune::run((&vehicle, &design, axis.as_deref()), track, to.as_deref(), designs)
        }
        Verb::Package { which, options } => package::run(&which, options),
        Verb::Export { which, options } => export::run(&which, options),
        Verb::Simulate { which, sea, turn, current } => {
            simulate::run(&which, turn, (current, sea.as_deref()))
        }
        Verb::Campaign { which, options } => campaign::run(&which, &options),
        Verb::Replay { results, flight } => campaign::replay(&results, flight),
        Verb::Report { which, paper, sea, beside } => report::run(&which, paper, sea.as_deref(), &beside),
        Verb::Show { which, options } => show::run(&which, &options),
        Verb::Verify(options) => verify::run(&options),
        Verb::Plot { record, vehicle, out } => plot::run(&record, vehicle.as_deref(), out),
        Verb::New { directory, like } => new::run(&directory, like),
        Verb::Doctor => doctor::run(),
        Verb::Completions { shell } => shell::completions(shell),
        Verb::Man { directory } => shell::man(&directory),
        Verb::Lpv(verb) => return lpv::run(&verb),
    }
    .map(|()| ExitCode::SUCCESS)
}
