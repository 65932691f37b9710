//! The ways in which a device can fail.

/// Why a device gave no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// It lacks what the method needs; this is not a fault.
    #[error("{0}")]
    Unsupported(String),
    /// It has no room for this much at once.
    #[error("{0}")]
    TooLarge(String),
    /// It ran out of memory.
    #[error("out of memory: {0}")]
    OutOfMemory(String),
    /// It did not come back in time, and is no longer used.
    #[error("no answer within {0} seconds")]
    TimedOut(u64),
    /// This many invocations gave up waiting for a lock, however often they were rerun.
    #[error("{0} invocations never got the lock that they waited for")]
    Stuck(u64),
    /// Pixels ask for more rounds than any can have layers.
    #[error("pixels ask for another round after {0}")]
    Endless(u32),
    /// It is gone.
    #[error("device lost: {0}")]
    Lost(String),
    /// It, or the validation before it, refused our request: a fault of ours or of the driver.
    #[error("refused: {0}")]
    Invalid(String),
}

impl Failure {
    /// Whether the device can no longer be used.
    #[must_use]
    pub fn is_fatal(&self) -> bool {
        matches!(self, Self::TimedOut(_) | Self::Lost(_))
    }
}

impl From<crate::error::Error> for Failure {
    fn from(error: crate::error::Error) -> Self {
        Self::Invalid(error.to_string())
    }
}

/// A device's result.
pub type Result<T> = std::result::Result<T, Failure>;
