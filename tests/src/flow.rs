//! Where an instruction goes next and what it does to the stack pointer, for the stack bound.

use crate::image::Image;
use crate::thumb::{Class, Insn};

/// Continuation of an instruction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Only the next instruction.
    Next,
    /// Only these addresses.
    Jump(Vec<u32>),
    /// The next instruction or this address.
    Either(u32),
    /// A call of this address, then the next instruction.
    Call(u32),
    /// A call through a register, then the next instruction.
    CallRegister,
    /// A jump through a register or a table that could not be read.
    JumpRegister,
    /// Back to the caller; under an IT condition also the next instruction.
    Return,
    /// Nowhere.
    Stop,
}

/// Sign extension of the low `bits` of `value`.
fn signed(value: u32, bits: u32) -> u32 {
    ((value << (32 - bits)) as i32 >> (32 - bits)) as u32
}

/// Continuation of `insn` at `at`; `in_it` tells that an IT block makes it conditional.
pub fn flow(image: &Image, at: u32, insn: &Insn, in_it: bool) -> Flow {
    let pc = at + 4;
    let (hw1, hw2) = (u32::from(insn.hw1), u32::from(insn.hw2));
    let jump = |offset: u32| {
        let target = pc.wrapping_add(offset);
        if in_it { Flow::Either(target) } else { Flow::Jump(vec![target]) }
    };
    match insn.class {
        Class::Trap if hw1 >> 8 == 0xDE || hw1 >> 8 == 0xF7 => Flow::Stop,
        Class::TableBranch => table(image, at, insn).map_or(Flow::JumpRegister, Flow::Jump),
        Class::Branch if insn.size() == 4 => wide_branch(pc, hw1, hw2, in_it),
        Class::Branch => match hw1 >> 11 {
            0b11100 => jump(signed(hw1 << 1, 12)),
            0b11010 | 0b11011 => Flow::Either(pc.wrapping_add(signed(hw1 << 1, 9))),
            0b10110 | 0b10111 => Flow::Either(pc + (hw1 >> 3 & 0x40 | hw1 >> 2 & 0x3E)),
            _ if hw1 & 0x80 != 0 => Flow::CallRegister,
            _ if hw1 >> 3 & 15 == 14 => Flow::Return,
            _ => Flow::JumpRegister,
        },
        // POP, LDM and LDR from the stack return; any other write of the counter is a jump.
        _ if insn.may_branch() && insn.address == 1 << 13 => Flow::Return,
        _ if insn.may_branch() => Flow::JumpRegister,
        _ => Flow::Next,
    }
}

/// Encodings T3 and T4 of B, and BL.
fn wide_branch(pc: u32, hw1: u32, hw2: u32, in_it: bool) -> Flow {
    let (sign, j1, j2) = (hw1 >> 10 & 1, hw2 >> 13 & 1, hw2 >> 11 & 1);
    if hw2 & 0x1000 == 0 {
        let offset = sign << 20 | j2 << 19 | j1 << 18 | (hw1 & 0x3F) << 12 | (hw2 & 0x7FF) << 1;
        return Flow::Either(pc.wrapping_add(signed(offset, 21)));
    }
    let (i1, i2) = (!(j1 ^ sign) & 1, !(j2 ^ sign) & 1);
    let offset = sign << 24 | i1 << 23 | i2 << 22 | (hw1 & 0x3FF) << 12 | (hw2 & 0x7FF) << 1;
    let target = pc.wrapping_add(signed(offset, 25));
    match (hw2 & 0x4000 != 0, in_it) {
        (true, _) => Flow::Call(target),
        (false, true) => Flow::Either(target),
        (false, false) => Flow::Jump(vec![target]),
    }
}

/// 16-bit NOP, the padding of tables of halfwords.
const NOP: u32 = 0xBF00;

/// Targets of TBB and TBH on the program counter. The table reaches to the next code, less its padding: a zero byte,
/// which would be a jump into the table itself, and a NOP, whose first byte is zero.
fn table(image: &Image, at: u32, insn: &Insn) -> Option<Vec<u32>> {
    if insn.hw1 & 15 != 15 {
        return None;
    }
    let base = at + 4;
    let end = *image.code.range(base..).next()?.0;
    let is_half = insn.hw2 & 0x10 != 0;
    let mut targets: Vec<u32> = (base..end)
        .step_by(if is_half { 2 } else { 1 })
        .filter_map(|a| match is_half {
            true => image.halfword(a).map(u32::from),
            false => image.byte(a).map(u32::from),
        })
        .take_while(|entry| *entry != 0 && *entry != NOP)
        .map(|entry| base + 2 * entry)
        .filter(|target| image.code.contains_key(target))
        .collect();
    targets.sort_unstable();
    targets.dedup();
    Some(targets)
}

/// Bytes that `insn` adds to the stack's depth; `None` where the amount is not in the encoding.
pub fn stack_change(insn: &Insn) -> Option<i32> {
    let (hw1, hw2) = (insn.hw1, insn.hw2);
    let low7 = i32::from(hw1 & 0x7F) * 4;
    let imm8 = i32::from(hw2 & 0xFF);
    let sets_stack_register = hw1 & 0xFFE0 == 0xF380 && matches!(hw2 & 0xFF, 8 | 9);
    if insn.writes & 1 << 13 == 0 && !sets_stack_register {
        return Some(0);
    }
    let wide = insn.size() == 4;
    match insn.class {
        Class::Alu if hw1 & 0xFF80 == 0xB080 => Some(low7),
        Class::Alu if hw1 & 0xFF80 == 0xB000 => Some(-low7),
        Class::Alu if wide && hw1 & 0xFBEF == 0xF1AD => Some(modified_immediate(hw1, hw2) as i32),
        Class::Alu if wide && hw1 & 0xFBEF == 0xF10D => {
            Some(-(modified_immediate(hw1, hw2) as i32))
        }
        Class::Alu if wide && hw1 & 0xFBFF == 0xF2AD => Some(plain_immediate(hw1, hw2)),
        Class::Alu if wide && hw1 & 0xFBFF == 0xF20D => Some(-plain_immediate(hw1, hw2)),
        // Only writeback changes the base; a pop into the stack pointer itself is dynamic.
        Class::StoreMany(_) | Class::LoadMany(_) if wide && hw1 & 0xFE40 == 0xE840 => {
            Some(if hw1 & 0x80 == 0 { 4 * imm8 } else { -4 * imm8 })
        }
        Class::StoreMany(n) if !wide || hw1 == 0xE92D || hw1 & 0xFFBF == 0xED2D => {
            Some(4 * n as i32)
        }
        Class::LoadMany(n) if !wide || hw1 == 0xE8BD || hw1 & 0xFFBF == 0xECBD => {
            Some(-4 * n as i32)
        }
        Class::Store | Class::Load if hw2 >> 12 != 13 && hw2 & 0x0900 == 0x0900 => {
            Some(if hw2 & 0x0200 == 0 { imm8 } else { -imm8 })
        }
        _ => None,
    }
}

/// ThumbExpandImm of i:imm3:imm8 (A5.3.2).
fn modified_immediate(hw1: u16, hw2: u16) -> u32 {
    let imm12 = plain_immediate(hw1, hw2) as u32;
    let byte = imm12 & 0xFF;
    match imm12 >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (byte | 0x80).rotate_right(imm12 >> 7),
    }
}

/// i:imm3:imm8.
fn plain_immediate(hw1: u16, hw2: u16) -> i32 {
    i32::from((hw1 & 0x400) << 1 | hw2 >> 4 & 0x700 | hw2 & 0xFF)
}
