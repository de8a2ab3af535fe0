//! UUIDs that follow from the content of a build: the same build has the same ones, another build others.
//!
//! FNV-1a of 128 bits (Fowler, Noll, Vo), as a UUID of version 8, whose bits are the maker's own (RFC 9562, section 5.8).

const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

/// What the content of a build comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Content(u128);

impl Content {
    pub(super) fn new() -> Self {
        Content(OFFSET)
    }

    pub(super) fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(PRIME);
        }
    }

    /// A number by its bits.
    pub(super) fn number(&mut self, value: f64) {
        self.add(&value.to_bits().to_le_bytes());
    }

    /// The UUID of something of this content.
    pub(super) fn uuid(mut self, of: &str) -> String {
        self.add(of.as_bytes());
        // The last bytes reach all bits only by the ones behind them.
        self.add(&[0; 16]);
        let [version, variant] = [0xf_u128 << 76, 0x3_u128 << 62];
        let bits = (self.0 & !version & !variant) | (0x8_u128 << 76) | (0x2_u128 << 62);
        let hex = format!("{bits:032x}");
        format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
    }
}

#[cfg(test)]
mod tests {
    use super::Content;

    /// Values of the authors' own tests of FNV-1a of 128 bits for "" and "a".
    #[test]
    fn hashes_are_those_of_the_authors() {
        let mut content = Content::new();
        assert_eq!(content.0, 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        content.add(b"a");
        assert_eq!(content.0, 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }

    #[test]
    fn uuids_have_the_form_of_version_8() {
        let uuid = Content::new().uuid("build");
        let groups: Vec<usize> = uuid.split('-').map(str::len).collect();
        assert_eq!(groups, [8, 4, 4, 4, 12]);
        assert!(&uuid[14..15] == "8" && "89ab".contains(&uuid[19..20]), "{uuid}");
        assert_ne!(uuid, Content::new().uuid("item"));
    }
}
