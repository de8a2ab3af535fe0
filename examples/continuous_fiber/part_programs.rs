//! The programs of a whole part: beads and tapes in the order in which they are laid, from home to home.

use super::motion::TapeMotion;
use curvlay_examples::args::Failure;
use curvlay_examples::motion::programs;
use curvlay_examples::motion::shown::{self, Played};
use curvlay_examples::motion::{TargetFormat, TargetLanguage, target_files};
use curvlay_examples::nalgebra::Isometry3;
use curvlay_examples::viewer;
use curvlay_kinematics::print_program::StreamOptions;
use curvlay_kinematics::program::{Step, write_urscript};
use curvlay_kinematics::workcell::{SixAxisWorkcell, Workcell};
use curvlay_toolpath::fiber::head::{LayerTapes, TapeHead};
use curvlay_toolpath::plan::PrintPlan;
use curvlay_trajectory::print::{self, SegmentKind};
use std::collections::BTreeMap;
use std::ops::Range;

/// Steps of a program of joints over time.
const STREAM_STEPS: f64 = 100_000.0;
/// Runs of the nozzle, or of the roller, from home to home.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Beads(Range<usize>),
    /// Of a list of tapes.
    Tapes(usize, Range<usize>),
}

/// What programs are written from.
pub struct Written<'a> {
    pub cell: &'a SixAxisWorkcell,
    pub beads: &'a print::PrintPlan<6, 1>,
    /// One for each list of tapes.
    pub taped: &'a [TapeMotion],
    pub tapes: &'a [LayerTapes],
    pub head: &'a TapeHead,
    pub home: [f64; 6],
}

impl Written<'_> {
    /// Beads and tapes in the order in which they are laid.
    pub fn items(&self) -> Vec<Item> {
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
            Item::Beads(runs) => self.beads.segments(runs.clone()).map(|leg| leg.duration()).sum(),
            Item::Tapes(list, runs) => self.taped[*list].plan.segments(runs.clone()).map(|leg| leg.duration()).sum(),
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

    pub fn streams(&self, items: &[Item]) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
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

    pub fn modules(&self, items: &[Item]) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
        if items.is_empty() {
            return Ok(BTreeMap::new());
        }
        let format = TargetFormat::new("fiber".to_owned(), TargetLanguage::Rapid, self.beads.max_filament_mm_s());
        let steps = items.iter().flat_map(|item| self.steps(item, false));
        Ok(target_files(steps, self.cell.equipment(), &format)?)
    }

    /// Everything for the viewer, in order.
    pub fn shown(
        &self,
        items: &[Item],
        frame_part: &Isometry3<f64>,
        print: &PrintPlan,
    ) -> (Vec<viewer::Step>, viewer::Robot) {
        let knots = |plan: &print::PrintPlan<6, 1>| -> usize {
            plan.segments(0..plan.runs.len()).map(|leg| leg.knots().len()).sum()
        };
        let all = knots(self.beads) + self.taped.iter().map(|taped| knots(&taped.plan)).sum::<usize>();
        let mut played = Played::new(self.cell, *frame_part, all);
        for item in items {
            match item {
                Item::Beads(runs) => shown::play(&mut played, self.beads, runs.clone(), &print.resolved.paths),
                Item::Tapes(number, runs) => {
                    let list = &self.tapes[*number];
                    let size = list.tapes.first().map_or([0.0; 2], |tape| [tape.width, tape.thickness]);
                    for leg in self.taped[*number].plan.segments(runs.clone()) {
                        let kind = if leg.kind == SegmentKind::Print { TAPE_KIND } else { viewer::Step::TRAVEL };
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
