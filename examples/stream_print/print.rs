//! A planned print: its programs, as steps one after the other, and where a tick of it is.

use curvlay_examples::args::Failure;
use curvlay_examples::input::{self, MAX_SETTINGS_BYTES};
use curvlay_examples::motion::{WORKCELL_FILE, workcell_model, workcell_of};
use curvlay_examples::output::is_numbered;
use curvlay_kinematics::program::ur_stream::{UrStreamError, UrStreamJob, UrStreamOptions, UrTick, UrTicks};
use curvlay_kinematics::program::{ProgramLimits, ServoRate, Step, UrScriptOptions, UrScriptReader};
use std::cell::{Cell, RefCell};
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The programs of a print, in their order.
#[derive(Clone, Debug)]
pub struct Print {
    /// Where they are.
    pub files: Vec<PathBuf>,
    /// Frames and payload of the first one, limits of the arm.
    pub script: UrScriptOptions,
    /// Of their streams.
    pub rate: ServoRate,
    /// Moves by joints are no faster than this, in rad/s.
    pub max_move_rad_s: f64,
}

/// What a pass through the ticks has found.
#[derive(Clone, Debug)]
pub struct Counted {
    /// Number and ticks of the print.
    pub job: UrStreamJob,
    /// The last tick of each program.
    pub ends: Vec<u32>,
    /// The first posture.
    pub first: [f64; 6],
    /// The fastest filament, in mm/s.
    pub filament_mm_s: f64,
}

impl Print {
    /// Finds the programs of a folder: those of its `programs.csv`, else all `print_NNN.script`. Moves by joints are as fast as they say, but no faster than
    /// `max_move_rad_s`.
    pub fn open(folder: &Path, max_move_rad_s: f64) -> Result<Self, Failure> {
        let files = listed(folder)?;
        let Some(first) = files.first() else {
            return Err(Failure::new(format!(
                "{}: no print_001.script; plan the print with `curved_layers --stage motion --program urscript`",
                folder.display()
            )));
        };
        let refused = |error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", first.display()));
        let open = || -> Result<_, Failure> {
            let file = File::open(first).map_err(|error| refused(&error))?;
            UrScriptReader::new(BufReader::new(file)).map_err(|error| refused(&error))
        };
        let reader = open()?;
        let script = UrScriptOptions {
            part_in_hand: reader.part_in_hand(),
            work: *reader.work(),
            tool: *reader.tool(),
            payload: reader.payload().copied(),
            limits: limits(folder)?,
            ..UrScriptOptions::default()
        };
        // Signals of the program are late by its look-ahead time.
        let [lookahead_s, gain] = servo_options(first).map_err(|error| refused(&error))?;
        let script = UrScriptOptions {
            lookahead_s: lookahead_s.unwrap_or(script.lookahead_s),
            gain: gain.unwrap_or(script.gain),
            ..script
        };
        let mut seconds = None;
        for step in open()? {
            if let Step::Servo { seconds: found, .. } = step.map_err(|error| refused(&error))? {
                seconds = Some(found);
                break;
            }
        }
        let rates = [ServoRate::Hz125, ServoRate::Hz500];
        let rate = seconds.and_then(|found| rates.into_iter().find(|rate| (rate.seconds() - found).abs() < 1e-9));
        let rate = rate.ok_or_else(|| {
            refused(&"it has no `servoj` at 125 or 500 Hz: plan with --program urscript, not urscript-movep")
        })?;
        Ok(Print { files, script, rate, max_move_rad_s })
    }

    /// The steps of all programs.
    pub fn steps(&self) -> Steps {
        Steps { files: self.files.clone(), reader: None, at: Rc::default(), failed: Rc::default() }
    }

    /// Reads all programs once: counts ticks, and finds what cannot be streamed.
    pub fn count(&self, options: &UrStreamOptions) -> Result<Counted, Failure> {
        let steps = self.steps();
        let (at, failed) = (steps.at.clone(), steps.failed.clone());
        let mut ends = vec![0; self.files.len()];
        let mut counted = 0;
        let (mut first, mut filament_mm_s) = (None, 0.0f64);
        let ticks = slowed(UrTicks::new(steps, options), self.max_move_rad_s).inspect(|tick| {
            if let Ok(tick) = tick {
                counted += 1;
                ends[at.get().saturating_sub(1)] = counted;
                first = first.or(Some(tick.joints));
                filament_mm_s = filament_mm_s.max(tick.filament_mm_s.unwrap_or(0.0));
            }
        });
        let job = UrStreamJob::of(ticks);
        if let Some(failure) = failed.borrow_mut().take() {
            return Err(failure);
        }
        let job = job.map_err(|error| {
            let file = &self.files[at.get().clamp(1, self.files.len()) - 1];
            Failure::new(format!("{}: {error} (counted through all programs)", file.display()))
        })?;
        Ok(Counted { job, ends, first: first.unwrap_or_default(), filament_mm_s })
    }

