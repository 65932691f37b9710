//! The only error that a user can get: some input is wrong.

/// What is wrong with the input: where (a file or an option), which field of it, and what would be right.
///
/// It prints as one line, `place: field: problem`, and the binary exits with 2 on it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct Error {
    place: String,
    problem: String,
}

/// A result whose error the user can fix.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// `place` is a file or an option; `problem` names the field and says what would be right.
    #[must_use]
    pub fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { place: place.into(), problem: problem.into() }
    }

    /// The file or option.
    #[must_use]
    pub fn place(&self) -> &str {
        &self.place
    }

    /// What is wrong with it.
    #[must_use]
    pub fn problem(&self) -> &str {
        &self.problem
    }
}
