//! Classifies Thumb-2 encodings of ARMv7E-M (Armv7-M Architecture Reference Manual, chapter A5) by what their time
//! depends on: the kind of work, how many words they move, and the registers that a following instruction may wait for.

use crate::vfp;

/// Kind of an instruction as the cycle tables tell them apart; word counts are 32-bit registers moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// Data processing, multiplication included (one cycle each on this core).
    Alu,
    /// `SDIV`, `UDIV`.
    Divide,
    /// One word or less from memory, exclusives and `VLDR` of a single included.
    Load,
    /// `LDRD`, `LDM`, `POP`, `VLDM`, `VPOP`, `VLDR` of a double.
    LoadMany(u32),
    /// One word or less to memory, exclusives and `VSTR` of a single included.
    Store,
    /// `STRD`, `STM`, `PUSH`, `VSTM`, `VPUSH`, `VSTR` of a double.
    StoreMany(u32),
    /// `B`, `BL`, `BX`, `BLX`, `CBZ`, `CBNZ`.
    Branch,
    /// `TBB`, `TBH`.
    TableBranch,
    /// `IT`.
    IfThen,
    /// `NOP`, `SEV`, `YIELD`, `WFI`, `WFE`, `CLREX`.
    Hint,
    /// `MRS`, `MSR`, `CPS`.
    System,
    /// `DSB`, `DMB`, `ISB`.
    Barrier,
    /// `SVC`, `BKPT`, `UDF`.
    Trap,
    /// Float arithmetic of one cycle whose result arrives one cycle late: add, subtract, multiply, convert.
    Float,
    /// Float moves, sign changes and comparisons.
    FloatMove,
    /// A float or a double between core and float registers.
    FloatTransfer,
    /// `VMLA`, `VMLS`, `VFMA`, `VFMS` and their negated forms.
    FloatMac,
    /// `VDIV`.
    FloatDivide,
    /// `VSQRT`.
    FloatRoot,
    /// Not an instruction of an ARMv7E-M with the single-precision unit.
    Unknown,
}

/// One decoded instruction. Core register sets have bit n for Rn, float register sets bit n for Sn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Insn {
    /// First halfword.
    pub hw1: u16,
    /// Second halfword; 0 in a 16-bit instruction.
    pub hw2: u16,
    /// Kind.
    pub class: Class,
    /// Core registers written.
    pub writes: u16,
    /// Core registers that form a load's or store's address.
    pub address: u16,
    /// Float registers written by arithmetic.
    pub float_writes: u32,
    /// Float registers read, but for the addend of a multiply-accumulate, which is wanted one cycle later.
    pub float_reads: u32,
}

impl Insn {
    pub(crate) fn new(hw1: u16, hw2: u16, class: Class) -> Self {
        Self { hw1, hw2, class, writes: 0, address: 0, float_writes: 0, float_reads: 0 }
    }

    fn writing(mut self, registers: u16) -> Self {
        self.writes |= registers;
        self
    }

    pub(crate) fn addressing(mut self, registers: u16) -> Self {
        self.address |= registers;
        self
    }

    /// Size, bytes.
    pub fn size(&self) -> u32 {
        if is_wide(self.hw1) { 4 } else { 2 }
    }

    /// Whether it is relative to the program counter and reads memory (a literal).
    pub fn is_literal(&self) -> bool {
        self.address & 1 << 15 != 0
    }

    /// Whether it is a branch with a condition of its own (not one from an IT block).
    pub fn is_conditional_branch(&self) -> bool {
        self.class == Class::Branch
            && match self.hw1 >> 12 {
                0b1011 | 0b1101 => true,
                0b1111 => self.hw2 & 0x5000 == 0,
                _ => false,
            }
    }

    /// Whether it may change the flow: a branch, or a write to the program counter.
    pub fn may_branch(&self) -> bool {
        matches!(self.class, Class::Branch | Class::TableBranch) || self.writes & 1 << 15 != 0
    }
}

/// Whether a first halfword opens a 32-bit instruction (A5.1).
pub fn is_wide(hw1: u16) -> bool {
    hw1 >> 11 >= 0b11101
}

