//! Programs of 100,000 targets, written into memory and read back.
//!
//! * `write_*`: the baseline for RAPID is what comes to mind first: the standard library's formatting, a line at a
//!   time, with the same numbers and digits.
//! * `read_*`: the baseline takes the numbers out of each line by splitting at brackets and commas; it checks nothing.
//!
//! Beside criterion's estimates the least time of 10 runs is printed: on a machine that others share it varies least.
#![allow(missing_docs)] // of what criterion's macros make

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use curvlay_benches::least_seconds;
use curvlay_kinematics::nalgebra::{Isometry3, Translation3, UnitQuaternion};
use curvlay_kinematics::program::*;
use std::hint::black_box;
use std::io::{self, Write};

const TARGETS: usize = 100_000;

/// A spiral over a dome, the tool along its normals.
fn path() -> Vec<Step> {
    let step = |k: usize| {
        let t = k as f64 / TARGETS as f64;
        let (angle, radius) = (600.0 * t, 90.0 * t);
        let tilt = UnitQuaternion::from_euler_angles(-0.5 * t * angle.sin(), 0.5 * t * angle.cos(), 0.1 * angle);
        let at = Translation3::new(600.0 + radius * angle.cos(), radius * angle.sin(), 300.0 - 20.0 * t * t);
        let target = Target { pose: Isometry3::from_parts(at, tilt), conf: ConfData::default() };
        let speed = Speed { mm_s: 20.0 + t, rad_s: 1.0 };
        let zone = if k + 1 == TARGETS { Zone::Stop } else { Zone::Blend(0.3) };
        Step::Move(Move { goal: Goal::Line(target), table: None, speed, zone })
    };
    (0..TARGETS).map(step).collect()
}

fn rapid(steps: &[Step]) -> Vec<Vec<u8>> {
    let mut files: Vec<std::rc::Rc<std::cell::RefCell<Vec<u8>>>> = Vec::new();
    write_rapid(steps.iter().copied(), &RapidOptions::default(), |_| {
        files.push(Default::default());
        Ok(Shared(files[files.len() - 1].clone()))
    })
    .expect("a sound path");
    files.into_iter().map(|file| file.take()).collect()
}

struct Shared(std::rc::Rc<std::cell::RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn baseline_rapid(steps: &[Step]) -> Vec<u8> {
    let mut out = Vec::new();
    for step in steps {
        let Step::Move(Move { goal: Goal::Line(target), speed, .. }) = step else { continue };
        let (at, q, c) = (target.pose.translation, target.pose.rotation, target.conf);
        writeln!(
            out,
            "    MoveL [[{:.4},{:.4},{:.4}],[{:.8},{:.8},{:.8},{:.8}],[{},{},{},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],[{:.4},{:.6},5000,1000],z0,tool0\\WObj:=wobj0;",
            at.x, at.y, at.z, q.w, q.i, q.j, q.k, c.cf1, c.cf4, c.cf6, c.cfx, speed.mm_s, speed.rad_s.to_degrees()
        )
        .expect("memory");
    }
    out
}

/// The sum of all x, so that nothing is left out.
fn baseline_read(text: &[u8]) -> f64 {
    let text = std::str::from_utf8(text).expect("ASCII");
    let numbers =
        |line: &str| -> Vec<f64> { line.split(['[', ']', ',']).filter_map(|word| word.trim().parse().ok()).collect() };
    text.lines().filter(|line| line.trim_start().starts_with("Move")).map(|line| numbers(line)[0]).sum()
}

fn sum_x<E: std::fmt::Debug>(steps: impl Iterator<Item = Result<Step, E>>) -> f64 {
    steps
        .map(|step| match step.expect("a sound file") {
            Step::Move(Move { goal: Goal::Line(target), .. }) => target.pose.translation.x,
            _ => 0.0,
        })
        .sum()
}

fn bench_programs(c: &mut Criterion) {
    let steps = path();
    let files = rapid(&steps);
    let (main, parts) = files.split_last().expect("files");
    let mut script = Vec::new();
    write_urscript(steps.iter().copied(), &UrScriptOptions::default(), &mut script).expect("a sound path");
    let mut csv = Vec::new();
    write_csv(steps.iter().copied(), &ProgramLimits::default(), &mut csv).expect("a sound path");
    let lines = baseline_rapid(&steps);
    let exact = sum_x(CsvReader::new(csv.as_slice()).expect("a head"));
    let of_parts = || parts.iter().map(|part| sum_x(RapidPart::new(part.as_slice()).expect("a head"))).sum::<f64>();
    assert_eq!(RapidMain::read(main.as_slice()).expect("a main").modules.len(), parts.len());
    for sum in [of_parts(), baseline_read(&lines), sum_x(UrScriptReader::new(script.as_slice()).expect("a head"))] {
        assert!((sum - exact).abs() < 1e-4 * TARGETS as f64);
    }
    let mut group = c.benchmark_group("programs");
    group.throughput(Throughput::Elements(TARGETS as u64)).sample_size(10);
    let mut bench = |name: &str, run: &dyn Fn() -> f64| {
        eprintln!("{name}: at least {:.3} s", least_seconds(10, || _ = black_box(run())));
        group.bench_function(name, |b| b.iter(run));
    };
    bench("write_rapid", &|| rapid(black_box(&steps)).len() as f64);
    bench("write_baseline", &|| baseline_rapid(black_box(&steps)).len() as f64);
    bench("write_urscript", &|| {
        let mut out = Vec::new();
        write_urscript(steps.iter().copied(), &UrScriptOptions::default(), &mut out).expect("sound");
        out.len() as f64
    });
    bench("write_csv", &|| {
        let mut out = Vec::new();
        write_csv(steps.iter().copied(), &ProgramLimits::default(), &mut out).expect("sound");
        out.len() as f64
    });
    bench("read_rapid", &of_parts);
    bench("read_baseline", &|| baseline_read(black_box(&lines)));
    bench("read_urscript", &|| sum_x(UrScriptReader::new(script.as_slice()).expect("a head")));
    bench("read_csv", &|| sum_x(CsvReader::new(csv.as_slice()).expect("a head")));
    group.finish();
}

criterion_group!(benches, bench_programs);
criterion_main!(benches);
