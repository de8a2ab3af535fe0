//! `trajectory.csv`: the motion, knot by knot, written and read again.

use super::planned::MotionRun;
use curvlay_kinematics::Track;
use curvlay_kinematics::workcell::Workcell;
use curvlay_trajectory::check::WrittenMotion;
use curvlay_trajectory::print::SegmentKind;
use std::io::{self, BufRead, Write};

/// The file in the output folder.
pub const FILE: &str = "trajectory.csv";

/// A line a knot. Times go on from motion to motion; enough digits for jerks. A track is in millimetres.
pub fn write_csv<const N: usize, const F: usize, W: Workcell<N, F>>(
    run: &MotionRun<N, F, W>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let track = run.cell.equipment().track();
    let name = |joint: usize| if joint == N && track.is_some() { "track_mm".to_owned() } else { format!("q{joint}") };
    let names: Vec<String> = (1..=N).map(name).collect();
    writeln!(out, "motion,time_s,{},kind,layer,path,waypoint,filament_mm", names.join(","))?;
    let (mut start, mut laid) = (0.0, 0.0);
    let plan = &run.plan;
    for (number, leg) in plan.segments(0..plan.runs.len()).enumerate() {
        let (kind, layer, path) = (leg.kind.name(), leg.run.layer + 1, leg.run.path);
        let passes = if leg.kind == SegmentKind::Print { &leg.run.passes[..] } else { &[] };
        let mut passes = passes.iter().filter_map(|&(knot, waypoint)| Some((knot, waypoint?))).peekable();
        for (knot, (time, joints)) in leg.knots().iter().enumerate() {
            write!(out, "{number},{}", start + time)?;
            let joints = on_track(*joints, track, Track::mm);
            joints.iter().try_for_each(|joint| write!(out, ",{joint:.13}"))?;
            write!(out, ",{kind},{layer},{path},")?;
            if let Some((_, waypoint)) = passes.next_if(|(passed, _)| *passed == knot) {
                write!(out, "{waypoint}")?;
            }
            writeln!(out, ",{:.6}", laid + leg.filament_mm(*time))?;
        }
        start += leg.duration();
        laid += leg.filament_mm(leg.duration());
    }
    Ok(())
}

/// Joints of which the last is turned into another unit where it is that of a track.
fn on_track<const N: usize>(mut joints: [f64; N], track: Option<&Track>, unit: fn(&Track, f64) -> f64) -> [f64; N] {
    if let (Some(track), Some(last)) = (track, joints.last_mut()) {
        *last = unit(track, *last);
    }
    joints
}

/// Reads the motions of a `trajectory.csv`, of a workcell with this track.
pub fn read_csv<const N: usize>(file: impl BufRead, track: Option<&Track>) -> io::Result<Vec<WrittenMotion<N>>> {
    let mut motions: Vec<WrittenMotion<N>> = Vec::new();
    let mut last = None;
    for (number, line) in file.lines().enumerate().skip(1) {
        let line = line?;
        let bad = || io::Error::other(format!("trajectory.csv, line {}: cannot be read again", number + 1));
        let cells: Vec<&str> = line.split(',').collect();
        let [motion, time, joints @ .., kind, layer, path, waypoint, _] = &cells[..] else { return Err(bad()) };
        if last.as_deref() != Some(*motion) {
            last = Some((*motion).to_owned());
            let kind = SegmentKind::ALL.into_iter().find(|known| known.name() == *kind).ok_or_else(bad)?;
            let layer = layer.parse::<u32>().ok().and_then(|layer| layer.checked_sub(1)).ok_or_else(bad)?;
            let path = path.parse().map_err(|_| bad())?;
            let (times, joints, waypoints) = (Vec::new(), Vec::new(), Vec::new());
            motions.push(WrittenMotion { kind, layer, path, times, joints, waypoints });
        }
        let motion = motions.last_mut().ok_or_else(bad)?;
        let joints: Option<Vec<f64>> = joints.iter().map(|joint| joint.parse().ok()).collect();
        motion.times.push(time.parse().map_err(|_| bad())?);
        let joints: [f64; N] = joints.and_then(|joints| joints.try_into().ok()).ok_or_else(bad)?;
        motion.joints.push(on_track(joints, track, Track::joint));
        if !waypoint.is_empty() {
            motion.waypoints.push((waypoint.parse().map_err(|_| bad())?, motion.times[motion.times.len() - 1]));
        }
    }
    Ok(motions)
}
