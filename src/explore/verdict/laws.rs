//! Laws: claims about what a method makes of slabs that lie near each other, whatever interleaves. Each is tried on every
//! instance of a grid, one invocation after another, in both orders of two fragments.

use crate::exec::one_pixel::OnePixel;
use crate::explore::program::subject::Subject;
use crate::fragment::{Fragment, data_of, depth_of};
use crate::scheme::merging::Merging;
use crate::scheme::merging::slab::{OPAQUE, Visibility};
use crate::scheme::{Config, Contract, Held, Record};

/// A law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Law {
    /// A slab that is merged with an invisible one is cut into up to three parts, which must look as it did.
    Restores,
    /// Where two surfaces change places by one depth code, what is seen changes by no more than one code's share.
    Blends,
}

impl Law {
    /// What its grid shows of a method.
    pub(super) fn on(self, subject: &Subject) -> Tried {
        match self {
            Self::Restores => restores(subject),
            Self::Blends => blends(subject),
        }
    }
}

/// What a law's grid showed.
pub(super) struct Tried {
    /// Instances.
    pub(super) instances: u64,
    /// What the grid covers.
    pub(super) grid: &'static str,
    /// The largest deviation.
    pub(super) most: f64,
    /// The largest that is allowed.
    pub(super) bound: f64,
    /// The instance that deviates most.
    pub(super) instance: String,
}

impl Tried {
    fn new(grid: &'static str, bound: f64) -> Self {
        Self { instances: 0, grid, most: 0.0, bound, instance: String::new() }
    }

    fn add(&mut self, deviation: f64, instance: impl FnOnce() -> String) {
        self.instances += 1;
        if deviation > self.most {
            (self.most, self.instance) = (deviation, instance());
        }
    }

    /// It holds on the whole grid.
    pub(super) fn holds(&self) -> bool {
        self.most <= self.bound
    }
}

/// Depth of the surfaces, and the thickness of their slabs, in codes: twice the precision, as published.
const DEPTH: u32 = 1 << 30;
const THICK: u32 = 512;

/// How far f64 may be off after a few dozen operations, some of which divide by what an opaque slab lets through, 2^-17.
const ROUNDING: f64 = 1e-9;

/// The largest slope of equation (4), over one thickness: at β = 0, where an opaque slab begins, -ln(1 - A) = 17 ln 2.
const STEEPEST: f64 = 11.8;

fn slab(depth: u32, thickness: u32, data: u32) -> Fragment {
    Fragment { pixel: 0, depth, data, extra: depth - thickness }
}

/// A method's pixel with room for two, at this β.
fn pixel(subject: &Subject, beta: f64) -> Option<OnePixel> {
    let merging = Merging { beta, ..Merging::default() };
    let base = Config { merging, ..Config::default() };
    OnePixel::new(subject.method, &OnePixel::config(2, 4, base))
}

/// What the pixel shows: its fragments or records over each other.
fn seen(pixel: &OnePixel, contract: &Contract, fragments: [Fragment; 2]) -> Visibility {
    let bare = |f: Fragment| Fragment { extra: 0, ..f };
    let fragments = fragments.map(|f| if contract.has_slabs() { f } else { bare(f) });
    let records: Vec<Record> = match pixel.store(&fragments).held {
        Held::Keys(keys) => {
            keys.iter().map(|&key| Record::surface(depth_of(key), data_of(key))).collect()
        }
        Held::Records(records) => records.into_list(),
        Held::Light(light) => {
            let [r, g, b] = light.color;
            return Visibility::new([r, g, b, 1.0 - light.transmittance]);
        }
        Held::Depth(_) => Vec::new(),
    };
    let all = records.iter().map(|record| Visibility::new(record.rgba));
    all.fold(Visibility::default(), Visibility::over)
}

fn apart(a: Visibility, b: Visibility) -> f64 {
    let pairs = a.rgba().into_iter().zip(b.rgba());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn describe(beta: f64, [a, b]: [Fragment; 2]) -> String {
    let one = |f: Fragment| format!("{:x}/{:x} thick {:x}", f.depth, f.data, f.depth - f.extra);
    format!("n=2 beta={beta} {} {}", one(a), one(b))
}

fn restores(subject: &Subject) -> Tried {
    let grid = "every opacity, nine places of an invisible slab, beta 0, 0.5 and 1, both orders";
    let mut tried = Tried::new(grid, ROUNDING);
    let half = i64::from(THICK) / 2;
    for beta in [0.0, 0.5, 1.0] {
        let Some(pixel) = pixel(subject, beta) else { return tried };
        for alpha in 0..=255u32 {
            let own = slab(DEPTH, THICK, alpha << 24 | 0x20_80FF);
            let alone = Visibility::new(Record::surface(own.depth, own.data).rgba);
            for (offset, thickness) in [
                (0, THICK),
                (half, THICK),
                (-half, THICK),
                (0, THICK / 2),
                (-half / 2, THICK / 2),
                (half / 2, 2 * THICK),
                (0, 2 * THICK),
                (1, 2),
                (-1, 2),
            ] {
                let depth = (i64::from(DEPTH) + offset) as u32;
                let unseen = slab(depth, thickness, 0x00_FFFF);
                for order in [[own, unseen], [unseen, own]] {
                    let found = seen(&pixel, subject.contract, order);
                    // An opaque slab has no inside, so its opacity counts as a little less.
                    let right = if alone.opacity > OPAQUE && found.opacity < 1.0 {
                        Visibility { color: alone.color.map(|c| c * OPAQUE), opacity: OPAQUE }
                    } else {
                        alone
                    };
                    tried.add(apart(found, right), || describe(beta, order));
                }
            }
        }
    }
    tried
}

fn blends(subject: &Subject) -> Tried {
    let grid =
        "two surfaces at most one depth code apart, 6 colours each, beta 0, 0.5 and 1, both orders";
    let mut tried = Tried::new(grid, 2.0 * STEEPEST / f64::from(THICK));
    let colors = [0xFF00_00FFu32, 0xFF00_FF00, 0xFFFF_0000, 0x8000_00FF, 0x80FF_FFFF, 0x40FF_8000];
    for beta in [0.0, 0.5, 1.0] {
        let Some(pixel) = pixel(subject, beta) else { return tried };
        for (a, b) in colors.iter().flat_map(|&a| colors.map(|b| (a, b))) {
            let at = |offset: u32| [slab(DEPTH, THICK, a), slab(DEPTH - 1 + offset, THICK, b)];
            let views: Vec<Visibility> = (0..3)
                .flat_map(|offset| {
                    let [one, other] = at(offset);
                    [[one, other], [other, one]]
                })
                .map(|order| seen(&pixel, subject.contract, order))
                .collect();
            for view in &views[1..] {
                tried.add(apart(views[0], *view), || describe(beta, at(2)));
            }
        }
    }
    tried
}
