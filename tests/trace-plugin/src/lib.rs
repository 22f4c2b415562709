//! A TCG plug-in that counts and prices every instruction of every tick, exactly. It knows no instruction set: a price
//! list from the host says what each address costs and to which stage it belongs.
//!
//! Arguments, each `name=value`: `prices` (the list), `stages` (their number), `ticks` and `sites` (files to write),
//! `start` (address of the function that is one tick).
#![allow(unsafe_code)]

mod qemu;
mod recorder;

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::{Mutex, MutexGuard};

use recorder::Recorder;

/// The plug-in interface's version that this library was written for.
#[unsafe(no_mangle)]
pub static qemu_plugin_version: c_int = 1;

static RECORDER: Mutex<Option<Recorder>> = Mutex::new(None);

/// Called once when the emulator loads the library; a value other than 0 stops it.
///
/// # Safety
/// `argv` holds `argc` strings that end in NUL, as the emulator guarantees.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: qemu::Id,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let arguments: Vec<String> = (0..argc.max(0) as usize)
        // SAFETY: `i` is below `argc`, and each entry is a C string (this function's contract).
        .map(|i| unsafe { CStr::from_ptr(*argv.add(i)) }.to_string_lossy().into_owned())
        .collect();
    match Recorder::open(&arguments) {
        Ok(recorder) => *lock() = Some(recorder),
        Err(why) => {
            eprintln!("trace plug-in: {why}");
            return 1;
        }
    }
    // SAFETY: `id` is the emulator's own, the callbacks live as long as the library, which is never unloaded.
    unsafe {
        qemu::qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
        qemu::qemu_plugin_register_atexit_cb(id, finished, std::ptr::null_mut());
    }
    0
}

fn lock() -> MutexGuard<'static, Option<Recorder>> {
    RECORDER.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

extern "C" fn translated(_id: qemu::Id, block: *mut qemu::Block) {
    let mut recorder = lock();
    let Some(recorder) = recorder.as_mut() else { return };
    // SAFETY: `block` and its instructions are valid during this callback, and `i` is below their number. The data
    // handed over is a number, not a pointer.
    unsafe {
        for i in 0..qemu::qemu_plugin_tb_n_insns(block) {
            let insn = qemu::qemu_plugin_tb_get_insn(block, i);
            let at = qemu::qemu_plugin_insn_vaddr(insn) as u32;
            let site = recorder.site(at, qemu::qemu_plugin_insn_size(insn) as u32);
            qemu::qemu_plugin_register_vcpu_insn_exec_cb(
                insn,
                executed,
                qemu::NO_REGISTERS,
                std::ptr::without_provenance_mut(site),
            );
        }
    }
}

extern "C" fn executed(_cpu: c_uint, site: *mut c_void) {
    if let Some(recorder) = lock().as_mut() {
        recorder.execute(site.addr());
    }
}

extern "C" fn finished(_id: qemu::Id, _data: *mut c_void) {
    if let Some(Err(why)) = lock().take().map(Recorder::finish) {
        eprintln!("trace plug-in: {why}");
        std::process::abort();
    }
}
