//! Code of an ELF image: functions by symbol, instructions where the mapping symbols say that code is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::thumb::{self, Insn};

/// One function: symbols of the same address share it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// First name, demangled, without the hash.
    pub name: String,
    /// First address.
    pub start: u32,
    /// First address past it.
    pub end: u32,
}

/// An image's code.
pub struct Image {
    /// Where it was read from.
    pub path: PathBuf,
    /// Instructions by address.
    pub code: BTreeMap<u32, Insn>,
    /// Functions by first address.
    pub functions: BTreeMap<u32, Function>,
    /// Every name that the image defines, demangled, with its address.
    pub symbols: Vec<(u32, String)>,
    /// Handlers in the vector table: Reset first, then each distinct exception in its order.
    pub vectors: Vec<u32>,
    bytes: BTreeMap<u32, u8>,
}

impl Image {
    /// Reads an ELF file.
    pub fn open(path: &Path) -> Result<Self, String> {
        let data = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let elf = object::File::parse(&*data).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut image = Self {
            path: path.to_path_buf(),
            code: BTreeMap::new(),
            functions: functions(&elf),
            symbols: symbols(&elf),
            vectors: Vec::new(),
            bytes: BTreeMap::new(),
        };
        for section in elf.sections() {
            let bytes = section.data().map_err(|e| e.to_string())?;
            let start = section.address() as u32;
            if section.kind() == SectionKind::Text {
                image.bytes.extend((start..).zip(bytes.iter().copied()));
                image.code.extend(instructions(&elf, start, bytes));
            }
            if section.name() == Ok(".vector_table") {
                image.vectors = vectors(bytes);
            }
        }
        Ok(image)
    }

    /// The function that holds `address`.
    pub fn function_at(&self, address: u32) -> Option<&Function> {
        self.functions.range(..=address).next_back().map(|(_, f)| f).filter(|f| address < f.end)
    }

    /// The one function whose demangled name contains `part`.
    pub fn function_named(&self, part: &str) -> Result<&Function, String> {
        let mut found = self.functions.values().filter(|f| f.name.contains(part));
        match (found.next(), found.next()) {
            (Some(one), None) => Ok(one),
            (None, _) => Err(format!("no function is called {part}")),
            (Some(a), Some(b)) => Err(format!("{part} may be {} or {}", a.name, b.name)),
        }
    }

    /// Little-endian halfword of a text section.
    pub fn halfword(&self, address: u32) -> Option<u16> {
        Some(u16::from_le_bytes([*self.bytes.get(&address)?, *self.bytes.get(&(address + 1))?]))
    }

    /// Byte of a text section.
    pub fn byte(&self, address: u32) -> Option<u8> {
        self.bytes.get(&address).copied()
    }
}

/// `$t` opens code, `$d` data (ELF for the Arm Architecture, mapping symbols).
fn instructions(elf: &object::File, start: u32, bytes: &[u8]) -> Vec<(u32, Insn)> {
    let end = start + bytes.len() as u32;
    let mut marks: Vec<(u32, bool)> = elf
        .symbols()
        .filter_map(|s| {
            let name = s.name().ok()?;
            let at = s.address() as u32;
            let kind = name.get(..2)?;
            ((start..end).contains(&at) && matches!(kind, "$t" | "$d"))
                .then_some((at, kind == "$t"))
        })
        .collect();
    marks.sort_unstable();
    let ends = marks.iter().skip(1).map(|m| m.0).chain([end]).collect::<Vec<_>>();
    let mut found = Vec::new();
    for (&(mut at, is_code), stop) in marks.iter().zip(ends) {
        let half = |at: u32| {
            let i = (at - start) as usize;
            bytes.get(i..i + 2).map_or(0, |b| u16::from_le_bytes([b[0], b[1]]))
        };
        while is_code && at < stop {
            let hw1 = half(at);
            let insn = thumb::decode(hw1, if thumb::is_wide(hw1) { half(at + 2) } else { 0 });
            found.push((at, insn));
            at += insn.size();
        }
    }
    found
}

/// Names of code and data, without mapping symbols.
fn symbols(elf: &object::File) -> Vec<(u32, String)> {
    elf.symbols()
        .filter(|s| s.is_definition())
        .filter_map(|s| Some((s.address() as u32 & !1, s.name().ok()?)))
        .filter(|(_, name)| !name.is_empty() && !name.starts_with('$'))
        .map(|(at, name)| (at, format!("{:#}", addr2line::demangle_auto(name.into(), None))))
        .collect()
}

/// Function symbols; one without a size (assembly) reaches to the next.
fn functions(elf: &object::File) -> BTreeMap<u32, Function> {
    let mut found: BTreeMap<u32, Function> = BTreeMap::new();
    for symbol in elf.symbols().filter(|s| s.kind() == SymbolKind::Text && s.is_definition()) {
        let start = symbol.address() as u32 & !1;
        let name = symbol.name().unwrap_or_default();
        if name.starts_with('$') {
            continue;
        }
        let name = format!("{:#}", addr2line::demangle_auto(name.into(), None));
        let end = start + symbol.size() as u32;
        let entry = found.entry(start).or_insert(Function { name: name.clone(), start, end });
        entry.end = entry.end.max(end);
    }
    let starts: Vec<u32> = found.keys().copied().skip(1).collect();
    let last = elf
        .sections()
        .filter(|s| s.kind() == SectionKind::Text)
        .map(|s| (s.address() + s.size()) as u32)
        .max()
        .unwrap_or(0);
    for (f, next) in found.values_mut().zip(starts.into_iter().chain([last])) {
        if f.end == f.start {
            f.end = next;
        }
    }
    found
}

/// Word 0 is the stack, the others are handlers with the Thumb bit, 0 where reserved.
fn vectors(table: &[u8]) -> Vec<u32> {
    let mut handlers = Vec::new();
    for word in table.chunks_exact(4).skip(1) {
        let at = u32::from_le_bytes([word[0], word[1], word[2], word[3]]) & !1;
        if at != 0 && !handlers.contains(&at) {
            handlers.push(at);
        }
    }
    handlers
}
