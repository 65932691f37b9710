//! A method's passes on a device, with its words in buffers whose layout is the simulator's.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use wgpu::{BindGroupEntry, BindGroupLayoutEntry, BufferUsages, ShaderStages};

use super::bounds;
use super::code::Code;
use super::light;
use super::shape::{FRAGMENT, SPARE, Shape, Words, words_of};
use super::source::{Constants, Path, Twin};
use crate::fragment::Fragment;
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::spirv::write::Entry;
use crate::scheme::contract::Keeps;
use crate::scheme::course::{Course, Part};
use crate::scheme::merging::sums::logarithms;
use crate::scheme::program::PassKind;

/// Threads of a workgroup; and workgroups in a row of a dispatch (`shared/index.wgsl`).
const WORKGROUP: u64 = 64;
const ROW: u64 = 32_768;

/// Fragments of one submission on the compute path; and where invocations wait for each other: so few that all of them
/// may give up before a watchdog ends the submission, and the device with it.
const CHUNK: usize = 1 << 20;
const WAITING_CHUNK: usize = 1 << 16;

/// How often an invocation that gives up waiting is run.
const PATIENCE: u32 = 1_000;

/// The outcome of an invocation that gave up (`shared/fragment.wgsl`).
const STUCK: u32 = 7;

/// The binding of the first group that has the words of all inputs, one after another.
const INPUTS: u32 = 5;

/// A group of bindings, whose layout is known.
#[derive(Debug)]
pub struct Group {
    pub(in crate::gpu) layout: wgpu::BindGroupLayout,
    pub(in crate::gpu) group: wgpu::BindGroup,
    /// The numbers of its bindings, ascending.
    pub(super) bindings: Vec<u32>,
}

/// A buffer, or a part of one, as a shader sees it.
#[derive(Clone, Copy, Debug)]
pub struct Bound<'a> {
    /// The binding's number.
    pub binding: u32,
    /// The buffer.
    pub buffer: &'a wgpu::Buffer,
    /// Its part: offset and size in bytes.
    pub part: Option<(u64, u64)>,
    /// The kind of access.
    pub kind: wgpu::BufferBindingType,
    /// The shader stages that see it.
    pub stages: ShaderStages,
}

impl<'a> Bound<'a> {
    fn entry(&self) -> BindGroupEntry<'a> {
        let (offset, size) = self.part.map_or((0, None), |(offset, size)| (offset, Some(size)));
        let size = size.and_then(std::num::NonZeroU64::new);
        let buffer = wgpu::BufferBinding { buffer: self.buffer, offset, size };
        BindGroupEntry { binding: self.binding, resource: wgpu::BindingResource::Buffer(buffer) }
    }
}

/// A storage buffer that can be written.
pub const WRITABLE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

/// A storage buffer that cannot be written.
pub const READABLE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };

/// Make a group.
///
/// # Errors
/// The device refuses it.
pub fn group(device: &Device, bound: &[Bound<'_>]) -> Result<Group> {
    let storage = bound.iter().filter(|b| b.kind != wgpu::BufferBindingType::Uniform).count();
    let most = device.limits.max_storage_buffers_per_shader_stage;
    if storage > most as usize {
        let problem = format!("needs {storage} storage buffers in a shader, at most {most}");
        return Err(Failure::Unsupported(problem));
    }
    let entry = |b: &Bound<'_>| BindGroupLayoutEntry {
        binding: b.binding,
        visibility: b.stages,
        ty: wgpu::BindingType::Buffer {
            ty: b.kind,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = bound.iter().map(entry).collect();
    let layout = device.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    });
    let entries: Vec<_> = bound.iter().map(Bound::entry).collect();
    let group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    let mut bindings: Vec<u32> = bound.iter().map(|b| b.binding).collect();
    bindings.sort_unstable();
    device.check().map(|()| Group { layout, group, bindings })
}

/// Commands that run beside a pass and share no buffer with it, so that nothing waits for them.
pub trait Beside: std::fmt::Debug {
    /// Put them before the pass.
    fn record(&self, encoder: &mut wgpu::CommandEncoder);
}

