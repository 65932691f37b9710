//! An operation that is known by its place and action only, on a memory whose operations are typed.

use super::layout::{Address, At, Atomic, Global, Pixel, Space};
use super::{Memory, Word};
use crate::memory::asked::Action;

/// Perform an action; the value read, or 0.
pub async fn perform<M: Memory>(mem: &M, address: Address, action: Action) -> u64 {
    match (address.pixel, address.bits) {
        (Some(pixel), 64) => act::<_, Pixel, u64>(mem, At::new(pixel, address.word), action).await,
        (Some(pixel), _) => act::<_, Pixel, u32>(mem, At::new(pixel, address.word), action).await,
        (None, 64) => act::<_, Global, u64>(mem, At::new(0, address.word), action).await,
        (None, _) => act::<_, Global, u32>(mem, At::new(0, address.word), action).await,
    }
}

async fn act<M: Memory, S: Space, W: Word>(mem: &M, at: At<S, Atomic, W>, action: Action) -> u64 {
    match action {
        Action::Read(access) => mem.read(at, access).await.to_u64(),
        Action::Write(value, access) => {
            mem.write(at, W::from_u64(value), access).await;
            0
        }
        Action::Update(update, order) => {
            mem.update(at, update.map(W::from_u64), order).await.to_u64()
        }
    }
}
