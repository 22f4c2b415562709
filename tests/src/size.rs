//! What an image occupies, by the flags of its sections.

use std::path::Path;

use object::elf::{SHF_ALLOC, SHF_EXECINSTR, SHF_WRITE};
use object::{Object, ObjectSection, SectionFlags, SectionKind};

/// Memory, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Code with the constants between it.
    pub text: u32,
    /// Constants, the vector table and what initialises variables.
    pub rodata: u32,
    /// Variables, without the stack.
    pub static_ram: u32,
}

impl Sizes {
    /// Sizes of the ELF file at `path`.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn of(path: &Path) -> Result<Self, String> {
        let data = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let elf = object::File::parse(&*data).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut sizes = Self::default();
        for section in elf.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
            let is = |flag: u32| sh_flags & u64::from(flag) != 0;
            let bytes = section.size() as u32;
            if !is(SHF_ALLOC) {
                continue;
            }
            if is(SHF_EXECINSTR) {
                sizes.text += bytes;
            } else if is(SHF_WRITE) {
                sizes.static_ram += bytes;
                let is_loaded = section.kind() != SectionKind::UninitializedData;
                sizes.rodata += if is_loaded { bytes } else { 0 };
            } else {
                sizes.rodata += bytes;
            }
        }
        Ok(sizes)
    }
}
