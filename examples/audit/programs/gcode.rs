//! G-code of slicers, of ours, and of five-axis machines, as moves of the tip on the part.

use super::arcs::{Centre, chords};
use super::builder::{Builder, Laid, Said};
use super::hints::{Hints, LayerMark, layer};
use super::lines::Lines;
use super::program::{Given, Program};
use curvlay_examples::laid::words;
use curvlay_kinematics::machine::FiveAxis;
use curvlay_toolpath::path::BeadKind;
use nalgebra::{Point3, UnitVector3, Vector3};
use std::io::BufRead;

/// A tip of the nozzle, and its direction.
type Pose = (Point3<f64>, UnitVector3<f64>);

/// Rotary axes move by no more than this at once, in radians: between two places the tip on the part is taken as going straight.
const TURN: f64 = 0.02;
/// Coordinates beyond this, in millimetres, are a slip.
const MAX_MM: f64 = 1e10;
/// Diameter of the filament of which nothing is known.
const FILAMENT_MM: f64 = 1.75;

struct State {
    builder: Builder,
    said: Said,
    machine: Option<FiveAxis>,
    scale: f64,
    unit_mm: f64,
    is_relative: bool,
    is_filament_relative: bool,
    motion: u32,
    /// Linear axes in millimetres, rotary ones in radians, where they are known.
    axes: [Option<f64>; 5],
    /// What programs call 0, in the same units.
    zero: [f64; 5],
    filament: f64,
    /// Direction of comments at the last tip and now.
    directions: [UnitVector3<f64>; 2],
    words: Vec<(char, f64)>,
}

/// Reads a program.
///
/// # Errors
/// The line and what is wrong.
pub fn read(reader: impl BufRead, hints: &Hints, machine: Option<FiveAxis>, given: &Given) -> Result<Program, String> {
    let diameter = given.filament_diameter_mm.or(hints.filament_diameter_mm).unwrap_or(FILAMENT_MM);
    let how = match (&machine, hints.has_directions) {
        (Some(machine), _) => format!("G-code of the axes of {}", machine.model().name),
        (None, true) => "G-code with directions in comments".to_owned(),
        (None, false) => "G-code of an upright nozzle".to_owned(),
    };
    let layers = if hints.has_layers { "layers by comments" } else { "layers by heights" };
    let mut state = State {
        builder: Builder::new(*given, diameter),
        said: Said::default(),
        machine,
        scale: given.scale,
        unit_mm: 1.0,
        is_relative: false,
        is_filament_relative: false,
        motion: 1,
        axes: [None; 5],
        zero: [0.0; 5],
        filament: 0.0,
        directions: [Vector3::z_axis(); 2],
        words: Vec::new(),
    };
    // Rotary axes stand at 0 until they move.
    (3..5).for_each(|k| state.axes[k] = Some(0.0));
    let mut lines = Lines::new(reader);
    while let Some(text) = lines.next()? {
        if let Err(what) = state.line(text, hints) {
            return Err(format!("line {}: {what}", lines.line));
        }
    }
    Ok(state.builder.finish(format!("{how}, {layers}, filament of {diameter} mm"), hints.has_layers, true))
}

impl State {
    fn line(&mut self, text: &str, hints: &Hints) -> Result<(), String> {
        let (code, comment) = text.split_once(';').map_or((text, None), |(code, comment)| (code, Some(comment.trim())));
        if let Some(comment) = comment {
            self.comment(comment, hints)?;
        }
        let code = code.trim();
        if !is_moves(code) {
            return self.other(code);
        }
        let mut found = std::mem::take(&mut self.words);
        let read = words(code, &mut found);
        self.words = found;
        read.map_err(|(column, expected)| format!("column {column}: expected {expected}"))?;
        self.command()
    }

