//! CRC-32 of what is kept or sent as bytes.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

static TABLE: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// CRC-32 (ISO-HDLC, that of Ethernet and zip) of `bytes`.
///
/// It finds every burst of up to 32 bits, every error of up to four bits in up to 371 bytes, and of up to
/// three bits in up to 11 KiB (Koopman's tables for 0x82608edb).
#[inline(never)]
pub fn crc32(bytes: &[u8]) -> u32 {
    TABLE.checksum(bytes)
}

/// A check sum under way.
pub type Digest = crc::Digest<'static, u32, Table<1>>;

/// The same, piece by piece.
pub fn digest() -> Digest {
    TABLE.digest()
}
