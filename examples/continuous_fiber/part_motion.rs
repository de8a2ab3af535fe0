//! The robot's motion for a whole part: beads by the nozzle and tapes by the roller, in one program from home to home.
//!
//! Both are planned in the same workcell, one with the nozzle and one with the roller in its place. After each layer with tapes the nozzle goes home, the head
//! changes there, the roller gets hot, lays the tapes of the layer, and goes home again. The motions for both begin and end in the same posture.
//!
//! What is written is read again: beads only under the nozzle, tapes only under a hot roller, all in the order of the layers, tapes where they were planned.

use super::layer::PartLayers;
use super::motion::{Placed, TapeMotion, along_tapes, mounted, six_axes};
use curvlay_examples::args::Failure;
use curvlay_examples::bars::Bars;
use curvlay_examples::motion::read_back::ReadBack;
use curvlay_examples::motion::shown::{self, Played};
use curvlay_examples::motion::{NO_HOME, OnCell, PlacedPaths, PrintingCell, bounds_of, home, programs, waypoints};
use curvlay_examples::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_examples::viewer;
use curvlay_kinematics::print_program::StreamOptions;
use curvlay_kinematics::program::{
    Goal, HeadInput, HeadSignal, Move, RapidOptions, ReadError, Step, UrScriptReader, read_rapid, write_urscript,
};
use curvlay_kinematics::workcell::{AnyWorkcell, GrowingOptions, GrowingScene, PartCells, SixAxisWorkcell, Workcell};
use curvlay_kinematics::{PlateOptions, place_on_plate};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::fill::FilledLayers;
use curvlay_toolpath::gouging::{GougingOptions, Nozzle};
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::plan::PrintPlan;
use curvlay_trajectory::print::{self, Fault, LegKind, PrintLimits, PrintOptions, plan_print};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io;
use std::ops::Range;

/// Diameter of a plate that the workcell leaves open, in millimetres, unless the part is wider, and the rim that then stays.
const PLATE_MM: f64 = 127.5;
const RIM_MM: f64 = 10.0;
/// How deep the nozzle may be in a layer on a planned motion, as a share of its height: what the machine file allows, a quarter, less a little.
const PLANNED_DEPTH: f64 = 0.24;
/// How far the nozzle may leave its path, as a share of the layer height.
const TOLERANCE: f64 = 0.25;
/// Steps of a program of joints over time.
const STREAM_STEPS: f64 = 100_000.0;
/// How far from a planned tape the roller may be while it presses, in millimetres: what its planned motion may leave it, and rounding.
pub const MAX_OFF_MM: f64 = 0.11;

/// What is planned, as far as it goes before the robot.
pub struct Work<'a> {
    pub layers: &'a PartLayers,
    pub surfaces: &'a [LayerSurface<'a>],
    pub filled: &'a FilledLayers,
    pub print: &'a PrintPlan,
    pub tapes: &'a [LayerTapes],
    pub head: &'a TapeHead,
    pub nozzle: &'a Nozzle,
    pub bead_mm: f64,
    pub bars: &'a Bars,
}

/// Runs of the nozzle, or of the roller, from home to home.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Beads(Range<usize>),
    /// Of a list of tapes.
    Tapes(usize, Range<usize>),
}

/// What the robot does.
pub struct PartMotion {
    /// Name of the workcell.
    pub cell: String,
    /// Motions along beads, and along tapes.
    pub runs: [usize; 2],
    /// Tapes and wires that were to be laid.
    pub tapes: usize,
    /// What is not printed or laid as planned: whether it is a tape, and what.
    pub faults: Vec<(bool, Fault)>,
    /// Seconds that the robot moves, but for waits.
    pub robot_s: f64,
    /// How far the tip is from its path at most, in mm: of the nozzle, and of the roller.
    pub max_deviation_mm: [f64; 2],
    /// How far the roller is turned away from a tape at most, in radians, and how it is mounted.
    pub max_turn: f64,
    pub mount: f64,
    /// Times that the head changes.
    pub changes: usize,
    /// Programs by name.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What they hold, read again.
    pub read: ReadAgain,
    /// The motion for the viewer.
    pub shown: Option<(Vec<viewer::Step>, viewer::Robot)>,
}

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

