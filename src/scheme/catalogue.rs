//! The catalogue: every method by name, one line each.

use super::ab_array::{AbArray, AtomicAdd, LoadStore};
use super::ab_ll::AbLinkedList;
use super::contract::Contract;
use super::kb::KBuffer;
use super::kplus_array::{Correct, KPlusArray, OneTest, RelaxedUnlock};
use super::kplus_array_published::KPlusArrayPublished;
use super::z_buffer::ZBuffer;
use super::{Scheme, exact};
use crate::error::{Error, Result};

/// Something to do with a method once its type is known.
pub trait Visitor {
    /// What comes of it.
    type Output;

    /// With a scheme.
    fn scheme<S: Scheme + Send + 'static>(self) -> Self::Output;

    /// With the oracle, which is not a scheme.
    fn exact(self) -> Self::Output;
}

macro_rules! catalogue {
    ($($scheme:ty,)*) => {
        /// Every method's contract; the oracle comes first.
        pub const CONTRACTS: &[Contract] = &[exact::CONTRACT, $(<$scheme as Scheme>::CONTRACT,)*];

        /// Visit the method of that name.
        ///
        /// # Errors
        /// There is none; the message lists those there are.
        pub fn visit<V: Visitor>(name: &str, visitor: V) -> Result<V::Output> {
            if name == exact::CONTRACT.name {
                return Ok(visitor.exact());
            }
            $(if name == <$scheme as Scheme>::CONTRACT.name {
                return Ok(visitor.scheme::<$scheme>());
            })*
            Err(unknown(name))
        }
    };
}

catalogue! {
    ZBuffer,
    AbArray<AtomicAdd>,
    AbArray<LoadStore>,
    AbLinkedList,
    KBuffer,
    KPlusArray<Correct>,
    KPlusArrayPublished,
    KPlusArray<RelaxedUnlock>,
    KPlusArray<OneTest>,
}

/// Every method's contract; the oracle comes first.
#[must_use]
pub fn contracts() -> Vec<&'static Contract> {
    CONTRACTS.iter().collect()
}

/// The contract of the method of that name.
///
/// # Errors
/// There is none; the message lists those there are.
pub fn contract(name: &str) -> Result<&'static Contract> {
    CONTRACTS.iter().find(|c| c.name == name).ok_or_else(|| unknown(name))
}

fn unknown(name: &str) -> Error {
    let names: Vec<&str> = CONTRACTS.iter().map(|c| c.name).collect();
    Error::new("--method", format!("no method is called '{name}'; there are {}", names.join(", ")))
}
