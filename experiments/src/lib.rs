//! What the experiments share.
//!
//! Each binary in `src/bin` repeats one experiment: it prints tables, writes them with pictures and a
//! record of the run into `experiments/out/<name>/`, and ends with exit code 1 when a number has left
//! the tolerance that `experiments/expected/<name>.toml` gives it.
//!
//! | module      | holds                                                                         |
//! |-------------|-------------------------------------------------------------------------------|
//! | [`run`]     | one run: arguments, numbers, files written, the check at the end               |
//! | [`expected`]| the numbers that a run must reach                                              |
//! | [`table`]   | tables, as Markdown and as CSV                                                  |
//! | [`picture`] | panels of curves and bars in one style, as SVG                                  |
//! | [`arm`]     | an arm of two bars, its cameras and silhouettes (ZS06, Fig. 2)                 |
//! | [`limb`]    | an arm of metaballs before cameras, and how a fitted arm is measured (PF02, PFD99) |
//! | [`contours`] | how far silhouettes are from the true ones, and pictures of both                |
//! | [`film`]    | films of a person before clutter, as recordings on disk                        |
//! | [`individual`] | somebody whose joints lie where publications leave them open               |
//! | [`held`]    | arms held where silhouettes hardly show them, and their errors (ZS06, Fig. 6)   |
//! | [`walker`]  | a walking person of metaballs, seen by seven cameras                           |
//! | [`metrics`] | how far fitted joint centres are from the true ones                             |
//! | [`figures`]   | what a fit is compared by                                                      |
//! | [`recorded`] | recordings that are shared by projects, with their truth, and their fit          |

pub mod arm;
pub mod contours;
pub mod expected;
pub mod figures;
pub mod film;
pub mod held;
pub mod individual;
pub mod limb;
pub mod metrics;
pub mod picture;
pub mod recorded;
pub mod run;
pub mod table;
pub mod walker;
