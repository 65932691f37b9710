//! Contention on purpose: how copies of litmus pixels are laid out and what else a device does at the same time, as
//! settings that a search can vary. After Alglave et al., "GPU concurrency: weak behaviours and programming assumptions"
//! (ASPLOS 2015: stressing memory, shuffling threads), and Levine et al., "MC Mutants: evaluating and improving testing
//! for memory consistency specifications" (ASPLOS 2023: many instances at once, tuned).

use serde::{Deserialize, Serialize};
use wgpu::{BufferUsages, ShaderStages};

use crate::error::{Error, Result};
use crate::fragment::Fragment;
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::program::{Beside, Bound, Group, WRITABLE, group};
use crate::num::random::Random;

/// Settings. It prints as it is parsed: `apart=64,group=1,hammer=0,burst=65536`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pressure {
    /// How many invocations lie between a pixel's fragments and the next ones, at least 1: neighbours.
    pub apart: u32,
    /// Invocations that stay together when all are shuffled; 0 if none are.
    pub group: u32,
    /// Workgroups that load the memory system beside.
    pub hammer: u32,
    /// Invocations of one dispatch, at least 1.
    pub burst: u32,
}

/// The largest value of a setting.
const MOST: u32 = 1 << 16;

impl Pressure {
    /// Settings at random: powers of two, or nothing.
    #[must_use]
    pub fn random(random: &mut Random) -> Self {
        let mut power = |least: u32, most: u32| {
            let steps = u64::from((most / least.max(1)).ilog2()) + 1;
            least.max(1) << random.below(steps)
        };
        let (apart, burst) = (power(1, 4_096), power(64, 16_384));
        let (group, hammer) = (power(1, 512) / 2, power(1, 1_024) / 2);
        Self { apart, group, hammer, burst }
    }

    /// What was typed.
    ///
    /// # Errors
    /// A setting is missing, unknown or out of range.
    pub fn parse(option: &str, text: &str) -> Result<Self> {
        let wrong = || {
            let problem = format!(
                "\"{text}\" must be like apart=64,group=1,hammer=0,burst=4096: at most {MOST} each, apart and burst at \
                 least 1"
            );
            Error::new(option, problem)
        };
        let mut found = [None; 4];
        for part in text.split(',') {
            let (name, value) = part.split_once('=').ok_or_else(wrong)?;
            let place = ["apart", "group", "hammer", "burst"].iter().position(|n| *n == name);
            let place = place.ok_or_else(wrong)?;
            found[place] = Some(value.parse::<u32>().map_err(|_| wrong())?);
        }
        let [Some(apart), Some(group), Some(hammer), Some(burst)] = found else {
            return Err(wrong());
        };
        let fits = apart.min(burst) > 0 && apart.max(burst).max(group).max(hammer) <= MOST;
        if fits { Ok(Self { apart, group, hammer, burst }) } else { Err(wrong()) }
    }

    /// What loads the memory system, if anything does.
    pub(super) fn beside(
        &self,
        device: &Device,
    ) -> std::result::Result<Option<Box<dyn Beside>>, Failure> {
        if self.hammer == 0 {
            return Ok(None);
        }
        Ok(Some(Box::new(Hammer::new(device, self.hammer)?)))
    }

    /// The invocations of so many copies of a pixel with these fragments.
    #[must_use]
    pub fn arrange(&self, own: &[Fragment], copies: u32, seed: u64) -> Vec<Fragment> {
        let mut all = Vec::with_capacity(own.len() * copies as usize);
        let pixels: Vec<u32> = (0..copies).collect();
        for block in pixels.chunks(self.apart as usize) {
            for fragment in own {
                all.extend(block.iter().map(|&pixel| Fragment { pixel, ..*fragment }));
            }
        }
        let mut random = Random::new(seed, 1);
        if self.group > 0 {
            let mut groups: Vec<&[Fragment]> = all.chunks(self.group as usize).collect();
            random.shuffle(&mut groups);
            all = groups.concat();
        }
        all
    }
}

impl std::fmt::Display for Pressure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { apart, group, hammer, burst } = self;
        write!(f, "apart={apart},group={group},hammer={hammer},burst={burst}")
    }
}

/// Bytes that are hammered: more than a first-level cache has.
const SCRATCH: u64 = 1 << 20;

/// Invocations that do nothing but load the memory system.
#[derive(Debug)]
pub(super) struct Hammer {
    workgroups: u32,
    group: Group,
    pipeline: wgpu::ComputePipeline,
}

impl Hammer {
    /// One with so many workgroups.
    ///
    /// # Errors
    /// Any error of the device.
    pub(super) fn new(device: &Device, workgroups: u32) -> std::result::Result<Self, Failure> {
        let scratch = device.buffer("scratch", SCRATCH, BufferUsages::STORAGE)?;
        let (binding, part, kind, stages) = (0, None, WRITABLE, ShaderStages::COMPUTE);
        let group = group(device, &[Bound { binding, buffer: &scratch, part, kind, stages }])?;
        let module = device.module("hammer", include_str!("../wgsl/pass/hammer.wgsl"))?;
        let device = (device, &device.device);
        let layout = device.1.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("hammer"),
            bind_group_layouts: &[Some(&group.layout)],
            immediate_size: 0,
        });
        let pipeline = device.1.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("hammer"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("hammer"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        device.0.check()?;
        Ok(Self { workgroups, group, pipeline })
    }
}

impl Beside for Hammer {
    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        compute.set_pipeline(&self.pipeline);
        compute.set_bind_group(0, &self.group.group, &[]);
        compute.dispatch_workgroups(self.workgroups, 1, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_as_they_are_printed() {
        let mut random = Random::new(7, 0);
        for _ in 0..1_000 {
            let one = Pressure::random(&mut random);
            assert_eq!(Pressure::parse("--stress", &one.to_string()), Ok(one));
        }
        for wrong in [
            "",
            "apart=1",
            "apart=0,group=0,hammer=0,burst=1",
            "apart=1,group=0,hammer=0,burst=0",
            "apart=1,group=0,hammer=0,burst=65537",
            "apart=1,group=0,hammer=x,burst=1",
            "apart=1,group=0,hammer=0,burst=1,more=1",
        ] {
            assert!(Pressure::parse("--stress", wrong).is_err(), "{wrong}");
        }
    }

    /// Every pixel has all its fragments, and unless they are shuffled they are as far apart as they should be.
    #[test]
    fn every_copy_has_its_fragments() {
        let own = [10, 20, 30].map(|depth| Fragment { pixel: 0, depth, data: 1, extra: 0 });
        for (apart, group) in [(1, 0), (4, 0), (4, 1), (64, 8), (7, 3), (100, 0)] {
            let all = Pressure { apart, group, hammer: 0, burst: 1 }.arrange(&own, 60, 3);
            let mut places = vec![Vec::new(); 60];
            for (place, fragment) in all.iter().enumerate() {
                places[fragment.pixel as usize].push((fragment.depth, place));
            }
            for of_pixel in &mut places {
                let before = of_pixel.clone();
                of_pixel.sort_unstable();
                assert_eq!(of_pixel.iter().map(|p| p.0).collect::<Vec<_>>(), [10, 20, 30]);
                if group == 0 {
                    assert_eq!(*of_pixel, before);
                }
            }
            if group == 0 && 60 % apart == 0 {
                assert!(places.iter().all(|p| p[1].1 - p[0].1 == apart as usize));
            }
        }
    }
}
