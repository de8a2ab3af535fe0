//! Files that nobody should write: the reader ends on each of them, with moves, or one error that has a place.

use crate::gcode_common::*;
use curvlay_toolpath::gcode::*;
use proptest::prelude::*;

/// Reads to the end: at most a move a line, finite numbers, one error at most and a place in the file with it.
fn reads(file: &[u8], dialect: Dialect, skip_other_m: bool) -> Result<(), TestCaseError> {
    let lines: Vec<&[u8]> = file.split(|&byte| byte == b'\n').collect();
    let options = ReadOptions { dialect, skip_other_m, ..ReadOptions::default() };
    let mut moves = 0;
    let mut reader = GcodeReader::new(file, options).unwrap();
    while let Some(item) = reader.next() {
        let place = match item {
            Ok(item) => {
                moves += 1;
                prop_assert!(moves <= lines.len());
                if let Some((tip, direction)) = place(&item) {
                    prop_assert!(tip.iter().all(|x| x.is_finite()) && (direction.norm() - 1.0).abs() < 1e-12);
                }
                continue;
            }
            Err(
                ReadError::Unexpected { line, column, .. }
                | ReadError::Command { line, column, .. }
                | ReadError::Missing { line, column, .. }
                | ReadError::Repeated { line, column, .. }
                | ReadError::Number { line, column, .. }
                | ReadError::NumberTooLong { line, column, .. }
                | ReadError::Direction { line, column, .. }
                | ReadError::Backwards { line, column, .. },
            ) => (line, column),
            Err(ReadError::LineTooLong { line, .. }) => (line, 1),
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        prop_assert!(reader.next().is_none(), "it goes on after an error");
        prop_assert_eq!(reader.lines(), place.0);
        let line = lines[place.0 as usize - 1];
        prop_assert!(place.1 >= 1 && place.1 as usize <= line.len() + 1, "{:?} {}", place, line.len());
        return Ok(());
    }
    Ok(())
}

/// Words that nearly are what they should be.
fn pieces() -> impl Strategy<Value = Vec<u8>> {
    const PIECES: [&str; 52] = [
        "G1",
        "G0",
        " ",
        "X1",
        "Y2.5",
        "Z-3",
        "F600",
        "E1",
        "nX0",
        "I0",
        "J1",
        ";DIR:0 0 1",
        ";DIR:",
        "nY0",
        "nZ1",
        "N12",
        "\n",
        "\r\n",
        "G92 E0",
        "G28",
        "M82",
        "M83",
        "G93",
        "G94",
        "B10",
        "C-400",
        "(",
        ")",
        ";",
        ".",
        "-",
        "+",
        "1",
        "00000000",
        "999999999999999999999",
        "G4 P1",
        "M104 S200",
        "M106",
        "T0",
        "M2730 P1",
        "M2732 S20",
        "M2731 S.5",
        "M2735",
        "G91",
        "n",
        "e",
        "1e9",
        "NaN",
        "\0",
        "\u{fffd}",
        "M117 x(",
        "%",
    ];
    prop::collection::vec(prop::sample::select(&PIECES[..]), 0..200).prop_map(|all| all.concat().into_bytes())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn random_bytes(file in prop::collection::vec(any::<u8>(), 0..2000), skip in any::<bool>()) {
        DIALECTS.into_iter().try_for_each(|dialect| reads(&file, dialect, skip))?;
        reads(&file, Dialect::Rotary(RotaryTable::default()), skip)?;
    }

    #[test]
    fn random_words(file in pieces(), skip in any::<bool>()) {
        DIALECTS.into_iter().try_for_each(|dialect| reads(&file, dialect, skip))?;
        reads(&file, Dialect::Rotary(RotaryTable::default()), skip)?;
    }

    /// Bytes of a sound file changed, left out, doubled; or the file cut off.
    #[test]
    fn damaged_files(
        moves in moves(200.0),
        damage in prop::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<u8>()), 1..6),
        dialect in 0..4usize,
    ) {
        let mut table = RotaryTable { tolerance_mm: None, ..RotaryTable::default() };
        table.tilt.limits = [-4.0, 4.0];
        let dialect = DIALECTS.get(dialect).copied().unwrap_or(Dialect::Rotary(table));
        let Ok(file) = written(&moves, &WriteOptions { dialect, ..WriteOptions::default() }) else { return Ok(()) };
        let mut file = file.into_bytes();
        for (place, kind, byte) in damage {
            if file.is_empty() {
                break;
            }
            let at = place.index(file.len());
            match kind {
                0 => file[at] = byte,
                1 => _ = file.remove(at),
                2 => file.insert(at, byte),
                _ => file.truncate(at + 1),
            }
        }
        reads(&file, dialect, false)?;
    }
}

/// A line without an end is refused after its first 16 KiB, whatever is promised after it.
#[test]
fn endless_lines_are_refused_at_once() {
    struct Endless(u64);
    impl std::io::Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.0 += buffer.len() as u64;
            assert!(self.0 < 100_000, "still reading");
            buffer.fill(b'1');
            Ok(buffer.len())
        }
    }
    let reader = std::io::BufReader::new(Endless(0));
    let first = GcodeReader::new(reader, ReadOptions::default()).unwrap().next();
    assert!(matches!(first, Some(Err(ReadError::LineTooLong { line: 1, most: 16_384 }))), "{first:?}");
}
