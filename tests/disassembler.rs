//! The decoder against an independent disassembler: over an image, and over encodings drawn at random.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use tests::flow::{Flow, flow, stack_change};
use tests::image::Image;
use tests::thumb::{self, Class, Insn};

fn demo() -> Image {
    tests::board::open("demo")
}

/// Address and text of each instruction.
fn disassemble(path: &Path, options: &[&str]) -> Vec<(u32, String)> {
    let output = Command::new("llvm-objdump")
        .args(["--no-show-raw-insn", "--mcpu=cortex-m4"])
        .args(options)
        .arg(path)
        .output()
        .expect("llvm-objdump");
    let line = |line: &str| {
        let (at, text) = line.split_once(':')?;
        let at = u32::from_str_radix(at.trim(), 16).ok()?;
        let text = text.split('@').next()?.trim().replace('\t', " ");
        let is_code = !text.is_empty()
            && !text.contains(".word")
            && !text.contains(".short")
            && !text.contains(".byte")
            && !text.contains("<unknown>")
            && !text.contains("<und>");
        is_code.then_some((at, text))
    };
    String::from_utf8_lossy(&output.stdout).lines().filter_map(line).collect()
}

fn is_conditioned(name: &str, stem: &str) -> bool {
    let conditions =
        ["", "eq", "ne", "hs", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];
    name.strip_prefix(stem).is_some_and(|rest| conditions.contains(&rest))
}

/// Words of a register list.
fn listed(operands: &str) -> u32 {
    let list = operands.split_once('{').map_or("", |(_, l)| l);
    list.split(',').map(|r| if r.trim().starts_with('d') { 2 } else { 1 }).sum()
}

/// Class by the mnemonic.
fn class_of(text: &str) -> Class {
    let (mnemonic, operands) = text.split_once(' ').unwrap_or((text, ""));
    let name = mnemonic.split('.').next().unwrap_or_default();
    let is_any = |stems: &[&str]| stems.iter().any(|stem| is_conditioned(name, stem));
    let starts = |stems: &[&str]| stems.iter().any(|stem| name.starts_with(stem));
    let is_double = operands.starts_with('d');
    if name.starts_with('v') {
        return match () {
            _ if starts(&["vldr"]) && is_double => Class::LoadMany(2),
            _ if starts(&["vldr"]) => Class::Load,
            _ if starts(&["vstr"]) && is_double => Class::StoreMany(2),
            _ if starts(&["vstr"]) => Class::Store,
            _ if starts(&["vldm", "vpop"]) => Class::LoadMany(listed(operands)),
            _ if starts(&["vstm", "vpush"]) => Class::StoreMany(listed(operands)),
            _ if starts(&["vml", "vfm", "vnml", "vfnm"]) => Class::FloatMac,
            _ if starts(&["vdiv"]) => Class::FloatDivide,
            _ if starts(&["vsqrt"]) => Class::FloatRoot,
            _ if starts(&["vmrs", "vmsr", "vabs", "vneg", "vcmp"]) => Class::FloatMove,
            _ if starts(&["vmov"]) && !mnemonic.contains(".32") && has_core(operands) => {
                Class::FloatTransfer
            }
            _ if starts(&["vmov"]) => Class::FloatMove,
            _ if starts(&["vadd", "vsub", "vmul", "vnmul", "vcvt"]) => Class::Float,
            _ => Class::Unknown,
        };
    }
    match () {
        _ if starts(&["it"]) => Class::IfThen,
        _ if starts(&["tb"]) => Class::TableBranch,
        _ if is_any(&["b", "bl", "bx", "blx", "cbz", "cbnz"]) => Class::Branch,
        _ if starts(&["ldrd"]) => Class::LoadMany(2),
        _ if starts(&["strd"]) => Class::StoreMany(2),
        _ if starts(&["ldr", "pld", "pli"]) => Class::Load,
        _ if starts(&["str"]) => Class::Store,
        _ if starts(&["ldm", "pop"]) => Class::LoadMany(listed(operands)),
        _ if starts(&["stm", "push"]) => Class::StoreMany(listed(operands)),
        _ if starts(&["sdiv", "udiv"]) => Class::Divide,
        _ if is_any(&["nop", "sev", "wfi", "wfe", "yield", "clrex", "hint", "dbg"]) => Class::Hint,
        _ if starts(&["mrs", "msr", "cps"]) => Class::System,
        _ if is_any(&["dsb", "dmb", "isb"]) => Class::Barrier,
        _ if starts(&["svc", "bkpt", "udf", "trap", "__brkdiv0"]) => Class::Trap,
        _ if starts(&["cdp", "mcr", "mrc", "mrrc", "ldc", "stc"]) => Class::Unknown,
        _ => Class::Alu,
    }
}

