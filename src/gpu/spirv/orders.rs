//! Acquire and release, by the names of functions.
//!
//! An atomic operation in a function whose name begins with `acquire_` acquires, and one in a function whose name begins
//! with `release_` releases, both at device scope. Each order is there twice: in the operation, as in the methods' own
//! source, and as a memory barrier behind an acquire and before a release. The barrier is what Vulkan's text rests on for
//! modules without its memory model; with coherent buffers it is how GLSL always wrote locks.

use std::collections::BTreeMap;

use rspirv::binary::Assemble;
use rspirv::dr::{Builder, Instruction, Operand, load_words};
use rspirv::spirv::{MemorySemantics, Op, Scope, Word};

use crate::gpu::driver::failure::{Failure, Result};

/// The orders that operations can get.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// What comes later sees what was written before the matching release.
    Acquire,
    /// What came earlier is seen after the matching acquire.
    Release,
}

impl Order {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Acquire, Self::Release];

    /// What the names of its functions begin with.
    #[must_use]
    pub const fn prefix(self) -> &'static str {
        match self {
            Self::Acquire => "acquire_",
            Self::Release => "release_",
        }
    }

    /// The order of a function's operations, by its name.
    #[must_use]
    pub fn of(function: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|order| function.starts_with(order.prefix()))
    }

    /// Its memory semantics, for storage buffers.
    #[must_use]
    pub fn semantics(self) -> MemorySemantics {
        let order = match self {
            Self::Acquire => MemorySemantics::ACQUIRE,
            Self::Release => MemorySemantics::RELEASE,
        };
        order | MemorySemantics::UNIFORM_MEMORY
    }

    /// Whether an instruction is an atomic operation that can have it: one that reads can acquire, one that writes can
    /// release.
    fn suits(self, op: Op) -> bool {
        match op {
            Op::AtomicLoad => self == Self::Acquire,
            Op::AtomicStore => self == Self::Release,
            Op::AtomicExchange
            | Op::AtomicCompareExchange
            | Op::AtomicIAdd
            | Op::AtomicISub
            | Op::AtomicSMin
            | Op::AtomicUMin
            | Op::AtomicSMax
            | Op::AtomicUMax
            | Op::AtomicAnd
            | Op::AtomicOr
            | Op::AtomicXor => true,
            _ => false,
        }
    }
}

/// A module with the orders put in; none if it has no function that asks for one.
///
/// # Errors
/// It cannot be read, or a function asks for an order and has no operation that can have it.
pub fn ordered(words: &[u32]) -> Result<Option<Vec<u32>>> {
    let module = load_words(words).map_err(|error| Failure::Invalid(error.to_string()))?;
    let orders = orders_of(&module.debug_names);
    if orders.is_empty() {
        return Ok(None);
    }
    let mut builder = Builder::new_from_module(module);
    let uint = builder.type_int(32, 0);
    let scope = builder.constant_bit32(uint, Scope::Device as u32);
    let [acquire, release] =
        Order::ALL.map(|order| builder.constant_bit32(uint, order.semantics().bits()));
    let mut module = builder.module();
    for function in &mut module.functions {
        let Some((name, order)) = function.def_id().and_then(|id| orders.get(&id)) else {
            continue;
        };
        let semantics = if *order == Order::Acquire { acquire } else { release };
        let change = Change { order: *order, scope, semantics };
        let changed: usize =
            function.blocks.iter_mut().map(|block| change.apply(&mut block.instructions)).sum();
        if changed == 0 {
            let problem = format!("{name} has no atomic operation that can have its order");
            return Err(Failure::Invalid(problem));
        }
    }
    Ok(Some(module.assemble()))
}

/// The functions that ask for an order, by their number.
fn orders_of(names: &[Instruction]) -> BTreeMap<Word, (String, Order)> {
    let named = |name: &Instruction| match name.operands.as_slice() {
        [Operand::IdRef(id), Operand::LiteralString(text)] => {
            Some((*id, (text.clone(), Order::of(text)?)))
        }
        _ => None,
    };
    names.iter().filter_map(named).collect()
}

/// What operations of one function get: an order, and the numbers of the constants for it.
struct Change {
    order: Order,
    scope: Word,
    semantics: Word,
}

impl Change {
    /// Change a block, and count the operations that were changed.
    fn apply(&self, block: &mut Vec<Instruction>) -> usize {
        let barrier = || {
            let operands =
                vec![Operand::IdScope(self.scope), Operand::IdMemorySemantics(self.semantics)];
            Instruction::new(Op::MemoryBarrier, None, None, operands)
        };
        let mut changed = 0;
        for mut instruction in std::mem::take(block) {
            if !self.order.suits(instruction.class.opcode) {
                block.push(instruction);
                continue;
            }
            changed += 1;
            self.mark(&mut instruction);
            match self.order {
                Order::Acquire => block.extend([instruction, barrier()]),
                Order::Release => block.extend([barrier(), instruction]),
            }
        }
        changed
    }

    /// Operands are a pointer, the scope and the semantics; of a compare-exchange also those of a failure, which only
    /// reads.
    fn mark(&self, operation: &mut Instruction) {
        operation.operands[1] = Operand::IdScope(self.scope);
        operation.operands[2] = Operand::IdMemorySemantics(self.semantics);
        let fails = operation.class.opcode == Op::AtomicCompareExchange;
        if fails && self.order == Order::Acquire {
            operation.operands[3] = Operand::IdMemorySemantics(self.semantics);
        }
    }
}
