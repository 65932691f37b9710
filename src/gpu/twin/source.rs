//! The WGSL text of a module: constants, the twin, and the entry points of its passes.
//!
//! One file per method, and shared parts by a plain include: a line `//# include NAME` is replaced by that file, once
//! in a module. A method that is another one but for a part includes that one's file, after a line `//# replaces NAME`:
//! what follows the line takes the place of that part, which is then not included. Which passes a twin has follows from
//! the functions that it defines: each gets its entry point from `pass/`.

use std::fmt::Write;

use crate::catalogue::Catalogue;
use crate::exec::Method;
use crate::explore::Profile;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::spirv::orders::Order;

/// A method in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    /// The method.
    pub method: Method,
    /// Its text, before includes.
    pub text: &'static str,
    /// What becomes of its atomic operations.
    pub form: Form,
}

/// What becomes of a twin's atomic operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// They are relaxed, as WGSL has them.
    #[default]
    Wgsl,
    /// Those that the method's source orders acquire or release, in SPIR-V.
    Vulkan,
}

macro_rules! files {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../wgsl/", $name, ".wgsl")))),*]
    };
}

/// The files that can be included.
const FILES: &[(&str, &str)] = files! {
    "pass/clear" "pass/clear_frame" "pass/frame" "pass/number" "pass/prepare" "pass/prepare_raster" "pass/raster" "pass/resolve"
    "pass/round" "pass/screen" "pass/store" "pass/store_raster"
    "shared/composite" "shared/depth" "shared/emit" "shared/fragment" "shared/fragments" "shared/grid" "shared/index"
    "shared/nearest" "shared/rays" "shared/sort" "shared/wide" "shared/word64"
    "parts/alike" "parts/array_up_to" "parts/buckets" "parts/counted_down" "parts/ends" "parts/list" "parts/lock" "parts/unlock"
    "parts/locked_row" "parts/max_array" "parts/max_heap" "parts/merged" "parts/ranges" "parts/table"
    "a_buffer/ab_array" "a_buffer/ab_ll" "a_buffer/s_buffer" "hash_table/ha64" "kplus_buffer/kplus_sb"
    "reach/frame_rows" "reach/frame_rows_atomic" "reach/frame_rows_updates" "reach/nodes" "reach/nodes_atomic"
    "reach/nodes_updates" "reach/pages" "reach/pages_atomic" "reach/pages_updates" "reach/pixel_rows"
    "reach/pixel_rows_atomic" "reach/pixel_rows_updates" "reach/updates" "reach/unlock_updates"
    "approximate/random" "approximate/ray" "approximate/sums" "approximate/table"
};

/// A form has its method's text, with `[this part, that one in its place]`.
macro_rules! twins {
    ($($method:literal $file:literal $([$part:literal $other:literal])*)*) => {
        &[$((
            $method,
            concat!(
                $("//# replaces ", $part, "\n//# include ", $other, "\n",)*
                include_str!(concat!("../wgsl/", $file, ".wgsl"))
            ),
        )),*]
    };
}

