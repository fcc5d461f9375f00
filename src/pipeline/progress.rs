//! How far a verb of the pipeline is.

/// Is told how far a verb is; does nothing unless it is told to.
pub trait Progress: Sync {
    /// A stage of `steps` steps begins.
    fn begin(&self, _stage: &'static str, _steps: usize) {}
    /// So many steps of the stage are done; called from any thread.
    fn advance(&self, _steps: usize) {}
    /// One step of the stage is done.
    fn step(&self) {
        self.advance(1);
    }
    /// The stage has ended.
    fn end(&self) {}
    /// Something that the user should know, in one line.
    fn note(&self, _line: &str) {}
}

/// Shows nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl Progress for NoProgress {}
