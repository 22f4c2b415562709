//! CRC-32 of what is kept or sent as bytes.

/// The reflected polynomial of IEEE 802.3.
const POLYNOMIAL: u32 = 0xEDB8_8320;

/// What four bits shifted out leave. One entry a nibble: a table by bytes is sixteen times as large and twice as fast.
static NIBBLES: [u32; 16] = {
    let mut table = [0; 16];
    let mut n = 0;
    while n < table.len() {
        let (mut entry, mut bit) = (n as u32, 0);
        while bit < 4 {
            entry = entry >> 1 ^ if entry & 1 == 0 { 0 } else { POLYNOMIAL };
            bit += 1;
        }
        table[n] = entry;
        n += 1;
    }
    table
};

/// CRC-32 (ISO-HDLC, that of Ethernet and zip) of `bytes`.
///
/// It finds every burst of up to 32 bits, every error of up to four bits in up to 371 bytes, and of up to
/// three bits in up to 11 KiB (Koopman's tables for 0x82608edb).
pub fn crc32(bytes: &[u8]) -> u32 {
    continued(0, bytes)
}

/// The CRC-32 of what `crc` is the CRC-32 of, followed by `bytes`; that of nothing is 0.
#[inline(never)]
pub fn continued(crc: u32, bytes: &[u8]) -> u32 {
    // The register as it was: this CRC inverts it at both ends.
    let mut register = !crc;
    for byte in bytes {
        register ^= u32::from(*byte);
        register = register >> 4 ^ NIBBLES[(register & 15) as usize];
        register = register >> 4 ^ NIBBLES[(register & 15) as usize];
    }
    !register
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bytes_have_the_sum_of_another_implementation() {
        let other = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let bytes: [u8; 256] = core::array::from_fn(|i| (i as u8).wrapping_mul(197));
        for length in 0..bytes.len() {
            assert_eq!(crc32(&bytes[..length]), other.checksum(&bytes[..length]), "{length}");
        }
    }

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
