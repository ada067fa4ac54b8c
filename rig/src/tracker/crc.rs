//! The checksum of OpenIGTLink: CRC-64 of ECMA-182, not reflected, starting at zero.

/// x⁶⁴ + x⁶² + … + x + 1, without its highest term.
const POLYNOMIAL: u64 = 0x42F0_E1EB_A9EA_3693;

const TABLE: [u64; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u64) << 56;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc >> 63 == 1 { (crc << 1) ^ POLYNOMIAL } else { crc << 1 };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

/// Continues `crc`, 0 at the beginning, with further bytes.
pub(super) fn crc64(crc: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(crc, |crc, byte| TABLE[usize::from((crc >> 56) as u8 ^ byte)] ^ (crc << 8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value_is_that_of_the_catalogue() {
        // CRC-64/ECMA-182 in the catalogue of parametrised CRC algorithms.
        assert_eq!(crc64(0, b"123456789"), 0x6C40_DF5F_0B49_7347);
        assert_eq!(crc64(crc64(0, b"1234"), b"56789"), 0x6C40_DF5F_0B49_7347);
    }
}