/// A twin, configured, with its buffers.
#[derive(Debug)]
pub struct Program<'d> {
    pub(in crate::gpu) device: &'d Device,
    pub(in crate::gpu) twin: Twin,
    pub(in crate::gpu) shape: Shape,
    pub(in crate::gpu) constants: Constants,
    /// By binding of the first group.
    pub(in crate::gpu) words: Vec<(u32, wgpu::Buffer)>,
    _table: Option<wgpu::Buffer>,
    _inputs: Option<wgpu::Buffer>,
    pub(in crate::gpu) words_group: Group,
    code: Code,
    /// Invocations that gave up waiting and were rerun.
    again: Cell<u64>,
    /// What runs beside geometry passes.
    beside: RefCell<Option<Box<dyn Beside>>>,
    /// Invocations of a dispatch of a geometry pass, if not as many as there may be.
    burst: Cell<Option<usize>>,
    /// The compiled passes, by entry point and overrides.
    passes: RefCell<BTreeMap<String, Dispatch>>,
}

/// A pipeline.
#[derive(Clone, Debug)]
pub struct Dispatch {
    pipeline: wgpu::ComputePipeline,
}

impl<'d> Program<'d> {
    /// Compile a twin and make its buffers.
    ///
    /// # Errors
    /// The device lacks something, has no room, or refuses.
    pub fn new(device: &'d Device, twin: Twin, shape: Shape, constants: Constants) -> Result<Self> {
        if twin.needs_atomics64() && !device.atomics64 {
            return Err(Failure::Unsupported("no atomic operations on 64 bits".to_owned()));
        }
        bounds::can(&shape)?;
        shape.fits(device)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let mut words = Vec::new();
        for binding in (0..4).filter(|&binding| twin.binds(binding)) {
            words.push((binding, device.buffer("words", shape.bytes(binding) + SPARE, usage)?));
        }
        let table = twin.binds(4).then(|| table(device, &shape)).transpose()?;
        let inputs = twin.binds(INPUTS).then(|| inputs(device, &shape)).transpose()?;
        let stages = ShaderStages::COMPUTE | ShaderStages::FRAGMENT;
        let bound = |(binding, buffer): &(u32, wgpu::Buffer)| (*binding, buffer.clone());
        let buffers: Vec<_> = words.iter().map(bound).collect();
        let mut bindings: Vec<Bound<'_>> = buffers
            .iter()
            .map(|(binding, buffer)| Bound {
                binding: *binding,
                buffer,
                part: None,
                kind: WRITABLE,
                stages,
            })
            .collect();
        bindings.extend(table.as_ref().map(|buffer| Bound {
            binding: 4,
            buffer,
            part: None,
            kind: wgpu::BufferBindingType::Uniform,
            stages,
        }));
        bindings.extend(inputs.as_ref().map(|buffer| Bound {
            binding: INPUTS,
            buffer,
            part: None,
            kind: READABLE,
            stages,
        }));
        let words_group = group(device, &bindings)?;
        let code = Code::new(device, twin, &twin.module(&constants, Path::Compute)?)?;
        let passes = RefCell::default();
        let again = Cell::default();
        let (beside, burst) = Default::default();
        Ok(Self {
            device,
            twin,
            shape,
            constants,
            words,
            _table: table,
            _inputs: inputs,
            words_group,
            code,
            again,
            beside,
            burst,
            passes,
        })
    }

    /// Invocations so far that gave up waiting, for a lock or for a compare-exchange, and were rerun.
    #[must_use]
    pub fn again(&self) -> u64 {
        self.again.get()
    }

    /// Put geometry passes under pressure: something beside them, and so many invocations in a dispatch, at least 1.
    pub fn press(&self, beside: Option<Box<dyn Beside>>, burst: u32) {
        *self.beside.borrow_mut() = beside;
        self.burst.set(Some(burst.max(1) as usize));
    }

