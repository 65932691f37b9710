//! What is checked: a method with invocations.

use crate::error::{Error, Result};
use crate::exec::Method;
use crate::scheme::{Contract, Scheme};

/// A method that can be explored: any but the oracle, which has no invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// The method.
    pub method: Method,
    /// What it promises.
    pub contract: &'static Contract,
}

impl Subject {
    /// A method.
    ///
    /// # Errors
    /// The method is the oracle: it has no invocations whose order could matter.
    pub fn new(method: Method) -> Result<Self> {
        if method.is_exact() {
            let problem =
                "is the sequential reference: it has no invocations whose order could matter";
            return Err(Error::new(method.name(), problem));
        }
        Ok(Self { method, contract: method.contract() })
    }

    /// A user's scheme.
    #[must_use]
    pub fn of<S: Scheme>() -> Self {
        Self { method: Method::of::<S>(), contract: &S::CONTRACT }
    }
}
