//! The part of the emulator's plug-in interface that is used (`qemu-plugin.h` of QEMU 7.2, API version 1). The
//! symbols are resolved from the emulator's executable when it loads the library.

use std::ffi::{c_int, c_uint, c_void};

/// `qemu_plugin_id_t`.
pub type Id = u64;

/// Opaque `struct qemu_plugin_tb`: a block that is being translated.
#[repr(C)]
pub struct Block {
    _opaque: [u8; 0],
}

/// Opaque `struct qemu_plugin_insn`.
#[repr(C)]
pub struct Instruction {
    _opaque: [u8; 0],
}

/// `QEMU_PLUGIN_CB_NO_REGS`: the callback touches no guest register.
pub const NO_REGISTERS: c_int = 0;

// SAFETY: the signatures are those of the header named above.
unsafe extern "C" {
    /// Calls `call` for each block translated.
    pub fn qemu_plugin_register_vcpu_tb_trans_cb(id: Id, call: extern "C" fn(Id, *mut Block));
    /// Calls `call` when the emulator exits.
    pub fn qemu_plugin_register_atexit_cb(
        id: Id,
        call: extern "C" fn(Id, *mut c_void),
        data: *mut c_void,
    );
    /// Calls `call` before each execution of an instruction of the block that is being translated.
    pub fn qemu_plugin_register_vcpu_insn_exec_cb(
        insn: *mut Instruction,
        call: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    /// Instructions in a block.
    pub fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    /// Instruction `index` of a block; valid while the block is being translated.
    pub fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut Instruction;
    /// Address of an instruction.
    pub fn qemu_plugin_insn_vaddr(insn: *const Instruction) -> u64;
    /// Size of an instruction, bytes.
    pub fn qemu_plugin_insn_size(insn: *const Instruction) -> usize;
}
