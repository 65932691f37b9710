//! The catalogue: every method by name, one line each.

use super::ab_array::{self, AbArray, AtomicAdd};
use super::ab_ll::{self, AbLinkedList};
use super::ab_ll_bucket::{self, AbBucketList};
use super::ab_ll_double::{self, AbDoubleList};
use super::ab_ll_paged::{self, AbPagedList};
use super::contract::Contract;
use super::depth_peel::{self, DepthPeel};
use super::depth_peel_bucket::BucketPeel;
use super::depth_peel_dual::{self, DualPeel};
use super::dfb::DynamicFragmentBuffer;
use super::ha::{self, Bits32, Bits64, HaBuffer};
use super::ha_cull::{self, HaCull};
use super::hash_coherent::{self, HashCoherent};
use super::kb::KBuffer;
use super::kb_ab::{self, KbAb};
use super::kb_ll::{self, KNearestList};
use super::kb_mdt32::{self, KbMdt32};
use super::kb_mdt64::{self, KbMdt64};
use super::kb_multi::{self, KBufferMulti};
use super::kb_ps::{self, KbPixelSync};
use super::kb_sr::KbStencilRouted;
use super::kplus::KPlus;
use super::kplus_array::{Correct, KPlusArray, faults};
use super::kplus_array_published::{KPlusArrayPublished, OrderedUnlock};
use super::kplus_heap::{self, KPlusHeap};
use super::kplus_multi::{self, KPlusMulti};
use super::kplus_sb::{self, KPlusSb};
use super::s_buffer::{self, SBuffer};
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
        SBuffer,
        DynamicFragmentBuffer,
        KBuffer,
        KbStencilRouted,
        KbMdt32,
        KbMdt64,
        KbPixelSync,
        KbAb<AbArray<AtomicAdd>>,
        KbAb<AbLinkedList>,
        KbAb<SBuffer>,
        KPlus,
        AbPagedList,
        AbBucketList,
        AbDoubleList,
        KNearestList,
        KPlusArray<Correct>,
        KPlusArrayPublished,
        KPlusHeap,
        KPlusHeap<kplus_heap::Published>,
        KPlusSb,
        KPlusSb<kplus_sb::Heap>,
        KPlusSb<kplus_sb::Published>,
        DepthPeel,
        DepthPeel<depth_peel::Published>,
        DualPeel,
        BucketPeel,
        KPlusMulti,
        KBufferMulti,
        HaBuffer<Bits64>,
        HaBuffer<Bits64, ha::Published>,
        HaBuffer<Bits64, ha::Multiset>,
        HaBuffer<Bits32>,
        HaCull,
        HaCull<ha_cull::Published>,
        HashCoherent,
        HashCoherent<hash_coherent::Published>,
    }
    faults {
        ZBuffer<z_buffer::ClearedToFarPlane>,
        ZBuffer<z_buffer::LoadStore>,
        AbArray<ab_array::OneTooMany>,
        AbArray<ab_array::LoadStore>,
        AbLinkedList<ab_ll::PublishedFirst>,
        AbLinkedList<ab_ll::OneTooMany>,
        AbLinkedList<ab_ll::PlainHead>,
        AbPagedList<ab_ll_paged::PlainUnlock>,
        AbPagedList<ab_ll_paged::OneTooMany>,
        AbPagedList<ab_ll_paged::NoLock>,
        AbBucketList<ab_ll_bucket::OtherDepth>,
        AbBucketList<ab_ll_bucket::NoBarrier>,
        AbBucketList<ab_ll_bucket::OpenEnd>,
        AbDoubleList<ab_ll_double::PublishedFirst>,
        AbDoubleList<ab_ll_double::RelaxedPublication>,
        KNearestList<kb_ll::PublishedFirst>,
        KNearestList<kb_ll::RelaxedPublication>,
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
        SBuffer<s_buffer::PlainCount>,
        SBuffer<s_buffer::NoBarrier>,
        SBuffer<s_buffer::OneTooMany>,
        KbMdt32<kb_mdt32::TwoFormulas>,
        KbMdt64<kb_mdt64::LoadStore>,
        KbMdt64<kb_mdt64::ClearedToFarPlane>,
        KbAb<AbLinkedList, kb_ab::First>,
        KbPixelSync<kb_ps::LeavesEarly>,
        KPlusHeap<kplus_heap::PlainUnlock>,
        KPlusHeap<kplus_heap::RelaxedCounter>,
        KPlusHeap<kplus_heap::RootFirst>,
        KPlusHeap<kplus_heap::DropsByArrival>,
        KPlusHeap<kplus_heap::EqualDepthStops>,
        DepthPeel<depth_peel::NotStrict>,
        DepthPeel<depth_peel::BehindNearPlane>,
        DualPeel<depth_peel_dual::MiddleTwice>,
        KPlusMulti<kplus_multi::Cut>,
        KBufferMulti<kb_multi::Unverified>,
        HaBuffer<Bits64, ha::faults::AgeOverflows>,
        HaBuffer<Bits64, ha::faults::NoBarrier>,
        HaBuffer<Bits64, ha::faults::NotReinserted>,
        HaBuffer<Bits64, ha::faults::AgeUntold>,
        HaBuffer<Bits64, ha::faults::OffsetReused>,
        HaBuffer<Bits64, ha::faults::LoadStore>,
        HaBuffer<Bits64, ha::faults::Area>,
        HaBuffer<Bits64, ha::faults::NoDepth>,
        HaCull<ha_cull::Braces>,
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
