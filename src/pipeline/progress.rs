//! How far a verb of the pipeline is.

/// Is told how far a verb is; does nothing unless it is told to.
pub trait Progress: Sync {
    /// A stage of `steps` steps begins.
    fn begin(&self, _stage: &'static str, _steps: usize) {}
    /// One step of the stage is done; called from any thread.
    fn step(&self) {}
    /// The stage has ended.
    fn end(&self) {}
}

/// Shows nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl Progress for NoProgress {}
