//! Numbers of things in words.

/// A number of things: 1 frame, 2 frames.
pub fn counted(count: usize, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {thing}{plural}")
}
