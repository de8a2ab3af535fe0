//! The nozzle against the plan: how far the tip is from the planned polyline while it extrudes, in the order of the plan, what of the plan it leaves out, and
//! whether the nozzle leans as planned.
//!
//! The plan is read as the tip goes along: only beads from where it is up to some way ahead are in memory. A place that is not near them is looked for farther
//! ahead; where it is not there either, the tip is off the plan.

use super::super::axes::NozzlePose;
use super::super::controller::Tick;
use super::bead::Bead;
use super::histogram::Histogram;
use super::worst::Worst;
use curvlay_examples::laid::to_chord;
use nalgebra::Point3;
use std::collections::VecDeque;

/// How far ahead of the last match the next one may be, in widths of the bead: beside the way of the tip itself.
const AHEAD_WIDTHS: f64 = 1.5;
/// The match may also be this much of a width behind.
const BEHIND_WIDTHS: f64 = 0.5;
/// Within this many widths the tip is on the plan; where a path ends, and another one may begin beside it, within fewer.
const NEAR_WIDTHS: f64 = 3.0;
const NEAR_END_WIDTHS: f64 = 1.0;
/// Within this many widths of it a place farther ahead is taken as where the tip is.
const FOUND_WIDTHS: f64 = 0.3;
/// Beads that are looked through farther ahead: while it goes on, and when the extruder is switched on.
const WIDE_BEADS: usize = 200;
const START_BEADS: usize = 5000;

/// Where on the plan the tip is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// The bead.
    pub bead: Bead,
    /// How far the tip is from it, in millimetres.
    pub off_mm: f64,
}

/// The judge.
pub struct Tip<'p> {
    plan: Box<dyn Iterator<Item = Result<Bead, String>> + 'p>,
    ahead: VecDeque<Bead>,
    /// How much of the first bead is passed.
    share: f64,
    /// The tip at the last tick, if it extruded.
    last: Option<Point3<f64>>,
    /// Whether the last match was at an end of a path, where it may leave the plan.
    is_at_end: bool,
    /// The extruder was off since the last match.
    is_start: bool,
    allowed_widths: f64,
    /// How far the tip is off: in millimetres, weighted by the way, and the worst as a share of the width.
    pub errors: Histogram,
    /// Worst error as a share of the width of the bead.
    pub worst: Worst,
    /// That error in millimetres.
    pub worst_mm: f64,
    /// Way while it extrudes, that on the plan, that between paths, in millimetres.
    pub extruded_mm: f64,
    /// The way that is off by more than is allowed.
    pub off_mm: f64,
    /// By how much the nozzle direction differs from the plan, in degrees: weighted by the way, and the worst.
    pub tilts: Histogram,
    /// The worst of them.
    pub tilt: Worst,
    /// The way on which it is more than is allowed.
    pub tilted_mm: f64,
    allowed_deg: f64,
    /// The way between paths.
    pub stray_mm: f64,
    /// Where most of that was at a tick.
    pub stray: Worst,
    /// Planned way, and that of beads whose ends the tip did not pass.
    pub planned_mm: f64,
    /// Way that is left out.
    pub missed_mm: f64,
    /// The first bead that is.
    pub missed_at: Option<Bead>,
    /// How far the worst of them is from the way of the tip; infinite at the end.
    pub missed_by_mm: f64,
    /// Filament of all that is planned so far.
    pub planned_filament_mm: f64,
}

impl<'p> Tip<'p> {
    /// Before the first bead; errors of more than `allowed_widths` widths count, and of more than `allowed_deg` degrees.
    pub fn new(
        plan: Box<dyn Iterator<Item = Result<Bead, String>> + 'p>,
        [allowed_widths, allowed_deg]: [f64; 2],
    ) -> Self {
        Tip {
            plan,
            ahead: VecDeque::new(),
            share: 0.0,
            last: None,
            is_at_end: true,
            is_start: true,
            allowed_widths,
            errors: Histogram::default(),
            worst: Worst::default(),
            worst_mm: 0.0,
            extruded_mm: 0.0,
            off_mm: 0.0,
            tilts: Histogram::default(),
            tilt: Worst::default(),
            tilted_mm: 0.0,
            allowed_deg,
            stray_mm: 0.0,
            stray: Worst::default(),
            planned_mm: 0.0,
            missed_mm: 0.0,
            missed_at: None,
            missed_by_mm: 0.0,
            planned_filament_mm: 0.0,
        }
    }

