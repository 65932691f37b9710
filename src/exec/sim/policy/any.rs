//! Any of the policies, as one type: the device's loop then contains their code, and one loop serves all of them.

use super::order::{InOrder, Reverse};
use super::pct::Pct;
use super::random::RandomSlot;
use super::recorded::Recorded;
use super::round_robin::RoundRobin;
use super::warp::Warp;
use super::{MAX_WARP, Policy, Scheduler, Scheduling};
use crate::error::{Error, Result};
use crate::exec::sim::schedule::Reader;

/// One of the policies.
#[derive(Debug)]
pub(in crate::exec::sim) struct Any(Inner);

#[derive(Debug)]
enum Inner {
    Order(InOrder),
    Reverse(Reverse),
    RoundRobin(RoundRobin),
    Random(RandomSlot),
    Warp(Warp),
    Pct(Pct),
    Recorded(Recorded),
}

/// The same call on each of them.
macro_rules! each {
    ($any:expr, $policy:ident => $call:expr) => {
        match $any {
            Inner::Order($policy) => $call,
            Inner::Reverse($policy) => $call,
            Inner::RoundRobin($policy) => $call,
            Inner::Random($policy) => $call,
            Inner::Warp($policy) => $call,
            Inner::Pct($policy) => $call,
            Inner::Recorded($policy) => $call,
        }
    };
}

impl Any {
    /// The policy that the settings name.
    ///
    /// # Errors
    /// See [`super::make`].
    pub(in crate::exec::sim) fn new(scheduling: &Scheduling) -> Result<Self> {
        let inner = match &scheduling.policy {
            Policy::Order => Inner::Order(InOrder::default()),
            Policy::Reverse => Inner::Reverse(Reverse::default()),
            Policy::RoundRobin => Inner::RoundRobin(RoundRobin::default()),
            Policy::Random => Inner::Random(RandomSlot::new(scheduling.seed)),
            Policy::Warp(lanes) if (1..=MAX_WARP).contains(lanes) => Inner::Warp(Warp::new(*lanes)),
            Policy::Warp(lanes) => {
                let problem = format!("warp:{lanes}: a warp has 1 to {MAX_WARP} lanes");
                return Err(Error::new("--schedule", problem));
            }
            Policy::Pct(0) => {
                return Err(Error::new("--schedule", "pct:0: the depth is at least 1"));
            }
            Policy::Pct(depth) => {
                Inner::Pct(Pct::new(scheduling.seed, *depth, scheduling.resident))
            }
            Policy::Recorded(bytes) => {
                let reader = Reader::new(bytes.clone(), scheduling.fingerprint)?;
                Inner::Recorded(Recorded::new(reader))
            }
        };
        Ok(Self(inner))
    }

    #[inline(never)]
    fn next_of_others(&mut self) -> Result<u32> {
        each!(&mut self.0, policy => policy.next())
    }
}

#[allow(clippy::inline_always, reason = "asked before every step")]
impl Scheduler for Any {
    fn admit(&mut self, slot: u32) {
        each!(&mut self.0, policy => policy.admit(slot));
    }

    fn retire(&mut self, slot: u32) {
        each!(&mut self.0, policy => policy.retire(slot));
    }

    fn waits(&mut self, slot: u32) {
        each!(&mut self.0, policy => policy.waits(slot));
    }

    /// Whole scenes run under `random`: only that policy is inlined in the loop itself.
    #[inline(always)]
    fn next(&mut self) -> Result<u32> {
        if let Inner::Random(policy) = &mut self.0 { policy.next() } else { self.next_of_others() }
    }

    #[inline(always)]
    fn hint(&self) -> Option<u32> {
        if let Inner::Random(policy) = &self.0 { policy.hint() } else { None }
    }

    fn group(&self) -> usize {
        each!(&self.0, policy => policy.group())
    }

    fn resident(&self, asked: usize) -> usize {
        each!(&self.0, policy => policy.resident(asked))
    }

    fn finish(&mut self) -> Result<()> {
        each!(&mut self.0, policy => policy.finish())
    }
}
