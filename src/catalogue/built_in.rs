//! The built-in methods, one line each.

use crate::exec::Method;
use crate::memory::Atomic;
use crate::scheme::a_buffer::ab_array::{self, AbArray, AtomicAdd};
use crate::scheme::a_buffer::ab_ll::{self, AbLinkedList};
use crate::scheme::a_buffer::ab_ll_bucket::{self, AbBucketList};
use crate::scheme::a_buffer::ab_ll_double::{self, AbDoubleList};
use crate::scheme::a_buffer::ab_ll_paged::{self, AbPagedList};
use crate::scheme::a_buffer::dfb::DynamicFragmentBuffer;
use crate::scheme::a_buffer::s_buffer::{self, SBuffer};
use crate::scheme::approximate::adaptive::{self, Adaptive};
use crate::scheme::approximate::hybrid::{self, Hybrid};
use crate::scheme::approximate::mbt::{self, Mbt};
use crate::scheme::approximate::mlab::{self, Mlab};
use crate::scheme::approximate::stochastic::{self, Stochastic, StochasticDepth};
use crate::scheme::approximate::unsorted::BlendUnsorted;
use crate::scheme::approximate::wboit::{self, Wboit};
use crate::scheme::culling::occupancy::{self, Occupancy};
use crate::scheme::hash_table::ha::{self, Bits32, Bits64, HaBuffer};
use crate::scheme::hash_table::ha_cull::{self, HaCull};
use crate::scheme::hash_table::hash_coherent::{self, HashCoherent};
use crate::scheme::k_buffer::kb::KBuffer;
use crate::scheme::k_buffer::kb_ab::{self, KbAb};
use crate::scheme::k_buffer::kb_ll::{self, KNearestList};
use crate::scheme::k_buffer::kb_mdt32::{self, KbMdt32};
use crate::scheme::k_buffer::kb_mdt64::{self, KbMdt64};
use crate::scheme::k_buffer::kb_multi::{self, KBufferMulti};
use crate::scheme::k_buffer::kb_ps::{self, KbPixelSync};
use crate::scheme::k_buffer::kb_sr::KbStencilRouted;
use crate::scheme::k_buffer::z_buffer::{self, ZBuffer};
use crate::scheme::kplus_buffer::k_variable::{self, KVariable};
use crate::scheme::kplus_buffer::kplus::KPlus;
use crate::scheme::kplus_buffer::kplus_array::{KPlusArray, faults};
use crate::scheme::kplus_buffer::kplus_array_published::{KPlusArrayPublished, OrderedUnlock};
use crate::scheme::kplus_buffer::kplus_array_word64::KPlusArrayWord64;
use crate::scheme::kplus_buffer::kplus_heap::{self, KPlusHeap};
use crate::scheme::kplus_buffer::kplus_multi::{self, KPlusMulti};
use crate::scheme::kplus_buffer::kplus_sb::{self, KPlusSb};
use crate::scheme::merging::dfb_merged::{self, DfbMerged, Overlapping, Smooth};
use crate::scheme::merging::skb_ofm::{SkbOfm, forms};
use crate::scheme::parts::lock::reach::Updated;
use crate::scheme::peeling::depth_peel::{self, DepthPeel};
use crate::scheme::peeling::depth_peel_bucket::BucketPeel;
use crate::scheme::peeling::depth_peel_dual::{self, DualPeel};

macro_rules! catalogue {
    (methods { $($scheme:ty,)* } once { $($once:ty,)* }) => {
        /// All of them: first the oracle; then the methods that promise something, compiled for every executor; then
        /// the mended forms, which are there for checks and devices, and the built-in faults, compiled once.
        pub(super) const METHODS: &[Method] = &[
            Method::EXACT,
            $(Method::of::<$scheme>(),)*
            $(Method::interpreted::<$once>(),)*
        ];
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
        KPlusArray,
        KPlusArrayPublished,
        KPlusHeap,
        KPlusHeap<kplus_heap::Published>,
        KPlusSb,
        KPlusSb<kplus_sb::Heap>,
        KPlusSb<kplus_sb::Published>,
        KVariable,
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
        Occupancy,
        DfbMerged<Smooth>,
        DfbMerged<Smooth<dfb_merged::Released>>,
        DfbMerged<Overlapping>,
        SkbOfm<forms::Exact>,
        SkbOfm<forms::Published>,
        SkbOfm<forms::Released>,
        Wboit,
        wboit::PublishedF32,
        Mbt,
        mbt::PublishedF32,
        Mlab,
        Adaptive,
        Adaptive<adaptive::Over>,
        Adaptive<adaptive::KeepsLast>,
        Hybrid,
        Hybrid<hybrid::Product>,
        Hybrid<hybrid::ByArrival>,
        Stochastic,
        Stochastic<stochastic::PlainMean>,
        StochasticDepth,
        BlendUnsorted,
    }
    once {
        AbPagedList<Atomic>,
        AbPagedList<Updated>,
        KNearestList<Atomic>,
        KNearestList<Updated>,
        KPlusArray<Atomic>,
        KPlusArray<Updated>,
        KPlusArrayWord64,
        KPlusHeap<Atomic>,
        KPlusHeap<Updated>,
        KPlusSb<Atomic>,
        KPlusSb<Updated>,
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
        faults::Faulty<faults::PlainUnlock>,
        faults::Faulty<faults::RelaxedUnlock>,
        faults::Faulty<faults::RelaxedExchange>,
        faults::Faulty<faults::RelaxedLock>,
        faults::Faulty<faults::SpinCap>,
        faults::Faulty<faults::TimeOut>,
        faults::Faulty<faults::ClearsOutside>,
        faults::Faulty<faults::RelaxedCounter>,
        faults::Faulty<faults::EarlyCount>,
        faults::Faulty<faults::EqualDepthStops>,
        faults::Faulty<faults::NoBarrierBeforeStore>,
        faults::Faulty<faults::NoBarrierBeforeResolve>,
        faults::Faulty<faults::SpinsFirst>,
        faults::Faulty<faults::OneTest>,
        faults::Faulty<faults::RootFirst>,
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
        KVariable<k_variable::faults::Rounded>,
        KVariable<k_variable::faults::FloatQuotient>,
        KVariable<k_variable::faults::NoBarrier>,
        KVariable<k_variable::faults::StaleCount>,
        Occupancy<occupancy::NearEnd>,
        Occupancy<occupancy::OneTooNear>,
        Occupancy<occupancy::EndsEarly>,
        DfbMerged<Smooth<dfb_merged::EightBits>>,
        DfbMerged<Smooth<dfb_merged::Closed>>,
        DfbMerged<Smooth<dfb_merged::FrontOnly>>,
        DfbMerged<Smooth<dfb_merged::Squared>>,
        DfbMerged<Smooth<dfb_merged::MixedTail>>,
        SkbOfm<forms::TailOutside>,
        SkbOfm<forms::NotEvicting>,
        SkbOfm<forms::EightBits>,
        SkbOfm<forms::FirstOnly>,
        SkbOfm<forms::Closed>,
        Wboit<wboit::ConstantWeight>,
        Wboit<wboit::PremultipliedTwice>,
        Wboit<wboit::EightBits>,
        Mlab<mlab::OpacitySum>,
        Mlab<mlab::FartherDepth>,
        Hybrid<hybrid::TailAlpha>,
        Stochastic<stochastic::SameSamples>,
    }
}

/// See [`super::DEFAULT`].
pub(super) const DEFAULT: Method = Method::of::<KPlusArray>();

/// See [`super::OCCUPANCY`].
pub(super) const OCCUPANCY: Method = Method::of::<Occupancy>();
