//! Modelled Cortex-M4F cycles of an instruction, in two variants.
//!
//! Sources: Arm Cortex-M4 Technical Reference Manual r0p1 (100166_0001), Table 3-1 and the FPU's Table 7-1, reprinted
//! in TI SWCU192 (CC13x2/CC26x2), Tables 3-25 and 3-27; pairing notes in the sections beside them; the stalls also in
//! GCC's `cortex-m4.md` and `cortex-m4-fpu.md`. All counts are for memory without wait states.

use crate::thumb::{Class, Insn};

/// Cycles in both variants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cycles {
    /// 1 an instruction, single load 2, several words 1 + N, `VMLA` 3, `VDIV` 14, integer division 12, branch 3.
    pub plain: u32,
    /// The tables' upper ends and every stall that the sources name.
    pub pessimistic: u32,
}

/// What an instruction costs by where the flow goes after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Price {
    /// The next instruction executed is the next in memory.
    pub through: Cycles,
    /// Any other is.
    pub taken: Cycles,
}

/// Pipeline refill P of the plain variant, cycles: 1 to 3 by the target's alignment and width.
const REFILL_PLAIN: u32 = 2;
/// P of the pessimistic variant.
const REFILL_PESSIMISTIC: u32 = 3;
/// B of the pessimistic variant, cycles: an `ISB` refills the pipeline; `DSB` and `DMB` drain one buffered store.
const BARRIER_PESSIMISTIC: u32 = 3;

/// Prices `insn`, followed in memory by `next` (`None` where data or the end of the code follows).
pub fn price(insn: &Insn, next: Option<&Insn>) -> Price {
    let through = base(insn);
    let stall = next.map_or(0, |next| stall(insn, next));
    let refill = |c: Cycles| Cycles {
        plain: c.plain + REFILL_PLAIN,
        pessimistic: c.pessimistic + REFILL_PESSIMISTIC,
    };
    Price {
        through: Cycles { pessimistic: through.pessimistic + stall, ..through },
        // An exception may follow any instruction: its entry is not this one's to pay.
        taken: if insn.may_branch() { refill(through) } else { through },
    }
}

/// Cycles without stalls and refill.
fn base(insn: &Insn) -> Cycles {
    let (plain, pessimistic) = match insn.class {
        Class::Alu | Class::Branch | Class::IfThen | Class::Hint => (1, 1),
        Class::Divide => (12, 12),
        // A literal may contend with the instruction fetch.
        Class::Load => (2, 2 + u32::from(insn.is_literal())),
        Class::LoadMany(n) => (1 + n, 1 + n + u32::from(insn.is_literal())),
        // The write buffer hides a store unless the next access waits for it.
        Class::Store => (1, 2),
        Class::StoreMany(n) => (1 + n, 1 + n),
        // At least two for the load and one for the addition before the refill.
        Class::TableBranch => (2, 3),
        Class::System => (1, 2),
        Class::Barrier => (1, 1 + BARRIER_PESSIMISTIC),
        Class::Float | Class::FloatMove => (1, 1),
        Class::FloatTransfer => (1, 2),
        Class::FloatMac => (3, 3),
        Class::FloatDivide | Class::FloatRoot => (14, 14),
        // A trap's own cost is its exception; an unknown one must not hide in a sum.
        Class::Trap => (1, 1),
        Class::Unknown => panic!("no price for {:04x} {:04x}", insn.hw1, insn.hw2),
    };
    Cycles { plain, pessimistic }
}

/// Cycles that `next` waits for a result of `insn`: one for a float result that arrives late, one for an address
/// that the register bank has not seen yet.
fn stall(insn: &Insn, next: &Insn) -> u32 {
    let float = insn.float_writes & next.float_reads != 0;
    let address = insn.writes & next.address & !(1 << 15) != 0;
    u32::from(float) + u32::from(address)
}
