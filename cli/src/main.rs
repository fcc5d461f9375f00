//! The program `maquette`: its words in, its exit code out.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(maquette_cli::run(std::env::args_os()))
}
