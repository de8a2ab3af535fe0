//! Drawings in a text file of our own: saved, and loaded as they were, to the last bit.
//!
//! Brooks saves a design as B3D, the classes of his program in binary (section 4.12). Here it is text, a record a line:
//!
//! | line | content |
//! |---|---|
//! | `curvlay-drawing 2` | first: the format and its version; version 1 has no `at`, `note` and `path` |
//! | `unit_mm X` | how many millimetres the unit of the file was; no line if it did not say |
//! | `skipped N KIND` | what was not drawn, and how many |
//! | `at PLACE` | where one of them was |
//! | `note TEXT` | what the reader assumed |
//! | `entity LINE open`, `entity LINE closed` | begins an entity: its line in the file it came from, and whether a segment closes it |
//! | `kind TEXT`, `layer TEXT` | of the entity |
//! | `path N nonzero`, `path N evenodd` | the entity is an outline of this path, whose outlines are filled together by this rule |
//! | `line X Y X Y` | a curve: a segment |
//! | `arc X Y UX UY VX VY FROM SWEEP` | centre, two conjugate half-diameters, angles in radians |
//! | `spline DEGREE` | a spline, with the lines `knots X ...`, `points X Y ...` and, if it is rational, `weights X ...` |
//! | `end` | last |
//!
//! Lengths are in millimetres. Numbers have the shortest digits that are read as the same number. Texts go to the end of the line, with
//! `\\`, `\n` and `\r` for backslash and ends of lines.

use super::curve::Curve;
use super::drawing::{Drawing, Entity, FillRule, PathFill};
use super::skipped::Skipped;
use nalgebra::{Point2, Vector2};
use std::io::{self, BufRead, Write};

/// Why a drawing could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The first line is another one.
    #[error("line 1: not a drawing in the format `{HEAD}`")]
    Head,
    /// A line that cannot be, or not there.
    #[error("line {line}: {what}")]
    Line {
        /// The line.
        line: u64,
        /// What is wrong with it.
        what: String,
    },
    /// The file ends before its last line.
    #[error("line {line}: the file ends before `end`")]
    Truncated {
        /// Its last line.
        line: u64,
    },
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
}

const HEAD: &str = "curvlay-drawing 2";
const OLD_HEAD: &str = "curvlay-drawing 1";

/// Longest line: a spline of a million points.
const LONGEST_LINE: u64 = 1 << 26;

/// Saves a drawing.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] for a number that is not finite, which names the entity; and what the writer reports.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{Curve, Drawing, load_drawing, save_drawing};
/// use curvlay_toolpath::nalgebra::Point2;
/// let mut drawing = Drawing::default();
/// drawing.add("RIM", [Curve::circle(Point2::new(1.0, 2.0), 0.1, 0.0, 1.0 / 3.0)]);
/// let mut file = Vec::new();
/// save_drawing(&mut file, &drawing)?;
/// assert_eq!(load_drawing(file.as_slice()).map_err(std::io::Error::other)?, drawing);
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn save_drawing(out: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    writeln!(out, "{HEAD}")?;
    if let Some(unit_mm) = drawing.unit_mm {
        writeln!(out, "unit_mm{}", numbers(0, [unit_mm])?)?;
    }
    for Skipped { what, count, places } in &drawing.skipped {
        writeln!(out, "skipped {count} {}", escaped(what))?;
        places.iter().try_for_each(|place| writeln!(out, "at {}", escaped(place)))?;
    }
    drawing.notes.iter().try_for_each(|note| writeln!(out, "note {}", escaped(note)))?;
    for (number, entity) in drawing.entities.iter().enumerate() {
        let Entity { kind, layer, line, curves, closed, fill } = entity;
        writeln!(out, "entity {line} {}", if *closed { "closed" } else { "open" })?;
        writeln!(out, "kind {}\nlayer {}", escaped(kind), escaped(layer))?;
        if let Some(PathFill { path, rule }) = fill {
            let rule = if *rule == FillRule::EvenOdd { "evenodd" } else { "nonzero" };
            writeln!(out, "path {path} {rule}")?;
        }
        let row = |values: Vec<f64>| numbers(number + 1, values);
        let flat = |points: &[Point2<f64>]| points.iter().flat_map(|p| [p.x, p.y]).collect::<Vec<f64>>();
        for curve in curves {
            match curve {
                Curve::Line { from, to } => writeln!(out, "line{}", row(flat(&[*from, *to]))?)?,
                Curve::Arc { centre, u, v, from, sweep } => {
                    writeln!(out, "arc{}", row(vec![centre.x, centre.y, u.x, u.y, v.x, v.y, *from, *sweep])?)?;
                }
                Curve::Spline { degree, knots, points, weights } => {
                    writeln!(out, "spline {degree}\nknots{}\npoints{}", row(knots.clone())?, row(flat(points))?)?;
                    if !weights.is_empty() {
                        writeln!(out, "weights{}", row(weights.clone())?)?;
                    }
                }
            }
        }
    }
    writeln!(out, "end")?;
    out.flush()
}