impl Work<'_> {
    /// Plans all motions and writes the programs.
    pub fn plan(&self, cell: &AnyWorkcell) -> Result<PartMotion, Failure> {
        let cell = six_axes(cell)?;
        let takes_stream = programs::takes_stream(cell.equipment()).map_err(Failure::new)?;
        let Work { layers, surfaces, filled, print, tapes, head, nozzle, bead_mm, bars } = *self;
        let options = PrintOptions::default();
        let grid = &layers.solid.grid;
        let [nx, ny, _] = grid.dims();
        let plate_mm = PLATE_MM.max(grid.cell_mm() * f64::from(nx).hypot(f64::from(ny)) + RIM_MM);
        let place =
            PlateOptions { stop_margin: options.stop_margin, rim_mm: bead_mm, ..PlateOptions::new(options.samples) };
        let all = print.resolved.paths.iter().flat_map(waypoints);
        let all: Vec<_> = all.map(|at| curvlay_kinematics::Waypoint { position: at.position, axis: at.axis }).collect();
        let progress = |p: curvlay_kinematics::Progress| bars.show(p.stage, p.done, p.total);
        let frame_part = place_on_plate(cell, &all, plate_mm, &place, &progress)?;
        let cells =
            layers.layered.uniform.field.cells_by_surface(&layers.layered.surfaces.heights_mm, grid.cell_mm())?;
        let grown = PartCells {
            dims: grid.dims(),
            rows: grid.rows(),
            cell_mm: grid.cell_mm(),
            origin: grid.origin(),
            frame_part,
            layers: &cells,
        };

        // Beads, by the nozzle.
        let progress = |p: curvlay_toolpath::Progress| bars.show(p.stage, p.done, p.total);
        let stack = filled.stack(surfaces)?;
        let gouging = GougingOptions { allowed_depth: PLANNED_DEPTH, ..GougingOptions::in_workcell() };
        let contacts = stack.contacts(&print.resolved.paths, nozzle, &gouging, &progress)?;
        let scene =
            PrintingCell::new(GrowingScene::new(cell, &grown, plate_mm, &GrowingOptions::default())?, &contacts);
        let paths = PlacedPaths::new(&print.resolved.paths, &print.deposition, &frame_part);
        let height_mm = layers.layered.surfaces.height_mm;
        let limits = PrintLimits {
            tolerance_mm: TOLERANCE * height_mm.min(bead_mm),
            ..PrintLimits::of(bounds_of(cell.limits()))
        };
        let robot = OnCell::new(cell.clone(), Vec::new());
        let progress = |p: curvlay_trajectory::Progress| bars.show(p.stage, p.done, p.total);
        let beads = plan_print(&robot, scene.clone(), &paths.paths(), &limits, &options, &progress)?;
        let home = home(&beads, &robot, &scene, (&limits, &options), &progress)?;
        let Some(home) = home else { return Ok(nowhere(cell, &beads, tapes)) };
        let cuts = self.cuts(cell, &beads);
        let beads = beads.with_homes(&robot, scene, &home, &cuts, &limits, &options, &progress)?;

        // Tapes, by the roller. A list is laid on all that is built by then, and planned by itself: the roller must not look along tapes of another layer.
        let mut built: Vec<Vec<u32>> = vec![Vec::new(); tapes.len()];
        for (list, built) in tapes.iter().zip(&mut built) {
            built.extend(cells.iter().take(list.layer as usize + 1).flatten());
        }
        let place = |list: &LayerTapes| Placed::list(list, 0, head, &frame_part);
        let all: Vec<Placed> = tapes.iter().flat_map(place).collect();
        let (with_roller, mount) = match all.is_empty() {
            true => (cell.clone(), 0.0),
            false => mounted(cell, &all, &grown, plate_mm)?,
        };
        let lay = |(list, built): (&LayerTapes, &Vec<u32>)| {
            let grown = PartCells { layers: std::slice::from_ref(built), ..grown };
            along_tapes((&with_roller, mount), place(list), &grown, plate_mm, Some(&home), bars)
        };
        let taped = tapes.iter().zip(&built).map(lay).collect::<Result<Vec<_>, _>>()?;
        let written = Written { cell, beads: &beads, taped: &taped, tapes, head, home };
        let items = written.items();
        let files = if takes_stream { written.streams(&items)? } else { written.modules(&items)? };
        let read = written.read(&items, &files, takes_stream)?;
        let shown = written.shown(&items, &frame_part, print);
        let faults = beads.faults.iter().map(|fault| (false, fault.clone()));
        let of_tapes = taped.iter().zip(tapes).flat_map(|(taped, list)| {
            let named = |fault: &Fault| (true, Fault { layer: list.layer, ..fault.clone() });
            taped.plan.faults.iter().map(named).collect::<Vec<_>>()
        });
        let most = |of: fn(&TapeMotion) -> f64| taped.iter().map(of).fold(0.0, f64::max);
        Ok(PartMotion {
            cell: cell.equipment().name().to_owned(),
            runs: [beads.runs.len(), taped.iter().map(|taped| taped.plan.runs.len()).sum()],
            tapes: tapes.iter().map(|list| list.tapes.len()).sum(),
            faults: faults.chain(of_tapes).collect(),
            robot_s: beads.robot_s() + taped.iter().map(|taped| taped.plan.robot_s()).sum::<f64>(),
            max_deviation_mm: [beads.max_deviation_mm, most(|taped| taped.plan.max_deviation_mm)],
            max_turn: most(|taped| taped.max_turn),
            mount,
            changes: 2 * items.iter().filter(|item| matches!(item, Item::Tapes(..))).count(),
            files,
            read,
            shown: Some(shown),
        })
    }

    /// The runs of beads before which the nozzle comes from home: behind layers with tapes, and where programs would grow too long.
    fn cuts(&self, cell: &SixAxisWorkcell, beads: &print::PrintPlan<6, 1>) -> BTreeSet<usize> {
        let mut cuts = programs::cuts(cell, beads, false, None);
        let layer = |run: usize| beads.runs[run].layer;
        let has_tapes = |run: &usize| self.tapes.iter().any(|list| (layer(run - 1)..layer(*run)).contains(&list.layer));
        cuts.extend((1..beads.runs.len()).filter(has_tapes));
        cuts
    }
}

