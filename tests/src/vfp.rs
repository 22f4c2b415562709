//! Classifies the single-precision floating-point encodings (Armv7-M Architecture Reference Manual, A6.4 to A6.7).

use crate::thumb::{Class, Insn, reg};

/// Decodes a coprocessor instruction; anything but coprocessors 10 and 11 is unknown here.
pub(crate) fn decode(hw1: u16, hw2: u16) -> Insn {
    let is_vfp = hw2 & 0x0E00 == 0x0A00;
    match hw1 >> 8 {
        0xEC | 0xED if is_vfp && hw1 & 0xFFE0 == 0xEC40 => pair_transfer(hw1, hw2),
        0xEC | 0xED if is_vfp => memory(hw1, hw2),
        0xEE if is_vfp && hw2 & 0x10 != 0 => transfer(hw1, hw2),
        0xEE if hw2 & 0x0F00 == 0x0A00 => arithmetic(hw1, hw2),
        _ => Insn::new(hw1, hw2, Class::Unknown),
    }
}

/// `count` single registers from `first`; past S31 nothing.
fn singles(first: u32, count: u32) -> u32 {
    let mask = (1u64 << count.min(32)) - 1;
    (mask << first) as u32
}

fn sd(hw1: u16, hw2: u16) -> u32 {
    u32::from(hw2 >> 12 << 1 | hw1 >> 6 & 1)
}

fn sn(hw1: u16, hw2: u16) -> u32 {
    u32::from((hw1 & 15) << 1 | hw2 >> 7 & 1)
}

fn sm(hw2: u16) -> u32 {
    u32::from((hw2 & 15) << 1 | hw2 >> 5 & 1)
}

/// `VLDR`, `VSTR`, `VLDM`, `VSTM`, `VPUSH`, `VPOP` (A6.5); an immediate counts words, also of doubles.
fn memory(hw1: u16, hw2: u16) -> Insn {
    let is_double = hw2 & 0x0100 != 0;
    let is_single_transfer = hw1 & 0x0120 == 0x0100;
    let words = match (is_single_transfer, is_double) {
        (true, false) => 1,
        (true, true) => 2,
        (false, _) => u32::from(hw2 & 0xFE | hw2 & !(hw2 >> 8) & 1),
    };
    let first = if is_double { u32::from(hw2 >> 12) << 1 } else { sd(hw1, hw2) };
    let is_load = hw1 & 0x10 != 0;
    let class = match (is_load, is_single_transfer && !is_double) {
        (true, true) => Class::Load,
        (true, false) => Class::LoadMany(words),
        (false, true) => Class::Store,
        (false, false) => Class::StoreMany(words),
    };
    let mut insn = Insn::new(hw1, hw2, class).addressing(reg(hw1));
    if hw1 & 0x20 != 0 {
        insn.writes = reg(hw1);
    }
    if !is_load {
        insn.float_reads = singles(first, words);
    }
    insn
}

/// `VMOV` between two core registers and two singles or a double (A6.7).
fn pair_transfer(hw1: u16, hw2: u16) -> Insn {
    let mut insn = Insn::new(hw1, hw2, Class::FloatTransfer);
    let first = if hw2 & 0x0100 != 0 { u32::from(hw2 & 15) << 1 } else { sm(hw2) };
    if hw1 & 0x10 != 0 {
        insn.writes = reg(hw2 >> 12) | reg(hw1);
        insn.float_reads = singles(first, 2);
    }
    insn
}

/// `VMOV` of one word, `VMRS`, `VMSR` (A6.6).
fn transfer(hw1: u16, hw2: u16) -> Insn {
    let to_core = hw1 & 0x10 != 0;
    let is_status = hw2 & 0x0100 == 0 && hw1 & 0xE0 == 0xE0;
    let is_half_of_double = hw2 & 0x0100 != 0;
    let class =
        if is_status || is_half_of_double { Class::FloatMove } else { Class::FloatTransfer };
    let mut insn = Insn::new(hw1, hw2, class);
    // VMRS to register 15 writes the flags.
    if to_core && !(is_status && hw2 >> 12 == 15) {
        insn.writes = reg(hw2 >> 12);
    }
    if to_core && !is_status {
        insn.float_reads = if is_half_of_double {
            singles(u32::from(hw1 & 15) << 1 | u32::from(hw1 >> 5 & 1), 1)
        } else {
            singles(sn(hw1, hw2), 1)
        };
    }
    insn
}

/// Data processing (A6.4), single precision.
fn arithmetic(hw1: u16, hw2: u16) -> Insn {
    let (d, n, m) = (1 << sd(hw1, hw2), 1 << sn(hw1, hw2), 1 << sm(hw2));
    let insn = |class, writes, reads| Insn {
        float_writes: writes,
        float_reads: reads,
        ..Insn::new(hw1, hw2, class)
    };
    match hw1 >> 4 & 0b1011 {
        0b0000 | 0b0001 | 0b1001 | 0b1010 => insn(Class::FloatMac, d, n | m),
        0b0010 | 0b0011 => insn(Class::Float, d, n | m),
        0b1000 => insn(Class::FloatDivide, d, n | m),
        0b1011 if hw2 & 0x40 == 0 => insn(Class::FloatMove, 0, 0),
        0b1011 => match (hw1 & 15, hw2 & 0x80 != 0) {
            (0, _) | (1, false) => insn(Class::FloatMove, 0, m),
            (1, true) => insn(Class::FloatRoot, d, m),
            (4, _) => insn(Class::FloatMove, 0, d | m),
            (5, _) => insn(Class::FloatMove, 0, d),
            // The fixed-point conversions read and write Sd.
            (10 | 11 | 14 | 15, _) => insn(Class::Float, d, d),
            (2 | 3 | 8 | 12 | 13, _) => insn(Class::Float, d, m),
            _ => insn(Class::Unknown, 0, 0),
        },
        _ => insn(Class::Unknown, 0, 0),
    }
}
