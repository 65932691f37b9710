//! Single runs of a litmus pixel under a policy: for instances too large to explore, and for looking at one schedule.

use crate::error::Result;
use crate::exec::sim::policy::{self, Scheduler, Scheduling};
use crate::explore::program::case::Case;
use crate::explore::program::machine::Conditions;
use crate::explore::program::schedule::{Move, Schedule};
use crate::explore::replay::run::{Run, Runner};
use crate::explore::search::explored::Limits;
use crate::num::random;

/// Steps after which a run is abandoned: its schedule may never end.
const MOST_STEPS: usize = 100_000;

/// The stream of the random numbers that choose among values.
const STREAM: u64 = 0xA17E_44A7;

/// Run an instance once, under a policy of the simulated device; where memory allows several values, the seed picks one
/// at random. Gives the schedule and the run; `None` if it does not end in time.
///
/// # Errors
/// A recorded schedule that does not fit.
pub(super) fn walk(
    case: &Case,
    conditions: Conditions,
    scheduling: &Scheduling,
    limits: &Limits<'_>,
) -> Result<Option<(Schedule, Run)>> {
    let mut runner = Runner::new(case, conditions);
    let mut policy = policy::make(scheduling)?;
    let (mut live, mut stage) = (runner.live(), runner.stage());
    let admit = |policy: &mut dyn Scheduler, live: u32| {
        (0..32).filter(|i| live & (1 << i) != 0).for_each(|i| policy.admit(i));
    };
    admit(&mut *policy, live);
    let mut schedule = Schedule::new();
    while live != 0 {
        if schedule.len() == MOST_STEPS || (limits.cancelled)() {
            return Ok(None);
        }
        let invocation = next(&mut *policy, &mut runner, live)?;
        let Some(invocation) = invocation else { return Ok(None) };
        let ways = runner.alternatives(invocation) as u64;
        let pick = random::bits(scheduling.seed, STREAM, schedule.len() as u64) % ways;
        let by = Move { invocation: invocation as u8, alternative: pick as u16 };
        runner.step(by);
        schedule.push(by);
        let now = runner.live();
        if runner.stage() != stage {
            // It was the last of its stage; the invocations of the next stage come now.
            stage = runner.stage();
            policy.retire(invocation as u32);
            admit(&mut *policy, now);
        } else if now != live {
            policy.retire(invocation as u32);
        } else if runner.waits(invocation) {
            policy.waits(invocation as u32);
        }
        live = now;
    }
    Ok(Some((schedule, runner.finish())))
}

/// The invocation that the policy names among those that can move; `None` if none can.
fn next(policy: &mut dyn Scheduler, runner: &mut Runner<'_>, live: u32) -> Result<Option<usize>> {
    let can_move =
        |runner: &mut Runner<'_>, i: usize| live & (1 << i) != 0 && runner.alternatives(i) > 0;
    // A lane that waits for others is skipped; a policy that insists on it is not asked forever.
    for _ in 0..64 {
        let slot = policy.next()? as usize;
        if can_move(runner, slot) {
            return Ok(Some(slot));
        }
    }
    Ok((0..32).find(|&i| can_move(runner, i)))
}
