//! Machine files of a million waypoints, written into memory and read back.
//!
//! * `write_*`: the baseline is what comes to mind first: `writeln!` with the standard library's formatting, the same
//!   words and digits, and no check.
//! * `read_*`: the baseline splits each line at spaces, parses what follows the letter, and keeps the filament's sum; it
//!   takes any line for sound.
//!
//! Beside criterion's estimates the least time of 10 runs is printed: on a machine that others share it varies least.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

/// The words that the baseline writes and reads.
const WORDS: Dialect = Dialect::Part(DirectionWords::Dissertation);

const WAYPOINTS: usize = 1_000_000;

/// A spiral over a dome, the nozzle along its normals.
fn path() -> Vec<Move> {
    let step = |k: usize| {
        let t = k as f64 / WAYPOINTS as f64;
        let (angle, radius) = (3000.0 * t, 10.0 + 80.0 * t);
        let (sin, cos) = angle.sin_cos();
        let tip = Point3::new(radius * cos, radius * sin, 60.0 - 50.0 * t * t);
        let direction = UnitVector3::new_normalize(Vector3::new(0.5 * t * cos, 0.5 * t * sin, 1.0));
        match k {
            0 => Move::Travel { tip, direction, feed_mm_s: 80.0 },
            _ => {
                Move::Print { tip, direction, filament_mm: 0.01 + 0.02 * t, feed_mm_s: 20.0 + (k / 100) as f64 * 1e-3 }
            }
        }
    };
    (0..WAYPOINTS).map(step).collect()
}

fn write(moves: &[Move], dialect: Dialect) -> Vec<u8> {
    let mut out = Vec::new();
    let options = WriteOptions { dialect, end: None, ..WriteOptions::default() };
    write_gcode(moves.iter().copied(), &options, &mut out).expect("a sound path");
    out
}

fn baseline_write(moves: &[Move]) -> Vec<u8> {
    let mut out = Vec::new();
    let (mut e, mut last) = (0.0, 0.0);
    for item in moves {
        let (word, tip, n, by, feed) = match item {
            Move::Print { tip, direction, filament_mm, feed_mm_s } => ("G1", tip, direction, *filament_mm, *feed_mm_s),
            Move::Travel { tip, direction, feed_mm_s } => ("G0", tip, direction, 0.0, *feed_mm_s),
            _ => continue,
        };
        e += by;
        write!(
            out,
            "{word} X{:.4} Y{:.4} Z{:.4} nX{:.6} nY{:.6} nZ{:.6} E{:.5}",
            tip.x, tip.y, tip.z, n.x, n.y, n.z, e
        )
        .expect("memory");
        if (feed - last).abs() > 0.0 {
            write!(out, " F{:.3}", feed * 60.0).expect("memory");
            last = feed;
        }
        out.push(b'\n');
    }
    out
}

/// The sum of all x and that of all filament, so that nothing is left out.
fn sums(file: &[u8], dialect: Dialect) -> [f64; 2] {
    let reader = GcodeReader::new(file, ReadOptions { dialect, ..ReadOptions::default() }).expect("sound options");
    let mut sums = [0.0; 2];
    for item in reader {
        match item.expect("a sound file") {
            Move::Print { tip, filament_mm, .. } => sums = [sums[0] + tip.x, sums[1] + filament_mm],
            Move::Travel { tip, .. } => sums[0] += tip.x,
            _ => {}
        }
    }
    sums
}

fn baseline_sums(file: &[u8]) -> [f64; 2] {
    let text = std::str::from_utf8(file).expect("ASCII");
    let (mut sums, mut e) = ([0.0; 2], 0.0);
    for line in text.lines().filter(|line| line.starts_with("G0") || line.starts_with("G1")) {
        let (mut at, mut normal) = ([0.0; 3], [0.0; 3]);
        for word in line.split(' ').skip(1) {
            let split = word.find(|c: char| !c.is_ascii_alphabetic()).expect("a number");
            let value: f64 = word[split..].parse().expect("a number");
            match &word[..split] {
                "X" => at[0] = value,
                "Y" => at[1] = value,
                "Z" => at[2] = value,
                "nX" => normal[0] = value,
                "nY" => normal[1] = value,
                "nZ" => normal[2] = value,
                "E" => (sums[1], e) = (sums[1] + value - e, value),
                _ => {}
            }
        }
        black_box((at, normal));
        sums[0] += at[0];
    }
    sums
}

fn bench_gcode(c: &mut Criterion) {
    let moves = path();
    let table = Dialect::Rotary(RotaryTable { tolerance_mm: None, ..RotaryTable::default() });
    let (file, plain, rotary) = (write(&moves, WORDS), baseline_write(&moves), write(&moves, table));
    let exact = sums(&file, WORDS);
    for other in [baseline_sums(&plain), sums(&plain, WORDS), sums(&rotary, table)] {
        assert!((0..2).all(|k| (exact[k] - other[k]).abs() < 1e-4 * WAYPOINTS as f64), "{exact:?} {other:?}");
    }
    eprintln!("bytes: ours {}, baseline {}, rotary {}", file.len(), plain.len(), rotary.len());
    let mut group = c.benchmark_group("gcode");
    group.throughput(Throughput::Elements(WAYPOINTS as u64)).sample_size(10);
    let mut bench = |name: &str, run: &dyn Fn() -> f64| {
        let time = |_| {
            let start = Instant::now();
            black_box(run());
            start.elapsed().as_secs_f64()
        };
        eprintln!("{name}: at least {:.3} s", (0..10).map(time).fold(f64::INFINITY, f64::min));
        group.bench_function(name, |b| b.iter(run));
    };
    bench("write_words", &|| write(black_box(&moves), WORDS).len() as f64);
    bench("write_rotary", &|| write(black_box(&moves), table).len() as f64);
    bench("write_baseline", &|| baseline_write(black_box(&moves)).len() as f64);
    bench("read_words", &|| sums(black_box(&file), WORDS)[0]);
    bench("read_rotary", &|| sums(black_box(&rotary), table)[0]);
    bench("read_baseline", &|| baseline_sums(black_box(&plain))[0]);
    group.finish();
}

criterion_group!(benches, bench_gcode);
criterion_main!(benches);
