//! A tool path as CSV: a line a move, every digit, nothing quoted.
//!
//! | column | meaning |
//! |---|---|
//! | `kind` | `travel`, `print`, `retract`, `prime`, `dwell` or `home`; of tapes `lay`, `feed`, `cut`, and the tools `nozzle`, `roller`, `conductor` |
//! | `x_mm`, `y_mm`, `z_mm`, `i`, `j`, `k` | tip and direction of the nozzle at the end of the move, of `travel`, `print` and `lay` |
//! | `filament_mm` | filament pushed forward, negative when it is drawn back; of `feed` the tape pushed out |
//! | `feed_mm_s` | speed of the tip; of the filament for `retract` and `prime` |
//! | `seconds` | how long the move takes at this speed; of a `dwell` how long it waits; 0 where the start is not known |
//! | `layer` | from 1 |
//! | `bead` | `wall`, `solid`, `skin`, `bridge`, `infill` or `support`, of `print` |
//! | `width_mm`, `height_mm` | of the bead, of `print` |
//!
//! What does not belong to a kind, or is not known, is empty. Temperatures, fans and the roller's force have no lines.

use super::{CamError, CamWritten, FEED, POSITIVE, check, goal, number};
use crate::gcode::{FiberCommand, Mark, Move, Tool};
use crate::path::BeadKind;
use nalgebra::{Point3, UnitVector3, distance};
use std::io::{BufWriter, Write};

/// The first line of a file.
pub const CSV_HEADER: &str = "kind,x_mm,y_mm,z_mm,i,j,k,filament_mm,feed_mm_s,seconds,layer,bead,width_mm,height_mm";

/// Writes a tool path as CSV.
///
/// # Arguments
/// * `moves`: as [`write_gcode`](crate::gcode::write_gcode) takes them, or what becomes one; layers and beads from the
///   [marks](crate::gcode::Mark) among them.
///
/// # Errors
/// [`CamError`] names the move that cannot be.
///
/// # Cost
/// Constant memory, `O(1)` a move.
///
/// # Example
/// ```
/// use curvlay_toolpath::cam::write_csv;
/// use curvlay_toolpath::gcode::Move;
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// let step = Move::Travel { tip: Point3::new(1.0, 2.5, 0.3), direction: Vector3::z_axis(), feed_mm_s: 80.0 };
/// let mut file = Vec::new();
/// write_csv([step], &mut file)?;
/// assert!(String::from_utf8(file)?.ends_with("\ntravel,1,2.5,0.3,0,0,1,,80,0,,,,\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_csv(moves: impl IntoIterator<Item = impl Into<Move>>, out: impl Write) -> Result<CamWritten, CamError> {
    let mut csv = Csv { out: BufWriter::new(out), lines: 0, at: None, layer: String::new(), bead: None };
    csv.header()?;
    let mut count = 0;
    for (index, step) in (0..).zip(moves) {
        count = index + 1;
        csv.add(index, step.into())?;
    }
    if count == 0 {
        return Err(CamError::Empty);
    }
    csv.out.flush()?;
    Ok(CamWritten { moves: count, lines: csv.lines })
}

/// Place and direction of a line whose move has none.
const NOWHERE: &str = ",,,,,";

/// A file that is being written, and what its next lines take from the moves before them.
struct Csv<W: Write> {
    out: BufWriter<W>,
    lines: u64,
    /// Where the tip is; `None` at the start and after homing, when the file does not know it.
    at: Option<Point3<f64>>,
    /// As it is written: empty before the first mark of a layer.
    layer: String,
    /// What the last mark of a bead says: kind, width, height.
    bead: Option<(BeadKind, f64, f64)>,
}

impl<W: Write> Csv<W> {
    fn header(&mut self) -> Result<(), CamError> {
        self.lines += 1;
        Ok(writeln!(self.out, "{CSV_HEADER}")?)
    }

    fn line(&mut self, kind: &str, place: &str, rest: &str) -> Result<(), CamError> {
        self.lines += 1;
        Ok(writeln!(self.out, "{kind},{place},{rest}")?)
    }