    fn comment(&mut self, comment: &str, hints: &Hints) -> Result<(), String> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| *value >= 0.0 && *value <= 1e6);
        let said = &mut self.said;
        if let Some(text) = comment.strip_prefix("DIR:") {
            let parts: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
            let parts: Option<[f64; 3]> = parts.and_then(|parts| parts.try_into().ok());
            let unit = parts
                .filter(|parts| parts.iter().all(|x| x.abs() <= 1e6))
                .and_then(|parts| UnitVector3::try_new(Vector3::from(parts), 1e-6));
            self.directions[1] = unit.ok_or("`DIR:` is no direction: three numbers, such as ;DIR:0 0 1")?;
        } else if let Some(value) = comment.strip_prefix("WIDTH:").and_then(number) {
            said.width_mm = value * self.scale;
        } else if let Some(value) = comment.strip_prefix("HEIGHT:").and_then(number) {
            said.height_mm = value * self.scale;
        } else if let Some(kind) = comment.strip_prefix("TYPE:") {
            said.kind = kind_of(kind.trim(), hints.is_solid);
        } else if hints.has_layers
            && let Some(mark) = layer(comment)
        {
            said.layer = Some(match (mark, said.layer) {
                (LayerMark::Number(number), _) => number.max(0) as u32,
                (LayerMark::Next, None) => 0,
                (LayerMark::Next, Some(layer)) => layer + 1,
            });
        }
        Ok(())
    }

    /// A line that is no move: only what changes the meaning of moves counts.
    fn other(&mut self, code: &str) -> Result<(), String> {
        let mut words = code.split_whitespace();
        match words.next() {
            Some("M82") => self.is_filament_relative = false,
            Some("M83") => self.is_filament_relative = true,
            Some("M200")
                if words.any(|word| {
                    word.strip_prefix('D').is_some_and(|size| size.parse().is_ok_and(|size: f64| size > 0.0))
                }) =>
            {
                return Err("M200: filament in cubic millimetres is not read: export lengths".to_owned());
            }
            _ => {}
        }
        Ok(())
    }

    fn word(&self, letter: char) -> Option<f64> {
        self.words.iter().rev().find(|(known, _)| *known == letter).map(|(_, value)| *value)
    }

    fn command(&mut self) -> Result<(), String> {
        let mut is_move = true;
        for k in 0..self.words.len() {
            let (letter, value) = self.words[k];
            let code = (value * 10.0).round() as i64;
            match (letter, code) {
                ('G', 0 | 10 | 20 | 30) => self.motion = (code / 10) as u32,
                ('G', 200) => self.unit_mm = 25.4,
                ('G', 210) => self.unit_mm = 1.0,
                ('G', 900) => self.is_relative = false,
                ('G', 910) => self.is_relative = true,
                ('G', 280) => {
                    // Where the end stops are is not said.
                    (0..3).for_each(|k| self.axes[k] = None);
                    self.builder.end();
                    is_move = false;
                }
                ('G', 920) => {
                    self.position();
                    is_move = false;
                }
                ('G', 901 | 50 | 51 | 180 | 190) => {
                    return Err(format!(
                        "G{value} is not read: export G0, G1, and G2 and G3 with I and J in the plane of x and y"
                    ));
                }
                ('G', 170 | 930 | 940 | 610 | 640 | 540..=590 | 911 | 400 | 490 | 800) => {}
                ('G', _) => is_move = false,
                ('M', 820 | 830) => self.is_filament_relative = code == 830,
                ('A' | 'B' | 'C', _) if self.machine.is_none() => {
                    return Err(format!("{letter} is a rotary axis: describe the machine with --machine FILE"));
                }
                _ => {}
            }
        }
        if is_move { self.motion() } else { Ok(()) }
    }

    /// The letters of axes: of the machine, or x, y and z.
    fn letters(&self) -> Vec<char> {
        self.machine.as_ref().map_or(vec!['X', 'Y', 'Z'], |machine| machine.letters().to_vec())
    }

    fn linear(&self) -> usize {
        self.machine.as_ref().map_or(3, FiveAxis::linear_count)
    }

    fn in_units(&self, k: usize, value: f64) -> f64 {
        if k < self.linear() { value * self.unit_mm * self.scale } else { value.to_radians() }
    }

    /// `G92`: the present place gets another name.
    fn position(&mut self) {
        for (k, letter) in self.letters().into_iter().enumerate() {
            if let Some(value) = self.word(letter) {
                let value = self.in_units(k, value);
                match self.axes[k] {
                    Some(at) => self.zero[k] = at - value,
                    None => (self.axes[k], self.zero[k]) = (Some(value), 0.0),
                }
            }
        }
        if let Some(filament) = self.word('E') {
            self.filament = filament * self.unit_mm;
        }
    }

    fn motion(&mut self) -> Result<(), String> {
        let filament = self.word('E').map(|said| said * self.unit_mm).map_or(0.0, |said| {
            let moved = if self.is_filament_relative { said } else { said - self.filament };
            self.filament += moved;
            moved
        });
        let before = self.axes;
        let mut has_moved = false;
        for (k, letter) in self.letters().into_iter().enumerate() {
            let Some(value) = self.word(letter) else { continue };
            let value = self.in_units(k, value);
            has_moved = true;
            self.axes[k] = match (self.is_relative, self.axes[k]) {
                (true, at) => at.map(|at| at + value),
                (false, _) => Some(value + self.zero[k]),
            };
        }
        if self.axes.iter().flatten().any(|at| at.abs() > MAX_MM) {
            return Err(format!("a place beyond {MAX_MM:e} mm: are the numbers millimetres?"));
        }
        let whole_circle = self.motion > 1 && (self.word('I').is_some() || self.word('J').is_some());
        if !has_moved && !whole_circle {
            return Ok(());
        }
        let axes = self.directions;
        self.directions[0] = axes[1];
        if filament <= 0.0 {
            self.builder.end();
            return Ok(());
        }
        let linear = self.linear();
        let known = |all: [Option<f64>; 5]| -> Option<[f64; 5]> {
            let is_known = (0..linear).all(|k| all[k].is_some());
            is_known.then(|| all.map(|at| at.unwrap_or(0.0)))
        };
        let Some(to) = known(self.axes) else {
            return Err(format!(
                "a bead before the place of {} is known: the first move needs all of them",
                self.letters()[..linear].iter().collect::<String>()
            ));
        };
        let Some(from) = known(before) else {
            self.builder.end();
            return Ok(());
        };
        let laid = self.laid(from, to, axes)?;
        let length: f64 = laid.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).sum();
        for pair in laid.windows(2) {
            let part = (pair[1].0 - pair[0].0).norm();
            if part > 0.0 {
                let filament_mm = Some(filament * part / length);
                self.builder.lay(
                    &Laid { tips: [pair[0].0, pair[1].0], axes: [pair[0].1, pair[1].1], filament_mm },
                    &self.said,
                )?;
            }
        }
        Ok(())
    }

    /// Tips and directions along a move.
    fn laid(&self, from: [f64; 5], to: [f64; 5], axes: [UnitVector3<f64>; 2]) -> Result<Vec<Pose>, String> {
        if let Some(machine) = &self.machine {
            if self.motion > 1 {
                return Err("arcs of axes are not read: export straight moves".to_owned());
            }
            let turn = (self.linear()..5).map(|k| (to[k] - from[k]).abs()).fold(0.0, f64::max);
            let count = (turn / TURN).ceil().clamp(1.0, 1e5) as u32;
            let at = |k: u32| {
                let share = f64::from(k) / f64::from(count);
                machine.forward(&[0, 1, 2, 3, 4].map(|axis| from[axis] + (to[axis] - from[axis]) * share))
            };
            return Ok((0..=count).map(at).collect());
        }
        let [from, to] = [from, to].map(|[x, y, z, ..]| Point3::new(x, y, z));
        if self.motion < 2 {
            return Ok(vec![(from, axes[0]), (to, axes[1])]);
        }
        let offset = |letter: char| self.word(letter).map(|value| value * self.unit_mm * self.scale);
        let centre = match (offset('R'), offset('I'), offset('J')) {
            (_, None, None) if self.word('R').is_none() => return Err("an arc without I, J or R".to_owned()),
            (Some(radius), None, None) => Centre::Radius(radius),
            (_, i, j) => Centre::Offset([i.unwrap_or(0.0), j.unwrap_or(0.0)]),
        };
        let places = chords(from, to, centre, self.motion == 2)?;
        let count = places.len() as f64;
        let mixed = |k: usize| {
            let share = (k + 1) as f64 / count;
            let direction = axes[0].into_inner() * (1.0 - share) + axes[1].into_inner() * share;
            UnitVector3::try_new(direction, 1e-9).unwrap_or(axes[1])
        };
        Ok(std::iter::once((from, axes[0])).chain(places.iter().enumerate().map(|(k, at)| (*at, mixed(k)))).collect())
    }
}

