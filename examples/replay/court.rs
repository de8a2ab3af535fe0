//! All judges at once, and what the report shows: takes ticks, whoever makes them.

use super::args::AllowArgs;
use super::axes::{Axes, NozzlePose};
use super::controller::Tick;
use super::judge::{Bead, Contact, Deposit, Joints, Match, Tip};
use super::machine::Machine;
use super::trace::{self, Thinned};
use curvlay_examples::laid::Nozzle;
use curvlay_examples::viewer::Step;
use nalgebra::Point3;
use std::io::{self, Write};

/// A tick at which the viewer shows how the robot stands: when, and the axes.
pub type Shown = (f64, Axes);

/// Most moments at which the robot is shown.
const MAX_SHOWN: usize = 4000;
/// Height and width of beads of which no plan says anything, as shares of the tip of the nozzle.
const BEAD_HEIGHT: f64 = 0.5;
const BEAD_WIDTH: f64 = 1.2;

/// The judges.
pub struct Court<'a> {
    machine: &'a Machine,
    tick_s: f64,
    nozzle: Nozzle,
    /// Axes against limits.
    pub joints: Joints,
    /// Tip against plan.
    pub tip: Option<Tip<'a>>,
    /// Material against plan.
    pub deposit: Deposit,
    /// Nozzle against what is built.
    pub contact: Contact,
    /// Greatest error of the tip over time, in millimetres.
    pub errors: Thinned<[f64; 2]>,
    /// Speed of the tip over the part, in mm/s.
    pub speeds: Thinned<[f64; 2]>,
    /// Axes over time.
    pub curves: Vec<Thinned<[f64; 2]>>,
    /// Steps of the viewer.
    pub steps: Thinned<Step>,
    /// How the robot stands.
    pub shown: Thinned<Shown>,
    /// Greatest speed of the tip, and while it extrudes, in mm/s.
    pub max_tip_mm_s: f64,
    last: Option<NozzlePose>,
    bead: Option<Bead>,
    /// The plan could not be read.
    pub fault: Option<String>,
    table: Option<Box<dyn Write + 'a>>,
    /// The table could not be written.
    pub unwritten: Option<io::Error>,
    /// Ticks.
    pub ticks: u64,
    /// Whether the program says how much material comes out.
    pub has_amounts: bool,
}

impl<'a> Court<'a> {
    /// Before the first tick.
    pub fn new(
        machine: &'a Machine,
        tick_s: f64,
        (nozzle, plate_mm): (Nozzle, Option<f64>),
        allow: &AllowArgs,
        plan: Option<Tip<'a>>,
    ) -> Self {
        let names = machine.axis_names();
        Court {
            machine,
            tick_s,
            nozzle,
            joints: Joints::new(machine.limits(), tick_s, allow.allow_limits),
            tip: plan,
            deposit: Deposit::new(tick_s, allow.allow_area),
            contact: Contact::new(nozzle, plate_mm, tick_s, allow.allow_contact),
            errors: trace::curve(),
            speeds: trace::curve(),
            curves: names.iter().map(|_| trace::curve()).collect(),
            steps: trace::steps(),
            shown: Thinned::new(MAX_SHOWN, |a, _| *a),
            max_tip_mm_s: 0.0,
            last: None,
            bead: None,
            fault: None,
            table: None,
            unwritten: None,
            ticks: 0,
            has_amounts: true,
        }
    }

    /// Writes every tick into a table.
    ///
    /// # Errors
    /// What the system says.
    pub fn write_to(&mut self, mut table: Box<dyn Write + 'a>) -> io::Result<()> {
        writeln!(table, "time_s,{},x_mm,y_mm,z_mm,i,j,k,filament_mm,file,step", self.machine.axis_names().join(","))?;
        self.table = Some(table);
        Ok(())
    }

    /// A tick.
    pub fn take(&mut self, tick: &Tick) {
        let pose = self.machine.nozzle_on_part(&tick.axes);
        let last = self.last.filter(|_| !tick.jumped);
        let way = last.map_or(0.0, |last| (pose.tip - last.tip).norm());
        self.max_tip_mm_s = self.max_tip_mm_s.max(way / self.tick_s);
        self.ticks += 1;
        self.joints.take(tick);
        let found = self.compare(tick, &pose, way);
        if let Some(found) = &found {
            self.bead = Some(found.bead);
            self.errors.push([tick.seconds, found.off_mm]);
        }
        self.deposit.take(tick, &pose.tip, way, found.as_ref());
        let height = self.bead.map_or(2.0 * BEAD_HEIGHT * self.nozzle.tip, |bead| bead.height);
        self.contact.take(tick, &pose, self.lays(tick).then_some(height));
        self.show(tick, &pose, way);
        self.last = Some(pose);
        if let Err(error) = self.write(tick, &pose) {
            (self.unwritten, self.table) = (Some(error), None);
        }
    }

    /// Whether material comes out.
    fn lays(&self, tick: &Tick) -> bool {
        tick.extrudes && (tick.filament_mm > 0.0 || !self.has_amounts)
    }

    fn compare(&mut self, tick: &Tick, pose: &NozzlePose, way: f64) -> Option<Match> {
        let judge = self.tip.as_mut().filter(|_| self.fault.is_none())?;
        match judge.take(tick, pose, way) {
            Ok(found) => found,
            Err(fault) => {
                self.fault = Some(fault);
                None
            }
        }
    }

    fn show(&mut self, tick: &Tick, pose: &NozzlePose, way: f64) {
        self.speeds.push([tick.seconds, way / self.tick_s]);
        for (k, curve) in self.curves.iter_mut().enumerate() {
            let scale = if self.machine.turns(k) { 1f64.to_degrees() } else { 1.0 };
            curve.push([tick.seconds, tick.axes[k] * scale]);
        }
        let [width, height] = match &self.bead {
            Some(bead) => [bead.width, bead.height],
            None => [2.0 * BEAD_WIDTH * self.nozzle.tip, 2.0 * BEAD_HEIGHT * self.nozzle.tip],
        };
        let (layer, path) = self.bead.map_or((0, 0), |bead| (bead.layer, bead.path));
        let kind = if self.lays(tick) && !tick.jumped { 0 } else { Step::TRAVEL };
        let (tip, direction, seconds) = (pose.tip, pose.axis, self.tick_s);
        self.steps.push(Step { tip, direction, width, height, kind, layer, path, seconds });
        self.shown.push((tick.seconds, tick.axes));
    }

    fn write(&mut self, tick: &Tick, pose: &NozzlePose) -> io::Result<()> {
        let Some(table) = &mut self.table else { return Ok(()) };
        write!(table, "{:.4}", tick.seconds)?;
        for axis in &tick.axes[..self.curves.len()] {
            write!(table, ",{axis:.9}")?;
        }
        let (Point3 { coords: p }, d) = (pose.tip, pose.axis);
        write!(table, ",{:.6},{:.6},{:.6},{:.6},{:.6},{:.6}", p.x, p.y, p.z, d.x, d.y, d.z)?;
        writeln!(table, ",{:.6},{},{}", tick.filament_mm, tick.place.file, tick.place.step)
    }

    /// The program has ended.
    pub fn finish(&mut self) {
        if let Some(Err(fault)) = self.tip.as_mut().map(Tip::finish) {
            self.fault = self.fault.take().or(Some(fault));
        }
        if let Some(Err(error)) = self.table.as_mut().map(|table| table.flush()) {
            self.unwritten = Some(error);
        }
        self.table = None;
    }
}
