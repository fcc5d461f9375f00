//! The program: everything is in the library's `cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    maquette::cli::run(std::env::args_os())
}
