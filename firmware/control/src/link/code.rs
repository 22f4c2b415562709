//! Message authentication codes.

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use shared::link::{Code, Frame, Key};
use subtle::ConstantTimeEq;

/// HMAC-SHA256 of `message`.
#[inline(never)]
pub fn hmac(key: &Key, message: &[u8]) -> Key {
    // A key of any length is taken.
    let Ok(mut mac) = Hmac::<Sha256>::new_from_slice(key) else { return [0; 32] };
    mac.update(message);
    mac.finalize().into_bytes().into()
}

/// The code that `frame` should carry under this key.
fn code(key: &Key, frame: &Frame) -> Code {
    let [code @ .., _, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _] = hmac(key, frame.coded());
    code
}

/// Whether `frame` carries the code of this key; takes equally long whatever the code.
pub fn is_coded(key: &Key, frame: &Frame) -> bool {
    code(key, frame).ct_eq(&frame.code).into()
}

/// Puts code and CRC in their places.
pub fn sign(key: &Key, frame: &mut Frame) {
    frame.code = code(key, frame);
    frame.seal();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 4231 section 4.2, test case 1, whose key of 20 bytes zeros fill up to any length.
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
}
