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

/// The CRC-32 of what `crc` is the CRC-32 of, followed by `bytes`; that of nothing is 0.
#[inline(never)]
pub fn continued(crc: u32, bytes: &[u8]) -> u32 {
    // The register as it was: this CRC inverts it at the end, and reflects it at the start.
    let mut digest = TABLE.digest_with_initial((!crc).reverse_bits());
    digest.update(bytes);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_and_any_way_to_cut_it() {
        // The catalogue's check value.
        let text = b"123456789";
        assert_eq!(crc32(text), 0xCBF4_3926);
        for cut in 0..=text.len() {
            let (a, b) = text.split_at(cut);
            assert_eq!(continued(continued(0, a), b), crc32(text), "{cut}");
        }
    }
}