/// The built-in twins, in the catalogue's order.
const TWINS: &[(&str, &str)] = twins! {
    "z-buffer" "k_buffer/z_buffer"
    "ab-array" "a_buffer/ab_array"
    "ab-ll" "a_buffer/ab_ll"
    "s-buffer" "a_buffer/s_buffer"
    "dfb" "a_buffer/dfb"
    "kb" "k_buffer/kb"
    "kb-mdt32" "k_buffer/kb_mdt32"
    "kb-mdt64" "k_buffer/kb_mdt64"
    "kb-ab-array" "k_buffer/kb_ab_array"
    "kb-ab-ll" "k_buffer/kb_ab_ll"
    "kb-ab-sb" "k_buffer/kb_ab_sb"
    "kplus" "kplus_buffer/kplus"
    "ab-ll-paged" "a_buffer/ab_ll_paged"
    "ab-ll-bucket" "a_buffer/ab_ll_bucket"
    "ab-ll-double" "a_buffer/ab_ll_double"
    "kb-ll" "k_buffer/kb_ll"
    "kplus-array" "kplus_buffer/kplus_array"
    "kplus-heap" "kplus_buffer/kplus_heap"
    "kplus-sb" "kplus_buffer/kplus_sb"
    "kplus-sb@heap" "kplus_buffer/kplus_sb_heap"
    "k-variable" "kplus_buffer/k_variable"
    "depth-peel" "peeling/depth_peel"
    "depth-peel-dual" "peeling/depth_peel_dual"
    "depth-peel-bucket" "peeling/depth_peel_bucket"
    "kplus-multi" "kplus_buffer/kplus_multi"
    "kb-multi" "k_buffer/kb_multi"
    "ha64" "hash_table/ha64"
    "ha64-multiset" "hash_table/ha64_multiset"
    "ha32" "hash_table/ha32"
    "hash-coherent" "hash_table/hash_coherent"
    "occupancy" "culling/occupancy"
    "skb+ofm" "merging/skb_ofm"
    "dfb+ofm" "merging/dfb_ofm"
    "wboit" "approximate/wboit"
    "mbt" "approximate/mbt"
    "mlab" "approximate/mlab"
    "hybrid" "approximate/hybrid"
    "stochastic" "approximate/stochastic"
    "ab-ll-paged@atomic" "a_buffer/ab_ll_paged" ["reach/pages" "reach/pages_atomic"]
    "ab-ll-paged@rmw" "a_buffer/ab_ll_paged" ["reach/pages" "reach/pages_updates"] ["parts/unlock" "reach/unlock_updates"]
    "kb-ll@atomic" "k_buffer/kb_ll" ["reach/nodes" "reach/nodes_atomic"]
    "kb-ll@rmw" "k_buffer/kb_ll" ["reach/nodes" "reach/nodes_updates"]
    "kplus-array@atomic" "kplus_buffer/kplus_array" ["reach/pixel_rows" "reach/pixel_rows_atomic"]
    "kplus-array@rmw" "kplus_buffer/kplus_array" ["reach/pixel_rows" "reach/pixel_rows_updates"] ["parts/unlock" "reach/unlock_updates"]
    "kplus-array@word64" "kplus_buffer/kplus_array_word64"
    "kplus-heap@atomic" "kplus_buffer/kplus_heap" ["reach/pixel_rows" "reach/pixel_rows_atomic"]
    "kplus-heap@rmw" "kplus_buffer/kplus_heap" ["reach/pixel_rows" "reach/pixel_rows_updates"] ["parts/unlock" "reach/unlock_updates"]
    "kplus-sb@atomic" "kplus_buffer/kplus_sb" ["reach/frame_rows" "reach/frame_rows_atomic"]
    "kplus-sb@rmw" "kplus_buffer/kplus_sb" ["reach/frame_rows" "reach/frame_rows_updates"] ["parts/unlock" "reach/unlock_updates"]
};

/// Entry points by the function that a twin defines: where they are, and whether they run invocations for fragments.
const ENTRIES: &[(&str, &str)] = &[
    ("clear_frame", "pass/clear_frame"),
    ("clear", "pass/clear"),
    ("prepare", "pass/prepare"),
    ("screen", "pass/screen"),
    ("frame", "pass/frame"),
    ("store", "pass/store"),
    ("resolve", "pass/resolve"),
    ("again", "pass/round"),
];

/// Those of the raster path.
const RASTER_ENTRIES: &[(&str, &str)] =
    &[("prepare", "pass/prepare_raster"), ("store", "pass/store_raster")];

/// The built-in twins, in the catalogue's order.
#[must_use]
pub fn twins() -> Vec<Twin> {
    let catalogue = Catalogue::built_in();
    let twin = |&(name, text): &(&str, &'static str)| {
        let method = catalogue.find("WGSL", name).ok()?;
        Some(Twin { method, text, form: Form::default() })
    };
    TWINS.iter().filter_map(twin).collect()
}

/// The built-in twin of a method.
#[must_use]
pub fn twin(method: Method) -> Option<Twin> {
    twins().into_iter().find(|twin| twin.method == method)
}

/// Which entry points a module has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Compute shaders.
    Compute,
    /// A vertex shader, and a fragment shader for every geometry pass.
    Raster,
}

impl Path {
    /// Attempts to take a lock before an invocation gives up: fewer than the 65,535 iterations after which some drivers
    /// end any loop. On the compute path an invocation that has given up is rerun, and given up for good at last; the
    /// raster path only has to be left.
    fn patience(self) -> u64 {
        match self {
            Self::Compute => 1 << 15,
            Self::Raster => 1 << 12,
        }
    }
}

impl Twin {
    /// The method's name, and the form if it is not WGSL.
    #[must_use]
    pub fn name(&self) -> String {
        match self.form {
            Form::Wgsl => self.method.name().to_owned(),
            Form::Vulkan => format!("{}/vulkan", self.method),
        }
    }

    /// Its Vulkan form; none if it asks for no order.
    #[must_use]
    pub fn vulkan(self) -> Option<Self> {
        let asks =
            |text: String| Order::ALL.iter().any(|o| text.contains(&format!("fn {}", o.prefix())));
        self.expanded().is_ok_and(asks).then_some(Self { form: Form::Vulkan, ..self })
    }

