//! A method as everything above schemes sees it: a value with its contract, which makes type-erased instances.
//!
//! There are two forms. [`Method::of`] compiles a scheme for every executor, which is what makes it fast. A scheme of
//! [`Method::interpreted`] is compiled once, for the memory that asks ([`Asked`]), which the explorer needs anyway;
//! executors then answer its questions, operation by operation, with the same results ([`super::interpret`]). Built-in
//! faults have that form: their speed does not matter.

use std::marker::PhantomData;

use super::drive::Pipeline;
use super::sim::turns::Stepped;
use crate::fragment::Fragment;
use crate::memory::asked::Asked;
use crate::memory::exclusive::Exclusive;
use crate::memory::native::Native;
use crate::memory::{Counters, Inputs, Layout, Snapshot};
use crate::scheme::task::{Invocation, Task, invoke};
use crate::scheme::{Config, Contract, Held, HeldKind, Holds, Moment, Readback, Scheme, exact};

/// Makes a scheme and its words for a configuration.
type Make = fn(&Config) -> Box<dyn Instance>;

/// A method, as a value. Two are the same if they have the same name.
#[derive(Clone, Copy)]
pub struct Method {
    contract: &'static Contract,
    holds: HeldKind,
    make: Option<Make>,
}

/// A scheme with its configuration and its words.
pub trait Instance: Send + Sync {
    /// Its words.
    fn layout(&self) -> &Layout;

    /// Invocations of a pass over the frame's words.
    fn invocations(&self, pass: usize) -> u32;

    /// See [`Scheme::invariant`].
    ///
    /// # Errors
    /// What is wrong, in words that name the fault.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String>;

    /// See [`Scheme::owner`].
    fn owner(&self, bits: u32, word: u64, value: u64) -> Option<u32>;

    /// See [`Scheme::readback`].
    fn readback(&self) -> Option<Readback>;

    /// See [`Scheme::expected`].
    fn expected(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Held>;

    /// See [`Scheme::possible`].
    fn possible(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Vec<Held>;

    /// See [`Scheme::chosen`].
    fn chosen(&self, inputs: &Inputs, counts: &[u32]) -> Vec<u32>;

    /// An invocation on memory that asks.
    fn ask<'a>(&'a self, mem: &'a Asked<'_>, task: Task) -> Invocation<'a>;

    /// The code compiled for executors, if there is any.
    fn compiled(&self) -> Option<&dyn Compiled>;
}

/// A scheme, compiled for every executor.
pub trait Compiled: Sync {
    /// For tiles.
    fn exclusive(&self) -> &dyn for<'a> Pipeline<Exclusive<'a, ()>>;

    /// For tiles, with operations counted.
    fn exclusive_counted(&self) -> &dyn for<'a> Pipeline<Exclusive<'a, Counters>>;

    /// For threads.
    fn native(&self) -> &dyn for<'a> Pipeline<Native<'a, ()>>;

    /// For threads, with operations counted.
    fn native_counted(&self) -> &dyn for<'a> Pipeline<Native<'a, Counters>>;

    /// For the simulated device.
    fn stepped(&self) -> &dyn Stepped;
}

impl<S: Scheme> Compiled for S {
    fn exclusive(&self) -> &dyn for<'a> Pipeline<Exclusive<'a, ()>> {
        self
    }

    fn exclusive_counted(&self) -> &dyn for<'a> Pipeline<Exclusive<'a, Counters>> {
        self
    }

    fn native(&self) -> &dyn for<'a> Pipeline<Native<'a, ()>> {
        self
    }

    fn native_counted(&self) -> &dyn for<'a> Pipeline<Native<'a, Counters>> {
        self
    }

    fn stepped(&self) -> &dyn Stepped {
        self
    }
}

impl Method {
    /// The oracle, which has no invocations.
    pub const EXACT: Self =
        Self { contract: &exact::CONTRACT, holds: HeldKind::Fragments, make: None };

    /// A scheme, compiled for every executor.
    #[must_use]
    pub const fn of<S: Scheme>() -> Self {
        // The library's own tests use the explorer heavily and do not depend on the executors' speed.
        if cfg!(test) { Self::interpreted::<S>() } else { Self::made::<S, ForExecutors>() }
    }

    /// A scheme, compiled once: slower on every executor, with the same results.
    #[must_use]
    pub const fn interpreted<S: Scheme>() -> Self {
        Self::made::<S, Once>()
    }

    const fn made<S: Scheme, F: Form>() -> Self {
        let make = |config: &Config| -> Box<dyn Instance> {
            let mut layout = Layout::default();
            let scheme = S::new(config, &mut layout);
            Box::new(Made::<S, F> { scheme, layout, form: PhantomData })
        };
        Self { contract: &S::CONTRACT, holds: <S::Holds as Holds>::KIND, make: Some(make) }
    }

    /// What it promises.
    #[must_use]
    pub const fn contract(&self) -> &'static Contract {
        self.contract
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.contract.name
    }

    /// What a pixel holds after resolve.
    #[must_use]
    pub const fn holds(&self) -> HeldKind {
        self.holds
    }

    /// Whether it is the oracle.
    #[must_use]
    pub const fn is_exact(&self) -> bool {
        self.make.is_none()
    }

    /// The method with a configuration; `None` if it is the oracle, which has no words and no invocations.
    #[must_use]
    pub fn instance(&self, config: &Config) -> Option<Box<dyn Instance>> {
        self.make.map(|make| make(config))
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Method {}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The forms in which a scheme is compiled.
trait Form: 'static {
    fn compiled<S: Scheme>(scheme: &S) -> Option<&dyn Compiled>;
}

/// Compiled for every executor.
enum ForExecutors {}

/// Compiled for the memory that asks, and for nothing else.
enum Once {}

impl Form for ForExecutors {
    fn compiled<S: Scheme>(scheme: &S) -> Option<&dyn Compiled> {
        Some(scheme)
    }
}

impl Form for Once {
    fn compiled<S: Scheme>(_: &S) -> Option<&dyn Compiled> {
        None
    }
}

struct Made<S, F> {
    scheme: S,
    layout: Layout,
    form: PhantomData<fn() -> F>,
}

impl<S: Scheme, F: Form> Instance for Made<S, F> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.scheme.invocations(pass)
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.scheme.invariant(words, pixel, moment)
    }

    fn owner(&self, bits: u32, word: u64, value: u64) -> Option<u32> {
        self.scheme.owner(bits, word, value)
    }

    fn readback(&self) -> Option<Readback> {
        self.scheme.readback()
    }

    fn expected(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Held> {
        self.scheme.expected(inputs, pixel, generated).map(Holds::into_held)
    }

    fn possible(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Vec<Held> {
        let all = self.scheme.possible(inputs, pixel, generated).into_iter();
        all.map(Holds::into_held).collect()
    }

    fn chosen(&self, inputs: &Inputs, counts: &[u32]) -> Vec<u32> {
        self.scheme.chosen(inputs, counts)
    }

    fn ask<'a>(&'a self, mem: &'a Asked<'_>, task: Task) -> Invocation<'a> {
        Box::pin(invoke(&self.scheme, mem, task))
    }

    fn compiled(&self) -> Option<&dyn Compiled> {
        F::compiled(&self.scheme)
    }
}
