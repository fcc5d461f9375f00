//! The results of the people who are seen besides the one who is measured.

use std::fs;
use std::path::PathBuf;

use super::OutFolder;

/// Where they are.
const PEOPLE: &str = "people";

impl OutFolder {
    /// Where the results of a person are who is seen besides the one who is measured.
    pub fn person(&self, number: usize) -> PathBuf {
        self.path.join(PEOPLE).join(number.to_string())
    }

    /// Removes the results of people whom an older run found besides these.
    pub fn keep_people(&self, kept: &[usize]) {
        let people = self.path.join(PEOPLE);
        for entry in fs::read_dir(&people).into_iter().flatten().flatten() {
            let number = entry.file_name().to_string_lossy().parse::<usize>();
            if number.is_ok_and(|number| !kept.contains(&number)) {
                // what cannot be removed is told apart by its date
                drop(fs::remove_dir_all(entry.path()));
            }
        }
        drop(fs::remove_dir(people));
    }
}
