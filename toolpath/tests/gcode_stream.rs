//! Five million waypoints from writer to reader in constant memory (one million in a debug build, which is slow). A binary of its own, since it
//! measures the memory of its process.
#![allow(clippy::unwrap_used)] // helpers of tests fail like tests

use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use std::io::{self, BufReader, Read, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

const WAYPOINTS: u64 = if cfg!(debug_assertions) { 1_000_000 } else { 5_000_000 };

/// Largest piece that a writer may collect, bytes.
const PIECE: usize = 40_000;

struct Sender(SyncSender<Vec<u8>>);

impl Write for Sender {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        assert!(bytes.len() <= PIECE, "{} bytes in one piece", bytes.len());
        self.0.send(bytes.to_vec()).map_err(io::Error::other)?;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Taker(Receiver<Vec<u8>>, Vec<u8>, usize);

impl Read for Taker {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.2 == self.1.len() {
            let Ok(next) = self.0.recv() else { return Ok(0) };
            (self.1, self.2) = (next, 0);
        }
        let count = buffer.len().min(self.1.len() - self.2);
        buffer[..count].copy_from_slice(&self.1[self.2..self.2 + count]);
        self.2 += count;
        Ok(count)
    }
}

fn waypoint(k: u64) -> Move {
    // Halves of a millimetre, so that all comes back to the last bit.
    let tip = Point3::new((k % 1000) as f64, (k / 1000 % 1000) as f64, (k / 1_000_000) as f64 + 0.5);
    let direction =
        if k.is_multiple_of(2) { Vector3::z_axis() } else { UnitVector3::new_unchecked(Vector3::new(0.6, 0.0, 0.8)) };
    match k {
        0 => Move::Travel { tip, direction, feed_mm_s: 50.0 },
        _ => Move::Print { tip, direction, filament_mm: 0.25, feed_mm_s: 20.0 },
    }
}

/// The most memory that this process has had, KiB.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "memory is read from /proc")]
fn millions_of_waypoints() {
    let before = peak();
    // At most four pieces are on their way.
    let (sender, receiver) = sync_channel(4);
    let options = WriteOptions { end: None, ..WriteOptions::default() };
    let writing = std::thread::spawn(move || write_gcode((0..WAYPOINTS).map(waypoint), &options, Sender(sender)));
    let reader = BufReader::new(Taker(receiver, Vec::new(), 0));
    let reader = GcodeReader::new(reader, ReadOptions::default()).unwrap();
    let mut count = 0;
    for item in reader.skip_while(|item| matches!(item, Ok(Move::Home))) {
        match (item.unwrap(), waypoint(count)) {
            (Move::Print { tip, filament_mm, .. }, Move::Print { tip: other, filament_mm: by, .. }) => {
                assert!(tip == other && (filament_mm - by).abs() < 1e-9, "{count}");
            }
            (Move::Travel { tip, .. }, Move::Travel { tip: other, .. }) => assert_eq!(tip, other),
            (one, other) => panic!("{count}: {one:?} {other:?}"),
        }
        count += 1;
    }
    assert_eq!(count, WAYPOINTS);
    let written = writing.join().unwrap().unwrap();
    assert_eq!(written.moves, WAYPOINTS);
    assert!(written.bytes > 30 * WAYPOINTS);
    let more = peak() - before;
    assert!(more < 4096, "{more} KiB more");
}
