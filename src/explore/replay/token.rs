//! Tokens: a failing schedule as text that can be shared.
//!
//! `fl2-` and base64 (URL-safe, without padding) of what was run, the schedule, what it showed, a digest of its
//! operations, and a checksum. A token is complete: method, instance, memory, schedule. It is refused if it has another
//! version of the format, if it is damaged, or if the operations that it leads to differ from those that it was made
//! from.

use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::run::{Event, Run};
use super::words::describe;
use crate::error::{Error, Result};
use crate::explore::memory::model::{MemoryModel, Profile};
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::{Conditions, MOST_INVOCATIONS};
use crate::explore::program::schedule::{Move, Schedule};
use crate::scheme::hash_table::table::{MOST_AGES, TableSettings};

/// The version of the format, and how a token begins.
const PREFIX: &str = "fl2-";

/// Bytes of the checksum.
const CHECK: usize = 4;

/// A run that can be repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Token {
    /// A schedule of a litmus pixel.
    Litmus(LitmusToken),
    /// A whole scene on the simulated device.
    Scene(SceneToken),
}

/// A token's bytes. A new form is a new variant at the end, so that old tokens keep their bytes.
#[derive(Serialize, Deserialize)]
enum Wire {
    Litmus(LitmusToken),
    Scene(SceneToken),
    /// A litmus pixel of a method with inputs, and their words.
    WithInputs(LitmusToken, Vec<Vec<u32>>),
    /// A litmus pixel whose fragments have a third word: the words of inputs, and every fragment's thickness or number.
    WithSlabs(LitmusToken, Vec<Vec<u32>>, Vec<u32>),
}

impl From<&Token> for Wire {
    fn from(token: &Token) -> Self {
        match token {
            Token::Litmus(token) if token.litmus.fragments.iter().any(|f| f.3 > 0) => {
                let thickness = token.litmus.fragments.iter().map(|f| f.3).collect();
                Self::WithSlabs(token.clone(), token.litmus.inputs.clone(), thickness)
            }
            Token::Litmus(token) if !token.litmus.inputs.is_empty() => {
                Self::WithInputs(token.clone(), token.litmus.inputs.clone())
            }
            Token::Litmus(token) => Self::Litmus(token.clone()),
            Token::Scene(token) => Self::Scene(token.clone()),
        }
    }
}

impl From<Wire> for Token {
    fn from(wire: Wire) -> Self {
        match wire {
            Wire::Litmus(token) => Self::Litmus(token),
            Wire::Scene(token) => Self::Scene(token),
            Wire::WithInputs(mut token, inputs) => {
                token.litmus.inputs = inputs;
                Self::Litmus(token)
            }
            Wire::WithSlabs(mut token, inputs, thickness) => {
                token.litmus.inputs = inputs;
                let own = token.litmus.fragments.iter_mut().zip(thickness);
                own.for_each(|(fragment, thickness)| fragment.3 = thickness);
                Self::Litmus(token)
            }
        }
    }
}

/// A schedule of a litmus pixel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LitmusToken {
    /// The method's name.
    pub method: String,
    /// The property that fails, or [`Self::OUTCOME`].
    pub property: String,
    /// The instance.
    pub litmus: Litmus,
    /// 0: sequentially consistent; 1, 2, 3: relaxed with the profiles in order.
    memory: u8,
    /// Lanes of a warp.
    warp: Option<u32>,
    /// (invocation, alternative, how often) from the beginning.
    runs: Vec<(u8, u16, u32)>,
    /// The same for what then repeats forever.
    cycle: Vec<(u8, u16, u32)>,
    /// The digest of the operations and their results.
    digest: u64,
}

/// A whole scene on the simulated device: everything that its result depends on, and the result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneToken {
    /// The method's name.
    pub method: String,
    /// The scene, as it is named on the command line.
    pub scene: String,
    /// The picture's size.
    pub size: [u32; 2],
    /// `-k`.
    pub k: Option<u32>,
    /// `--schedule`.
    pub schedule: String,
    /// `--seed`.
    pub seed: u64,
    /// `--resident`.
    pub resident: u64,
    /// What identifies the result: `fragments_hash`, or `image_hash` of a method without lists.
    pub fragments_hash: String,
}

impl LitmusToken {
    /// Stands for the property in a token that is there for its outcome, which may be right.
    pub const OUTCOME: &str = "outcome";

    /// A token of a schedule and its run. `cycle` repeats forever after it.
    #[must_use]
    pub fn new(
        method: &str,
        property: &str,
        litmus: &Litmus,
        conditions: Conditions,
        [stem, cycle]: [&[Move]; 2],
        run: &Run,
    ) -> Self {
        let memory = match conditions.memory {
            MemoryModel::Sequential => 0,
            MemoryModel::Relaxed(Profile::Vulkan) => 1,
            MemoryModel::Relaxed(Profile::Glsl) => 2,
            MemoryModel::Relaxed(Profile::Wgsl) => 3,
        };
        Self {
            method: method.to_owned(),
            property: property.to_owned(),
            litmus: litmus.clone(),
            memory,
            warp: conditions.warp,
            runs: pack(stem),
            cycle: pack(cycle),
            digest: digest(&run.events),
        }
    }

    /// The conditions of the run.
    #[must_use]
    pub fn conditions(&self) -> Conditions {
        let memory = match self.memory {
            0 => MemoryModel::Sequential,
            n => MemoryModel::Relaxed(Profile::ALL[usize::from(n - 1) % Profile::ALL.len()]),
        };
        Conditions { memory, warp: self.warp }
    }