    /// A tick, and how far the tip went since the last one.
    ///
    /// # Returns
    /// Where on the plan it is, if it extrudes and is on it.
    ///
    /// # Errors
    /// What the reader of the plan says.
    pub fn take(&mut self, tick: &Tick, pose: &NozzlePose, way_mm: f64) -> Result<Option<Match>, String> {
        let tip = &pose.tip;
        if !tick.extrudes {
            if self.last.take().is_some() {
                self.lift();
            }
            self.is_start = true;
            return Ok(None);
        }
        // The first tick of a stroke has its way from before the extruder ran.
        let way = if self.last.is_some() { way_mm } else { 0.0 };
        let found = self.find(tip, way)?;
        self.extruded_mm += way;
        let found = match found {
            Some((bead, share, off_mm)) => {
                self.pass(bead, share, tip);
                let bead = self.ahead[0];
                self.is_at_end = self.left_of_path() < bead.width;
                self.is_start = false;
                self.error(tick, tip, &bead, off_mm, way);
                self.lean(tick, pose, bead.tilt_off(share, &pose.axis).to_degrees(), way);
                Some(Match { bead, off_mm })
            }
            None => {
                self.lost(tick, tip, way);
                None
            }
        };
        self.last = Some(*tip);
        Ok(found)
    }

    fn error(&mut self, tick: &Tick, tip: &Point3<f64>, bead: &Bead, off_mm: f64, way: f64) {
        self.errors.add(off_mm, way.max(1e-9));
        let share = off_mm / bead.width;
        if share > self.worst.value {
            self.worst_mm = off_mm;
        }
        self.worst.take(share, tick, Some(tip));
        if share > self.allowed_widths {
            self.off_mm += way;
        }
    }

    /// The nozzle direction differs from the plan by so many degrees.
    fn lean(&mut self, tick: &Tick, pose: &NozzlePose, off_deg: f64, way: f64) {
        self.tilts.add(off_deg, way.max(1e-9));
        self.tilt.take(off_deg, tick, Some(&pose.tip));
        if off_deg > self.allowed_deg {
            self.tilted_mm += way;
        }
    }

    /// The tip is not on the plan: on its way between two paths, or astray.
    fn lost(&mut self, tick: &Tick, tip: &Point3<f64>, way: f64) {
        if self.is_at_end {
            self.stray_mm += way;
            self.stray.take(way, tick, Some(tip));
            return;
        }
        let Some(bead) = self.ahead.front().copied() else { return };
        let (_, off_mm) = bead.nearest(tip, self.share);
        self.error(tick, tip, &bead, off_mm, way);
    }

    /// How much of the path under way is left, up to one width.
    fn left_of_path(&self) -> f64 {
        let Some(first) = self.ahead.front() else { return 0.0 };
        let mut left = (1.0 - self.share) * first.length();
        for bead in self.ahead.iter().skip(1).take_while(|bead| bead.path == first.path) {
            left += bead.length();
            if left > first.width {
                break;
            }
        }
        left
    }

    /// Reads beads until there are so many, or so much way.
    fn read(&mut self, beads: usize, way_mm: f64) -> Result<(), String> {
        let mut way: f64 = self.ahead.iter().take(beads).map(Bead::length).sum();
        while self.ahead.len() < beads && way < way_mm {
            let Some(bead) = self.plan.next().transpose()? else { break };
            way += bead.length();
            self.planned_mm += bead.length();
            self.planned_filament_mm += bead.filament_mm;
            self.ahead.push_back(bead);
        }
        Ok(())
    }

