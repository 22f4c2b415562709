//! IT blocks: which instructions they make conditional, and those that end a function under their condition.

use std::collections::BTreeMap;

use crate::flow::{Flow, flow, stack_change};
use crate::image::{Function, Image};
use crate::thumb::{Class, Insn};

/// An instruction inside an IT block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditional {
    /// First address past the block.
    end: u32,
    /// It is executed where the block's condition holds ("then"), not where it fails ("else").
    is_then: bool,
}

/// Conditional instructions of a function, by address.
pub type Conditionals = BTreeMap<u32, Conditional>;

/// Finds all instructions that IT makes conditional: one to four after each, by its mask's lowest set bit.
pub fn conditionals(image: &Image, function: &Function) -> Conditionals {
    let body = || image.code.range(function.start..function.end);
    let mut found = BTreeMap::new();
    for (&at, it) in body().filter(|(_, insn)| insn.class == Class::IfThen) {
        let mask = u32::from(it.hw1 & 15);
        let length = 4 - mask.trailing_zeros();
        let block = || image.code.range(at + it.size()..function.end).take(length as usize);
        let end = block().last().map_or(at, |(at, insn)| at + insn.size());
        // The first is always a "then"; the mask gives the others' lowest condition bit.
        let condition = u32::from(it.hw1 >> 4) & 1;
        for (n, (&at, _)) in (0u32..).zip(block()) {
            let is_then = n == 0 || mask >> (4 - n) & 1 == condition;
            found.insert(at, Conditional { end, is_then });
        }
    }
    found
}

/// Where the function goes on if the condition fails, when the rest of the block from `at`, `depth` bytes deep, pops
/// all and returns if it holds. Pops leave the flags alone, so one condition decides about all of them together.
pub fn epilogue_end(image: &Image, all: &Conditionals, at: u32, depth: u32) -> Option<u32> {
    let first = all.get(&at)?;
    let mut left = depth;
    let mut last = Flow::Next;
    for (at, insn) in image.code.range(at..first.end) {
        if last != Flow::Next || all.get(at) != Some(first) || !is_pop(insn) {
            return None;
        }
        left = left.checked_add_signed(stack_change(insn)?)?;
        last = flow(image, *at, insn, true);
    }
    (last == Flow::Return && left == 0).then_some(first.end)
}

/// Loads registers from the stack and frees their place.
fn is_pop(insn: &Insn) -> bool {
    matches!(insn.class, Class::Load | Class::LoadMany(_)) && stack_change(insn) < Some(0)
}