/// Decodes one instruction; `hw2` is ignored where `hw1` is a whole instruction.
pub fn decode(hw1: u16, hw2: u16) -> Insn {
    if is_wide(hw1) { wide(hw1, hw2) } else { narrow(hw1) }
}

/// The set of register `n`.
pub(crate) fn reg(n: u16) -> u16 {
    1 << (n & 15)
}

/// 16-bit instructions (A5.2).
fn narrow(hw: u16) -> Insn {
    let insn = |class| Insn::new(hw, 0, class);
    let (low, middle, high) = (reg(hw & 7), reg(hw >> 3 & 7), reg(hw >> 8 & 7));
    let memory = |is_load: bool, rt: u16, address: u16| {
        if is_load {
            insn(Class::Load).writing(rt).addressing(address)
        } else {
            insn(Class::Store).addressing(address)
        }
    };
    let list = u32::from(hw & 0xFF).count_ones();
    match hw >> 11 {
        0b00000..=0b00011 => insn(Class::Alu).writing(low),
        0b00101 => insn(Class::Alu),
        0b00100 | 0b00110 | 0b00111 => insn(Class::Alu).writing(high),
        0b01000 if hw & 0x0400 == 0 => match hw >> 6 & 15 {
            8 | 10 | 11 => insn(Class::Alu),
            _ => insn(Class::Alu).writing(low),
        },
        0b01000 => match hw >> 8 & 3 {
            3 => insn(Class::Branch),
            1 => insn(Class::Alu),
            _ => insn(Class::Alu).writing(reg(hw & 7 | hw >> 4 & 8)),
        },
        0b01001 => memory(true, high, reg(15)),
        0b01010 | 0b01011 => memory(hw >> 9 & 7 > 2, low, middle | reg(hw >> 6 & 7)),
        0b01100..=0b10001 => memory(hw & 0x0800 != 0, low, middle),
        0b10010 | 0b10011 => memory(hw & 0x0800 != 0, high, reg(13)),
        0b10100 | 0b10101 => insn(Class::Alu).writing(high),
        0b10110 | 0b10111 => narrow_misc(hw),
        0b11000 => insn(Class::StoreMany(list)).writing(high).addressing(high),
        0b11001 => insn(Class::LoadMany(list)).writing(high | hw & 0xFF).addressing(high),
        0b11010 | 0b11011 if hw >> 9 & 7 == 7 => insn(Class::Trap),
        _ => insn(Class::Branch),
    }
}

/// Miscellaneous 16-bit instructions (A5.2.5).
fn narrow_misc(hw: u16) -> Insn {
    let insn = |class| Insn::new(hw, 0, class);
    let words = u32::from(hw & 0x1FF).count_ones();
    match hw >> 8 & 15 {
        0 => insn(Class::Alu).writing(reg(13)),
        1 | 3 | 9 | 11 => insn(Class::Branch),
        2 | 10 => insn(Class::Alu).writing(reg(hw & 7)),
        4 | 5 => insn(Class::StoreMany(words)).writing(reg(13)).addressing(reg(13)),
        6 => insn(Class::System),
        12 | 13 => insn(Class::LoadMany(words))
            .writing(reg(13) | hw & 0xFF | (hw & 0x100) << 7)
            .addressing(reg(13)),
        14 => insn(Class::Trap),
        15 if hw & 15 == 0 => insn(Class::Hint),
        15 => insn(Class::IfThen),
        _ => insn(Class::Unknown),
    }
}

/// 32-bit instructions (A5.3).
fn wide(hw1: u16, hw2: u16) -> Insn {
    let alu = Insn::new(hw1, hw2, Class::Alu);
    let rd = hw2 >> 8 & 15;
    match hw1 >> 8 {
        0xE8 | 0xE9 if hw1 & 0x40 == 0 => multiple(hw1, hw2),
        0xE8 | 0xE9 => dual_or_exclusive(hw1, hw2),
        0xEC..=0xEF => vfp::decode(hw1, hw2),
        0xF0..=0xF7 if hw2 & 0x8000 != 0 => control(hw1, hw2),
        0xF8 | 0xF9 => single(hw1, hw2),
        0xFB if hw1 & 0xD0 == 0x90 && hw2 & 0xF0 == 0xF0 => {
            Insn { class: Class::Divide, ..alu }.writing(reg(rd))
        }
        0xFB if hw1 & 0x80 != 0 => alu.writing(reg(rd) | reg(hw2 >> 12)),
        // Rd = 15 makes TST, TEQ, CMN and CMP of AND, EOR, ADD and SUB.
        0xEA | 0xEB | 0xF0..=0xF7 | 0xFA | 0xFB if rd == 15 => alu,
        0xEA | 0xEB | 0xF0..=0xF7 | 0xFA | 0xFB => alu.writing(reg(rd)),
        _ => Insn { class: Class::Unknown, ..alu },
    }
}