    /// A move that leads somewhere.
    fn go(
        &mut self,
        index: u64,
        step: Move,
        (tip, d, feed): (Point3<f64>, UnitVector3<f64>, f64),
    ) -> Result<(), CamError> {
        check(index, &tip, &d, feed)?;
        let seconds = self.at.map_or(0.0, |at| distance(&at, &tip)) / feed;
        let place = format!("{},{},{},{},{},{}", tip.x, tip.y, tip.z, d.x, d.y, d.z);
        let layer = &self.layer;
        let (kind, rest) = match step {
            Move::Print { filament_mm, .. } => {
                let filament = number(index, "filament_mm", filament_mm, POSITIVE)?;
                let bead = self.bead.map_or_else(
                    || ",,".to_owned(),
                    |(kind, width, height)| format!("{},{width},{height}", name(kind)),
                );
                ("print", format!("{filament},{feed},{seconds},{layer},{bead}"))
            }
            Move::Lay { .. } => ("lay", format!(",{feed},{seconds},{layer},,,")),
            _ => ("travel", format!(",{feed},{seconds},{layer},,,")),
        };
        self.line(kind, &place, &rest)?;
        self.at = Some(tip);
        Ok(())
    }

    /// Adds the line of a move. Marks have no lines: they hold for those that follow.
    fn add(&mut self, index: u64, step: Move) -> Result<(), CamError> {
        if let Some(goal) = goal(&step) {
            return self.go(index, step, goal);
        }
        let layer = &self.layer;
        match step {
            Move::Retract { filament_mm, feed_mm_s } | Move::Prime { filament_mm, feed_mm_s } => {
                let filament = number(index, "filament_mm", filament_mm, POSITIVE)?;
                let (feed, seconds) = (number(index, "feed_mm_s", feed_mm_s, FEED)?, filament / feed_mm_s);
                let is_back = matches!(step, Move::Retract { .. });
                // Zero has no sign.
                let (kind, signed) = if is_back { ("retract", 0.0 - filament) } else { ("prime", filament) };
                self.line(kind, NOWHERE, &format!("{signed},{feed},{seconds},{layer},,,"))
            }
            Move::Dwell { seconds } => {
                let seconds = number(index, "seconds", seconds, POSITIVE)?;
                self.line("dwell", NOWHERE, &format!(",,{seconds},{layer},,,"))
            }
            Move::Home => {
                self.at = None;
                self.line("home", NOWHERE, &format!(",,,{layer},,,"))
            }
            Move::Fiber(command) => self.tape(index, command),
            Move::Mark(mark) => self.mark(index, mark),
            _ => Ok(()),
        }
    }

    /// A command to what lays tapes; press and heat have no line.
    fn tape(&mut self, index: u64, command: FiberCommand) -> Result<(), CamError> {
        let layer = &self.layer;
        match command {
            FiberCommand::Tool(tool) => {
                let kind = match tool {
                    Tool::Nozzle => "nozzle",
                    Tool::Roller => "roller",
                    Tool::Conductor => "conductor",
                };
                self.line(kind, NOWHERE, &format!(",,,{layer},,,"))
            }
            FiberCommand::Feed { length_mm } => {
                let length = number(index, "length_mm", length_mm, POSITIVE)?;
                self.line("feed", NOWHERE, &format!("{length},,,{layer},,,"))
            }
            FiberCommand::Cut => self.line("cut", NOWHERE, &format!(",,,{layer},,,")),
            _ => Ok(()),
        }
    }

    /// What is said of the moves that follow.
    fn mark(&mut self, index: u64, mark: Mark) -> Result<(), CamError> {
        match mark {
            Mark::Layer { number, .. } => self.layer = (u64::from(number) + 1).to_string(),
            Mark::Bead { kind, width_mm, height_mm } => {
                // Checked here, not where they are written: the error then names the mark.
                for (what, value) in [("width_mm", width_mm), ("height_mm", height_mm)] {
                    number(index, what, value, POSITIVE)?;
                }
                self.bead = Some((kind, width_mm, height_mm));
            }
        }
        Ok(())
    }
}

fn name(kind: BeadKind) -> &'static str {
    match kind {
        BeadKind::Wall => "wall",
        BeadKind::Solid => "solid",
        BeadKind::Skin => "skin",
        BeadKind::Infill => "infill",
        BeadKind::Bridge => "bridge",
        BeadKind::Support => "support",
        BeadKind::SparseSupport => "sparse_support",
        BeadKind::SupportBridge => "support_bridge",
    }
}
