//! The catalogue: every method by name, one line each.

use super::ab_array::{self, AbArray, AtomicAdd};
use super::ab_ll::{self, AbLinkedList};
use super::contract::Contract;
use super::depth_peel::{self, DepthPeel};
use super::depth_peel_bucket::BucketPeel;
use super::depth_peel_dual::{self, DualPeel};
use super::kb::KBuffer;
use super::kb_multi::{self, KBufferMulti};
use super::kplus_array::{Correct, KPlusArray, faults};
use super::kplus_array_published::{KPlusArrayPublished, OrderedUnlock};
use super::kplus_multi::{self, KPlusMulti};
use super::z_buffer::{self, ZBuffer};
use super::{Scheme, exact};
use crate::error::{Error, Result};

/// Something to do with a method once its type is known.
pub trait Visitor {
    /// What comes of it.
    type Output;

    /// With a scheme.
    fn scheme<S: Scheme + Send + 'static>(self) -> Self::Output;

    /// With a built-in fault: a scheme too, but one that nobody hurries, so that a visitor may spare the compiler some
    /// of its forms.
    fn fault<S: Scheme + Send + 'static>(self) -> Self::Output
    where
        Self: Sized,
    {
        self.scheme::<S>()
    }

    /// With the oracle, which is not a scheme.
    fn exact(self) -> Self::Output;
}

macro_rules! catalogue {
    (methods { $($scheme:ty,)* } faults { $($fault:ty,)* }) => {
        /// Every method's contract; the oracle comes first.
        pub const CONTRACTS: &[Contract] = &[
            exact::CONTRACT,
            $(<$scheme as Scheme>::CONTRACT,)*
            $(<$fault as Scheme>::CONTRACT,)*
        ];

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
            $(if name == <$fault as Scheme>::CONTRACT.name {
                return Ok(visitor.fault::<$fault>());
            })*
            Err(unknown(name))
        }
    };
}

catalogue! {
    methods {
        ZBuffer,
        AbArray<AtomicAdd>,
        AbLinkedList,
        KBuffer,
        KPlusArray<Correct>,
        KPlusArrayPublished,
        DepthPeel,
        DepthPeel<depth_peel::Published>,
        DualPeel,
        BucketPeel,
        KPlusMulti,
        KBufferMulti,
    }
    faults {
        ZBuffer<z_buffer::ClearedToFarPlane>,
        ZBuffer<z_buffer::LoadStore>,
        AbArray<ab_array::OneTooMany>,
        AbArray<ab_array::LoadStore>,
        AbLinkedList<ab_ll::PublishedFirst>,
        AbLinkedList<ab_ll::OneTooMany>,
        AbLinkedList<ab_ll::PlainHead>,
        KPlusArray<faults::PlainUnlock>,
        KPlusArray<faults::RelaxedUnlock>,
        KPlusArray<faults::RelaxedExchange>,
        KPlusArray<faults::RelaxedLock>,
        KPlusArray<faults::SpinCap>,
        KPlusArray<faults::TimeOut>,
        KPlusArray<faults::ClearsOutside>,
        KPlusArray<faults::RelaxedCounter>,
        KPlusArray<faults::EarlyCount>,
        KPlusArray<faults::EqualDepthStops>,
        KPlusArray<faults::NoBarrierBeforeStore>,
        KPlusArray<faults::NoBarrierBeforeResolve>,
        KPlusArray<faults::SpinsFirst>,
        KPlusArray<faults::OneTest>,
        KPlusArray<faults::RootFirst>,
        KPlusArrayPublished<OrderedUnlock>,
        DepthPeel<depth_peel::NotStrict>,
        DepthPeel<depth_peel::BehindNearPlane>,
        DualPeel<depth_peel_dual::MiddleTwice>,
        KPlusMulti<kplus_multi::Cut>,
        KBufferMulti<kb_multi::Unverified>,
    }
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
