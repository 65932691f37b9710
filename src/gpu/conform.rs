//! Twin conformance: invocations of litmus pixels one at a time, in every order, on the device and in the simulator; after
//! each, all words are the same, and so is what the invocation said of its fragment. So a verdict about the one speaks
//! for the other, as far as single invocations go.

use serde::Serialize;
use wgpu::{BufferUsages, ShaderStages};

use super::device::Device;
use super::failure::{Failure, Result};
use super::program::{Bound, Group, Pass, Program, Shape, WRITABLE, constants, group, words_of};
use super::source::Twin;
use crate::exec::drive::{Outcomes, Pipeline};
use crate::explore::litmus::{Family, Litmus, instances};
use crate::fragment::{Data, Fragment};
use crate::memory::Layout;
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::num::depth::Format;
use crate::raster::Record;
use crate::scheme::catalogue::{self, Visitor};
use crate::scheme::contract::{Contract, Kind};
use crate::scheme::{Config, Outcome, Scheme};

/// Room of a fragment in its buffer: what devices want offsets to be multiples of.
const SLOT: u64 = 256;

/// What was compared on a device, of one method.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Conformance {
    /// The adapter.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// The method.
    pub method: String,
    /// Litmus pixels.
    pub instances: u64,
    /// Orders of their fragments.
    pub orders: u64,
    /// Steps after which all words were compared.
    pub steps: u64,
    /// Words compared.
    pub words: u64,
    /// What differs first, if anything does.
    pub difference: Option<String>,
    /// Why nothing could be compared.
    pub unsupported: Option<String>,
}

/// How much to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Fragments, from 1 up to this.
    pub fragments: u32,
    /// Different configurations: each is a program to compile.
    pub programs: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Self { fragments: 3, programs: 24 }
    }
}

/// One step: what runs, and nothing else does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Clear,
    Prepare(usize, usize),
    Screen(usize, u32),
    Frame(usize),
    Store(usize),
}

fn steps(contract: &Contract, order: &[usize], pixels: u32) -> Vec<Step> {
    let mut steps = vec![Step::Clear];
    for (number, pass) in contract.program.passes.iter().enumerate() {
        match pass.kind {
            Kind::Prepare => steps.extend(order.iter().map(|&i| Step::Prepare(number, i))),
            Kind::Screen => steps.extend((0..pixels).map(|pixel| Step::Screen(number, pixel))),
            Kind::Frame => steps.push(Step::Frame(number)),
            Kind::Store => steps.extend(order.iter().map(|&i| Step::Store(i))),
        }
    }
    steps
}

/// All words by binding, and what a store invocation said.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Seen {
    words: [Vec<u8>; 4],
    outcome: Option<u32>,
}

/// Runs the steps in the simulator.
struct Host<'a> {
    config: Config,
    fragments: &'a [Fragment],
    orders: &'a [Vec<Step>],
}

impl Visitor for Host<'_> {
    type Output = Vec<Vec<Seen>>;

    fn scheme<S: Scheme + Send + 'static>(self) -> Self::Output {
        let mut layout = Layout::default();
        let scheme = S::new(&self.config, &mut layout);
        self.orders.iter().map(|steps| self.run(&scheme, &layout, steps)).collect()
    }

    fn exact(self) -> Self::Output {
        Vec::new()
    }
}

impl Host<'_> {
    fn run(
        &self,
        scheme: &dyn for<'m> Pipeline<Exclusive<'m, ()>>,
        layout: &Layout,
        steps: &[Step],
    ) -> Vec<Seen> {
        let pixels = self.config.pixels;
        let own = Owned::new(layout.per_pixel(), pixels as usize);
        let shared = Shared::new(layout.per_frame(), 1);
        let mem = Exclusive::new(&own, &shared, None, &());
        let step = |step: &Step| {
            let mut outcome = None;
            match *step {
                Step::Clear => {
                    scheme.clear_frame(&mem);
                    scheme.clear(&mem, 0..pixels);
                }
                Step::Prepare(pass, i) => scheme.prepare(&mem, pass, &self.fragments[i..=i]),
                Step::Screen(pass, pixel) => scheme.screen(&mem, pass, pixel..pixel + 1),
                Step::Frame(pass) => scheme.frame(&mem, pass, 0..scheme.invocations(pass)),
                Step::Store(i) => {
                    let mut outcomes: Outcomes = [Outcome::Kept; 64];
                    scheme.store(&mem, &self.fragments[i..=i], &mut outcomes);
                    outcome = Some(outcomes[0] as u32);
                }
            }
            let ((p32, p64), (f32, f64)) = (own.all(), shared.all());
            let words = [bytes(&p32), bytes(&p64), bytes(&f32), bytes(&f64)];
            Seen { words, outcome }
        };
        steps.iter().map(step).collect()
    }
}

fn bytes<T: bytemuck::NoUninit>(words: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(words).to_vec()
}

