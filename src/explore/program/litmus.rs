//! Litmus pixels: one to three pixels, their fragments, k, and the room that the method is configured with; and the
//! stages of tasks that they are to a method. [`super::instances`] enumerates them.

use serde::{Deserialize, Serialize};

use crate::fragment::{Fragment, key};
use crate::memory::{Inputs, Layout};
use crate::raster::Grid;
use crate::scheme::contract::{Extra, Keeps};
use crate::scheme::course::{Course, Part};
use crate::scheme::hash_table::table::TableSettings;
use crate::scheme::program::PassKind;
use crate::scheme::task::Task;
use crate::scheme::{Config, Contract};

/// A fragment of a small program: its pixel, depth and data; and, of a method with slabs, the thickness in depth words
/// (0 is a surface), or the number of its triangle, if the method asks for it.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
)]
pub struct Entry(pub u32, pub u32, pub u32, #[serde(skip)] pub u32);

/// A small program: one store invocation per fragment.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Litmus {
    /// Pixels, 1 to 3 when generated.
    pub pixels: u32,
    /// `-k`, for a method that takes one.
    pub k: Option<u32>,
    /// The scene as the method is configured for it: fragments in total, and at a pixel.
    pub room: u32,
    /// Its fragments, in submission order.
    pub fragments: Vec<Entry>,
    /// How many of the first fragments have a helper invocation next to them.
    pub helpers: u32,
    /// The hash table, for a method that has one.
    pub table: Option<TableSettings>,
    /// The words of the method's inputs, in the order of their declaration, each by pixel, data word or place in the
    /// frame. Missing words have the input's default.
    #[serde(skip)]
    pub inputs: Vec<Vec<u32>>,
}

/// Tasks that run at the same time, between two barriers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// The name of its first pass.
    pub name: &'static str,
    /// One invocation each.
    pub tasks: Vec<Task>,
    /// Which of them are helpers.
    pub helpers: std::ops::Range<usize>,
}

impl Stage {
    /// Whether an invocation is a helper.
    #[must_use]
    pub fn is_helper(&self, invocation: usize) -> bool {
        self.helpers.contains(&invocation)
    }
}

/// Offsets of a table that a line shows, at most.
const SHOWN: usize = 8;

impl Litmus {
    /// One fragment on one pixel: enough to get a method's words.
    #[must_use]
    pub fn of_one(contract: &Contract) -> Self {
        Self {
            pixels: 1,
            k: contract.default_k.map(|_| 1),
            room: 1,
            fragments: vec![Entry::default()],
            helpers: 0,
            table: None,
            inputs: Vec::new(),
        }
    }

    /// The method's configuration.
    #[must_use]
    pub fn config(&self, contract: &Contract) -> Config {
        let bound = |pixel| {
            let count = self.fragments.iter().filter(|f| f.0 == pixel).count() as u64;
            let k = self.k.filter(|_| contract.keeps == Keeps::Nearest);
            k.map_or(count, |k| count.min(u64::from(k)))
        };
        let bounded: u64 = (0..self.pixels).map(bound).sum();
        let room = u64::from(self.room);
        let counts = (0..self.pixels).map(|p| self.fragments.iter().filter(|f| f.0 == p).count());
        let pages: u64 = counts.map(|n| (n as u64).div_ceil(u64::from(contract.page))).sum();
        let short = u64::from((self.room as usize) < self.fragments.len());
        Config {
            k: self.k,
            pixels: self.pixels,
            generated: room,
            max_depth_complexity: self.room,
            bounded: bounded.min(room),
            pages: pages - short,
            grid: Grid { width: self.pixels, height: 1, tile: 16 },
            table: self.table.unwrap_or_default(),
            records: u64::from(self.k.unwrap_or(1)) * u64::from(self.pixels),
            ..Config::default()
        }
    }