fn has_core(operands: &str) -> bool {
    operands.split(',').any(|o| ["r", "sp", "lr", "pc"].iter().any(|p| o.trim().starts_with(p)))
}

/// The register that a data processing or load instruction's text names as its destination, where the decoder's
/// stalls depend on it.
fn float_destination(text: &str, class: Class) -> Option<u32> {
    let is_arithmetic =
        matches!(class, Class::Float | Class::FloatMac | Class::FloatDivide | Class::FloatRoot);
    let operands = text.split_once(' ')?.1;
    let first = operands.split(',').next()?.trim().strip_prefix('s')?;
    if is_arithmetic { Some(1 << first.parse::<u32>().ok()?) } else { None }
}

/// Core registers inside the brackets of an address.
fn address_registers(text: &str) -> Option<u16> {
    let inside = text.split_once('[')?.1.split_once(']')?.0;
    let number = |name: &str| match name.trim() {
        "sp" => Some(13),
        "lr" => Some(14),
        "pc" => Some(15),
        r => r.strip_prefix('r')?.parse::<u16>().ok(),
    };
    Some(inside.split(',').filter_map(number).fold(0, |set, n| set | 1 << n))
}

/// Bytes that the text adds to the stack's depth, where it names the stack pointer as a constant's base or a list's.
fn stack_change_of(text: &str) -> Option<i32> {
    let (mnemonic, operands) = text.split_once(' ')?;
    let words = 4 * listed(operands) as i32;
    let name = mnemonic.trim_end_matches(".w");
    let constant = |s: &str| s.trim_start_matches(", ").strip_prefix('#')?.parse::<i32>().ok();
    let own = operands.strip_prefix("sp, ").map(|o| o.strip_prefix("sp, ").unwrap_or(o));
    match name {
        "push" | "vpush" => Some(words),
        "pop" | "vpop" => Some(-words),
        "stmdb" | "vstmdb" if operands.starts_with("sp!") => Some(words),
        "ldm" | "vldmia" if operands.starts_with("sp!") => Some(-words),
        "sub" | "subw" => constant(own?),
        "add" | "addw" => constant(own?).map(|c| -c),
        _ if operands.ends_with("]!") => {
            constant(operands.split_once("[sp")?.1.trim_end_matches("]!")).map(|c| -c)
        }
        _ => constant(operands.split_once("[sp],")?.1.trim()).map(|c| -c),
    }
}

/// Target that a direct branch's text names.
fn target_of(text: &str) -> Option<u32> {
    let at = text.split_once("0x")?.1;
    u32::from_str_radix(at.split_whitespace().next()?, 16).ok()
}

fn target(image: &Image, at: u32, insn: &Insn) -> Option<u32> {
    match flow(image, at, insn, false) {
        Flow::Jump(targets) if insn.class == Class::Branch => targets.first().copied(),
        Flow::Either(target) | Flow::Call(target) => Some(target),
        _ => None,
    }
}

