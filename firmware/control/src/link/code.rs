//! Message authentication codes: HMAC-SHA256 (RFC 2104), put together from the rounds of `sha2`. The `hmac` crate's
//! types would take 500 bytes of stack more than there are; the tests hold this to it.

use sha2::block_api::compress256;
use shared::link::{CODED_BYTES, Code, Frame, Key};
use subtle::ConstantTimeEq;

/// First state of SHA-256 (FIPS 180-4, section 5.3.3).
const INITIAL: [u32; 8] = [
    0x6A09_E667,
    0xBB67_AE85,
    0x3C6E_F372,
    0xA54F_F53A,
    0x510E_527F,
    0x9B05_688C,
    0x1F83_D9AB,
    0x5BE0_CD19,
];
/// RFC 2104, section 2.
const INNER_PAD: u8 = 0x36;
const OUTER_PAD: u8 = 0x5C;
/// Size of a block of SHA-256.
const BLOCK: usize = 64;
/// What fits into one block beside the padding's first bit and the length of 64 bits.
const MESSAGE_MAX: usize = BLOCK - 9;
const _: () = assert!(CODED_BYTES <= MESSAGE_MAX && size_of::<Key>() <= MESSAGE_MAX);

/// HMAC-SHA256 of a message of at most [`MESSAGE_MAX`] bytes.
#[inline(never)]
pub fn hmac(key: &Key, message: &[u8]) -> Key {
    let inner = half(key, INNER_PAD, message);
    half(key, OUTER_PAD, &inner)
}

/// SHA-256 of a block with the padded key and one with the message.
#[inline(never)]
fn half(key: &Key, pad: u8, message: &[u8]) -> Key {
    let mut state = INITIAL;
    let mut block = [0; BLOCK];
    for (slot, byte) in block.iter_mut().zip(key) {
        *slot = *byte;
    }
    for byte in &mut block {
        *byte ^= pad;
    }
    compress256(&mut state, core::slice::from_ref(&block));
    block.fill(0);
    for (slot, byte) in block.iter_mut().zip(message) {
        *slot = *byte;
    }
    // The padding of FIPS 180-4, section 5.1.1.
    if let Some(slot) = block.get_mut(message.len()) {
        *slot = 0x80;
    }
    let bits = 8 * (BLOCK + message.len()) as u16;
    [block[BLOCK - 2], block[BLOCK - 1]] = bits.to_be_bytes();
    compress256(&mut state, core::slice::from_ref(&block));
    bytemuck::cast(state.map(u32::to_be))
}

/// The code that `frame` should carry under this key.
#[inline(always)]
fn code(key: &Key, frame: &Frame) -> Code {
    let [code @ .., _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _] = hmac(key, frame.coded());
    code
}

/// Whether `frame` carries the code of this key; takes equally long whatever the code.
#[inline(never)]
pub fn is_coded(key: &Key, frame: &Frame) -> bool {
    code(key, frame).ct_eq(&frame.code).into()
}

/// Puts code and CRC in their places.
#[inline(never)]
pub fn sign(key: &Key, frame: &mut Frame) {
    frame.code = code(key, frame);
    frame.seal();
}

#[cfg(test)]
mod tests {
    use hmac::{Hmac, KeyInit, Mac};
    use sha2::Sha256;

    use super::*;

    /// RFC 4231 section 4.2, test case 1: zeros fill the key of 20 bytes up to any length.
    #[test]
    fn the_standards_first_vector() {
        let mut key = [0; 32];
        key[..20].fill(0x0B);
        let expected = [
            0xB0, 0x34, 0x4C, 0x61, 0xD8, 0xDB, 0x38, 0x53, 0x5C, 0xA8, 0xAF, 0xCE, 0xAF, 0x0B,
            0xF1, 0x2B, 0x88, 0x1D, 0xC2, 0x00, 0xC9, 0x83, 0x3D, 0xA7, 0x26, 0xE9, 0x37, 0x6C,
            0x2E, 0x32, 0xCF, 0xF7,
        ];
        assert_eq!(hmac(&key, b"Hi There"), expected);
    }

    /// Route two: the crate, for every length.
    #[test]
    fn every_length_agrees_with_the_crate() {
        let message: [u8; MESSAGE_MAX] = core::array::from_fn(|i| (i * 73 + 5) as u8);
        for length in 0..=MESSAGE_MAX {
            let key = [length as u8 ^ 0x5A; 32];
            let mut mac = Hmac::<Sha256>::new_from_slice(&key).unwrap();
            mac.update(&message[..length]);
            let expected: Key = mac.finalize().into_bytes().into();
            assert_eq!(hmac(&key, &message[..length]), expected, "{length}");
        }
    }
}
