//! The programs of a whole part, read again: beads only under the nozzle, tapes only under a hot roller, all in the order of the layers,
//! tapes where they were planned.

use super::motion::TapeMotion;
use super::part_programs::{Item, Written};
use curvlay_examples::args::Failure;
use curvlay_examples::count::counted;
use curvlay_examples::motion::read_back::ReadBack;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_kinematics::print_program::StreamOptions;
use curvlay_kinematics::program::{Goal, HeadInput, HeadSignal, Move, ReadError, Step, UrScriptReader, read_rapid};
use curvlay_kinematics::workcell::Workcell;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::ops::Range;

/// How far from a planned tape the roller may be while it presses, in millimetres: what its planned motion may leave it, and rounding.
pub const MAX_OFF_MM: f64 = 0.11;

/// What the programs hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadAgain {
    /// Beads and tapes that they lay, by the signals.
    pub laid: [usize; 2],
    /// Cuts.
    pub cuts: usize,
    /// What is not in order, in words.
    pub wrong: Vec<String>,
    /// How far the roller is from the planned tapes at most while it presses, in mm.
    pub tape_off_mm: f64,
    /// What the readers of prints find of the nozzle's part.
    pub beads: ReadBack,
}

impl Written<'_> {
    /// Reads the programs again.
    pub fn read(
        &self,
        items: &[Item],
        files: &BTreeMap<String, Vec<u8>>,
        is_stream: bool,
    ) -> Result<ReadAgain, Failure> {
        let refused = |error: ReadError| Failure::new(format!("the program as it was written: {error}"));
        let mut steps: Vec<Step> = Vec::new();
        if is_stream {
            for file in files.values() {
                let reader = UrScriptReader::new(&file[..]).map_err(refused)?;
                steps.extend(reader.collect::<Result<Vec<_>, _>>().map_err(refused)?);
            }
        } else if let Some(main) = files.get("fiber.mod") {
            let open = |name: &str| {
                files.get(name).map(|file| &file[..]).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))
            };
            steps
                .extend(read_rapid(&main[..], open).map_err(refused)?.collect::<Result<Vec<_>, _>>().map_err(refused)?);
        }
        let mut read = ReadAgain::default();
        let parts = split(&steps, is_stream);
        // Targets of beads that follow each other are one part; each stream begins with a move.
        let mut merged: Vec<(bool, Vec<&Item>)> = Vec::new();
        for item in items {
            let is_tape = matches!(item, Item::Tapes(..));
            match merged.last_mut() {
                Some((false, list)) if !is_tape && !is_stream => list.push(item),
                _ => merged.push((is_tape, vec![item])),
            }
        }
        let order: Vec<bool> = parts.iter().map(|part| part.is_tape).collect();
        if order != merged.iter().map(|(is_tape, _)| *is_tape).collect::<Vec<_>>() {
            read.wrong.push("beads and tapes are not in the order of the layers".to_owned());
            return Ok(read);
        }
        for (part, (_, list)) in parts.iter().zip(&merged) {
            let (Some(first), Some(last)) = (list.first(), list.last()) else { continue };
            match (first, last) {
                (Item::Tapes(number, runs), _) => {
                    self.read_tapes(part.steps, &self.taped[*number], runs.clone(), &mut read);
                }
                (Item::Beads(first), Item::Beads(last)) => {
                    let all = part.steps.iter().map(|step| Ok::<_, ReadError>(*step));
                    let print = (self.cell, self.beads, &self.home);
                    read.beads.add(print, first.start..last.end, all).map_err(refused)?;
                    let on = |step: &&Step| **step == Step::Extruder(true);
                    read.laid[0] += part.steps.iter().filter(on).count();
                }
                _ => {}
            }
        }
        if read.laid[0] != self.beads.runs.len() {
            read.wrong.push(format!("{} laid instead of {}", counted(read.laid[0], "bead"), self.beads.runs.len()));
        }
        Ok(read)
    }

    /// The tapes of a layer in a program: heat before pressure, one cut each, in order and where they were planned.
    fn read_tapes(&self, steps: &[Step], taped: &TapeMotion, runs: Range<usize>, read: &mut ReadAgain) {
        // Signals of a stream come as late as the arm is behind it.
        let StreamOptions { rate, lag_s, .. } = StreamOptions::of_workcell(self.cell.equipment());
        let mut roller = RollerRead {
            taped,
            runs,
            lag: (lag_s.max(0.0) / rate.seconds()).round() as usize,
            behind: VecDeque::new(),
            is_ready: false,
            is_hot: self.head.celsius <= 0.0,
            presses: false,
            cuts: 0,
            line: Vec::new(),
            off_mm: 0.0,
            laid: 0,
        };
        for step in steps {
            roller.pass(step, read);
        }
        if roller.runs.next().is_some() {
            read.wrong.push("planned tapes are not in the program".to_owned());
        }
        read.laid[1] += roller.laid;
        read.tape_off_mm = read.tape_off_mm.max(roller.off_mm);
    }
}