    /// A compute pass: an entry point of the module, and its second group, if it has one. It is compiled once.
    ///
    /// # Errors
    /// The device refuses.
    pub fn pass(
        &self,
        entry: &str,
        second: Option<&Group>,
        overrides: &[(&str, f64)],
    ) -> Result<Dispatch> {
        let name = format!("{entry} {overrides:?}");
        if let Some(pass) = self.passes.borrow().get(&name) {
            return Ok(pass.clone());
        }
        let groups = [Some(&self.words_group), second];
        let layouts = groups.map(|group| group.map(|group| &group.layout));
        let bindings: Vec<&[u32]> =
            groups.iter().flatten().map(|g| g.bindings.as_slice()).collect();
        let module = Entry { name: entry, overrides, bindings: &bindings };
        let module = self.code.module(self.device, &module)?;
        let device = &self.device.device;
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: if second.is_some() { &layouts } else { &layouts[..1] },
            immediate_size: 0,
        });
        let compilation_options = wgpu::PipelineCompilationOptions {
            constants: overrides,
            ..wgpu::PipelineCompilationOptions::default()
        };
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry),
            compilation_options,
            cache: None,
        });
        self.device.check()?;
        let pass = Dispatch { pipeline };
        self.passes.borrow_mut().insert(name, pass.clone());
        Ok(pass)
    }

    /// Run this many invocations of a pass.
    pub fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pass: &Dispatch,
        second: Option<&wgpu::BindGroup>,
        invocations: u64,
    ) {
        let workgroups = invocations.div_ceil(WORKGROUP);
        if workgroups == 0 {
            return;
        }
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        compute.set_pipeline(&pass.pipeline);
        compute.set_bind_group(0, &self.words_group.group, &[]);
        if let Some(second) = second {
            compute.set_bind_group(1, second, &[]);
        }
        let (across, down) = (workgroups.min(ROW), workgroups.div_ceil(ROW));
        compute.dispatch_workgroups(across as u32, down as u32, 1);
    }

    /// Set every byte of every word to this value, before the clear pass.
    pub fn fill(&self, byte: u8) {
        for (_, buffer) in &self.words {
            self.device.queue.write_buffer(buffer, 0, &vec![byte; buffer.size() as usize]);
        }
    }

    /// The clear pass.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn clear(&self) -> Result<()> {
        let mut encoder = self.device.encoder();
        if self.twin.defines("clear_frame") {
            let pass = self.pass("clear_frame_pass", None, &[])?;
            self.dispatch(&mut encoder, &pass, None, 1);
        }
        let pass = self.pass("clear_pass", None, &[])?;
        self.dispatch(&mut encoder, &pass, None, self.shape.config.pixels.into());
        self.device.submit(encoder)
    }

    /// Run the method's course up to the first resolve, which the caller runs if it wants the results; `geometry` runs
    /// the passes over fragments, by the function of the twin.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn run(&self, geometry: impl FnMut(&str) -> Result<()>) -> Result<()> {
        self.frame(geometry, |_| Ok(false)).map(drop)
    }

    /// Run the method's course. `resolve` resolves every pixel, is told how many rounds were before, and says whether a
    /// pixel needs another one. Gives the number of rounds.
    ///
    /// # Errors
    /// Any error of the device; or rounds without end.
    pub fn frame(
        &self,
        mut geometry: impl FnMut(&str) -> Result<()>,
        mut resolve: impl FnMut(u32) -> Result<bool>,
    ) -> Result<u32> {
        let program = &self.shape.contract.program;
        // A round finds a layer, or that there are none left.
        let most = self.shape.config.max_depth_complexity.saturating_add(2);
        let mut rounds = 0;
        let mut part = |part: &Part| match *part {
            Part::Clear => self.clear().map(|()| false),
            Part::Resolve => {
                let again = resolve(rounds)?;
                rounds += 1;
                if again && rounds == most { Err(Failure::Endless(rounds)) } else { Ok(again) }
            }
            Part::Pass(number) => match program.passes[number].kind {
                PassKind::Store => geometry("store"),
                PassKind::Prepare => geometry("prepare"),
                PassKind::Screen => self.screen_pass(number),
                PassKind::Frame => self.frame_pass(number),
            }
            .map(|()| false),
        };
        Course::of(program)
            .walk(|parts| parts.iter().try_fold(false, |again, one| Ok(part(one)? | again)))
    }

    /// A full-screen pass.
    fn screen_pass(&self, number: usize) -> Result<()> {
        let pass = self.pass("screen_pass", None, &[("PASS", number as f64)])?;
        let mut encoder = self.device.encoder();
        self.dispatch(&mut encoder, &pass, None, self.shape.config.pixels.into());
        self.device.submit(encoder)
    }

    /// One pass over the frame's words.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn frame_pass(&self, number: usize) -> Result<()> {
        let pass = self.frame_words(number)?;
        let mut encoder = self.device.encoder();
        self.dispatch(&mut encoder, &pass, None, self.shape.invocations[number].into());
        self.device.submit(encoder)
    }

    /// A pass over the frame's words, compiled.
    pub(in crate::gpu) fn frame_words(&self, number: usize) -> Result<Dispatch> {
        let invocations = self.shape.invocations[number];
        let overrides = [("PASS", number as f64), ("INVOCATIONS", f64::from(invocations))];
        self.pass("frame_pass", None, &overrides)
    }

    /// A geometry pass on the compute path. An invocation that gives up waiting has stored nothing, and is rerun.
    ///
    /// # Errors
    /// Any error of the device; or an invocation that waits forever.
    pub fn compute(&self, function: &str, fragments: &[Fragment]) -> Result<()> {
        let chunk = if self.twin.waits() { WAITING_CHUNK } else { CHUNK };
        let chunk = self.burst.get().map_or(chunk, |burst| burst.min(chunk));
        fragments.chunks(chunk).try_for_each(|chunk| {
            self.invoke(function, chunk.iter().map(words_of).collect())?;
            Ok(())
        })
    }

    /// Invocations of a geometry pass, at most [`CHUNK`].
    fn invoke(&self, function: &str, mut words: Vec<Words>) -> Result<()> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let buffer = self.device.buffer("fragments", FRAGMENT * words.len() as u64, usage)?;
        for _ in 0..PATIENCE {
            self.invoke_once(function, &buffer, &words)?;
            if !(self.twin.waits() && function == "store") {
                return Ok(());
            }
            let found = self.device.read(&buffer, FRAGMENT * words.len() as u64)?;
            words = bytemuck::pod_collect_to_vec(&found);
            words.retain(|fragment| fragment[4] == STUCK);
            if words.is_empty() {
                return Ok(());
            }
            self.again.set(self.again.get() + words.len() as u64);
        }
        Err(Failure::Stuck(words.len() as u64))
    }

    /// Rerun the invocations that gave up waiting on the raster path.
    ///
    /// # Errors
    /// As [`Self::compute`].
    pub(in crate::gpu) fn repeat(&self, words: Vec<Words>) -> Result<()> {
        self.again.set(self.again.get() + words.len() as u64);
        self.invoke("store", words)
    }

    fn invoke_once(&self, function: &str, buffer: &wgpu::Buffer, words: &[Words]) -> Result<()> {
        self.device.queue.write_buffer(buffer, 0, bytemuck::cast_slice(words));
        let entry = format!("{function}_pass");
        let (group, pass) =
            self.fragments_group(buffer, 0, FRAGMENT * words.len() as u64, &entry)?;
        let mut encoder = self.device.encoder();
        if let Some(beside) = &*self.beside.borrow() {
            beside.record(&mut encoder);
        }
        self.dispatch(&mut encoder, &pass, Some(&group.group), words.len() as u64);
        self.device.submit(encoder)
    }

    /// The second group of a geometry pass over a part of a buffer of fragments, and the pass.
    pub(in crate::gpu) fn fragments_group(
        &self,
        buffer: &wgpu::Buffer,
        offset: u64,
        size: u64,
        entry: &str,
    ) -> Result<(Group, Dispatch)> {
        let bound = Bound {
            binding: 0,
            buffer,
            part: Some((offset, size)),
            kind: WRITABLE,
            stages: ShaderStages::COMPUTE,
        };
        let group = group(self.device, &[bound])?;
        let pass = self.pass(entry, Some(&group), &[])?;
        Ok((group, pass))
    }
}

/// The words of all inputs.
fn inputs(device: &Device, shape: &Shape) -> Result<wgpu::Buffer> {
    let mut words = shape.input_words();
    words.resize(words.len().max(1), 0);
    device.filled("inputs", bytemuck::cast_slice(&words), BufferUsages::STORAGE)
}

/// What a method looks up: a number for every opacity, of one that mixes or approximates; else the offsets of a hash
/// table's ages.
fn table(device: &Device, shape: &Shape) -> Result<wgpu::Buffer> {
    if let Some(numbers) = light::table(shape.contract) {
        return device.filled("numbers", bytemuck::cast_slice(&*numbers), BufferUsages::UNIFORM);
    }
    if shape.contract.keeps == Keeps::Merged {
        return device.filled(
            "logarithms",
            bytemuck::cast_slice(&*logarithms()),
            BufferUsages::UNIFORM,
        );
    }
    let mut offsets = shape.config.table.offsets();
    offsets.resize(256, [0; 2]);
    device.filled("offsets", bytemuck::cast_slice(&offsets), BufferUsages::UNIFORM)
}
