//! A part with a layer: which profiles and which part it names, and its segments.

use super::names::{OURS, TOOLPATH};
use super::profile::{Measures, Range, STEPS};
use super::{FACTOR_DECIMALS, Line, Segment, UNIT_FACTOR_MM, WriteBuildError};
use nalgebra::{Isometry3, Quaternion};
use std::io::Write;

/// Digits of quaternions behind the point: 1e-9 rad.
const QUATERNION_DECIMALS: usize = 9;
/// Digits of filament, mm, and of seconds.
const AMOUNT_DECIMALS: usize = 6;
/// Greatest integer of the extension.
const MAX_INTEGER: f64 = i32::MAX as f64;

/// Opens a layer part. `profiles` are the UUIDs of all profiles; segments name them by their place from 1, and the part of the build as 1.
pub(super) fn open(part: &str, profiles: &[String], out: &mut impl Write) -> Result<(), WriteBuildError> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<layer xmlns=\"{TOOLPATH}\" xmlns:n=\"{OURS}\">")?;
    writeln!(out, "<parts><part id=\"1\" uuid=\"{part}\"/></parts>")?;
    write!(out, "<profiles>")?;
    for (at, uuid) in profiles.iter().enumerate() {
        write!(out, "<profile id=\"{}\" uuid=\"{uuid}\"/>", at + 1)?;
    }
    writeln!(out, "</profiles>\n<segments>")?;
    Ok(())
}

/// Closes it.
pub(super) fn close(out: &mut impl Write) -> Result<(), WriteBuildError> {
    writeln!(out, "</segments>\n</layer>")?;
    Ok(())
}

/// Writes segment number `index`; `jump_s` is how long what was left out before it takes.
pub(super) fn write(
    index: usize,
    segment: &Segment,
    jump_s: f64,
    measures: &Measures,
    out: &mut impl Write,
) -> Result<(), WriteBuildError> {
    let Some((profile, measured)) = measures.get(segment.kind) else {
        return Err(WriteBuildError::Changed { segment: index });
    };
    let microseconds = |seconds: f64| (seconds * 1e6).round();
    write!(out, "<segment type=\"polyline6d\" profileid=\"{}\" partid=\"1\" tag=\"{}\"", profile + 1, segment.path)?;
    let all: f64 = segment.lines.iter().map(|line| line.seconds).sum();
    for (name, seconds) in [("timeprediction", Some(all)), ("jumpprediction", Some(jump_s).filter(|s| *s > 0.0))] {
        // Beyond what the extension can say, 35 minutes, nothing is said.
        if let Some(time) = seconds.map(microseconds).filter(|time| *time <= MAX_INTEGER) {
            write!(out, " {name}=\"{time}\"")?;
        }
    }
    let amounts = [("prime", segment.prime_mm), ("retract", segment.retract_mm), ("filament", segment.filament_mm)];
    for (name, mm) in amounts.into_iter().filter(|(_, mm)| mm.abs() > 0.0) {
        write!(out, " n:{name}=\"")?;
        decimal(mm, AMOUNT_DECIMALS, out)?;
        write!(out, "\"")?;
    }
    writeln!(out, ">")?;
    let speed = measured.speed();
    let sizes = [("e", measured.width()), ("f", measured.height())];
    let mut turn = None;
    pose(index, 0, &segment.start, &mut turn, out)?;
    writeln!(out, "/>")?;
    for (at, line) in segment.lines.iter().enumerate() {
        pose(index, at, &line.end, &mut turn, out)?;
        if let Some([from, to]) = line.bead {
            let ends = [[from.width_mm, to.width_mm], [from.height_mm, to.height_mm]];
            for ((name, range), ends) in sizes.iter().zip(ends) {
                factors(name, *range, ends, out)?;
            }
        }
        of_line(line, speed, out)?;
        writeln!(out, "/>")?;
    }
    writeln!(out, "</segment>")?;
    Ok(())
}

/// Speed of a line; where the tip stands its time.
fn of_line(line: &Line, speed: Option<Range>, out: &mut impl Write) -> Result<(), WriteBuildError> {
    match line.speed_mm_s {
        Some(value) => factors("g", speed, [value; 2], out),
        None => {
            write!(out, " n:seconds=\"")?;
            decimal(line.seconds, AMOUNT_DECIMALS, out)?;
            write!(out, "\"")?;
            Ok(())
        }
    }
}

/// A value at both ends of a line: one factor if they are alike.
fn factors(name: &str, range: Option<Range>, ends: [f64; 2], out: &mut impl Write) -> Result<(), WriteBuildError> {
    let Some(range) = range.filter(Range::varies) else { return Ok(()) };
    let [from, to] = ends.map(|value| f64::from(range.steps(value)) / f64::from(STEPS));
    let same = range.steps(ends[0]) == range.steps(ends[1]);
    let named = if same { vec![("", from)] } else { vec![("1", from), ("2", to)] };
    for (end, factor) in named {
        write!(out, " {name}{end}=\"")?;
        decimal(factor, FACTOR_DECIMALS, out)?;
        write!(out, "\"")?;
    }
    Ok(())
}

/// Opens a point with its place and its quaternion, of the sign that is nearer to the one before.
fn pose(
    segment: usize,
    line: usize,
    at: &Isometry3<f64>,
    before: &mut Option<Quaternion<f64>>,
    out: &mut impl Write,
) -> Result<(), WriteBuildError> {
    write!(out, "<point6d")?;
    let limit = MAX_INTEGER * UNIT_FACTOR_MM;
    for (name, value) in ["x", "y", "z"].into_iter().zip(at.translation.vector.iter()) {
        let steps = (value / UNIT_FACTOR_MM).round();
        // False for NaN.
        let is_within = steps.abs() <= MAX_INTEGER;
        if !is_within {
            return Err(WriteBuildError::Number {
                segment,
                line,
                what: name,
                value: *value,
                least: -limit,
                most: limit,
            });
        }
        write!(out, " {name}=\"{}\"", steps as i32)?;
    }
    let turn = *at.rotation.quaternion();
    // False for NaN.
    let is_unit = (turn.norm() - 1.0).abs() <= 1e-6;
    if !is_unit {
        let (value, least, most) = (turn.norm(), 1.0 - 1e-6, 1.0 + 1e-6);
        return Err(WriteBuildError::Number { segment, line, what: "length of the quaternion", value, least, most });
    }
    let turn = if before.is_some_and(|before| before.dot(&turn) < 0.0) { -turn } else { turn };
    *before = Some(turn);
    for (name, value) in [("i", turn.i), ("j", turn.j), ("k", turn.k), ("w", turn.w)] {
        write!(out, " {name}=\"")?;
        decimal(value, QUATERNION_DECIMALS, out)?;
        write!(out, "\"")?;
    }
    Ok(())
}

/// A number with so many digits behind the point, zeros at the end left out, and no sign on zero.
fn decimal(value: f64, decimals: usize, out: &mut impl Write) -> Result<(), WriteBuildError> {
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    out.write_all(if text == "-0" { "0" } else { text }.as_bytes())?;
    Ok(())
}
