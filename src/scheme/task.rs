//! What one invocation does, as data: for code that runs invocations of several passes at once, or of methods whose
//! type it does not know.

use std::future::Future;
use std::pin::Pin;

use super::held::Holds;
use super::{Held, Outcome, Scheme};
use crate::fragment::Fragment;
use crate::memory::Memory;

/// What one invocation does. Passes are numbered as in the contract's program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Task {
    /// Nothing.
    Idle,
    /// Clear the frame's words.
    ClearFrame,
    /// Clear a pixel.
    Clear(u32),
    /// An earlier geometry pass's part for a fragment.
    Prepare(u8, Fragment),
    /// A full-screen pass's part for a pixel.
    Screen(u8, u32),
    /// One invocation of a pass over the frame's words.
    Frame(u8, u32),
    /// Store a fragment.
    Store(Fragment),
    /// Resolve a pixel, and say whether it needs another round.
    Resolve(u32),
}

impl Task {
    /// The fragment that it is done for.
    #[must_use]
    pub fn fragment(&self) -> Option<Fragment> {
        match *self {
            Self::Prepare(_, fragment) | Self::Store(fragment) => Some(fragment),
            _ => None,
        }
    }

    /// The pixel that it is done for.
    #[must_use]
    pub fn pixel(&self) -> Option<u32> {
        match *self {
            Self::Clear(pixel) | Self::Screen(_, pixel) | Self::Resolve(pixel) => Some(pixel),
            _ => self.fragment().map(|fragment| fragment.pixel),
        }
    }
}

/// A running invocation, without its type.
pub type Invocation<'a> = Pin<Box<dyn Future<Output = Ended> + 'a>>;

/// What an invocation gave when it ended.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Ended {
    /// Nothing.
    Done,
    /// What became of the fragment, as far as its invocation knows.
    Stored(Outcome),
    /// What a pixel holds, as it came out of memory, and whether it needs another round.
    Resolved(u32, Held, bool),
}

/// Run an invocation.
pub async fn invoke<S: Scheme, M: Memory>(scheme: &S, mem: &M, task: Task) -> Ended {
    match task {
        Task::Idle => {}
        Task::ClearFrame => scheme.clear_frame(mem).await,
        Task::Clear(pixel) => scheme.clear(mem, pixel).await,
        Task::Prepare(pass, fragment) => scheme.prepare(mem, usize::from(pass), fragment).await,
        Task::Screen(pass, pixel) => scheme.screen(mem, usize::from(pass), pixel).await,
        Task::Frame(pass, index) => scheme.frame(mem, usize::from(pass), index).await,
        Task::Store(fragment) => return Ended::Stored(scheme.store(mem, fragment).await),
        Task::Resolve(pixel) => return resolve(scheme, mem, pixel).await,
    }
    Ended::Done
}

/// Run a resolve invocation.
pub async fn resolve<S: Scheme, M: Memory>(scheme: &S, mem: &M, pixel: u32) -> Ended {
    let mut held = S::Holds::default();
    scheme.resolve(mem, pixel, &mut held).await;
    let again = S::CONTRACT.program.repeats && scheme.again(mem, pixel).await;
    Ended::Resolved(pixel, held.into_held(), again)
}