/// Load and store multiple (A5.3.5).
fn multiple(hw1: u16, hw2: u16) -> Insn {
    let base = reg(hw1);
    let back = if hw1 & 0x20 != 0 { base } else { 0 };
    let n = hw2.count_ones();
    if hw1 & 0x10 != 0 {
        Insn::new(hw1, hw2, Class::LoadMany(n)).writing(hw2 | back).addressing(base)
    } else {
        Insn::new(hw1, hw2, Class::StoreMany(n)).writing(back).addressing(base)
    }
}

/// Load and store dual and exclusive, table branch (A5.3.6).
fn dual_or_exclusive(hw1: u16, hw2: u16) -> Insn {
    let base = reg(hw1);
    let insn = |class| Insn::new(hw1, hw2, class).addressing(base);
    let is_load = hw1 & 0x10 != 0;
    if hw1 & 0x0120 == 0 {
        return match (is_load, hw1 & 0x80 != 0, hw2 >> 4 & 15) {
            (true, true, 0 | 1) => insn(Class::TableBranch).addressing(reg(hw2)),
            (true, ..) => insn(Class::Load).writing(reg(hw2 >> 12)),
            // STREX holds the status register in bits 11:8, STREXB and STREXH in bits 3:0.
            (false, false, _) => insn(Class::Store).writing(reg(hw2 >> 8)),
            (false, true, _) => insn(Class::Store).writing(reg(hw2)),
        };
    }
    let back = if hw1 & 0x20 != 0 { base } else { 0 };
    if is_load {
        insn(Class::LoadMany(2)).writing(reg(hw2 >> 12) | reg(hw2 >> 8) | back)
    } else {
        insn(Class::StoreMany(2)).writing(back)
    }
}

/// Load and store of one word, halfword or byte (A5.3.7 to A5.3.10).
fn single(hw1: u16, hw2: u16) -> Insn {
    let base = reg(hw1);
    let has_index = hw1 & 0x80 == 0 && hw2 & 0x0FC0 == 0 && hw1 & 15 != 15;
    let address = base | if has_index { reg(hw2) } else { 0 };
    let has_writeback = hw1 & 0x80 == 0 && hw2 & 0x0900 == 0x0900 && hw1 & 15 != 15;
    let back = if has_writeback { base } else { 0 };
    let rt = reg(hw2 >> 12);
    if hw1 & 0x10 == 0 {
        return Insn::new(hw1, hw2, Class::Store).writing(back).addressing(address);
    }
    // A byte or halfword load to the program counter is a preload hint.
    let is_hint = rt == reg(15) && hw1 & 0x60 != 0x40;
    let written = if is_hint { 0 } else { rt };
    Insn::new(hw1, hw2, Class::Load).writing(written | back).addressing(address)
}

/// Branches and miscellaneous control (A5.3.4).
fn control(hw1: u16, hw2: u16) -> Insn {
    let insn = |class| Insn::new(hw1, hw2, class);
    if hw2 & 0x5000 != 0 || hw1 >> 7 & 7 != 7 {
        return insn(Class::Branch);
    }
    match hw1 >> 4 & 0x7F {
        0x38 | 0x39 => insn(Class::System),
        0x3A if hw2 & 0x0700 != 0 => insn(Class::System),
        0x3A => insn(Class::Hint),
        0x3B if hw2 & 0x00F0 == 0x0020 => insn(Class::Hint),
        0x3B => insn(Class::Barrier),
        0x3E | 0x3F => insn(Class::System).writing(reg(hw2 >> 8)),
        0x7F => insn(Class::Trap),
        _ => insn(Class::Unknown),
    }
}
