//! The checksum of OpenIGTLink: CRC-64 of ECMA-182, not reflected, starting at zero.

use crc::{CRC_64_ECMA_182, Crc};

static CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// Continues `crc`, 0 at the beginning, with further bytes.
pub(super) fn crc64(crc: u64, bytes: &[u8]) -> u64 {
    let mut digest = CRC.digest_with_initial(crc);
    digest.update(bytes);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checksum_resumes_where_it_was() {
        // CRC-64/ECMA-182 in the catalogue of parametrised CRC algorithms.
        assert_eq!(crc64(0, b"123456789"), 0x6C40_DF5F_0B49_7347);
        assert_eq!(crc64(crc64(0, b"1234"), b"56789"), 0x6C40_DF5F_0B49_7347);
    }
}
