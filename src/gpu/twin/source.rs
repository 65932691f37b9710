//! The WGSL text of a module: constants, the twin, and the entry points of its passes.
//!
//! One file per method, and shared parts by a plain include: a line `//# include NAME` is replaced by that file, once
//! in a module. Which passes a twin has follows from the functions that it defines: each gets its entry point from
//! `pass/`.

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
    "pass/screen" "pass/store" "pass/store_raster"
    "shared/composite" "shared/depth" "shared/emit" "shared/fragment" "shared/fragments" "shared/grid" "shared/index"
    "shared/sort" "shared/wide" "shared/word64"
    "parts/counted_down" "parts/list" "parts/lock" "parts/locked_row" "parts/max_array" "parts/max_heap" "parts/merged"
    "parts/ranges" "parts/table"
    "approximate/random" "approximate/ray" "approximate/sums" "approximate/table"
};

macro_rules! twins {
    ($($method:literal $file:literal)*) => {
        &[$(($method, include_str!(concat!("../wgsl/", $file, ".wgsl")))),*]
    };
}

/// The built-in twins, by the names of their methods, in the catalogue's order.
const TWINS: &[(&str, &str)] = twins! {
    "z-buffer" "k_buffer/z_buffer"
    "ab-array" "a_buffer/ab_array"
    "ab-ll" "a_buffer/ab_ll"
    "s-buffer" "a_buffer/s_buffer"
    "dfb" "a_buffer/dfb"
    "kb" "k_buffer/kb"
    "kb-mdt32" "k_buffer/kb_mdt32"
    "kb-mdt64" "k_buffer/kb_mdt64"
    "ab-ll-paged" "a_buffer/ab_ll_paged"
    "kb-ll" "k_buffer/kb_ll"
    "kplus-array" "kplus_buffer/kplus_array"
    "kplus-heap" "kplus_buffer/kplus_heap"
    "kplus-sb" "kplus_buffer/kplus_sb"
    "k-variable" "kplus_buffer/k_variable"
    "ha64" "hash_table/ha64"
    "ha32" "hash_table/ha32"
    "occupancy" "culling/occupancy"
    "skb+ofm" "merging/skb_ofm"
    "dfb+ofm" "merging/dfb_ofm"
    "wboit" "approximate/wboit"
    "mbt" "approximate/mbt"
    "mlab" "approximate/mlab"
    "stochastic" "approximate/stochastic"
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
        self.text.contains(&format!("fn {function}("))
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
        self.text.contains("//# include parts/lock\n")
    }

    /// Whether its invocations may give up waiting, for a lock or for a compare-exchange, with nothing stored.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.text.contains("STUCK")
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
        let mut text = constants.text();
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

fn include(from: &str, seen: &mut Vec<String>, into: &mut String) -> Result<()> {
    for line in from.lines() {
        match line.strip_prefix("//# include ") {
            Some(name) if seen.iter().any(|one| one == name) => {}
            Some(name) => {
                let file = FILES.iter().find(|(known, _)| *known == name);
                let (_, text) =
                    file.ok_or_else(|| Failure::Invalid(format!("there is no file {name}.wgsl")))?;
                seen.push(name.to_owned());
                include(text, seen, into)?;
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
