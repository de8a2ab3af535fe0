//! Where in the print a tick is: its program, and from `trajectory.csv` its layer and path.

use super::print::{Counted, Print};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// A motion of `trajectory.csv`.
#[derive(Clone, Debug, PartialEq)]
struct Motion {
    begins_s: f64,
    kind: String,
    layer: String,
    path: String,
}

/// Knows the places of ticks.
#[derive(Clone, Debug)]
pub struct Places {
    names: Vec<String>,
    ends: Vec<u32>,
    period_s: f64,
    motions: Vec<Motion>,
}

impl Places {
    /// Of a print, with the motions that its folder has; without that file ticks have a program only.
    pub fn of(folder: &Path, print: &Print, counted: &Counted) -> Self {
        let name = |path: &std::path::PathBuf| {
            path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        };
        let motions =
            File::open(folder.join("trajectory.csv")).map(|file| motions(BufReader::new(file))).unwrap_or_default();
        Places {
            names: print.files.iter().map(name).collect(),
            ends: counted.ends.clone(),
            period_s: print.rate.seconds(),
            motions,
        }
    }

    /// A tick in words, from 1: `print_002.script, tick 310 of it, layer 12, path 3 (print)`.
    pub fn name(&self, tick: u32) -> String {
        let file = self.ends.partition_point(|end| *end < tick).min(self.ends.len().saturating_sub(1));
        let before = self.before(file);
        let step = tick.saturating_sub(before);
        let mut text = format!("{}, tick {step} of it", self.names.get(file).map_or("", String::as_str));
        // The first tick of a program is the move to its begin.
        let time_s = self.begins_s(file) + f64::from(step.saturating_sub(1)) * self.period_s;
        let at = self.motions.partition_point(|motion| motion.begins_s <= time_s);
        if let Some(Motion { kind, layer, path, .. }) = at.checked_sub(1).map(|at| &self.motions[at]) {
            text += &format!(", layer {layer}, path {path} ({kind})");
        }
        text
    }

    /// Ticks of the programs before one.
    fn before(&self, file: usize) -> u32 {
        file.checked_sub(1).map_or(0, |last| self.ends[last])
    }

    /// When a program begins. Its ticks and the ends that they round are counted; the begin is that of the nearest motion.
    fn begins_s(&self, file: usize) -> f64 {
        let about_s = f64::from(self.before(file).saturating_sub(2 * file as u32)) * self.period_s;
        let begins = self.motions.iter().map(|motion| motion.begins_s);
        begins.min_by(|a, b| (a - about_s).abs().total_cmp(&(b - about_s).abs())).unwrap_or(about_s)
    }
}

/// Lines that are no motion are passed over: the file is read for names only.
fn motions(file: impl BufRead) -> Vec<Motion> {
    let mut motions: Vec<Motion> = Vec::new();
    let mut last = None;
    for line in file.lines().skip(1).map_while(Result::ok) {
        let cells: Vec<&str> = line.split(',').collect();
        let [number, time, .., kind, layer, path, _, _] = &cells[..] else { continue };
        if last.as_deref() == Some(*number) {
            continue;
        }
        last = Some((*number).to_owned());
        let Ok(begins_s) = time.parse() else { continue };
        let [kind, layer, path] = [kind, layer, path].map(|cell| (*cell).to_owned());
        motions.push(Motion { begins_s, kind, layer, path });
    }
    motions
}
