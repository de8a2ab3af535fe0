//! What is laid along the way: filament over way, against the plan.

use super::super::controller::Tick;
use super::tip::Match;
use super::worst::Worst;
use nalgebra::Point3;

/// Beads are compared with the plan over ways of this many widths: less is what a drop evens out.
const CHUNK_WIDTHS: f64 = 1.0;
/// A tip that goes slower than this rests, in mm/s: a drop grows there.
const REST_MM_S: f64 = 0.01;

/// The judge.
#[derive(Clone, Debug)]
pub struct Deposit {
    tick_s: f64,
    /// Shares of the planned area that are too much, in either direction.
    allowed: f64,
    /// Way, filament, planned filament of the chunk under way.
    chunk: [f64; 3],
    /// All filament, in millimetres.
    pub filament_mm: f64,
    /// Filament while the tip is not on the plan.
    pub stray_filament_mm: f64,
    /// Way that was compared, and that with too much or too little, in millimetres.
    pub compared_mm: f64,
    /// Way with too little or too much.
    pub off_mm: f64,
    /// The worst area, as a share of the planned one beside 1.
    pub worst: Worst,
    /// Seconds for which filament comes while the tip rests, the longest at once, and all.
    pub rest_s: f64,
    /// The longest such rest.
    pub rest: Worst,
    resting_s: f64,
}

impl Deposit {
    /// Nothing is laid.
    pub fn new(tick_s: f64, allowed: f64) -> Self {
        Deposit {
            tick_s,
            allowed,
            chunk: [0.0; 3],
            filament_mm: 0.0,
            stray_filament_mm: 0.0,
            compared_mm: 0.0,
            off_mm: 0.0,
            worst: Worst::default(),
            rest_s: 0.0,
            rest: Worst::default(),
            resting_s: 0.0,
        }
    }

    /// A tick: how far the tip went, and where on the plan it is.
    pub fn take(&mut self, tick: &Tick, tip: &Point3<f64>, way_mm: f64, found: Option<&Match>) {
        self.filament_mm += tick.filament_mm;
        let rests = tick.filament_mm > 0.0 && way_mm < REST_MM_S * self.tick_s && !tick.jumped;
        self.resting_s = if rests { self.resting_s + self.tick_s } else { 0.0 };
        if rests {
            self.rest_s += self.tick_s;
            self.rest.take(self.resting_s, tick, Some(tip));
        }
        let Some(Match { bead, .. }) = found else {
            self.stray_filament_mm += tick.filament_mm;
            self.chunk = [0.0; 3];
            return;
        };
        let length = bead.length();
        let planned = if length > 0.0 { bead.filament_mm / length * way_mm } else { 0.0 };
        let [way, filament, wanted] = &mut self.chunk;
        (*way, *filament, *wanted) = (*way + way_mm, *filament + tick.filament_mm, *wanted + planned);
        if *way >= CHUNK_WIDTHS * bead.width {
            let off = (*filament / *wanted - 1.0).abs();
            self.compared_mm += *way;
            self.off_mm += if off <= self.allowed { 0.0 } else { *way };
            self.worst.take(off, tick, Some(tip));
            self.chunk = [0.0; 3];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bead::Bead;
    use super::*;

    #[test]
    fn twice_the_filament_is_twice_the_area() {
        let bead = Bead {
            from: Point3::origin(),
            to: Point3::new(100.0, 0.0, 0.0),
            directions: None,
            width: 1.0,
            height: 0.5,
            filament_mm: 50.0,
            path: 0,
            layer: 0,
        };
        let mut deposit = Deposit::new(0.01, 0.3);
        let tick = |filament_mm: f64| Tick {
            seconds: 0.0,
            axes: [0.0; 8],
            filament_mm,
            extrudes: true,
            place: Default::default(),
            blend_mm: 0.0,
            streams: true,
            jumped: false,
        };
        let on = Match { bead, off_mm: 0.0 };
        let tip = Point3::origin();
        for k in 0..1000 {
            deposit.take(&tick(if k < 500 { 0.05 } else { 0.1 }), &tip, 0.1, Some(&on));
        }
        assert!((deposit.compared_mm - 100.0).abs() < 1.1 && (deposit.off_mm - 50.0).abs() < 1.1, "{deposit:?}");
        assert!((deposit.worst.value - 1.0).abs() < 1e-9 && deposit.rest_s == 0.0);
        for _ in 0..30 {
            deposit.take(&tick(0.1), &tip, 0.0, Some(&on));
        }
        deposit.take(&tick(0.1), &tip, 0.1, None);
        assert!((deposit.rest.value - 0.3).abs() < 1e-9 && (deposit.stray_filament_mm - 0.1).abs() < 1e-12);
    }
}
