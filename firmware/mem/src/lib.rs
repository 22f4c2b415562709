#![no_std]
//! What the compiler calls to copy, clear and compare, in a few bytes each: those that come with it are unrolled for
//! long blocks and together take 1.5 KiB; the longest block of a tick has a hundred bytes.
//!
//! Only a target has them: a board's binary names this package, whose symbols then go before the compiler's. Accesses
//! are volatile so that the compiler does not see a copy in them, which it would call itself for.
#![cfg(target_os = "none")]
#![allow(unsafe_code, reason = "the compiler hands over addresses")]

/// # Safety
/// As C's `memcpy`.
#[inline(never)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memcpy(to: *mut u8, from: *const u8, length: usize) {
    for i in 0..length {
        // SAFETY: the caller's.
        unsafe { to.add(i).write_volatile(from.add(i).read_volatile()) };
    }
}

/// # Safety
/// As C's `memcpy`, both on a word's boundary.
#[inline(never)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memcpy4(to: *mut u32, from: *const u32, length: usize) {
    let words = length / 4;
    for i in 0..words {
        // SAFETY: the caller's.
        unsafe { to.add(i).write_volatile(from.add(i).read_volatile()) };
    }
    // SAFETY: the caller's.
    unsafe { __aeabi_memcpy(to.add(words).cast(), from.add(words).cast(), length % 4) };
}

/// # Safety
/// As [`__aeabi_memcpy4`].
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memcpy8(to: *mut u32, from: *const u32, length: usize) {
    // SAFETY: the caller's.
    unsafe { __aeabi_memcpy4(to, from, length) };
}

/// # Safety
/// Writes zeros into `length` bytes.
#[inline(never)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memclr(to: *mut u8, length: usize) {
    for i in 0..length {
        // SAFETY: the caller's.
        unsafe { to.add(i).write_volatile(0) };
    }
}

/// # Safety
/// As [`__aeabi_memclr`], from a word's boundary on.
#[inline(never)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memclr4(to: *mut u32, length: usize) {
    let words = length / 4;
    for i in 0..words {
        // SAFETY: the caller's.
        unsafe { to.add(i).write_volatile(0) };
    }
    // SAFETY: the caller's.
    unsafe { __aeabi_memclr(to.add(words).cast(), length % 4) };
}

/// # Safety
/// As [`__aeabi_memclr4`].
#[unsafe(no_mangle)]
unsafe extern "C" fn __aeabi_memclr8(to: *mut u32, length: usize) {
    // SAFETY: the caller's.
    unsafe { __aeabi_memclr4(to, length) };
}

/// # Safety
/// As C's `memcmp`.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(a: *const u8, b: *const u8, length: usize) -> i32 {
    for i in 0..length {
        // SAFETY: the caller's.
        let (a, b) = unsafe { (a.add(i).read_volatile(), b.add(i).read_volatile()) };
        if a != b {
            return i32::from(a) - i32::from(b);
        }
    }
    0
}