    /// What nothing guarantees of it, if its method is no race; empty if all is.
    #[must_use]
    pub fn not_guaranteed(&self) -> &'static str {
        match self.form {
            _ if self.method.contract().is_within_wgsl() => "",
            Form::Wgsl => "not guaranteed by WGSL",
            Form::Vulkan if self.locks() => "nothing guarantees that a lock's holder goes on",
            Form::Vulkan => "",
        }
    }

    /// How the checker calls the memory that it runs on.
    #[must_use]
    pub fn profile(&self) -> Profile {
        match self.form {
            Form::Wgsl => Profile::Wgsl,
            Form::Vulkan => Profile::Vulkan,
        }
    }

    /// Whether the twin defines a function.
    #[must_use]
    pub fn defines(&self, function: &str) -> bool {
        self.expanded().is_ok_and(|text| text.contains(&format!("fn {function}(")))
    }

    /// Whether it declares a binding of the first group.
    #[must_use]
    pub fn binds(&self, binding: u32) -> bool {
        let declared = format!("@group(0) @binding({binding})");
        self.expanded().is_ok_and(|text| text.contains(&declared))
    }

    /// Whether it waits for locks.
    #[must_use]
    pub fn locks(&self) -> bool {
        self.expanded().is_ok_and(|text| text.contains("const TAKEN"))
    }

    /// Whether its invocations may give up waiting, for a lock or for a compare-exchange, with nothing stored.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.expanded().is_ok_and(|text| text.replace("const STUCK", "").contains("STUCK"))
    }

    /// Whether it needs atomic operations on 64 bits, which WGSL has only as an extension of naga's.
    #[must_use]
    pub fn needs_atomics64(&self) -> bool {
        self.expanded().is_ok_and(|text| text.contains("atomic<u64>"))
    }

    fn expanded(&self) -> Result<String> {
        let mut text = String::new();
        include(self.text, &mut Vec::new(), &mut text)?;
        Ok(text)
    }

    /// The module's text.
    ///
    /// # Errors
    /// An include that does not exist.
    pub fn module(&self, constants: &Constants, path: Path) -> Result<String> {
        let entries = match path {
            Path::Compute => ENTRIES,
            Path::Raster => RASTER_ENTRIES,
        };
        let mut text = constants.clone().with("PATIENCE", path.patience()).text();
        let mut seen = Vec::new();
        include(self.text, &mut seen, &mut text)?;
        for (function, file) in entries {
            if self.defines(function) {
                text.push('\n');
                include(&format!("//# include {file}\n"), &mut seen, &mut text)?;
            }
        }
        Ok(text)
    }
}

/// The text of a file that can be included.
fn known(name: &str) -> Result<&'static str> {
    let file = FILES.iter().find(|(known, _)| *known == name);
    let (_, text) =
        file.ok_or_else(|| Failure::Invalid(format!("there is no file {name}.wgsl")))?;
    Ok(text)
}

fn include(from: &str, seen: &mut Vec<String>, into: &mut String) -> Result<()> {
    for line in from.lines() {
        if let Some(name) = line.strip_prefix("//# replaces ") {
            known(name)?;
            seen.push(name.to_owned());
            continue;
        }
        match line.strip_prefix("//# include ") {
            Some(name) if seen.iter().any(|one| one == name) => {}
            Some(name) => {
                seen.push(name.to_owned());
                include(known(name)?, seen, into)?;
            }
            None => {
                into.push_str(line);
                into.push('\n');
            }
        }
    }
    Ok(())
}

/// Numbers that precede a twin as constants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constants {
    text: String,
}

impl Constants {
    /// Add an unsigned one.
    #[must_use]
    pub fn with(mut self, name: &str, value: u64) -> Self {
        let _ = writeln!(self.text, "const {name}: u32 = {value}u;");
        self
    }

    /// Add one, and a second one, at least 1, for the length of an array; the second name ends in `_ROOM`.
    #[must_use]
    pub fn with_room(self, name: &str, value: u64) -> Self {
        self.with(name, value).with(&format!("{name}_ROOM"), value.max(1))
    }

    /// Add a signed one.
    #[must_use]
    pub fn with_signed(mut self, name: &str, value: i64) -> Self {
        let _ = writeln!(self.text, "const {name}: i32 = {value}i;");
        self
    }

    /// Add a float: the nearest of single precision.
    #[must_use]
    pub fn with_float(mut self, name: &str, value: f64) -> Self {
        let value = value as f32;
        let value = if value.is_finite() { value } else { 0.0 };
        let _ = writeln!(self.text, "const {name}: f32 = {value:e}f;");
        self
    }

    /// Add a power of two as a float.
    #[must_use]
    pub fn with_power(mut self, name: &str, exponent: i32) -> Self {
        let _ = writeln!(self.text, "const {name}: f32 = 0x1p{exponent}f;");
        self
    }

    fn text(&self) -> String {
        self.text.clone()
    }
}
