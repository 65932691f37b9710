//! Twin conformance: invocations of litmus pixels one at a time, in every order, on the device and in the simulator;
//! after each, all words must be the same, and so must the invocation's outcome for its fragment. So a verdict about
//! one holds for the other, as far as single invocations are concerned. Where rounds are repeated, resolve is a step too:
//! it prepares the next round.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};
use wgpu::{BufferUsages, ShaderStages};

use super::seen::{Judged, Seen, difference};
use crate::exec::Instance;
use crate::exec::drive::Pipeline;
use crate::exec::interpret::Interpreted;
use crate::explore::Subject;
use crate::explore::program::instances::{Family, instances};
use crate::explore::program::litmus::Litmus;
use crate::fragment::{Data, Fragment};
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::bounds::Bounds;
use crate::gpu::twin::program::{Bound, Dispatch, Group, Program, WRITABLE, group};
use crate::gpu::twin::resolve::Resolve;
use crate::gpu::twin::shape::{FRAGMENT, Shape, constants, words_of};
use crate::gpu::twin::source::Twin;
use crate::memory::Inputs;
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::num::depth::Format;
use crate::num::orders::orders;
use crate::raster::{Batch, Record};
use crate::scheme::contract::Contract;
use crate::scheme::course::{Course, Part};
use crate::scheme::program::PassKind;
use crate::scheme::{Config, HeldKind, Outcomes};

/// Room for a fragment in its buffer: the alignment that devices require of offsets.
const SLOT: u64 = 256;

/// What was compared on a device for one method.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// The first difference, if any.
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

/// One step; nothing else runs during it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Clear,
    Prepare(usize, usize),
    Screen(usize, u32),
    Frame(usize),
    Store(usize),
    /// After so many rounds.
    Resolve(u32),
}

fn steps(contract: &Contract, order: &[usize], pixels: u32, part: Part, rounds: u32) -> Vec<Step> {
    match part {
        Part::Clear => vec![Step::Clear],
        Part::Resolve if contract.program.repeats => vec![Step::Resolve(rounds)],
        Part::Resolve => Vec::new(),
        Part::Pass(number) => match contract.program.passes[number].kind {
            PassKind::Prepare => order.iter().map(|&i| Step::Prepare(number, i)).collect(),
            PassKind::Screen => (0..pixels).map(|pixel| Step::Screen(number, pixel)).collect(),
            PassKind::Frame => vec![Step::Frame(number)],
            PassKind::Store => order.iter().map(|&i| Step::Store(i)).collect(),
        },
    }
}

/// Runs the steps in the simulator.
struct Host<'a> {
    contract: &'static Contract,
    holds: HeldKind,
    instance: &'a dyn Instance,
    inputs: &'a Inputs,
    pixels: u32,
    fragments: &'a [Fragment],
}

impl Host<'_> {
    /// All steps with the fragments in this order, and what is seen after each.
    fn run(&self, order: &[usize]) -> Vec<(Step, Seen)> {
        let (layout, pixels) = (self.instance.layout(), self.pixels);
        let interpreted = Interpreted { instance: self.instance, inputs: self.inputs };
        let scheme: &dyn for<'m> Pipeline<Exclusive<'m, ()>> = match self.instance.compiled() {
            Some(compiled) => compiled.exclusive(),
            None => &interpreted,
        };
        let own = Owned::new(layout.per_pixel(), pixels as usize);
        let shared = Shared::new(layout.per_frame(), 1);
        let mem = Exclusive::new(&own, &shared, self.inputs, &());
        let (mut seen, mut rounds) = (Vec::new(), 0);
        let mut step = |step: Step| {
            let (mut outcome, mut again) = (None, false);
            match step {
                Step::Clear => {
                    scheme.clear_frame(&mem);
                    scheme.clear(&mem, 0..pixels);
                }
                Step::Prepare(pass, i) => {
                    scheme.prepare(&mem, pass, &Batch::one(self.fragments[i]));
                }
                Step::Screen(pass, pixel) => scheme.screen(&mem, pass, pixel..pixel + 1),
                Step::Frame(pass) => scheme.frame(&mem, pass, 0..scheme.invocations(pass)),
                Step::Store(i) => {
                    let mut outcomes = Outcomes::default();
                    scheme.store(&mem, &Batch::one(self.fragments[i]), &mut outcomes);
                    outcome = Some(outcomes.first());
                }
                Step::Resolve(_) => {
                    let resolve = |pixel| scheme.resolve(&mem, pixel, &mut self.holds.empty());
                    again = (0..pixels).fold(false, |again, pixel| resolve(pixel) | again);
                }
            }
            let ((p32, p64), (f32, f64)) = (own.all(), shared.all());
            let words = [bytes(&p32), bytes(&p64), bytes(&f32), bytes(&f64)];
            seen.push((step, Seen { words, outcome }));
            again
        };
        let course = Course::of(&self.contract.program);
        let walked = course.walk(|parts| {
            let all = parts.iter().flat_map(|&p| steps(self.contract, order, pixels, p, rounds));
            let again = all.fold(false, |again, one| step(one) | again);
            rounds += u32::from(parts.contains(&Part::Resolve));
            Ok::<bool, Infallible>(again)
        });
        let Ok(_) = walked;
        seen
    }
}

