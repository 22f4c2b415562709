//! What outlives the loss of power, in the last sector of flash: the operator's key, and a count of boots.
//!
//! The sector is written with the key by a programmer, which erases the rest. Each boot then clears one more word, and
//! nothing here ever erases: a count that went back would let recorded frames be taken again.

use core::sync::atomic::{AtomicU32, Ordering};

use firmware::link::Access;
use shared::link::{DEFAULT_KEY, Key};
use stm32f4::stm32f446::flash;

use crate::wait::{TimedOut, until};

/// 128 KiB.
const SECTOR_WORDS: usize = 0x8000;
const KEY_WORDS: usize = size_of::<Key>() / 4;
/// An erased word.
const ERASED: u32 = u32::MAX;
/// A used one.
const BOOTED: u32 = 0;
/// Programming a word takes 16 us, 100 us at most (DS10693, flash memory programming): this is at least 600 us.
const PROGRAM_POLLS: u32 = 10_000;
/// Opens the control register (RM0390 section 3.5.1).
const UNLOCK: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

unsafe extern "C" {
    /// By `memory.x`.
    safe static _kept: [AtomicU32; SECTOR_WORDS];
}

/// Who may command the board. Counts this boot; where that fails, only the default key is left, with which nothing is
/// armed.
pub fn access(flash: &flash::RegisterBlock) -> Access {
    let nobody = Access { key: DEFAULT_KEY, boots: 0 };
    let Some((key, log)) = _kept.split_first_chunk::<KEY_WORDS>() else { return nobody };
    let boots = log.iter().rposition(|word| load(word) != ERASED).map_or(0, |last| last + 1);
    let key = key.each_ref().map(load);
    match log.get(boots) {
        Some(word) if key != [ERASED; KEY_WORDS] && program(flash, word).is_ok() => {
            Access { key: bytemuck::cast(key.map(u32::to_le)), boots: boots as u32 + 1 }
        }
        _ => nobody,
    }
}

fn load(word: &AtomicU32) -> u32 {
    word.load(Ordering::SeqCst)
}

/// Clears one erased word, and sees that it is (section 3.5.4). The data cache is off meanwhile: it would not notice.
fn program(flash: &flash::RegisterBlock, word: &AtomicU32) -> Result<(), TimedOut> {
    let idle = || until(PROGRAM_POLLS, || flash.sr().read().bsy().bit_is_clear());
    flash.acr().modify(|_, w| w.dcen().disabled());
    idle()?;
    for key in UNLOCK {
        flash.keyr().write(|w| w.key().set(key));
    }
    flash.cr().write(|w| w.psize().psize32().pg().set_bit());
    word.store(BOOTED, Ordering::SeqCst);
    let programmed = idle();
    flash.cr().write(|w| w.lock().set_bit());
    flash.acr().modify(|_, w| w.dcrst().set_bit());
    flash.acr().modify(|_, w| w.dcrst().clear_bit());
    flash.acr().modify(|_, w| w.dcen().enabled());
    programmed.and(if load(word) == BOOTED { Ok(()) } else { Err(TimedOut) })
}