/// Numbers with a blank before each.
fn numbers(entity: usize, values: impl IntoIterator<Item = f64>) -> io::Result<String> {
    let mut text = String::new();
    for value in values {
        if !value.is_finite() {
            let what = if entity > 0 {
                format!("entity {entity} has a number that is not finite")
            } else {
                "the unit is not finite".to_owned()
            };
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        text += &format!(" {value:?}");
    }
    Ok(text)
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('\n', "\\n").replace('\r', "\\r")
}

fn unescaped(text: &str) -> Option<String> {
    let mut out = String::new();
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        out.push(match c {
            '\\' => match chars.next()? {
                '\\' => '\\',
                'n' => '\n',
                'r' => '\r',
                _ => return None,
            },
            c => c,
        });
    }
    Some(out)
}

/// Loads a drawing that was saved. Curves are checked when the drawing is [flattened](Drawing::contours).
///
/// # Errors
/// [`LoadError`] names the line.
pub fn load_drawing(mut input: impl BufRead) -> Result<Drawing, LoadError> {
    let mut drawing = Drawing::default();
    let mut number = 0;
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let read = io::Read::take(&mut input, LONGEST_LINE).read_until(b'\n', &mut bytes)?;
        if read == 0 {
            return Err(if number == 0 { LoadError::Head } else { LoadError::Truncated { line: number } });
        }
        number += 1;
        let not_text = |_| match number {
            1 => LoadError::Head,
            line => LoadError::Line { line, what: "it is not UTF-8".to_owned() },
        };
        let text = std::str::from_utf8(&bytes).map_err(not_text)?;
        let text = text.strip_suffix('\n').unwrap_or(text);
        let text = text.strip_suffix('\r').unwrap_or(text);
        if number == 1 {
            if ![HEAD, OLD_HEAD].contains(&text) {
                return Err(LoadError::Head);
            }
            continue;
        }
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        if word == "end" {
            return Ok(drawing);
        }
        Line { number, word, rest }.read_into(&mut drawing)?;
    }
}

/// A line of the file after the first.
struct Line<'a> {
    number: u64,
    /// What it gives: its first word.
    word: &'a str,
    rest: &'a str,
}