fn bytes<T: bytemuck::NoUninit>(words: &[T]) -> Vec<u8> {
    bytemuck::cast_slice(words).to_vec()
}

/// Compare a twin with its method.
///
/// # Errors
/// The device is lost. The result says what it cannot do.
pub fn conform(device: &Device, twin: Twin, extent: Extent) -> Result<Conformance> {
    let subject = Subject::new(twin.method)?;
    let mut sum = Conformance {
        adapter: device.name.name.clone(),
        driver: device.name.driver.clone(),
        method: twin.name(),
        ..Conformance::default()
    };
    for (group, litmus) in programs(&subject, extent) {
        let mut shape = Shape::new(twin.method, litmus.config(subject.contract))?;
        shape.inputs = litmus.inputs(&shape.layout);
        // The stored fragments are given, in the method's own format.
        let record = Record { depth: Format::D32, data: Data::Color };
        let constants = constants(&shape, record, [0; 3]);
        match Program::new(device, twin, shape, constants) {
            Ok(program) => {
                let bench = Bench::new(&program)?;
                for litmus in &group {
                    bench.compare(litmus, &mut sum)?;
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

/// Litmus pixels by configuration and inputs, each group with its first one. Of many, an evenly spaced selection.
fn programs(subject: &Subject, extent: Extent) -> Vec<(Vec<Litmus>, Litmus)> {
    let family = Family { fragments: extent.fragments, ks: vec![1, 2, 3], helpers: 0 };
    let mut programs: Vec<(Vec<Litmus>, Litmus)> = Vec::new();
    let key = |litmus: &Litmus| (litmus.config(subject.contract), litmus.inputs.clone());
    let mut keys: Vec<(Config, Vec<Vec<u32>>)> = Vec::new();
    for litmus in instances(subject, &family) {
        let own = key(&litmus);
        match keys.iter().position(|known| *known == own) {
            Some(known) => programs[known].0.push(litmus),
            None => {
                keys.push(own);
                programs.push((vec![litmus.clone()], litmus));
            }
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
    store: Dispatch,
    prepare: Option<Dispatch>,
    clear: Vec<(Dispatch, u64)>,
    /// By pass and pixel.
    screens: Vec<Vec<Dispatch>>,
    frames: Vec<Option<Dispatch>>,
    /// Where rounds are repeated. What pixels hold is not compared, so that their lists need no room.
    resolve: Option<Resolve<'a, 'd>>,
}

/// The most fragments of a litmus pixel.
const MOST: u64 = 8;

impl<'a, 'd> Bench<'a, 'd> {
    fn new(program: &'a Program<'d>) -> Result<Self> {
        let device = program.device;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let fragments = device.buffer("fragments", SLOT * MOST, usage)?;
        let slot = |i: u64| {
            let part = Some((i * SLOT, FRAGMENT));
            let stages = ShaderStages::COMPUTE;
            group(device, &[Bound { binding: 0, buffer: &fragments, part, kind: WRITABLE, stages }])
        };
        let slots: Vec<Group> = (0..MOST).map(slot).collect::<Result<_>>()?;
        let geometry = |entry| program.pass(entry, Some(&slots[0]), &[]);
        let twin = program.twin;
        let pixels = program.shape.config.pixels;
        let mut clear = Vec::new();
        if twin.defines("clear_frame") {
            clear.push((program.pass("clear_frame_pass", None, &[])?, 1));
        }
        clear.push((program.pass("clear_pass", None, &[])?, pixels.into()));
        let mut frames = Vec::new();
        let mut screens = Vec::new();
        for (number, pass) in program.shape.contract.program.passes.iter().enumerate() {
            let mut of_pass = Vec::new();
            for pixel in 0..if pass.kind == PassKind::Screen { pixels } else { 0 } {
                let overrides = [("PASS", number as f64), ("ONLY", pixel.into())];
                of_pass.push(program.pass("screen_pass", None, &overrides)?);
            }
            screens.push(of_pass);
            let frame = pass.kind == PassKind::Frame;
            frames.push(frame.then(|| program.frame_words(number)).transpose()?);
        }
        let room = vec![0; pixels as usize + 1];
        let resolve = twin.defines("again").then(|| Resolve::new(program, &[0; 256], &room));
        Ok(Self {
            program,
            resolve: resolve.transpose()?,
            store: geometry("store_pass")?,
            prepare: twin.defines("prepare").then(|| geometry("prepare_pass")).transpose()?,
            clear,
            screens,
            frames,
            slots,
            fragments,
        })
    }

    fn compare(&self, litmus: &Litmus, sum: &mut Conformance) -> Result<()> {
        let Shape { contract, config, ref inputs, .. } = self.program.shape;
        let fragments: Vec<Fragment> = litmus.fragments(contract).collect();
        let orders: Vec<Vec<usize>> = orders(fragments.len());
        let method = self.program.twin.method;
        let Some(instance) = method.instance(&config) else { return Ok(()) };
        let (instance, pixels, holds) = (&*instance, config.pixels, method.holds());
        let host = Host { contract, holds, instance, inputs, pixels, fragments: &fragments };
        let (runs, right): (Vec<Vec<Step>>, Vec<Vec<Seen>>) =
            orders.iter().map(|order| host.run(order).into_iter().unzip()).unzip();
        let mut slots = vec![0u8; (SLOT * MOST) as usize];
        for (i, fragment) in fragments.iter().enumerate() {
            let at = i * SLOT as usize;
            slots[at..at + FRAGMENT as usize]
                .copy_from_slice(bytemuck::cast_slice(&words_of(fragment)));
        }
        self.program.device.queue.write_buffer(&self.fragments, 0, &slots);
        let found = self.run(&runs)?;
        let judged = Judged {
            bounds: Bounds::of(self.program.twin.method, &config),
            words: instance.layout().per_pixel().words64 as usize,
            fragments: fragments.len() as u64,
        };
        sum.instances += 1;
        sum.orders += orders.len() as u64;
        for (order, (steps, (right, found))) in
            orders.iter().zip(runs.iter().zip(right.iter().zip(&found)))
        {
            for (step, (right, found)) in steps.iter().zip(right.iter().zip(found)) {
                sum.steps += 1;
                sum.words += right.words.iter().map(|words| words.len() as u64 / 4).sum::<u64>();
                if sum.difference.is_some() {
                    continue;
                }
                if let Some(what) = difference(&judged, right, found) {
                    sum.difference = Some(format!(
                        "{}, order {order:?}, after {step:?}: {what}",
                        litmus.describe()
                    ));
                }
            }
        }
        Ok(())
    }

    /// Run all orders on the device, and give all words after every step.
    fn run(&self, runs: &[Vec<Step>]) -> Result<Vec<Vec<Seen>>> {
        let (device, shape) = (self.program.device, &self.program.shape);
        let sizes: [u64; 4] = std::array::from_fn(|binding| shape.bytes(binding as u32));
        let size = sizes.iter().sum::<u64>() + FRAGMENT;
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
                    let (from, to) = (i as u64 * SLOT, at + size - FRAGMENT);
                    encoder.copy_buffer_to_buffer(&self.fragments, from, &all, to, FRAGMENT);
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
            let fragment: Vec<u32> = bytemuck::pod_collect_to_vec(rest);
            let outcome = fragment.last().copied().filter(|_| matches!(step, Step::Store(_)));
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
            Step::Screen(number, pixel) => {
                let pixels = program.shape.config.pixels.into();
                let pass = &self.screens[number][pixel as usize];
                program.dispatch(encoder, pass, None, pixels);
            }
            Step::Frame(number) => {
                if let Some(pass) = &self.frames[number] {
                    let invocations = program.shape.invocations[number];
                    program.dispatch(encoder, pass, None, invocations.into());
                }
            }
            Step::Store(i) => program.dispatch(encoder, &self.store, slot(i), 1),
            Step::Resolve(before) => {
                if let Some(resolve) = &self.resolve {
                    resolve.encode(encoder, before);
                }
            }
        }
    }
}