/// Compare a twin with its method.
///
/// # Errors
/// The device is lost. What it cannot do is said in the result.
pub fn conform(device: &Device, twin: &'static Twin, extent: Extent) -> Result<Conformance> {
    let contract = catalogue::contract(twin.method)?;
    let mut sum = Conformance {
        adapter: device.name.name.clone(),
        driver: device.name.driver.clone(),
        method: twin.method.to_owned(),
        ..Conformance::default()
    };
    for (config, group) in programs(contract, extent) {
        let shape = Shape::new(twin.method, config)?;
        // What is stored is given, in the method's own format.
        let record = Record { depth: Format::D32, data: Data::Color };
        let constants = constants(&shape, record, [0; 3]);
        match Program::new(device, twin, shape, constants) {
            Ok(program) => {
                let bench = Bench::new(&program)?;
                for litmus in &group {
                    bench.compare(contract, litmus, &mut sum)?;
                }
            }
            Err(Failure::Unsupported(why)) => {
                sum.unsupported = Some(why);
                break;
            }
            Err(failure) => return Err(failure),
        }
    }
    Ok(sum)
}

/// Litmus pixels by configuration; of many, some, evenly chosen.
fn programs(contract: &Contract, extent: Extent) -> Vec<(Config, Vec<Litmus>)> {
    let family = Family { fragments: extent.fragments, ks: vec![1, 2, 3], helpers: 0 };
    let mut programs: Vec<(Config, Vec<Litmus>)> = Vec::new();
    for litmus in instances(contract, &family) {
        let config = litmus.config(contract);
        match programs.iter_mut().find(|(known, _)| *known == config) {
            Some((_, group)) => group.push(litmus),
            None => programs.push((config, vec![litmus])),
        }
    }
    let step = programs.len().div_ceil(extent.programs).max(1);
    programs.into_iter().step_by(step).collect()
}

/// A program, with a slot for every fragment and its passes compiled.
struct Bench<'a, 'd> {
    program: &'a Program<'d>,
    fragments: wgpu::Buffer,
    slots: Vec<Group>,
    store: Pass,
    prepare: Option<Pass>,
    clear: Vec<(Pass, u64)>,
    screens: Vec<Pass>,
    frames: Vec<Option<Pass>>,
}

/// The most fragments of a litmus pixel.
const MOST: u64 = 8;

impl<'a, 'd> Bench<'a, 'd> {
    fn new(program: &'a Program<'d>) -> Result<Self> {
        let device = program.device;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let fragments = device.buffer("fragments", SLOT * MOST, usage)?;
        let slot = |i: u64| {
            let part = Some((i * SLOT, 16));
            let stages = ShaderStages::COMPUTE;
            group(device, &[Bound { binding: 0, buffer: &fragments, part, kind: WRITABLE, stages }])
        };
        let slots: Vec<Group> = (0..MOST).map(slot).collect::<Result<_>>()?;
        let geometry = |entry| program.pass(entry, Some(&slots[0].layout), &[]);
        let twin = program.twin;
        let pixels = program.shape.config.pixels;
        let mut clear = Vec::new();
        if twin.defines("clear_frame") {
            clear.push((program.pass("clear_frame_pass", None, &[])?, 1));
        }
        clear.push((program.pass("clear_pass", None, &[])?, pixels.into()));
        let mut screens = Vec::new();
        if twin.defines("screen") {
            for pixel in 0..pixels {
                screens.push(program.pass("screen_pass", None, &[("ONLY", pixel.into())])?);
            }
        }
        let mut frames = Vec::new();
        for (number, pass) in program.shape.contract.program.passes.iter().enumerate() {
            let frame = pass.kind == Kind::Frame;
            frames.push(frame.then(|| program.frame_words(number)).transpose()?);
        }
        Ok(Self {
            program,
            store: geometry("store_pass")?,
            prepare: twin.defines("prepare").then(|| geometry("prepare_pass")).transpose()?,
            clear,
            screens,
            frames,
            slots,
            fragments,
        })
    }

    fn compare(&self, contract: &Contract, litmus: &Litmus, sum: &mut Conformance) -> Result<()> {
        let fragments: Vec<Fragment> = litmus.fragments().collect();
        let orders: Vec<Vec<usize>> = permutations(fragments.len());
        let runs: Vec<Vec<Step>> =
            orders.iter().map(|order| steps(contract, order, litmus.pixels)).collect();
        let config = self.program.shape.config;
        let host = Host { config, fragments: &fragments, orders: &runs };
        let right = catalogue::visit(contract.name, host)?;
        let mut slots = vec![0u8; (SLOT * MOST) as usize];
        for (i, fragment) in fragments.iter().enumerate() {
            let at = i * SLOT as usize;
            slots[at..at + 16].copy_from_slice(bytemuck::cast_slice(&words_of(fragment)));
        }
        self.program.device.queue.write_buffer(&self.fragments, 0, &slots);
        let found = self.run(&runs)?;
        sum.instances += 1;
        sum.orders += orders.len() as u64;
        for (order, (steps, (right, found))) in
            orders.iter().zip(runs.iter().zip(right.iter().zip(&found)))
        {
            for (step, (right, found)) in steps.iter().zip(right.iter().zip(found)) {
                sum.steps += 1;
                sum.words += right.words.iter().map(|words| words.len() as u64 / 4).sum::<u64>();
                if right != found && sum.difference.is_none() {
                    let what = difference(right, found);
                    sum.difference = Some(format!(
                        "{}, order {order:?}, after {step:?}: {what}",
                        litmus.describe()
                    ));
                }
            }
        }
        Ok(())
    }