    /// The fragments, as the contract's method knows them.
    pub fn fragments(&self, contract: &Contract) -> impl Iterator<Item = Fragment> + '_ {
        let extra = contract.extra;
        let all = self.fragments.iter().enumerate();
        all.map(move |(i, &Entry(pixel, depth, data, third))| {
            let extra = match extra {
                Extra::Nothing => 0,
                Extra::Rank => self.fragments[..i].iter().filter(|f| f.0 == pixel).count() as u32,
                Extra::Near => depth.saturating_sub(third),
                Extra::Primitive => third,
            };
            Fragment { pixel, depth, data, extra }
        })
    }

    /// How many fragments each pixel has.
    #[must_use]
    pub fn counts(&self) -> Vec<u32> {
        let mut counts = vec![0; self.pixels as usize];
        self.fragments.iter().for_each(|f| counts[f.0 as usize] += 1);
        counts
    }

    /// The keys generated at a pixel, sorted.
    #[must_use]
    pub fn generated(&self, pixel: u32) -> Vec<u64> {
        let own = self.fragments.iter().filter(|f| f.0 == pixel);
        let mut keys: Vec<u64> = own.map(|f| key(f.1, f.2)).collect();
        keys.sort_unstable();
        keys
    }

    /// The fragments generated at a pixel, in canonical order, whatever their ranks.
    #[must_use]
    pub fn sorted(&self, contract: &Contract, pixel: u32) -> Vec<Fragment> {
        let unranked =
            |f: Fragment| if contract.has_third_word() { f } else { Fragment { extra: 0, ..f } };
        let own = self.fragments(contract).filter(|f| f.pixel == pixel).map(unranked);
        let mut own: Vec<Fragment> = own.collect();
        own.sort_unstable();
        own
    }

    /// The words of the method's inputs.
    #[must_use]
    pub fn inputs(&self, layout: &Layout) -> Inputs {
        let mut inputs = Inputs::defaults(layout);
        for (input, words) in self.inputs.iter().enumerate().take(layout.inputs().len()) {
            inputs.fill(input, words.clone());
        }
        inputs
    }

    /// The stages of the method's course, with the invocations that run in each at the same time.
    pub(in crate::explore) fn stages(
        &self,
        contract: &Contract,
        course: &Course,
        invocations: impl Fn(usize) -> u32,
    ) -> Vec<Stage> {
        course.stages().iter().map(|parts| self.stage(contract, parts, &invocations)).collect()
    }

    /// Passes first, then the helpers next to their fragments, then clears and resolves that run at the same time.
    fn stage(
        &self,
        contract: &Contract,
        parts: &[Part],
        invocations: &impl Fn(usize) -> u32,
    ) -> Stage {
        let fragments = || self.fragments(contract);
        let (mut tasks, mut helping, mut around) = (Vec::new(), Vec::new(), Vec::new());
        let mut name = None;
        for part in parts {
            let Part::Pass(number) = *part else {
                let pixels = 0..self.pixels;
                match part {
                    Part::Clear => {
                        around.push(Task::ClearFrame);
                        around.extend(pixels.map(Task::Clear));
                    }
                    _ => around.extend(pixels.map(Task::Resolve)),
                }
                continue;
            };
            let (pass, place) = (&contract.program.passes[number], number as u8);
            name = name.or(Some(pass.name));
            let mut of_fragments = |task: &dyn Fn(Fragment) -> Task| {
                tasks.extend(fragments().map(task));
                helping.extend(fragments().take(self.helpers as usize).map(task));
            };
            match pass.kind {
                PassKind::Store => of_fragments(&Task::Store),
                PassKind::Prepare => of_fragments(&|fragment| Task::Prepare(place, fragment)),
                PassKind::Screen => tasks.extend((0..self.pixels).map(|p| Task::Screen(place, p))),
                PassKind::Frame => {
                    tasks.extend((0..invocations(number)).map(|i| Task::Frame(place, i)));
                }
            }
        }
        let begin = tasks.len();
        tasks.append(&mut helping);
        let helpers = begin..tasks.len();
        tasks.append(&mut around);
        let alone = if parts == [Part::Clear] { "clear" } else { "resolve" };
        Stage { name: name.unwrap_or(alone), tasks, helpers }
    }

    /// Values for words that were never written: the ends of the range, and a value that could be mistaken for a
    /// fragment. A method that never reads such a word is explored only once, so these stand for arbitrary memory; one
    /// that does is explored with each of them, at each such word.
    pub(in crate::explore) fn candidates(&self) -> [u64; 3] {
        let middle = self.fragments.get(self.fragments.len() / 2);
        [0, middle.map_or(1, |f| key(f.1, f.2)), u64::MAX]
    }

    /// How many operations an invocation may have. Beyond, a loop is taken for endless: a search gives up, and says so.
    /// The correct methods need a tenth of that. It grows with the square of the fragments, as sorting in
    /// memory does.
    #[must_use]
    pub fn most_operations(&self) -> usize {
        let (n, k) = (self.fragments.len(), self.k.unwrap_or(0).min(1_024) as usize);
        512 + 16 * (n * n + k + self.room as usize)
    }

    /// One line: n, k, room if it is short, and the fragments.
    #[must_use]
    pub fn describe(&self) -> String {
        use std::fmt::Write;
        let mut text = format!("n={}", self.fragments.len());
        if let Some(k) = self.k {
            let _ = write!(text, " k={k}");
        }
        if (self.room as usize) < self.fragments.len() {
            let _ = write!(text, " room={}", self.room);
        }
        if self.pixels > 1 {
            let _ = write!(text, " pixels={}", self.pixels);
        }
        if let Some(table) = &self.table {
            let [width, height] = table.size;
            let _ = write!(text, " table={width}x{height} ages={} offsets=", table.ages);
            let offsets = table.offsets();
            let cells = offsets.iter().take(SHOWN).map(|[x, y]| format!("{x},{y}"));
            let _ = write!(text, "{}", cells.collect::<Vec<_>>().join(" "));
            if offsets.len() > SHOWN {
                let _ = write!(text, " ... seed={:x}", table.seed);
            }
        }
        if self.helpers > 0 {
            let _ = write!(text, " helpers={}", self.helpers);
        }
        for (input, words) in self.inputs.iter().enumerate() {
            let words: Vec<String> = words.iter().map(|word| format!("{word:x}")).collect();
            let _ = write!(text, " input{input}={}", words.join(","));
        }
        for &Entry(pixel, depth, data, thickness) in &self.fragments {
            let place = if self.pixels > 1 { format!("p{pixel}:") } else { String::new() };
            let _ = write!(text, " {place}{depth:x}/{data:x}");
            if thickness > 0 {
                let _ = write!(text, " thick {thickness:x}");
            }
        }
        text
    }
}
