//! Runs a command: from its words to its exit status.

use crate::outcome::{ARGUMENTS, CHECK_FAILED, Failure, Outcome};
use crate::signals;
use crate::terminal::say;
use clap::{ArgMatches, Command, FromArgMatches, Parser};
use std::env;
use std::ffi::OsString;
use std::process::ExitCode;

/// Parses the command line and runs `main` on it.
///
/// # Returns
/// 0: done (help and version, too). 1: `main` failed, one line on stderr says at what. 2: the arguments cannot be
/// used, one line on stderr says which. 3: done, but checks failed, each with its line on stderr.
pub fn run_with_args<A: Parser>(main: impl FnOnce(A) -> Result<Outcome, Failure>) -> ExitCode {
    run_command(A::command(), env::args_os(), |args, _| main(args))
}

/// The same for a command that is more than its declaration, on a command line whose first word is the name of the program. `main` gets
/// the matches, too: they know [what was typed](crate::args::is_typed).
pub fn run_command<A: FromArgMatches>(
    command: Command,
    words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    main: impl FnOnce(A, &ArgMatches) -> Result<Outcome, Failure>,
) -> ExitCode {
    let parsed = command.try_get_matches_from(words).and_then(|matches| Ok((A::from_arg_matches(&matches)?, matches)));
    match parsed {
        Ok((args, matches)) => run(|| main(args, &matches)),
        Err(error) if !error.use_stderr() => {
            // Help; if it cannot be written, nobody is there to read it.
            let _ = error.print();
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&one_line(&error));
            ExitCode::from(ARGUMENTS)
        }
    }
}

/// Runs `main` and turns its end into an exit status, as [`run_with_args`].
pub fn run(main: impl FnOnce() -> Result<Outcome, Failure>) -> ExitCode {
    signals::handle();
    match main() {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::ChecksFailed(failed)) => {
            failed.iter().for_each(|check| say(&format!("check failed: {check}")));
            ExitCode::from(CHECK_FAILED)
        }
        Err(failure) => {
            say(&format!("error: {}", failure.message()));
            ExitCode::from(failure.status)
        }
    }
}

/// What clap says, without usage and hints, in one line that begins with `error: `.
pub fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines =
        text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}