    /// The moves, those of a cycle once.
    #[must_use]
    pub fn schedule(&self) -> Schedule {
        unpack(&self.runs).chain(unpack(&self.cycle)).collect()
    }

    /// The moves that repeat forever.
    #[must_use]
    pub fn cycle(&self) -> usize {
        unpack(&self.cycle).count()
    }

    /// Check that a run is the one that the token was made from.
    ///
    /// # Errors
    /// Its operations or results differ: the method has changed since.
    pub fn verify(&self, run: &Run) -> Result<()> {
        if digest(&run.events) == self.digest {
            return Ok(());
        }
        let problem = format!(
            "leads to other operations of {} than those that it was made from: the method has changed since",
            self.method
        );
        Err(bad(&problem))
    }
}

fn pack(schedule: &[Move]) -> Vec<(u8, u16, u32)> {
    let mut runs: Vec<(u8, u16, u32)> = Vec::new();
    for by in schedule {
        match runs.last_mut() {
            Some((i, a, times)) if (*i, *a) == (by.invocation, by.alternative) => *times += 1,
            _ => runs.push((by.invocation, by.alternative, 1)),
        }
    }
    runs
}

fn unpack(runs: &[(u8, u16, u32)]) -> impl Iterator<Item = Move> + '_ {
    runs.iter().flat_map(|&(invocation, alternative, times)| {
        std::iter::repeat_n(Move { invocation, alternative }, times as usize)
    })
}

/// 8 bytes of the SHA-256 of the operations with their results.
fn digest(events: &[Event]) -> u64 {
    let mut digest = Sha256::new();
    for event in events {
        let what = match &event.operation {
            Some((cell, action)) => {
                format!("{:?}:{}:{} {}", cell.pixel, cell.word, cell.bits, describe(*action))
            }
            None => "merge".to_owned(),
        };
        digest.update(format!("{} {what} = {:x}\n", event.by.invocation, event.result));
    }
    let bytes = digest.finalize();
    u64::from_le_bytes(std::array::from_fn(|i| bytes[i]))
}

impl std::fmt::Display for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut bytes = postcard::to_stdvec(&Wire::from(self)).map_err(|_| std::fmt::Error)?;
        bytes.extend(checksum(&bytes));
        write!(f, "{PREFIX}{}", URL_SAFE_NO_PAD.encode(bytes))
    }
}

impl std::str::FromStr for Token {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        let Some(body) = text.strip_prefix(PREFIX) else {
            let other = text.strip_prefix("fl").and_then(|t| t.split_once('-'));
            return Err(match other {
                Some((version, _)) if version.chars().all(|c| c.is_ascii_digit()) => bad(&format!(
                    "is of version {version} of the format; this fragloom reads version {}",
                    PREFIX.trim_matches(|c: char| !c.is_ascii_digit())
                )),
                _ => bad(&format!("is not a token: a token begins with {PREFIX}")),
            });
        };
        let damaged =
            || bad("is damaged: its checksum does not fit (was it cut when it was copied?)");
        let bytes = URL_SAFE_NO_PAD.decode(body).map_err(|_| damaged())?;
        if bytes.len() <= CHECK {
            return Err(damaged());
        }
        let (payload, check) = bytes.split_at(bytes.len() - CHECK);
        if checksum(payload) != check {
            return Err(damaged());
        }
        let wire: Wire = postcard::from_bytes(payload).map_err(|_| damaged())?;
        let token = Self::from(wire);
        token.check()?;
        Ok(token)
    }
}

impl Token {
    /// The most moves of a token: longer ones are not made here, and would only take memory.
    const MOST_MOVES: u64 = 10_000_000;

    /// The most words of inputs.
    const MOST_WORDS: usize = 4_096;

    /// Check what holds for every well-formed token.
    fn check(&self) -> Result<()> {
        let Self::Litmus(token) = self else { return Ok(()) };
        let Litmus { pixels, fragments, room, helpers, k, table, inputs } = &token.litmus;
        let fits = |t: &TableSettings| t.cells() <= 64 && t.size[0] > 0 && t.size[1] > 0;
        let moves = token.runs.iter().chain(&token.cycle).map(|run| u64::from(run.2)).sum::<u64>();
        let invocations = fragments.len() + *helpers as usize + 2 * *pixels as usize + 1;
        let small = invocations <= MOST_INVOCATIONS && (1..=8).contains(pixels);
        let sane = small
            && token.memory <= 3
            && *helpers as usize <= fragments.len()
            && *room <= 256
            && k.is_none_or(|k| (1..=256).contains(&k))
            && fragments.iter().all(|f| f.0 < *pixels && f.1 != u32::MAX)
            && table.as_ref().is_none_or(|t| fits(t) && (1..=MOST_AGES).contains(&t.ages))
            && token.warp.is_none_or(|w| w > 0)
            && inputs.iter().map(Vec::len).sum::<usize>() <= Self::MOST_WORDS
            && moves <= Self::MOST_MOVES;
        if sane { Ok(()) } else { Err(bad("does not describe a litmus pixel that fragloom makes")) }
    }
}

fn checksum(payload: &[u8]) -> [u8; CHECK] {
    let digest = Sha256::digest(payload);
    std::array::from_fn(|i| digest[i])
}

fn bad(problem: &str) -> Error {
    Error::new("TOKEN", format!("the token {problem}"))
}
