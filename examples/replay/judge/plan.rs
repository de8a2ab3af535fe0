//! The plan: tool paths as `toolpath.gcode` (directions in comments) or `toolpath.csv` has them, bead by bead.

use super::bead::Bead;
use curvlay_examples::laid::words as gcode_words;
use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::HashMap;
use std::io::{BufRead, Lines};

/// From the frame of the plan to that of the part in the machine: turned about z, then shifted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// The turn, in radians.
    pub turn: f64,
    /// What is taken off x and y, in millimetres.
    pub shift_mm: [f64; 2],
}

/// A plan that is read.
pub struct Plan<R> {
    lines: Lines<R>,
    line: u64,
    turn: Rotation3<f64>,
    shift: Vector3<f64>,
    filament_mm2: f64,
    format: Format,
    state: State,
    words: Vec<(char, f64)>,
}

enum Format {
    Gcode,
    /// The column of each name.
    Csv(HashMap<String, usize>),
}

#[derive(Clone, Copy, Debug)]
struct State {
    tip: Option<Point3<f64>>,
    /// Direction there, and the one that holds now; none before the plan has said any.
    leant: Option<Vector3<f64>>,
    direction: Option<Vector3<f64>>,
    /// By tags; 0: not said.
    width: f64,
    height: f64,
    filament_mm: f64,
    is_relative: bool,
    motion: f64,
    path: u32,
    layer: u32,
    has_layer: bool,
    /// Whether the next bead begins a path.
    is_new: bool,
}

impl<R: BufRead> Plan<R> {
    /// Begins to read.
    ///
    /// # Arguments
    /// * `is_csv`: whether it is a table, else G-code.
    /// * `filament_mm2`: cross-section of the filament, for beads whose size the plan does not say.
    ///
    /// # Errors
    /// A table without its columns.
    pub fn new(reader: R, is_csv: bool, placement: Placement, filament_mm2: f64) -> Result<Self, String> {
        let mut lines = reader.lines();
        let (mut format, mut line) = (Format::Gcode, 0);
        if is_csv {
            let head = lines.next().transpose().map_err(|error| error.to_string())?.unwrap_or_default();
            let columns: HashMap<String, usize> =
                head.trim().split(',').enumerate().map(|(k, name)| (name.to_owned(), k)).collect();
            for name in ["kind", "x_mm", "y_mm", "z_mm", "i", "j", "k", "filament_mm", "layer", "width_mm", "height_mm"]
            {
                if !columns.contains_key(name) {
                    return Err(format!(
                        "line 1: the column `{name}` is missing: is it the toolpath.csv of curved_layers?"
                    ));
                }
            }
            (format, line) = (Format::Csv(columns), 1);
        }
        let Placement { turn, shift_mm: [x, y] } = placement;
        let state = State {
            tip: None,
            leant: None,
            direction: None,
            width: 0.0,
            height: 0.0,
            filament_mm: 0.0,
            is_relative: false,
            motion: 0.0,
            path: 0,
            layer: 0,
            has_layer: false,
            is_new: false,
        };
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
        let (shift, words) = (Vector3::new(x, y, 0.0), Vec::new());
        Ok(Plan { lines, line, turn, shift, filament_mm2, format, state, words })
    }

    fn bead_of_line(&mut self, text: &str) -> Result<Option<Bead>, String> {
        match &self.format {
            Format::Gcode => self.gcode(text),
            Format::Csv(columns) => {
                let cells: Vec<&str> = text.split(',').collect();
                let cell = |name: &str| columns.get(name).and_then(|&k| cells.get(k)).copied().unwrap_or("");
                let number = |name: &str| -> Result<f64, String> {
                    let value = cell(name).parse::<f64>().ok().filter(|value| value.abs() <= 1e9);
                    value.ok_or_else(|| format!("`{name}` is `{}`, not a number", cell(name)))
                };
                match cell("kind") {
                    kind @ ("travel" | "print") => {
                        let tip = Point3::new(number("x_mm")?, number("y_mm")?, number("z_mm")?);
                        let direction = Vector3::new(number("i")?, number("j")?, number("k")?);
                        let prints = kind == "print";
                        let filament = if prints { number("filament_mm")? } else { 0.0 };
                        if prints {
                            (self.state.width, self.state.height) = (number("width_mm")?, number("height_mm")?);
                            self.state.layer = (number("layer")? - 1.0).max(0.0) as u32;
                        }
                        self.state.direction = direction.try_normalize(1e-6);
                        Ok(self.moved(tip, filament))
                    }
                    _ => Ok(None),
                }
            }
        }
    }

