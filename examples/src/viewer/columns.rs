//! Columns of small numbers, made short: each is written as differences from number to number, low bytes before high bytes, and all of them
//! are deflated together (RFC 1950). Places along a path differ little, so most high bytes are 0 or 255.

use flate2::{Compression, write::ZlibEncoder};
use serde_json::{Value, json};
use std::io::Write;

/// Columns in the order in which they were added.
#[derive(Debug, Default)]
pub(super) struct Columns {
    bytes: Vec<u8>,
    names: Vec<Value>,
}

impl Columns {
    /// Adds numbers of `WIDTH` bytes (1, 2 or 4); higher bytes are cut off.
    pub(super) fn add<const WIDTH: usize>(&mut self, name: &str, numbers: impl Iterator<Item = u32> + Clone) {
        let differences = numbers.clone().scan(0u32, |last, number| {
            let difference = number.wrapping_sub(*last);
            *last = number;
            Some(difference)
        });
        for byte in 0..WIDTH {
            self.bytes.extend(differences.clone().map(|difference| (difference >> (8 * byte)) as u8));
        }
        self.names.push(json!([name, WIDTH, numbers.count()]));
    }

    /// Name, width in bytes and count of each column, and all of them deflated.
    pub(super) fn finish(self) -> (Value, Vec<u8>) {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        // Into memory: it cannot fail.
        let deflated = encoder.write_all(&self.bytes).and_then(|()| encoder.finish()).unwrap_or_default();
        (Value::from(self.names), deflated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use proptest::prelude::*;
    use std::io::Read;

    /// What the script does.
    fn read(bytes: &[u8], width: usize, count: usize) -> Vec<u32> {
        let mut last = 0u32;
        let of = |i: usize| (0..width).fold(0u32, |sum, byte| sum | u32::from(bytes[byte * count + i]) << (8 * byte));
        let mask = u32::MAX >> (32 - 8 * width);
        let mut next = |i| {
            last = last.wrapping_add(of(i)) & mask;
            last
        };
        (0..count).map(&mut next).collect()
    }

    proptest! {
        #[test]
        fn what_is_read_is_what_was_written(a in prop::collection::vec(0u32..=0xff, 0..40), b in prop::collection::vec(0u32..=0xffff, 0..40),
                                            c in prop::collection::vec(any::<u32>(), 0..40)) {
            let mut columns = Columns::default();
            columns.add::<1>("a", a.iter().copied());
            columns.add::<2>("b", b.iter().copied());
            columns.add::<4>("c", c.iter().copied());
            let (names, deflated) = columns.finish();
            prop_assert_eq!(names, json!([["a", 1, a.len()], ["b", 2, b.len()], ["c", 4, c.len()]]));
            let mut bytes = Vec::new();
            ZlibDecoder::new(&deflated[..]).read_to_end(&mut bytes).unwrap();
            let (of_a, rest) = bytes.split_at(a.len());
            let (of_b, of_c) = rest.split_at(2 * b.len());
            prop_assert_eq!(read(of_a, 1, a.len()), a);
            prop_assert_eq!(read(of_b, 2, b.len()), b);
            prop_assert_eq!(read(of_c, 4, c.len()), c);
        }
    }
}
