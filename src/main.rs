//! The `maquette` program: parses, runs, sets the exit code.

fn main() {}
