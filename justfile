# `just` lists the recipes; `.ci/run` is what a change must pass.

_default:
    @just --list

# Format, lints, tests, documentation: before every commit
check:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets -- -D warnings
    cargo test --workspace
    RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --workspace

# Everything, with licences and sources, as the checks do it
test-all:
    .ci/run

# One experiment by name, see experiments/README.md
experiments NAME:
    cargo run --release -p experiments --bin {{NAME}}

# Speed of the inner loops
bench:
    cargo bench --workspace