    /// The bead at which the tip is, the share of it, and the distance.
    fn find(&mut self, tip: &Point3<f64>, way: f64) -> Result<Option<(usize, f64, f64)>, String> {
        self.read(2, f64::INFINITY)?;
        let Some(first) = self.ahead.front().copied() else { return Ok(None) };
        let length = first.length();
        let reach = AHEAD_WIDTHS * first.width + 2.0 * way;
        self.read(WIDE_BEADS, length + reach)?;
        let behind = if length > 0.0 { BEHIND_WIDTHS * first.width / length } else { 0.0 };
        let mut best: Option<(usize, f64, f64)> = None;
        let mut begin = -self.share * length;
        for (k, bead) in self.ahead.iter().enumerate().take(WIDE_BEADS) {
            if begin > reach {
                break;
            }
            let (share, off) = bead.nearest(tip, if k == 0 { (self.share - behind).max(0.0) } else { 0.0 });
            if best.is_none_or(|(_, _, least)| off < least) {
                best = Some((k, share, off));
            }
            begin += bead.length();
        }
        let near = if self.is_at_end && !self.is_start { NEAR_END_WIDTHS } else { NEAR_WIDTHS };
        if best.is_some_and(|(_, _, off)| off <= near * first.width) {
            return Ok(best);
        }
        self.find_far(tip)
    }

    /// The same farther ahead.
    fn find_far(&mut self, tip: &Point3<f64>) -> Result<Option<(usize, f64, f64)>, String> {
        let beads = if self.is_start { START_BEADS } else { WIDE_BEADS };
        self.read(beads, f64::INFINITY)?;
        let near = self.ahead.iter().take(beads).enumerate().find_map(|(k, bead)| {
            let (share, off) = bead.nearest(tip, 0.0);
            (off <= FOUND_WIDTHS * bead.width).then_some((k, share, off))
        });
        Ok(near)
    }

    /// Goes on to a bead: ends of those before it must be near to the way of the tip.
    fn pass(&mut self, bead: usize, share: f64, tip: &Point3<f64>) {
        let from = self.last.unwrap_or(*tip);
        for _ in 0..bead {
            let Some(passed) = self.ahead.pop_front() else { return };
            let off = to_chord(&passed.to, &from, tip);
            if off > self.allowed_widths * passed.width {
                self.miss(passed, off);
            }
        }
        self.share = if bead == 0 { self.share.max(share) } else { share };
    }

    fn miss(&mut self, bead: Bead, off_mm: f64) {
        self.missed_mm += bead.length();
        self.missed_at = self.missed_at.or(Some(bead));
        self.missed_by_mm = self.missed_by_mm.max(off_mm);
    }

    /// The extruder goes off: what is left of a path but for a width is done.
    fn lift(&mut self) {
        if !self.is_at_end {
            return;
        }
        let Some(path) = self.ahead.front().map(|bead| bead.path).filter(|_| self.share > 0.0) else { return };
        while self.ahead.front().is_some_and(|bead| bead.path == path) {
            self.ahead.pop_front();
        }
        self.share = 0.0;
    }

