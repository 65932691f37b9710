//! Options of methods that approximate.

use clap::{Args, ValueEnum};

use crate::catalogue;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::scheme::approximate::Approximation;
use crate::scheme::approximate::wboit::Weight;

/// As given. The name of its group tells it from the other options that are flattened into the same command.
#[derive(Clone, Debug, Args)]
#[group(id = "approximation")]
pub(in crate::cli) struct Typed {
    /// For kplus-array, what becomes of what it has no room for: blend, behind the k nearest in the order of arrival; or
    /// average or product, which do not depend on arrival (hybrid and hybrid@product) [default: none; --tail alone: blend]
    #[arg(long, value_enum, value_name = "TAIL", num_args = 0..=1, default_missing_value = "blend", require_equals = true)]
    tail: Option<Tail>,

    /// For wboit, the weight of a fragment, by its number in the paper
    #[arg(long, value_enum, value_name = "EQUATION", default_value = "eq7")]
    weight: Equation,

    /// For mbt, the number of power moments: 4, 6 or 8
    #[arg(long, value_name = "M", default_value_t = 4, allow_negative_numbers = true)]
    pub(super) moments: u32,

    /// For stochastic, samples a pixel, 1 to 64
    #[arg(long, value_name = "S", default_value_t = 8, allow_negative_numbers = true)]
    pub(super) samples: u32,

    /// For stochastic, the seed of the samples, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    sample_seed: u64,
}

/// `--tail`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tail {
    Blend,
    Average,
    Product,
}

/// `--weight`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Equation {
    Eq7,
    Eq8,
    Eq9,
    Eq10,
}

impl Typed {
    /// The methods, with the tail that is asked for.
    ///
    /// # Errors
    /// None of them has one to choose.
    pub(in crate::cli) fn with_tail(&self, methods: Vec<Method>) -> Result<Vec<Method>> {
        let Some(tail) = self.tail else { return Ok(methods) };
        let default = catalogue::DEFAULT;
        if !methods.contains(&default) {
            let given: Vec<&str> = methods.iter().map(Method::name).collect();
            let problem =
                format!("is an option of {default} alone, and not of {}", given.join(", "));
            return Err(Error::new("--tail", problem));
        }
        let tailed = catalogue::method(match tail {
            Tail::Blend => "kplus-array+tail",
            Tail::Average => "hybrid",
            Tail::Product => "hybrid@product",
        })?;
        Ok(methods
            .into_iter()
            .map(|method| if method == default { tailed } else { method })
            .collect())
    }

    /// Completed; ranges are checked with all other options.
    pub(in crate::cli) fn complete(&self) -> Approximation {
        let weight = match self.weight {
            Equation::Eq7 => Weight::Eq7,
            Equation::Eq8 => Weight::Eq8,
            Equation::Eq9 => Weight::Eq9,
            Equation::Eq10 => Weight::Eq10,
        };
        let Self { moments, samples, sample_seed: seed, .. } = *self;
        Approximation { weight, moments, samples, seed }
    }
}
