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
use nalgebra::distance;
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
    let mut out = BufWriter::new(out);
    writeln!(out, "{CSV_HEADER}")?;
    let (mut written, mut at, mut layer, mut bead) = (CamWritten { moves: 0, lines: 1 }, None, String::new(), None);
    for (index, step) in (0..).zip(moves) {
        let step = step.into();
        written.moves = index + 1;
        let mut line = |kind: &str, place: &str, rest: &str| -> Result<(), CamError> {
            written.lines += 1;
            Ok(writeln!(out, "{kind},{place},{rest}")?)
        };
        if let Some((tip, direction, feed)) = goal(&step) {
            check(index, &tip, &direction, feed)?;
            let seconds = at.map_or(0.0, |at| distance(&at, &tip)) / feed;
            let d = direction;
            let place = format!("{},{},{},{},{},{}", tip.x, tip.y, tip.z, d.x, d.y, d.z);
            match (step, bead) {
                (Move::Print { filament_mm, .. }, bead) => {
                    let filament = number(index, "filament_mm", filament_mm, POSITIVE)?;
                    let bead = bead.map_or_else(
                        || ",,".to_owned(),
                        |(kind, width, height): (BeadKind, f64, f64)| format!("{},{width},{height}", name(kind)),
                    );
                    line("print", &place, &format!("{filament},{feed},{seconds},{layer},{bead}"))?;
                }
                (Move::Lay { .. }, _) => line("lay", &place, &format!(",{feed},{seconds},{layer},,,"))?,
                _ => line("travel", &place, &format!(",{feed},{seconds},{layer},,,"))?,
            }
            at = Some(tip);
            continue;
        }
        const NOWHERE: &str = ",,,,,";
        match step {
            Move::Retract { filament_mm, feed_mm_s } | Move::Prime { filament_mm, feed_mm_s } => {
                let filament = number(index, "filament_mm", filament_mm, POSITIVE)?;
                let (feed, seconds) = (number(index, "feed_mm_s", feed_mm_s, FEED)?, filament / feed_mm_s);
                let is_back = matches!(step, Move::Retract { .. });
                // Zero has no sign.
                let (kind, signed) = if is_back { ("retract", 0.0 - filament) } else { ("prime", filament) };
                line(kind, NOWHERE, &format!("{signed},{feed},{seconds},{layer},,,"))?;
            }
            Move::Dwell { seconds } => {
                let seconds = number(index, "seconds", seconds, POSITIVE)?;
                line("dwell", NOWHERE, &format!(",,{seconds},{layer},,,"))?;
            }
            Move::Home => {
                line("home", NOWHERE, &format!(",,,{layer},,,"))?;
                at = None;
            }
            Move::Fiber(FiberCommand::Tool(tool)) => {
                let kind = match tool {
                    Tool::Nozzle => "nozzle",
                    Tool::Roller => "roller",
                    Tool::Conductor => "conductor",
                };
                line(kind, NOWHERE, &format!(",,,{layer},,,"))?;
            }
            Move::Fiber(FiberCommand::Feed { length_mm }) => {
                let length = number(index, "length_mm", length_mm, POSITIVE)?;
                line("feed", NOWHERE, &format!("{length},,,{layer},,,"))?;
            }
            Move::Fiber(FiberCommand::Cut) => line("cut", NOWHERE, &format!(",,,{layer},,,"))?,
            Move::Mark(Mark::Layer { number, .. }) => layer = (u64::from(number) + 1).to_string(),
            Move::Mark(Mark::Bead { kind, width_mm, height_mm }) => {
                let size = [("width_mm", width_mm), ("height_mm", height_mm)];
                size.into_iter().try_for_each(|(what, value)| number(index, what, value, POSITIVE).map(|_| ()))?;
                bead = Some((kind, width_mm, height_mm));
            }
            _ => {}
        }
    }
    if written.moves == 0 {
        return Err(CamError::Empty);
    }
    out.flush()?;
    Ok(written)
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
