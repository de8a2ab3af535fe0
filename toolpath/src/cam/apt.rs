//! APT, the language of cutter locations (ISO 4343): `GOTO/x,y,z,i,j,k`.
//!
//! A file is statements, one a line of at most 72 characters:
//!
//! | statement | meaning |
//! |---|---|
//! | `PARTNO/name`, `UNITS/MM`, `MULTAX/ON` | the name; millimetres; each `GOTO` has the direction of the tool |
//! | `GOTO/x,y,z,i,j,k` | the tip goes straight to there; `i,j,k` points from the tip into the nozzle |
//! | `RAPID` | the next `GOTO` is as fast as the machine goes: a travel |
//! | `FEDRAT/f,MMPM` | the speed from here on, mm/min |
//! | `AUXFUN/n` | a function of the machine, `Mn`: the extruder on and off |
//! | `PAINT/COLOR,n` | the colour of what follows, by the kind of the bead |
//! | `LOADTL/n` | the tool: 1 nozzle, 2 roller, 3 conductor |
//! | `PPRINT/text` | a comment: layers, and what a tape head does (`TAPE FEED 12.5`, `PRESS`, `HEAT`, `CUT`), which a post-processor must know |
//! | `DELAY/s` | waits so many seconds |
//! | `END`, `FINI` | the end |
//!
//! How much filament a move takes has no word in APT: it follows from the extruder's own settings, or take [CSV](super::write_csv).

use super::{CamError, CamWritten, POSITIVE, check, goal, number};
use crate::gcode::{FiberCommand, Mark, Move, Tool};
use crate::path::BeadKind;
use nalgebra::{Point3, UnitVector3};
use std::io::{BufWriter, Write};

/// How an APT file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AptOptions<'a> {
    /// What `PARTNO` says; characters other than ASCII letters, digits, blanks, points, dashes and underlines become underlines, and 60 are taken.
    /// Default `CURVLAY`.
    pub name: &'a str,
    /// Numbers of the functions that switch the extruder on and off; `None` for none. Default 101 and 103, as RepRap had them.
    pub extruder: Option<[u16; 2]>,
}

impl Default for AptOptions<'_> {
    fn default() -> Self {
        AptOptions { name: "CURVLAY", extruder: Some([101, 103]) }
    }
}

/// Most characters of a name: statements have 72.
const NAME: usize = 60;

/// Writes a tool path as APT.
///
/// # Arguments
/// * `moves`: as [`write_gcode`](crate::gcode::write_gcode) takes them, or what becomes one. Temperatures, fans and strokes of the
///   filament have no statement and are passed over; homing becomes `GOHOME`.
///
/// Places have 4 digits behind the point, directions 6, feeds 3.
///
/// # Errors
/// [`CamError`] names the move that cannot be.
///
/// # Cost
/// Constant memory, `O(1)` a move.
///
/// # Example
/// ```
/// use curvlay_toolpath::cam::{AptOptions, write_apt};
/// use curvlay_toolpath::gcode::Move;
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// let direction = Vector3::z_axis();
/// let moves = [
///     Move::Travel { tip: Point3::new(1.0, 2.0, 0.3), direction, feed_mm_s: 80.0 },
///     Move::Print { tip: Point3::new(11.0, 2.0, 0.3), direction, filament_mm: 0.4, feed_mm_s: 20.0 },
/// ];
/// let mut file = Vec::new();
/// write_apt(moves, &AptOptions::default(), &mut file)?;
/// let file = String::from_utf8(file)?;
/// assert!(file.contains("RAPID\nGOTO/1,2,0.3,0,0,1\nAUXFUN/101\nFEDRAT/1200,MMPM\nGOTO/11,2,0.3,0,0,1\nAUXFUN/103\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_apt(
    moves: impl IntoIterator<Item = impl Into<Move>>,
    options: &AptOptions<'_>,
    out: impl Write,
) -> Result<CamWritten, CamError> {
    let mut writer = Writer { out: BufWriter::new(out), lines: 0, is_on: false, feed: String::new(), kind: None };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, ' ' | '.' | '-' | '_');
    let name: String = options.name.chars().take(NAME).map(|c| if is_plain(c) { c } else { '_' }).collect();
    writer.line(&format!("PARTNO/{name}"))?;
    writer.line("UNITS/MM")?;
    writer.line("MULTAX/ON")?;
    let mut count = 0;
    for (index, step) in (0..).zip(moves) {
        writer.step(index, &step.into(), options)?;
        count = index + 1;
    }
    if count == 0 {
        return Err(CamError::Empty);
    }
    writer.extruder(false, options)?;
    writer.line("END")?;
    writer.line("FINI")?;
    writer.out.flush()?;
    Ok(CamWritten { moves: count, lines: writer.lines })
}