impl Line<'_> {
    fn wrong(&self, what: &str) -> LoadError {
        LoadError::Line { line: self.number, what: what.to_owned() }
    }

    fn string(&self, text: &str) -> Result<String, LoadError> {
        unescaped(text).ok_or_else(|| self.wrong("a backslash must come before `\\`, `n` or `r`"))
    }

    fn numbers(&self) -> Result<Vec<f64>, LoadError> {
        let value = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
        let all: Option<Vec<f64>> = self.rest.split_ascii_whitespace().map(value).collect();
        all.ok_or_else(|| self.wrong("a number is not one, or not finite"))
    }

    /// So many numbers; `wanted` says how many.
    fn exactly<const N: usize>(&self, wanted: &str) -> Result<[f64; N], LoadError> {
        self.numbers()?.try_into().map_err(|_| self.wrong(wanted))
    }

    /// The entity that the line belongs to: the last one.
    fn entity<'d>(&self, drawing: &'d mut Drawing) -> Result<&'d mut Entity, LoadError> {
        drawing.entities.last_mut().ok_or_else(|| self.wrong("it belongs to an entity, but no entity precedes it"))
    }

    /// Adds what the line gives to the drawing.
    fn read_into(&self, drawing: &mut Drawing) -> Result<(), LoadError> {
        match self.word {
            "unit_mm" => drawing.unit_mm = Some(self.exactly::<1>("it must have one number")?[0]),
            "skipped" => {
                let parts = self.rest.split_once(' ').and_then(|(count, kind)| Some((kind, count.parse().ok()?)));
                let (kind, count) = parts.ok_or_else(|| self.wrong("it must have a number and a kind"))?;
                drawing.skipped.push(Skipped { what: self.string(kind)?, count, places: Vec::new() });
            }
            "at" => match drawing.skipped.last_mut() {
                Some(skipped) => skipped.places.push(self.string(self.rest)?),
                None => return Err(self.wrong("it belongs to what is skipped, and there is nothing yet")),
            },
            "note" => drawing.notes.push(self.string(self.rest)?),
            "entity" => drawing.entities.push(self.new_entity()?),
            "path" => {
                let fill = self.fill()?;
                self.entity(drawing)?.fill = Some(fill);
            }
            "kind" => self.entity(drawing)?.kind = self.string(self.rest)?,
            "layer" => self.entity(drawing)?.layer = self.string(self.rest)?,
            "line" | "arc" | "spline" => {
                let curve = self.curve()?;
                self.entity(drawing)?.curves.push(curve);
            }
            "knots" | "points" | "weights" => self.read_into_spline(drawing)?,
            _ => return Err(self.wrong("its first word is unknown")),
        }
        Ok(())
    }

    /// An entity whose other lines follow.
    fn new_entity(&self) -> Result<Entity, LoadError> {
        let parts = self.rest.split_once(' ').and_then(|(line, state)| Some((line.parse().ok()?, state)));
        let (line, closed) = match parts {
            Some((line, "open")) => (line, false),
            Some((line, "closed")) => (line, true),
            _ => return Err(self.wrong("it must have the number of a line, and `open` or `closed`")),
        };
        Ok(Entity { kind: String::new(), layer: String::new(), line, curves: vec![], closed, fill: None })
    }

    fn fill(&self) -> Result<PathFill, LoadError> {
        match self.rest.split_once(' ').map(|(path, rule)| (path.parse(), rule)) {
            Some((Ok(path), "nonzero")) => Ok(PathFill { path, rule: FillRule::NonZero }),
            Some((Ok(path), "evenodd")) => Ok(PathFill { path, rule: FillRule::EvenOdd }),
            _ => Err(self.wrong("it must have a number, and `nonzero` or `evenodd`")),
        }
    }

    /// A curve; of a spline the degree, whose other lines follow.
    fn curve(&self) -> Result<Curve, LoadError> {
        Ok(match self.word {
            "line" => {
                let [a, b, c, d] = self.exactly("it must have four numbers")?;
                Curve::Line { from: Point2::new(a, b), to: Point2::new(c, d) }
            }
            "arc" => {
                let [x, y, ux, uy, vx, vy, from, sweep] = self.exactly("it must have eight numbers")?;
                Curve::Arc { centre: Point2::new(x, y), u: Vector2::new(ux, uy), v: Vector2::new(vx, vy), from, sweep }
            }
            _ => {
                let degree = self.rest.trim().parse().map_err(|_| self.wrong("it must have a degree"))?;
                Curve::Spline { degree, knots: vec![], points: vec![], weights: vec![] }
            }
        })
    }

    /// Numbers of the last curve, which is a spline.
    fn read_into_spline(&self, drawing: &mut Drawing) -> Result<(), LoadError> {
        let all = self.numbers()?;
        let curve = drawing.entities.last_mut().and_then(|entity| entity.curves.last_mut());
        let Some(Curve::Spline { knots, points, weights, .. }) = curve else {
            return Err(self.wrong("it belongs to a spline, but no spline precedes it"));
        };
        match self.word {
            "knots" => *knots = all,
            "weights" => *weights = all,
            _ if all.len().is_multiple_of(2) => *points = all.chunks(2).map(|p| Point2::new(p[0], p[1])).collect(),
            _ => return Err(self.wrong("points have two numbers each")),
        }
        Ok(())
    }
}
