//! Colours without lists: what a method that approximates must give. A twin emits all words of a pixel, and the
//! simulator's own resolve makes the colour of them.

use rayon::prelude::*;

use super::bounds::Bounds;
use crate::exec::drive::Pipeline;
use crate::exec::interpret::Interpreted;
use crate::exec::promise::Promise;
use crate::exec::{Instance, Method};
use crate::fragment::Fragment;
use crate::memory::Inputs;
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::raster::Batch;
use crate::scheme::approximate::{mbt, passing};
use crate::scheme::program::PassKind;
use crate::scheme::{Config, Contract, Held, HeldKind, Light, Outcomes};

/// The numbers that a method that approximates looks up by opacity (`approximate/table.wgsl`); `None` for others.
#[must_use]
pub fn table(contract: &Contract) -> Option<Box<[u64; 256]>> {
    if !contract.keeps.is_approximate() {
        return None;
    }
    Some(if contract.name == "mbt" { mbt::absorbances() } else { passing::logarithms() })
}

/// The simulator's own method.
pub struct Simulator {
    contract: &'static Contract,
    instance: Box<dyn Instance>,
    inputs: Inputs,
}

/// A method on the memory of one thread.
type OnOne<'a> = &'a dyn for<'m> Pipeline<Exclusive<'m, ()>>;

impl Simulator {
    /// A method with a configuration; `None` if a pixel does not hold a colour.
    #[must_use]
    pub fn new(method: Method, config: &Config) -> Option<Self> {
        let instance = method.instance(config).filter(|_| method.holds() == HeldKind::Color)?;
        let inputs = Inputs::defaults(instance.layout());
        Some(Self { contract: method.contract(), instance, inputs })
    }

    /// 64-bit words of a pixel as a twin emits them: those of 64 bits, then those of 32 bits in pairs, the first one in
    /// the lower half.
    #[must_use]
    pub fn room(&self) -> usize {
        let sizes = self.instance.layout().per_pixel();
        (sizes.words64 + sizes.words32.div_ceil(2)) as usize
    }

    fn with<T>(&self, run: impl FnOnce(OnOne<'_>) -> T) -> T {
        let interpreted = Interpreted { instance: &*self.instance, inputs: &self.inputs };
        match self.instance.compiled() {
            Some(compiled) => run(compiled.exclusive()),
            None => run(&interpreted),
        }
    }

    /// The words of all pixels after these fragments, one after another, by pixel.
    #[must_use]
    pub fn words(&self, pixels: u32, fragments: &[Fragment]) -> Vec<u64> {
        let layout = self.instance.layout();
        let sizes = layout.per_pixel();
        let own = Owned::new(sizes, pixels as usize);
        let shared = Shared::new(layout.per_frame(), 1);
        let mem = Exclusive::new(&own, &shared, &self.inputs, &());
        self.with(|scheme| {
            scheme.clear_frame(&mem);
            scheme.clear(&mem, 0..pixels);
            for (number, pass) in self.contract.program.passes.iter().enumerate() {
                match pass.kind {
                    PassKind::Prepare => fragments.iter().for_each(|&fragment| {
                        scheme.prepare(&mem, number, &Batch::one(fragment));
                    }),
                    PassKind::Screen => scheme.screen(&mem, number, 0..pixels),
                    PassKind::Frame => scheme.frame(&mem, number, 0..scheme.invocations(number)),
                    PassKind::Store => fragments.iter().for_each(|&fragment| {
                        let mut outcomes = Outcomes::default();
                        scheme.store(&mem, &Batch::one(fragment), &mut outcomes);
                    }),
                }
            }
        });
        let (narrow, wide) = own.all();
        let (n32, n64) = (sizes.words32 as usize, sizes.words64 as usize);
        let mut words = Vec::with_capacity(self.room() * pixels as usize);
        for pixel in 0..pixels as usize {
            words.extend_from_slice(&wide[pixel * n64..(pixel + 1) * n64]);
            let pairs = narrow[pixel * n32..(pixel + 1) * n32].chunks(2);
            words.extend(pairs.map(|pair| {
                let upper = pair.get(1).copied().unwrap_or_default();
                u64::from(upper) << 32 | u64::from(pair[0])
            }));
        }
        words
    }

    /// The colour of a pixel with these words.
    #[must_use]
    pub fn light(&self, pixel: u32, words: &[u64]) -> Light {
        let layout = self.instance.layout();
        let sizes = layout.per_pixel();
        let (wide, pairs) = words.split_at(words.len().min(sizes.words64 as usize));
        let narrow: Vec<u32> =
            pairs.iter().flat_map(|&pair| [pair as u32, (pair >> 32) as u32]).collect();
        let own = Owned::of(sizes, 1, (&narrow, wide));
        let shared = Shared::new(layout.per_frame(), 1);
        let mem = Exclusive::new(&own, &shared, &self.inputs, &()).from(pixel);
        let mut held = HeldKind::Color.empty();
        self.with(|scheme| scheme.resolve(&mem, pixel, &mut held));
        match held {
            Held::Light(light) => light,
            _ => Light::default(),
        }
    }

    /// The colour that a pixel must have with these fragments in canonical order, if arrival does not decide.
    #[must_use]
    pub fn expected(&self, pixel: u32, fragments: &[Fragment]) -> Option<Held> {
        self.instance.expected(&self.inputs, pixel, fragments)
    }
}

/// What a method that approximates must give.
#[derive(Clone, Debug)]
pub struct Promised {
    /// Where the words of each pixel begin in the results of resolve; one entry more than there are pixels.
    pub starts: Vec<u32>,
    /// How far a device's words and colours may be from these.
    pub bounds: Bounds,
    /// The simulator's own words, as far as arrival does not decide.
    words: Vec<u64>,
    /// By pixel, its colour; `None` where arrival decides.
    lights: Vec<Option<Light>>,
    method: Method,
    config: Config,
}

impl Promised {
    /// For pixels with these fragments, in canonical order. `None` if the method does not give colours.
    #[must_use]
    pub fn new(
        method: Method,
        config: &Config,
        generated: &[Vec<Fragment>],
        promise: &Promise<'_>,
    ) -> Option<Self> {
        let simulator = Simulator::new(method, config)?;
        let light = |(pixel, list): (usize, &Vec<Fragment>)| match promise.pixel(pixel as u32, list)
        {
            Some(Held::Light(light)) => Some(light),
            _ => None,
        };
        let room = simulator.room() as u32;
        Some(Self {
            starts: (0..=generated.len() as u32).map(|pixel| pixel * room).collect(),
            bounds: Bounds::of(method, config),
            words: simulator.words(generated.len() as u32, &generated.concat()),
            lights: generated.par_iter().enumerate().map(light).collect(),
            method,
            config: *config,
        })
    }

    /// The simulator's own method.
    #[must_use]
    pub fn simulator(&self) -> Option<Simulator> {
        Simulator::new(self.method, &self.config)
    }

    /// How many pixels there are.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.lights.len()
    }

    /// A pixel's words, if its fragments come in canonical order.
    #[must_use]
    pub fn words(&self, pixel: usize) -> &[u64] {
        &self.words[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }

    /// A pixel's colour; `None` where arrival decides.
    #[must_use]
    pub fn light(&self, pixel: usize) -> Option<Light> {
        self.lights[pixel]
    }
}