    /// The ticks, for a sender; what fails is left in the cell.
    pub fn ticks(
        &self,
        options: &UrStreamOptions,
    ) -> (impl Iterator<Item = Result<UrTick, UrStreamError>> + use<>, Rc<RefCell<Option<Failure>>>) {
        let steps = self.steps();
        let failed = steps.failed.clone();
        (slowed(UrTicks::new(steps, options), self.max_move_rad_s), failed)
    }
}

/// Ticks whose moves by joints are no faster than `most`, in rad/s.
fn slowed(
    ticks: impl Iterator<Item = Result<UrTick, UrStreamError>>,
    most: f64,
) -> impl Iterator<Item = Result<UrTick, UrStreamError>> {
    ticks.map(move |tick| tick.map(|tick| UrTick { move_rad_s: tick.move_rad_s.map(|speed| speed.min(most)), ..tick }))
}

/// Limits of the arm of the run: its wrist may turn without end. Without the workcell of the run those that no arm of the maker goes beyond.
fn limits(folder: &Path) -> Result<ProgramLimits, Failure> {
    let file = folder.join(WORKCELL_FILE);
    if !file.is_file() {
        return Ok(UrScriptOptions::default().limits);
    }
    let mut model = workcell_model(&file)?;
    // Their meshes may be elsewhere by now.
    model.arm.bodies = None;
    Ok(ProgramLimits::of_arm(workcell_of(model, Some(&file))?.equipment().arm()))
}

/// Look-ahead time and gain of the first `servoj` of a program.
fn servo_options(path: &Path) -> std::io::Result<[Option<f64>; 2]> {
    for line in BufReader::new(File::open(path)?).lines() {
        let line = line?;
        if line.contains("servoj(") {
            let of = |name: &str| line.split_once(name)?.1.split([',', ')']).next()?.trim().parse().ok();
            return Ok(["lookahead_time=", "gain="].map(of));
        }
    }
    Ok([None; 2])
}

/// The programs of a folder.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let list = folder.join("programs.csv");
    let is_script = |name: &str| is_numbered(name, "print_", 3, ".script");
    if list.is_file() {
        let text = input::read_text(&list, MAX_SETTINGS_BYTES)?;
        let names = text.lines().skip(1).filter_map(|line| line.split(',').next()).filter(|name| is_script(name));
        return Ok(names.map(|name| folder.join(name)).collect());
    }
    let entries = fs::read_dir(folder).map_err(|error| Failure::new(format!("{}: {error}", folder.display())))?;
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| is_script(name));
    names.sort();
    Ok(names.into_iter().map(|name| folder.join(name)).collect())
}

/// The steps of programs one after the other. Ends at the first error, which is left in a cell.
pub struct Steps {
    files: Vec<PathBuf>,
    reader: Option<UrScriptReader<BufReader<File>>>,
    /// Programs that were begun.
    at: Rc<Cell<usize>>,
    failed: Rc<RefCell<Option<Failure>>>,
}

impl Steps {
    fn fail(&mut self, error: impl std::fmt::Display) {
        let file = &self.files[self.at.get().saturating_sub(1)];
        *self.failed.borrow_mut() = Some(Failure::new(format!("{}: {error}", file.display())));
        self.at.set(self.files.len());
        self.reader = None;
    }
}

impl Iterator for Steps {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        loop {
            match self.reader.as_mut().and_then(Iterator::next) {
                Some(Ok(step)) => return Some(step),
                Some(Err(error)) => {
                    self.fail(error);
                    return None;
                }
                None => {}
            }
            let path = self.files.get(self.at.get())?.clone();
            self.at.set(self.at.get() + 1);
            match File::open(&path) {
                Ok(file) => match UrScriptReader::new(BufReader::new(file)) {
                    Ok(reader) => self.reader = Some(reader),
                    Err(error) => self.fail(error),
                },
                Err(error) => self.fail(error),
            }
        }
    }
}
