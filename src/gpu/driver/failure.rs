//! What a device can do to us.

/// Why a device gave no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// It has not what the method needs; it is not at fault.
    #[error("{0}")]
    Unsupported(String),
    /// It has no room for so much at once.
    #[error("{0}")]
    TooLarge(String),
    /// It ran out of memory.
    #[error("out of memory: {0}")]
    OutOfMemory(String),
    /// It did not come back in time, and is not used any more.
    #[error("no answer within {0} seconds")]
    TimedOut(u64),
    /// So many invocations gave up waiting for a lock, however often they were run.
    #[error("{0} invocations waited for a lock, and none would come")]
    Stuck(u64),
    /// It is gone.
    #[error("device lost: {0}")]
    Lost(String),
    /// It, or the validation before it, refused what we asked: a fault of ours or of the driver.
    #[error("refused: {0}")]
    Invalid(String),
}

impl Failure {
    /// The device can be used no more.
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
