//! What the judges found, in words.

use super::args::Args;
use super::court::Court;
use super::judge::{Quantity, Worst};
use super::program::Files;
use super::program::command::Place;
use super::run::Executed;
use super::setup::Setup;
use curvlay_examples::findings::{Findings, Severity, accept, percent};

/// Times, speeds and places of the findings.
pub struct Judged<'a> {
    args: &'a Args,
    setup: &'a Setup,
    executed: &'a Executed,
    court: &'a Court<'a>,
    findings: Findings,
}

/// Where half of the way is off by more than this share of the worst error, the whole program is off.
const SYSTEMATIC: f64 = 0.3;

/// All findings of a run.
pub fn findings(args: &Args, setup: &Setup, executed: &Executed, court: &Court) -> Findings {
    let mut judged = Judged { args, setup, executed, court, findings: Findings::default() };
    judged.machine();
    judged.time();
    judged.targets();
    judged.limits();
    judged.tip();
    judged.deposit();
    judged.contact();
    judged.findings
}

/// `step 12 of print_001.script, 3.456 s`.
pub fn place(executed: &Executed, gcode: bool, worst: &Worst) -> String {
    format!("{}, after {:.2} s", command(executed, gcode, worst.place), worst.seconds)
}

/// `step 12 of print_001.script`: where no time is known.
fn command(executed: &Executed, gcode: bool, place: Place) -> String {
    let word = if gcode { "line" } else { "step" };
    let file = executed.files.get(place.file as usize).map_or("", String::as_str);
    format!("{word} {} of {file}", place.step)
}