    fn gcode(&mut self, text: &str) -> Result<Option<Bead>, String> {
        let comment = gcode_words(text.trim_end(), &mut self.words)
            .map_err(|(column, expected)| format!("column {column}: expected {expected}"))?;
        if let Some(comment) = comment {
            self.comment(&comment)?;
        }
        let state = &mut self.state;
        let word = |letter: char| self.words.iter().rev().find(|(known, _)| *known == letter).map(|(_, value)| *value);
        for (letter, value) in &self.words {
            match (letter, (value * 10.0).round() as i64) {
                ('G', 0 | 10) => state.motion = *value,
                ('G', 280) => state.tip = None,
                ('G', 920) => {
                    state.filament_mm = word('E').unwrap_or(state.filament_mm);
                    return Ok(None);
                }
                ('G', 20 | 30 | 910 | 200) => {
                    return Err("arcs, inches and relative places are not read in a plan".to_owned());
                }
                ('M', 820 | 830) => state.is_relative = *value > 82.5,
                ('B' | 'C' | 'A', _) => {
                    return Err("the plan has rotary axes: give the one in the part (toolpath.gcode)".to_owned());
                }
                _ => {}
            }
        }
        let said = word('E');
        let filament = said.map_or(0.0, |said| if state.is_relative { said } else { said - state.filament_mm });
        if let Some(said) = said {
            state.filament_mm = if state.is_relative { state.filament_mm + said } else { said };
        }
        let place = ['X', 'Y', 'Z'].map(word);
        if place.iter().all(Option::is_none) {
            return Ok(None);
        }
        let before = state.tip.unwrap_or_else(Point3::origin);
        let tip = Point3::from([0, 1, 2].map(|k| place[k].unwrap_or(before[k])));
        Ok(self.moved(tip, filament.max(0.0)))
    }

    fn comment(&mut self, comment: &str) -> Result<(), String> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.abs() <= 1e6);
        let state = &mut self.state;
        if let Some(text) = comment.strip_prefix("DIR:") {
            let mut parts = text.split_whitespace().map(number);
            let mut next = || parts.next().flatten();
            let direction = next().zip(next()).zip(next()).map(|((x, y), z)| Vector3::new(x, y, z));
            let direction = direction.and_then(|direction| direction.try_normalize(1e-6));
            let wrong = || format!("`{comment}` is no direction: three numbers, such as ;DIR:0 0 1");
            state.direction = Some(direction.ok_or_else(wrong)?);
        } else if let Some(value) = comment.strip_prefix("WIDTH:").and_then(number) {
            state.width = value;
        } else if let Some(value) = comment.strip_prefix("HEIGHT:").and_then(number) {
            state.height = value;
        } else if comment == "LAYER_CHANGE" {
            state.layer += u32::from(state.has_layer);
            state.has_layer = true;
        } else if let Some(value) = comment.strip_prefix("LAYER:").and_then(number) {
            state.layer = value.max(0.0) as u32;
        }
        Ok(())
    }

    /// The tip has moved: a bead, if it lays anything.
    fn moved(&mut self, tip: Point3<f64>, filament_mm: f64) -> Option<Bead> {
        let state = &mut self.state;
        let before = state.tip.replace(tip);
        let leant = std::mem::replace(&mut state.leant, state.direction);
        let from = before.filter(|from| filament_mm > 0.0 && (tip - from).norm() > 0.0);
        let Some(from) = from else {
            state.is_new = true;
            return None;
        };
        state.path += u32::from(std::mem::take(&mut state.is_new));
        let side = (filament_mm * self.filament_mm2 / (tip - from).norm()).sqrt();
        let or_square = |size: f64| if size > 0.0 { size } else { side };
        let placed = |point: &Point3<f64>| self.turn * point - self.shift;
        Some(Bead {
            from: placed(&from),
            to: placed(&tip),
            directions: leant.zip(state.direction).map(|(from, to)| [self.turn * from, self.turn * to]),
            width: or_square(state.width),
            height: or_square(state.height),
            filament_mm,
            path: state.path.saturating_sub(1),
            layer: state.layer,
        })
    }
}