struct Writer<W: Write> {
    out: BufWriter<W>,
    lines: u64,
    /// Whether the extruder is on.
    is_on: bool,
    /// The last feed, as written.
    feed: String,
    kind: Option<BeadKind>,
}

impl<W: Write> Writer<W> {
    fn line(&mut self, line: &str) -> Result<(), CamError> {
        self.lines += 1;
        Ok(writeln!(self.out, "{line}")?)
    }

    fn extruder(&mut self, on: bool, options: &AptOptions) -> Result<(), CamError> {
        match options.extruder.filter(|_| on != self.is_on) {
            Some([switch_on, switch_off]) => {
                self.is_on = on;
                self.line(&format!("AUXFUN/{}", if on { switch_on } else { switch_off }))
            }
            None => Ok(()),
        }
    }

    fn step(&mut self, index: u64, step: &Move, options: &AptOptions) -> Result<(), CamError> {
        if let Some((tip, direction, feed_mm_s)) = goal(step) {
            check(index, &tip, &direction, feed_mm_s)?;
            let prints = matches!(step, Move::Print { .. });
            self.extruder(prints, options)?;
            if prints || matches!(step, Move::Lay { .. }) {
                let feed = short(feed_mm_s * 60.0, 3);
                if self.feed != feed {
                    self.line(&format!("FEDRAT/{feed},MMPM"))?;
                    self.feed = feed;
                }
            } else {
                self.line("RAPID")?;
            }
            return self.line(&place(&tip, &direction));
        }
        match *step {
            Move::Retract { .. } | Move::Home => {
                self.extruder(false, options)?;
                if matches!(step, Move::Home) { self.line("GOHOME") } else { Ok(()) }
            }
            Move::Fiber(command) => self.fiber(index, command),
            Move::Dwell { seconds } => {
                let seconds = number(index, "seconds", seconds, POSITIVE)?;
                self.line(&format!("DELAY/{}", short(seconds, 3)))
            }
            Move::Mark(Mark::Layer { number, .. }) => self.line(&format!("PPRINT/LAYER {}", u64::from(number) + 1)),
            Move::Mark(Mark::Bead { kind, .. }) if self.kind != Some(kind) => {
                self.kind = Some(kind);
                let colour = match kind {
                    BeadKind::Wall => 1,
                    BeadKind::Solid => 2,
                    BeadKind::Skin => 3,
                    BeadKind::Infill => 4,
                    BeadKind::Bridge => 5,
                    BeadKind::Support => 6,
                    BeadKind::SparseSupport => 7,
                    BeadKind::SupportBridge => 8,
                };
                self.line(&format!("PAINT/COLOR,{colour}"))
            }
            _ => Ok(()),
        }
    }
}

impl<W: Write> Writer<W> {
    /// What a tape head does.
    fn fiber(&mut self, index: u64, command: FiberCommand) -> Result<(), CamError> {
        let positive = |what, value| number(index, what, value, POSITIVE).map(|value| short(value, 1));
        let line = match command {
            FiberCommand::Tool(Tool::Nozzle) => "LOADTL/1".to_owned(),
            FiberCommand::Tool(Tool::Roller) => "LOADTL/2".to_owned(),
            FiberCommand::Tool(Tool::Conductor) => "LOADTL/3".to_owned(),
            FiberCommand::Feed { length_mm } => format!("PPRINT/TAPE FEED {}", positive("length_mm", length_mm)?),
            FiberCommand::Press { newtons } => format!("PPRINT/TAPE PRESS {}", positive("newtons", newtons)?),
            FiberCommand::Heat { celsius, .. } => format!("PPRINT/TAPE HEAT {}", positive("celsius", celsius)?),
            FiberCommand::Cut => "PPRINT/TAPE CUT".to_owned(),
        };
        self.line(&line)
    }
}

fn place(tip: &Point3<f64>, direction: &UnitVector3<f64>) -> String {
    let numbers = tip.iter().map(|c| short(*c, 4)).chain(direction.iter().map(|c| short(*c, 6)));
    format!("GOTO/{}", numbers.collect::<Vec<_>>().join(","))
}

/// A number without zeros at its end, and zero without a sign.
fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text[..] };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