/// Whether a line has moves or their modes, and not a command of a firmware with text.
fn is_moves(code: &str) -> bool {
    let code = code.trim_start_matches(['/', '%', ' ']);
    let mut letters = code.chars();
    let Some(first) = letters.next() else { return false };
    let is_word = letters.find(|c| !c.is_whitespace()).is_some_and(|c| c.is_ascii_digit() || "+-.".contains(c));
    is_word && "GNXYZABCEFUVWgnxyzabcefuvw(".contains(first) || first == '('
}

/// What a bead is for, by the names of PrusaSlicer and its relatives, and of Cura. Sparse beads and what goes over them is not judged for support; support is
/// nearly always sparse, and no name says where it is not.
fn kind_of(name: &str, is_solid: bool) -> BeadKind {
    match name {
        "Internal infill" | "Sparse infill" | "FILL" if !is_solid => BeadKind::Infill,
        "External perimeter" | "Outer wall" | "WALL-OUTER" => BeadKind::Wall,
        "Support material" | "Support" | "SUPPORT" => BeadKind::SparseSupport,
        "Support material interface" | "Support interface" | "SUPPORT-INTERFACE" => BeadKind::SupportBridge,
        "Skirt/Brim" | "Skirt" | "Brim" | "SKIRT" | "Wipe tower" | "Prime tower" | "PRIME-TOWER" | "Custom" => {
            BeadKind::Support
        }
        _ => BeadKind::Solid,
    }
}