/// What the text says and the decoder does not.
fn disagreement(image: &Image, at: u32, text: &str, insn: &Insn) -> Option<String> {
    let class = class_of(text);
    let float = float_destination(text, class).unwrap_or(0);
    if class == Class::Unknown {
        return (insn.class != class).then(|| format!("{at:#x} {text}: {insn:x?}"));
    }
    // A lane of a double also prints in brackets.
    let has_address = !text.starts_with("vmov");
    let address = if has_address { address_registers(text) } else { None };
    let is_direct = class == Class::Branch && text.contains("0x");
    let agrees = class == insn.class
        && float == insn.float_writes
        && address.is_none_or(|set| set == insn.address)
        && (!is_direct || target_of(text) == target(image, at, insn))
        && stack_change_of(text).is_none_or(|bytes| stack_change(insn) == Some(bytes));
    (!agrees).then(|| {
        let target = target(image, at, insn);
        format!("{at:#x} {text}: {insn:x?} to {target:x?} stack {:?}", stack_change(insn))
    })
}

#[test]
fn every_instruction_of_an_image_agrees() {
    let image = demo();
    let mut seen: BTreeMap<String, u32> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (at, text) in disassemble(&image.path, &["-d"]) {
        let insn = image.code.get(&at).unwrap_or_else(|| panic!("{at:#x} {text} is not decoded"));
        *seen.entry(format!("{:?}", insn.class)).or_default() += 1;
        wrong.extend(disagreement(&image, at, &text, insn));
    }
    println!("{seen:?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What the manual leaves undefined and the disassembler prints in its own way: float lists that are empty, reach past
/// the last register, or hold an odd number of words of doubles (FLDMX, FSTMX).
fn is_unpredictable(hw1: u16, hw2: u16) -> bool {
    let is_list = hw1 >> 9 == 0x76 && hw2 & 0x0E00 == 0x0A00 && hw1 & 0x0120 != 0x0100;
    let is_double = hw2 & 0x0100 != 0;
    let (vd, d, count) = (hw2 >> 12, hw1 >> 6 & 1, hw2 & 0xFF);
    let first = if is_double { vd * 2 + d * 32 } else { vd * 2 + d };
    let is_past_end = count == 0 || first + count > 32 || is_double && count % 2 != 0;
    // A load of the stack pointer that also writes it back.
    let is_double_write = hw1 == 0xF85D && hw2 >> 12 == 13 && hw2 & 0x0900 == 0x0900;
    is_list && is_past_end || is_double_write
}

/// All 16-bit encodings and a draw of 32-bit ones, each followed by NOPs so that a refusal cannot shift the next.
#[test]
fn encodings_drawn_at_random_agree() {
    const NOP: u16 = 0xBF00;
    let mut seed = 1u64;
    let mut draw = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as u16
    };
    let narrow = (0..0xE800u16).map(|hw| (hw, NOP));
    let wide: Vec<_> = (0..200_000).map(|_| (draw() % 0x1800 + 0xE800, draw())).collect();
    let slots: Vec<(u16, u16)> = narrow.chain(wide).collect();
    let bytes: Vec<u8> =
        slots.iter().flat_map(|&(a, b)| [a, b, NOP, NOP]).flat_map(u16::to_le_bytes).collect();
    let image = demo();
    let folder = tempfile::tempdir().expect("folder");
    let (raw, elf) = (folder.path().join("raw"), folder.path().join("elf"));
    std::fs::write(&raw, bytes).expect("raw");
    let status = Command::new("llvm-objcopy")
        .args(["-I", "binary", "-O", "elf32-littlearm"])
        .args([&raw, &elf])
        .status();
    assert!(status.expect("llvm-objcopy").success());

    let mut wrong = BTreeSet::new();
    let mut compared = 0;
    for (at, text) in disassemble(&elf, &["-D", "-j", ".data", "--triple=thumbv7em-none-eabihf"]) {
        let (hw1, hw2) = slots[at as usize / 8];
        if at % 8 != 0 || is_unpredictable(hw1, hw2) {
            continue;
        }
        compared += 1;
        wrong.extend(disagreement(&image, at, &text, &thumb::decode(hw1, hw2)));
    }
    println!("{compared} compared");
    assert!(compared > 60_000);
    assert!(wrong.is_empty(), "{} {:#?}", wrong.len(), wrong.iter().take(40).collect::<Vec<_>>());
}