    /// The program has ended: all that is left of the plan is left out.
    ///
    /// # Errors
    /// What the reader of the plan says.
    pub fn finish(&mut self) -> Result<(), String> {
        self.lift();
        loop {
            self.read(1, f64::INFINITY)?;
            let Some(bead) = self.ahead.pop_front() else { return Ok(()) };
            let left = Bead { from: bead.from + (bead.to - bead.from) * self.share, ..bead };
            self.share = 0.0;
            if left.length() > self.allowed_widths * left.width {
                self.miss(left, f64::INFINITY);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn beads() -> Vec<Bead> {
        let corner = |x: f64, y: f64| Point3::new(x, y, 0.3);
        let paths = [
            vec![corner(0.0, 0.0), corner(20.0, 0.0), corner(20.0, 10.0), corner(0.0, 10.0)],
            vec![corner(0.0, 12.0), corner(20.0, 12.0)],
        ];
        let bead = |path: usize, ends: &[Point3<f64>]| Bead {
            from: ends[0],
            to: ends[1],
            directions: Some([Vector3::z(); 2]),
            width: 1.0,
            height: 0.3,
            filament_mm: 1.0,
            path: path as u32,
            layer: 0,
        };
        paths.iter().enumerate().flat_map(|(k, path)| path.windows(2).map(move |ends| bead(k, ends))).collect()
    }

    /// Goes along corners, extruding on some of the ways.
    fn judged(ways: &[([f64; 2], bool)]) -> Tip<'static> {
        leaning(ways, Vector3::z())
    }

    fn leaning(ways: &[([f64; 2], bool)], axis: Vector3<f64>) -> Tip<'static> {
        let mut judge = Tip::new(Box::new(beads().into_iter().map(Ok)), [0.25, 5.0]);
        let mut at = Point3::new(ways[0].0[0], ways[0].0[1], 0.3);
        let mut seconds = 0.0;
        for ([x, y], extrudes) in ways {
            let to = Point3::new(*x, *y, 0.3);
            let steps = ((to - at).norm() / 0.2).ceil().max(1.0) as u32;
            let mut before = at;
            for k in 1..=steps {
                let tip = at + (to - at) * (f64::from(k) / f64::from(steps));
                seconds += 0.01;
                let tick = Tick {
                    seconds,
                    axes: [0.0; 8],
                    filament_mm: 0.0,
                    extrudes: *extrudes,
                    place: Default::default(),
                    blend_mm: 0.0,
                    streams: true,
                    jumped: false,
                };
                judge.take(&tick, &NozzlePose { tip, axis }, (tip - before).norm()).unwrap();
                before = tip;
            }
            at = to;
        }
        judge.finish().unwrap();
        judge
    }

    #[test]
    fn what_follows_the_plan_has_no_error() {
        let judge = judged(&[
            ([0.0, 0.0], false),
            ([20.0, 0.0], true),
            ([20.0, 10.0], true),
            ([0.0, 10.0], true),
            ([0.0, 12.0], false),
            ([20.0, 12.0], true),
        ]);
        assert!(judge.worst_mm < 1e-9 && judge.missed_mm < 1e-9 && judge.stray_mm < 1e-9);
        assert!(
            (judge.planned_mm - 70.0).abs() < 1e-9 && (judge.extruded_mm - 69.6).abs() < 0.1,
            "{}",
            judge.extruded_mm
        );
    }

    #[test]
    fn a_nozzle_that_leans_otherwise_is_seen_at_the_right_tip() {
        let axis = Vector3::new(10f64.to_radians().sin(), 0.0, 10f64.to_radians().cos());
        let judge = leaning(&[([0.0, 0.0], false), ([20.0, 0.0], true)], axis);
        assert!((judge.tilt.value - 10.0).abs() < 1e-9 && judge.worst_mm < 1e-9, "{:?}", judge.tilt);
        assert!((judge.tilted_mm - 20.0).abs() < 0.3 && (judge.tilts.quantile(0.5) / 10.0 - 1.0).abs() < 0.05);
    }

    #[test]
    fn a_corner_that_is_cut_is_an_error_and_left_out() {
        let judge = judged(&[
            ([0.0, 0.0], false),
            ([18.0, 0.0], true),
            ([20.0, 2.0], true),
            ([20.0, 10.0], true),
            ([0.0, 10.0], true),
            ([0.0, 12.0], false),
            ([20.0, 12.0], true),
        ]);
        // The middle of the cut is a millimetre from either bead.
        assert!((judge.worst_mm - 1.0).abs() < 0.1, "{}", judge.worst_mm);
        assert!(judge.missed_mm > 19.0 && judge.missed_by_mm > 1.0 && judge.off_mm > 1.0);
    }

    #[test]
    fn a_path_that_is_left_out_is_missed_and_the_next_one_is_found() {
        let judge = judged(&[([0.0, 12.0], false), ([20.0, 12.0], true)]);
        assert!((judge.missed_mm - 50.0).abs() < 1e-9 && judge.worst_mm < 1e-9, "{}", judge.missed_mm);
        let judge = judged(&[([0.0, 0.0], false), ([20.0, 0.0], true)]);
        assert!((judge.missed_mm - 50.0).abs() < 0.3, "{}", judge.missed_mm);
    }

    #[test]
    fn an_extruder_that_stays_on_strays_between_paths() {
        let ways = [[0.0, 0.0], [20.0, 0.0], [20.0, 10.0], [0.0, 10.0], [-20.0, 20.0], [0.0, 12.0], [20.0, 12.0]];
        let judge = judged(&ways.map(|way| (way, true)));
        assert!(judge.stray_mm > 35.0 && judge.worst_mm <= 1.0 + 1e-9, "{} {}", judge.stray_mm, judge.worst_mm);
    }
}