/// Without a home posture there are no programs.
fn nowhere(cell: &SixAxisWorkcell, beads: &print::PrintPlan<6, 1>, tapes: &[LayerTapes]) -> PartMotion {
    let fault = Fault { layer: 0, path: 0, kind: print::FaultKind::NoTransfer, waypoint: 0, what: NO_HOME.to_owned() };
    PartMotion {
        cell: cell.equipment().name().to_owned(),
        runs: [beads.runs.len(), 0],
        tapes: tapes.iter().map(|list| list.tapes.len()).sum(),
        faults: vec![(false, fault)],
        robot_s: 0.0,
        max_deviation_mm: [beads.max_deviation_mm, 0.0],
        max_turn: 0.0,
        mount: 0.0,
        changes: 0,
        files: BTreeMap::new(),
        read: ReadAgain::default(),
        shown: None,
    }
}

/// What programs are written from.
struct Written<'a> {
    cell: &'a SixAxisWorkcell,
    beads: &'a print::PrintPlan<6, 1>,
    /// One for each list of tapes.
    taped: &'a [TapeMotion],
    tapes: &'a [LayerTapes],
    head: &'a TapeHead,
    home: [f64; 6],
}

impl Written<'_> {
    /// Beads and tapes in the order in which they are laid.
    fn items(&self) -> Vec<Item> {
        let mut items: Vec<((u32, u32), Item)> = Vec::new();
        for runs in programs::pieces(self.beads) {
            items.push(((self.beads.runs[runs.start].layer, 0), Item::Beads(runs)));
        }
        for (number, (list, taped)) in self.tapes.iter().zip(self.taped).enumerate() {
            let pieces = programs::pieces(&taped.plan).into_iter();
            items.extend(pieces.map(|runs| ((list.layer, 1), Item::Tapes(number, runs))));
        }
        items.sort_by_key(|(key, _)| *key);
        items.into_iter().map(|(_, item)| item).collect()
    }

    /// Seconds of an item.
    fn seconds(&self, item: &Item) -> f64 {
        match item {
            Item::Beads(runs) => self.beads.legs(runs.clone()).map(|leg| leg.duration()).sum(),
            Item::Tapes(list, runs) => self.taped[*list].plan.legs(runs.clone()).map(|leg| leg.duration()).sum(),
        }
    }

    fn steps(&self, item: &Item, is_stream: bool) -> Box<dyn Iterator<Item = Step> + '_> {
        match item {
            Item::Beads(runs) if is_stream => Box::new(programs::stream(self.cell, self.beads, runs.clone())),
            Item::Beads(runs) => Box::new(programs::targets(self.cell, self.beads, runs.clone())),
            Item::Tapes(list, runs) if is_stream => Box::new(self.taped[*list].stream(runs.clone(), self.head)),
            Item::Tapes(list, runs) => Box::new(self.taped[*list].targets(runs.clone(), self.head)),
        }
    }

    /// The items of each program of joints over time: one, unless it would be too long for a controller.
    fn programs(&self, items: &[Item]) -> Vec<Range<usize>> {
        let period = StreamOptions::of_workcell(self.cell.equipment()).rate.seconds();
        let (mut pieces, mut steps): (Vec<Range<usize>>, f64) = (Vec::new(), 0.0);
        for (number, item) in items.iter().enumerate() {
            let more = self.seconds(item) / period;
            match pieces.last_mut() {
                Some(piece) if steps + more <= STREAM_STEPS => {
                    piece.end = number + 1;
                    steps += more;
                }
                _ => {
                    pieces.push(number..number + 1);
                    steps = more;
                }
            }
        }
        pieces
    }

    fn streams(&self, items: &[Item]) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
        let mut files = BTreeMap::new();
        for (number, piece) in self.programs(items).into_iter().enumerate() {
            let name = format!("part_{:03}", number + 1);
            let options = programs::urscript_options(self.cell, self.beads, &name);
            let mut file = Vec::new();
            write_urscript(items[piece].iter().flat_map(|item| self.steps(item, true)), &options, &mut file)?;
            files.insert(format!("{name}.script"), file);
        }
        Ok(files)
    }

    fn modules(&self, items: &[Item]) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
        if items.is_empty() {
            return Ok(BTreeMap::new());
        }
        let options = RapidOptions { name: "fiber".to_owned(), ..RapidOptions::of_workcell(self.cell.equipment()) };
        Ok(programs::rapid_files(items.iter().flat_map(|item| self.steps(item, false)), &options)?)
    }

    /// Reads the programs again.
    fn read(&self, items: &[Item], files: &BTreeMap<String, Vec<u8>>, is_stream: bool) -> Result<ReadAgain, Failure> {
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
            read.wrong.push(format!("{} beads are laid instead of {}", read.laid[0], self.beads.runs.len()));
        }
        Ok(read)
    }

    /// The tapes of a layer in a program: heat before pressure, one cut each, in order and where they were planned.
    fn read_tapes(&self, steps: &[Step], taped: &TapeMotion, mut runs: Range<usize>, read: &mut ReadAgain) {
        let mut wrong = |what: &str| read.wrong.push(what.to_owned());
        let (mut is_ready, mut is_hot, mut presses, mut cuts) = (false, self.head.celsius <= 0.0, false, 0);
        let mut line: Vec<Point3<f64>> = Vec::new();
        let mut off_mm: f64 = 0.0;
        let mut laid = 0;
        // Signals of a stream come as late as the arm is behind it.
        let StreamOptions { rate, lag_s, .. } = StreamOptions::of_workcell(self.cell.equipment());
        let lag = (lag_s.max(0.0) / rate.seconds()).round() as usize;
        let mut behind: VecDeque<[f64; 6]> = VecDeque::new();
        for step in steps {
            let joints = match step {
                Step::Wait(HeadInput::ToolReady) => {
                    is_ready = true;
                    None
                }
                Step::Wait(HeadInput::Hot) => {
                    is_hot = true;
                    None
                }
                Step::Signal { signal: HeadSignal::Press, on } => {
                    if *on {
                        if !(is_ready && is_hot) {
                            wrong("the roller presses before it is in place and hot");
                        }
                        laid += 1;
                        cuts = 0;
                        match runs.next() {
                            Some(run) => line = taped.placed[taped.plan.runs[run].path].line().collect(),
                            None => wrong("a tape is laid that was not planned"),
                        }
                    } else if cuts != 1 {
                        wrong("a tape is not cut once");
                    }
                    presses = *on;
                    None
                }
                Step::Signal { signal: HeadSignal::Cut, on: true } => {
                    cuts += 1;
                    read.cuts += 1;
                    None
                }
                Step::Extruder(true) => {
                    wrong("the extruder is on under the roller");
                    None
                }
                Step::Servo { joints, .. } => {
                    behind.push_back(*joints);
                    if behind.len() > lag { behind.pop_front() } else { None }
                }
                Step::Move(Move { goal: Goal::Line(target), .. }) if presses => {
                    off_mm = off_mm.max(apart(&Point3::from(target.pose.translation.vector), &line));
                    None
                }
                _ => None,
            };
            let tip = joints.filter(|_| presses).and_then(|joints| taped.cell.nozzle_on_part(&joints));
            if let Some(tip) = tip {
                off_mm = off_mm.max(apart(&Point3::from(tip.translation.vector), &line));
            }
        }
        if runs.next().is_some() {
            wrong("planned tapes are not in the program");
        }
        read.laid[1] += laid;
        read.tape_off_mm = read.tape_off_mm.max(off_mm);
    }

    /// Everything for the viewer, in order.
    fn shown(
        &self,
        items: &[Item],
        frame_part: &Isometry3<f64>,
        print: &PrintPlan,
    ) -> (Vec<viewer::Step>, viewer::Robot) {
        let knots = |plan: &print::PrintPlan<6, 1>| -> usize {
            plan.legs(0..plan.runs.len()).map(|leg| leg.knots().len()).sum()
        };
        let all = knots(self.beads) + self.taped.iter().map(|taped| knots(&taped.plan)).sum::<usize>();
        let mut played = Played::new(self.cell, *frame_part, all);
        for item in items {
            match item {
                Item::Beads(runs) => shown::play(&mut played, self.beads, runs.clone(), &print.resolved.paths),
                Item::Tapes(number, runs) => {
                    let list = &self.tapes[*number];
                    let size = list.tapes.first().map_or([0.0; 2], |tape| [tape.width, tape.thickness]);
                    for leg in self.taped[*number].plan.legs(runs.clone()) {
                        let kind = if leg.kind == LegKind::Print { TAPE_KIND } else { viewer::Step::TRAVEL };
                        let path = (print.resolved.paths.len() + leg.run.path) as u32;
                        played.add((list.layer, path), &leg.knots(), |_| Some((kind, size)));
                    }
                }
            }
        }
        played.finish()
    }
}

/// The kind of a tape in the viewer: behind those of beads.
pub const TAPE_KIND: u8 = shown::BEAD_KINDS;

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