impl<R: BufRead> Iterator for Plan<R> {
    type Item = Result<Bead, String>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let text = match self.lines.next()? {
                Ok(text) => text,
                Err(error) => return Some(Err(error.to_string())),
            };
            self.line += 1;
            match self.bead_of_line(&text) {
                Ok(Some(bead)) => return Some(Ok(bead)),
                Ok(None) => {}
                Err(what) => return Some(Err(format!("line {}: {what}", self.line))),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "G28\nM82\nG92 E0\n;LAYER_CHANGE\nG0 X0 Y0 Z1 F600 ;DIR:0 0 1\n;WIDTH:0.5\n;HEIGHT:0.3\nG1 X10 E2 F600\nG1 Y5 E3 ;DIR:0 0.6 0.8\nG1 E2\nG0 X0 Y0\n;LAYER_CHANGE\nG1 E3\nG1 X1 E3.5\n";

    #[test]
    fn beads_paths_and_layers() {
        let beads: Vec<Bead> =
            Plan::new(TEXT.as_bytes(), false, Placement::default(), 2.4).unwrap().map(Result::unwrap).collect();
        assert_eq!(beads.len(), 3);
        assert_eq!((beads[0].length(), beads[0].filament_mm, beads[0].width, beads[0].height), (10.0, 2.0, 0.5, 0.3));
        assert_eq!(
            (beads[1].directions.map(|[from, to]| (from.z, to.y)), beads[1].to),
            (Some((1.0, 0.6)), Point3::new(10.0, 5.0, 1.0))
        );
        let plain =
            Plan::new("G0 X0 Y0 Z1\nG1 X1 E1".as_bytes(), false, Placement::default(), 2.4).unwrap().next().unwrap();
        assert_eq!(plain.unwrap().directions, None);
        assert_eq!([0, 1, 2].map(|k| beads[k].path), [0, 0, 1]);
        assert_eq!([0, 1, 2].map(|k| beads[k].layer), [0, 0, 1]);
        // Turned by a quarter about z, then shifted.
        let placement = Placement { turn: std::f64::consts::FRAC_PI_2, shift_mm: [1.0, 2.0] };
        let bead = Plan::new(TEXT.as_bytes(), false, placement, 2.4).unwrap().next().unwrap().unwrap();
        assert!((bead.to - Point3::new(-1.0, 8.0, 1.0)).norm() < 1e-12, "{}", bead.to);
    }

    #[test]
    fn a_table_is_the_same_plan() {
        let text = "kind,x_mm,y_mm,z_mm,i,j,k,filament_mm,feed_mm_s,seconds,layer,bead,width_mm,height_mm\n\
                    travel,0,0,1,0,0,1,0,10,1,,,,\nprint,10,0,1,0,0,1,2,10,1,1,wall,0.5,0.3\nretract,,,,,,,-1,10,1,,,,\nprint,10,5,1,0,0,1,1,10,1,2,wall,0.5,0.3\n";
        let beads: Vec<Bead> =
            Plan::new(text.as_bytes(), true, Placement::default(), 2.4).unwrap().map(Result::unwrap).collect();
        assert_eq!((beads.len(), beads[0].filament_mm, beads[1].layer, beads[1].path), (2, 2.0, 1, 0));
        let error =
            |text: &'static str| Plan::new(text.as_bytes(), true, Placement::default(), 2.4).map(|plan| plan.last());
        assert!(error("kind,x_mm\n").err().unwrap().contains("`y_mm` is missing"));
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &'static str| {
            Plan::new(text.as_bytes(), false, Placement::default(), 2.4).unwrap().find_map(Result::err).unwrap()
        };
        assert!(fault("G1 X1\nG1 X2 B5 E1").starts_with("line 2: the plan has rotary axes"));
        assert!(fault("G1 X1 ;DIR:0 0").starts_with("line 1: `DIR:0 0` is no direction"));
        assert!(fault("G2 X1").contains("arcs"));
        assert!(fault("G1 ?").contains("column 4"));
    }
}