impl Judged<'_> {
    fn is_gcode(&self) -> bool {
        matches!(self.setup.machine, super::machine::Machine::FiveAxis(_))
    }

    fn at(&self, worst: &Worst) -> String {
        place(self.executed, self.is_gcode(), worst)
    }

    fn at_command(&self, at: Place) -> String {
        command(self.executed, self.is_gcode(), at)
    }

    fn machine(&mut self) {
        if let Some(by) = &self.setup.machine_by {
            let severity = if by.starts_with("a guess") { Severity::Warning } else { Severity::Note };
            self.findings.add(severity, "no workcell was named, this one was taken", by.clone(), "");
        }
        let Files { kind, paths, others } = &self.setup.files;
        if !others.is_empty() {
            let first = paths[0].file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            let amount = format!("{first} ({})", kind.name());
            self.findings
                .explain(Severity::Note, "of the programs in the folder one is replayed", amount, "")
                .cause(format!("not replayed: {}", others.join(", ")));
        }
        if self.setup.plan.is_none() {
            self.findings
                .explain(Severity::Note, "there is no plan: the tip and the beads are compared with nothing", "", "")
                .try_to("--plan toolpath.gcode");
        }
    }

    fn time(&mut self) {
        let Executed { seconds, programmed_s, .. } = *self.executed;
        let (planned, whose) = match self.setup.planned_s {
            Some(planned) => (planned, "planned"),
            None => (programmed_s, "programmed"),
        };
        if planned <= 0.0 {
            return;
        }
        let off = (seconds / planned - 1.0).abs();
        if off > self.args.allow.allow_time.unwrap_or(0.0) {
            let amount = format!("{seconds:.1} s instead of {planned:.1} s, {}", percent(off));
            let what = format!("the program takes another time than {whose}");
            let finding = self.findings.explain(Severity::Failed, what, amount, "");
            if seconds > planned {
                finding.cause("accelerations, blends and limits of axes take time, in which the extruder goes on");
            }
            finding.allow(accept("--allow-time", off));
        }
    }

    fn targets(&mut self) {
        let obstacles = &self.executed.obstacles;
        let (count, off_mm, at) = obstacles.missed;
        if count > 0 {
            let amount = format!("{count} of {} moves, by up to {off_mm:.3} mm", obstacles.moves);
            self.findings
                .explain(Severity::Failed, "targets are out of reach", amount, self.at_command(at))
                .cause("no joints near to those before bring the tool there: too far, or past a singular posture")
                .try_to("compare tool and work object of the program with the workcell");
        }
        if let (count @ 1.., Some(at)) = obstacles.turned {
            let amount = format!("{count} of {} moves", obstacles.moves);
            self.findings
                .explain(Severity::Failed, "targets are reached in other quarter turns than their configuration data say", amount, self.at_command(at))
                .cause("a joint was turned by a whole turn, or the branch of the arm is another; with ConfL\\On the controller stops there");
        }
        if let (count @ 1.., Some(at)) = obstacles.endless {
            self.findings
                .explain(
                    Severity::Failed,
                    "moves take more than a day and are left out",
                    count.to_string(),
                    self.at_command(at),
                )
                .cause("a speed or a time with a wrong unit");
        }
        if let (count @ 1.., Some(at)) = obstacles.cut {
            let amount = format!("{count} of {} moves", obstacles.moves);
            self.findings
                .explain(Severity::Warning, "blend zones are wider than half of a move", amount, self.at_command(at))
                .cause(
                    "ABB controllers cut such zones, Universal Robots skip the blend and say so (overlapping blends)",
                )
                .try_to("smaller zones, or longer moves");
        }
    }

    fn limits(&mut self) {
        let names = self.setup.machine.axis_names();
        let allowed = self.args.allow.allow_limits;
        for quantity in Quantity::ALL {
            let (axis, worst) = self.court.joints.worst(quantity);
            let is_failed = worst.value > if quantity == Quantity::Range { 0.0 } else { allowed };
            let Some(name) = names.get(axis).filter(|_| is_failed) else { continue };
            let turns = self.setup.machine.turns(axis);
            let (what, amount) = match quantity {
                Quantity::Range if turns => {
                    ("an axis leaves its range", format!("{name} by {:.3} degrees", worst.value.to_degrees()))
                }
                Quantity::Range => ("an axis leaves its range", format!("{name} by {:.3} mm", worst.value)),
                Quantity::Speed => ("an axis is faster than its limit", format!("{name}, {:.2} times", worst.value)),
                Quantity::Acceleration => {
                    ("an axis accelerates more than its limit", format!("{name}, {:.2} times", worst.value))
                }
                Quantity::Jerk => {
                    ("the jerk of an axis is above its limit", format!("{name}, {:.2} times", worst.value))
                }
            };
            let place = self.at(&worst);
            let finding = self.findings.explain(Severity::Failed, what, amount, place);
            if quantity == Quantity::Speed && worst.value > JUMP {
                finding.cause(
                    "the program jumps: a step is missing, or a joint turned by a whole turn or to the other side",
                );
            }
            if quantity != Quantity::Range {
                finding.allow(accept("--allow-limits", worst.value));
            }
        }
    }

    fn tip(&mut self) {
        let Some(tip) = &self.court.tip else { return };
        let allow = &self.args.allow;
        if tip.worst.value > allow.allow_tip {
            let share = if tip.extruded_mm > 0.0 { tip.off_mm / tip.extruded_mm } else { 0.0 };
            let amount = format!(
                "{:.3} mm, {} of a bead; over {} of the way",
                tip.worst_mm,
                percent(tip.worst.value),
                percent(share)
            );
            let is_whole = tip.errors.quantile(0.5) > SYSTEMATIC * tip.worst_mm;
            let cause = if is_whole {
                "the whole program is off: a tool, a pivot, a work object or an axis of the machine is another than the plan had".to_owned()
            } else if tip.worst.blend_mm > 0.0 {
                format!("it is in a blend that reaches {:.3} mm from its corner", tip.worst.blend_mm)
            } else {
                String::new()
            };
            let place = self.at(&tip.worst);
            self.findings
                .explain(Severity::Failed, "the tip is off the planned path", amount, place)
                .cause(cause)
                .allow(accept("--allow-tip", tip.worst.value));
        }
        self.tilt();
        self.missed();
    }

    /// What the tip leaves out, and where it extrudes beside the plan.
    fn missed(&mut self) {
        let Some(tip) = &self.court.tip else { return };
        let allow = &self.args.allow;
        let missed = if tip.planned_mm > 0.0 { tip.missed_mm / tip.planned_mm } else { 0.0 };
        if missed > allow.allow_missed {
            let by = if tip.missed_by_mm.is_finite() {
                format!(", passed {:.3} mm away", tip.missed_by_mm)
            } else {
                String::new()
            };
            let amount = format!("{:.1} mm, {}{by}", tip.missed_mm, percent(missed));
            let place = tip.missed_at.map_or_else(String::new, |bead| {
                format!(
                    "the first at {:.2}, {:.2}, {:.2} mm, layer {}, path {}",
                    bead.to.x,
                    bead.to.y,
                    bead.to.z,
                    bead.layer + 1,
                    bead.path
                )
            });
            self.findings
                .explain(Severity::Failed, "planned ways are left out", amount, place)
                .cause("lines or files of the program are missing, or corners are cut")
                .allow(accept("--allow-missed", missed));
        }
        let stray = if tip.extruded_mm > 0.0 { tip.stray_mm / tip.extruded_mm } else { 0.0 };
        if stray > allow.allow_stray {
            let place = self.at(&tip.stray);
            self.findings
                .explain(
                    Severity::Failed,
                    "the extruder runs between planned paths",
                    format!("{:.1} mm, {}", tip.stray_mm, percent(stray)),
                    place,
                )
                .cause("it is not switched off where a path ends")
                .allow(accept("--allow-stray", stray));
        }
    }

    fn tilt(&mut self) {
        let Some(tip) = &self.court.tip else { return };
        let allowed = self.args.allow.allow_tilt_deg;
        if tip.tilt.value <= allowed {
            return;
        }
        let share = if tip.extruded_mm > 0.0 { tip.tilted_mm / tip.extruded_mm } else { 0.0 };
        let amount = format!("{:.2} degrees; more than {allowed} over {} of the way", tip.tilt.value, percent(share));
        let is_whole = tip.tilts.quantile(0.5) > SYSTEMATIC * tip.tilt.value;
        let is_polar = matches!(&self.setup.machine, super::machine::Machine::FiveAxis(printer) if printer.linear < 3);
        let cause = if is_polar {
            "with two linear axes a direction follows from the place: the machine leaves the rest of the tilt out"
        } else if is_whole {
            "the whole program is off: the tool, the zero or the sense of a rotary axis, or the way the part lies is another than the plan had"
        } else {
            ""
        };
        let place = self.at(&tip.tilt);
        self.findings
            .explain(Severity::Failed, "the nozzle direction differs from the plan", amount, place)
            .cause(cause)
            .allow(accept("--allow-tilt", tip.tilt.value));
    }

    fn deposit(&mut self) {
        let (deposit, allow) = (&self.court.deposit, &self.args.allow);
        if self.executed.ends_extruding {
            self.findings.add(Severity::Failed, "the extruder runs when the program ends", "", "");
        }
        if deposit.rest.value > allow.allow_rest {
            let (amount, place) = (
                format!("{:.2} s at once, {:.2} s in all", deposit.rest.value, deposit.rest_s),
                self.at(&deposit.rest),
            );
            self.findings
                .explain(Severity::Failed, "material comes out while the tip rests", amount, place)
                .allow(accept("--allow-rest", deposit.rest.value));
        }
        let Some(tip) = &self.court.tip else { return };
        if !self.court.has_amounts {
            let what = "the flavour says when material comes out, not how much: the thickness of beads is compared with nothing";
            self.findings.add(Severity::Note, what, "", "");
            return;
        }
        if tip.planned_filament_mm > 0.0 {
            let off = (deposit.filament_mm / tip.planned_filament_mm - 1.0).abs();
            if off > allow.allow_deposit {
                let amount = format!("{} of it", percent(deposit.filament_mm / tip.planned_filament_mm));
                self.findings
                    .explain(Severity::Failed, "another amount is deposited than planned", amount, "")
                    .allow(accept("--allow-deposit", off));
            }
        }
        let share = if deposit.compared_mm > 0.0 { deposit.off_mm / deposit.compared_mm } else { 0.0 };
        if share > allow.allow_area_share {
            let amount = format!("over {} of the way, by {} at worst", percent(share), percent(deposit.worst.value));
            let place = self.at(&deposit.worst);
            self.findings
                .explain(Severity::Failed, "beads are thicker or thinner than planned", amount, place)
                .cause("the tip is slower or faster than the extruder expects")
                .allow(accept("--allow-area-share", share));
        }
    }

    fn contact(&mut self) {
        let contact = &self.court.contact;
        for (touch, what) in
            [(&contact.built, "the nozzle is in what is built"), (&contact.plate, "the nozzle is in the plate")]
        {
            if touch.times > 0 {
                let times = if touch.times == 1 { "once".to_owned() } else { format!("{} times", touch.times) };
                let amount =
                    format!("{times}, {:.2} s, {:.3} mm deeper than is allowed", touch.seconds, touch.worst.value);
                let place = self.at(&touch.worst);
                self.findings.add(Severity::Failed, what, amount, place);
            }
        }
    }
}

/// A speed so many times above the limit is a jump.
const JUMP: f64 = 3.0;