    /// Run all orders on the device; all words after every step.
    fn run(&self, runs: &[Vec<Step>]) -> Result<Vec<Vec<Seen>>> {
        let (device, shape) = (self.program.device, &self.program.shape);
        let sizes: [u64; 4] = std::array::from_fn(|binding| shape.bytes(binding as u32));
        let size = sizes.iter().sum::<u64>() + 16;
        let count: usize = runs.iter().map(Vec::len).sum();
        let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let all = device.buffer("snapshots", size * count as u64, usage)?;
        let mut encoder = device.encoder();
        let mut at = 0;
        for steps in runs {
            for (_, buffer) in &self.program.words {
                encoder.clear_buffer(buffer, 0, None);
            }
            for &step in steps {
                self.step(&mut encoder, step);
                for (binding, buffer) in &self.program.words {
                    let bytes = sizes[*binding as usize];
                    let offset = at + sizes[..*binding as usize].iter().sum::<u64>();
                    if bytes > 0 {
                        encoder.copy_buffer_to_buffer(buffer, 0, &all, offset, bytes);
                    }
                }
                if let Step::Store(i) = step {
                    let (from, to) = (i as u64 * SLOT, at + size - 16);
                    encoder.copy_buffer_to_buffer(&self.fragments, from, &all, to, 16);
                }
                at += size;
            }
        }
        device.submit(encoder)?;
        let bytes = device.read(&all, size * count as u64)?;
        let mut snapshots = bytes.chunks_exact(size as usize);
        let mut seen = |step: &Step| {
            let snapshot = snapshots.next().unwrap_or_default();
            let mut rest = snapshot;
            let words = sizes.map(|size| {
                let (words, behind) = rest.split_at(size as usize);
                rest = behind;
                words.to_vec()
            });
            let outcome = u32::from_le_bytes([rest[12], rest[13], rest[14], rest[15]]);
            let outcome = matches!(step, Step::Store(_)).then_some(outcome);
            Seen { words, outcome }
        };
        Ok(runs.iter().map(|steps| steps.iter().map(&mut seen).collect()).collect())
    }

    fn step(&self, encoder: &mut wgpu::CommandEncoder, step: Step) {
        let program = self.program;
        let slot = |i: usize| Some(&self.slots[i].group);
        match step {
            Step::Clear => {
                for (pass, invocations) in &self.clear {
                    program.dispatch(encoder, pass, None, *invocations);
                }
            }
            Step::Prepare(_, i) => {
                if let Some(pass) = &self.prepare {
                    program.dispatch(encoder, pass, slot(i), 1);
                }
            }
            Step::Screen(_, pixel) => {
                let pixels = program.shape.config.pixels.into();
                program.dispatch(encoder, &self.screens[pixel as usize], None, pixels);
            }
            Step::Frame(number) => {
                if let Some(pass) = &self.frames[number] {
                    let invocations = program.shape.invocations[number];
                    program.dispatch(encoder, pass, None, invocations.into());
                }
            }
            Step::Store(i) => program.dispatch(encoder, &self.store, slot(i), 1),
        }
    }
}

fn difference(right: &Seen, found: &Seen) -> String {
    const NAMES: [&str; 4] = ["pixels'", "pixels' 64-bit", "the frame's", "the frame's 64-bit"];
    for (name, (right, found)) in NAMES.iter().zip(right.words.iter().zip(&found.words)) {
        let words = |bytes: &[u8]| -> Vec<u32> { bytemuck::pod_collect_to_vec(bytes) };
        let (right, found) = (words(right), words(found));
        if let Some(at) = (0..right.len()).find(|&i| found.get(i) != right.get(i)) {
            let found = found.get(at).copied().unwrap_or_default();
            return format!("{name} words, [{at}] is {found:x} instead of {:x}", right[at]);
        }
    }
    format!("the outcome is {:?} instead of {:?}", found.outcome, right.outcome)
}

/// All orders of so many things.
fn permutations(n: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for i in 0..n {
        let longer = |order: &Vec<usize>| {
            let order = order.clone();
            (0..=order.len()).map(move |place| {
                let mut order = order.clone();
                order.insert(place, i);
                order
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutations_are_all_different() {
        let all: std::collections::BTreeSet<_> = permutations(4).into_iter().collect();
        assert_eq!(all.len(), 24);
    }
}
