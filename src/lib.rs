//! fragloom: a bit-exact CPU rasterizer that runs multi-fragment shaders as real concurrent programs.
//!
//! Load a scene, draw it with a scheme of your own, check the scheme under every interleaving, and replay what is wrong:
//!
//! ```
//! use fragloom::catalogue::Catalogue;
//! use fragloom::exec::Method;
//! use fragloom::explore::{Limits, Plan, Subject, Token, check, replay};
//! use fragloom::fragment::Fragment;
//! use fragloom::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
//! use fragloom::render::{Options, render};
//! use fragloom::scene::{self, Overrides};
//! use fragloom::scheme::{Config, Contract, Keeps, Keys, Outcome, Scheme};
//!
//! /// Keeps the nearest fragment; but between its load and its store, another invocation may store.
//! struct Nearest {
//!     entry: Words<Pixel, Atomic, u64>,
//! }
//!
//! impl Scheme for Nearest {
//!     const CONTRACT: Contract = Contract::new("nearest", Keeps::One);
//!     type Holds = Keys;
//!
//!     fn new(_: &Config, layout: &mut Layout) -> Self {
//!         Self { entry: layout.pixel(1) }
//!     }
//!
//!     async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
//!         mem.store(self.entry.at(pixel, 0), u64::MAX, Order::Relaxed).await;
//!     }
//!
//!     async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
//!         let entry = self.entry.at(fragment.pixel, 0);
//!         let old = mem.load(entry, Order::Relaxed).await;
//!         if fragment.key() >= old {
//!             return Outcome::Culled;
//!         }
//!         mem.store(entry, fragment.key(), Order::Relaxed).await;
//!         if old == u64::MAX { Outcome::Kept } else { Outcome::Evicted }
//!     }
//!
//!     async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
//!         let entry = mem.load(self.entry.at(pixel, 0), Order::Relaxed).await;
//!         keys.extend((entry != u64::MAX).then_some(entry));
//!     }
//! }
//!
//! // Draw, with its fragments accounted for.
//! let overrides = Overrides { size: Some([64, 48]), ..Overrides::default() };
//! let scene = scene::load("cubes", &overrides)?;
//! let nearest = Method::of::<Nearest>();
//! let drawn = render(&scene, &Options { method: nearest, ..Options::default() })?;
//! assert_eq!(drawn.report.kept, drawn.lists()?.entries.len() as u64);
//!
//! // Check: two invocations are enough to lose a fragment.
//! let limits = Limits { states: 100_000, cancelled: &|| false };
//! let plan = Plan { fragments: Some(2), ..Plan::default() };
//! let rows = check(&Subject::new(nearest)?, &plan, &limits);
//! let token = rows.iter().find_map(|row| row.token.as_ref()).expect("an interleaving that loses one");
//!
//! // Replay: the same operations with the same results, anywhere.
//! let Token::Litmus(token) = token.parse()? else { unreachable!("litmus pixels were checked") };
//! let catalogue = Catalogue::built_in().with(nearest)?;
//! let replayed = replay::replay(&catalogue, &token)?;
//! assert!(replayed.run.violations().next().is_some());
//! # Ok::<(), fragloom::error::Error>(())
//! ```
//!
//! `fragloom::cli::main(&catalogue)` is the whole command line with that method in it (`examples/user_scheme.rs`).
//!
//! Data flows one way through the modules, in this order, and a module uses only those before it (`tests/layering.rs`
//! checks that):
//!
//! `error` → `num` → `image` → `scene` → `fragment` → `raster` → `memory` → `scheme` → `resolve` → `exec` →
//! `catalogue` → `effect` → `render` → `inspect` → `explore` → `gpu` → `report` →
//! `golden` → `judge` → `reproduce` → `cli`

pub mod catalogue;
pub mod cli;
pub mod effect;
pub mod error;
pub mod exec;
pub mod explore;
pub mod fragment;
pub mod golden;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
pub mod inspect;
pub mod judge;
pub mod memory;
pub mod num;
pub mod raster;
pub mod render;
pub mod report;
pub mod reproduce;
pub mod resolve;
pub mod scene;
pub mod scheme;