/// The roller along the steps of a program.
struct RollerRead<'a> {
    taped: &'a TapeMotion,
    /// Runs whose tapes are not laid yet.
    runs: Range<usize>,
    /// By how many ticks the arm is behind a stream, and the joints that it has not reached.
    lag: usize,
    behind: VecDeque<[f64; 6]>,
    is_ready: bool,
    is_hot: bool,
    presses: bool,
    /// Cuts of the tape that is laid.
    cuts: usize,
    /// The planned line of that tape, and how far the roller was from lines at most.
    line: Vec<Point3<f64>>,
    off_mm: f64,
    laid: usize,
}

impl RollerRead<'_> {
    /// Goes on by a step.
    fn pass(&mut self, step: &Step, read: &mut ReadAgain) {
        match step {
            Step::Wait(HeadInput::ToolReady) => self.is_ready = true,
            Step::Wait(HeadInput::Hot) => self.is_hot = true,
            Step::Signal { signal: HeadSignal::Press, on } => self.press(*on, read),
            Step::Signal { signal: HeadSignal::Cut, on: true } => {
                self.cuts += 1;
                read.cuts += 1;
            }
            Step::Extruder(true) => read.wrong.push("the extruder is on under the roller".to_owned()),
            Step::Servo { joints, .. } => {
                self.behind.push_back(*joints);
                let reached = if self.behind.len() > self.lag { self.behind.pop_front() } else { None };
                let tip = reached.filter(|_| self.presses).and_then(|joints| self.taped.cell.nozzle_on_part(&joints));
                if let Some(tip) = tip {
                    self.is_at(&Point3::from(tip.translation.vector));
                }
            }
            Step::Move(Move { goal: Goal::Line(target), .. }) if self.presses => {
                self.is_at(&Point3::from(target.pose.translation.vector));
            }
            _ => {}
        }
    }

    /// The contact line of the roller is there while it presses.
    fn is_at(&mut self, tip: &Point3<f64>) {
        self.off_mm = self.off_mm.max(apart(tip, &self.line));
    }

    /// The roller goes down on a tape, which must be in place and hot, or up from one, which must be cut once.
    fn press(&mut self, on: bool, read: &mut ReadAgain) {
        let mut wrong = |what: &str| read.wrong.push(what.to_owned());
        self.presses = on;
        if !on {
            if self.cuts != 1 {
                wrong("a tape is not cut once");
            }
            return;
        }
        if !(self.is_ready && self.is_hot) {
            wrong("the roller presses before it is in place and hot");
        }
        self.laid += 1;
        self.cuts = 0;
        match self.runs.next() {
            Some(run) => self.line = self.taped.placed[self.taped.plan.runs[run].path].line().collect(),
            None => wrong("a tape is laid that was not planned"),
        }
    }
}

/// A part of a program: under the nozzle, or from the call of a roller to its leaving.
struct ProgramPart<'a> {
    is_tape: bool,
    steps: &'a [Step],
}

/// Steps by what lays; a stream of beads ends where the next move begins one. Moves without beads are left out.
fn split(steps: &[Step], is_stream: bool) -> Vec<ProgramPart<'_>> {
    let is_tool = |step: &Step, called: bool| match step {
        Step::Signal { signal: HeadSignal::Roller | HeadSignal::Conductor, on } => *on == called,
        _ => false,
    };
    let (mut parts, mut rest) = (Vec::new(), steps);
    while !rest.is_empty() {
        let call = rest.iter().position(|step| is_tool(step, true)).unwrap_or(rest.len());
        let (beads, from) = rest.split_at(call);
        let streams = beads.chunk_by(|_, next| !(is_stream && matches!(next, Step::Move(_))));
        let laid = streams.filter(|steps| steps.contains(&Step::Extruder(true)));
        parts.extend(laid.map(|steps| ProgramPart { is_tape: false, steps }));
        let end = from.iter().position(|step| is_tool(step, false)).map_or(from.len(), |at| at + 1);
        // The wait for the nozzle follows.
        let end = end + usize::from(matches!(from.get(end), Some(Step::Wait(_))));
        let (tapes, behind) = from.split_at(end);
        if !tapes.is_empty() {
            parts.push(ProgramPart { is_tape: true, steps: tapes });
        }
        rest = behind;
    }
    parts
}

/// How far a place is from a polyline, in millimetres.
fn apart(at: &Point3<f64>, line: &[Point3<f64>]) -> f64 {
    let to = |ends: &[Point3<f64>]| {
        let way: Vector3<f64> = ends[1] - ends[0];
        let share = ((at - ends[0]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        (ends[0] + way * share - at).norm()
    };
    line.windows(2).map(to).fold(f64::INFINITY, f64::min)
}
