//! Programs of targets on the part, in the language of the controller.

use super::programs::{full_scale, takes_stream};
use crate::outcome::Failure;
use curvlay_kinematics::program::{
    KrlOptions, RapidOptions, Step, TpOptions, WriteError, write_krl, write_rapid, write_tp,
};
use curvlay_kinematics::workcell::{Equipment, ProgramLanguage};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

/// Moves of a RAPID module, half a megabyte.
const RAPID_MODULE_MOVES: u32 = 5000;

/// Languages of programs of targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetLanguage {
    /// Of ABB.
    Rapid,
    /// Of KUKA.
    Krl,
    /// Of Fanuc.
    Tp,
}

impl TargetLanguage {
    /// That of the controller of a cell; `None` for one that takes joints over time, see [`takes_stream`].
    ///
    /// # Errors
    /// In words, for an arm of a maker whose language is not written, and as of [`takes_stream`].
    pub fn of(equipment: &Equipment) -> Result<Option<Self>, Failure> {
        if takes_stream(equipment).map_err(Failure::new)? {
            return Ok(None);
        }
        match equipment.language() {
            Some(ProgramLanguage::UrScript) => Ok(None),
            Some(ProgramLanguage::Rapid) => Ok(Some(Self::Rapid)),
            Some(ProgramLanguage::Krl) => Ok(Some(Self::Krl)),
            Some(ProgramLanguage::Tp) => Ok(Some(Self::Tp)),
            None => Err(Failure::new(format!(
                "{}: no programs are written in the language of its controller; if it reads RAPID, KRL or TP, name that as `controller.language` \
                 of a workcell file; `curved_layers --stage motion --program csv` writes the targets as a table",
                equipment.name()
            ))),
        }
    }
}

/// How a program of targets is written.
#[derive(Clone, Debug)]
pub struct TargetFormat {
    /// Its name, without the ending of a file.
    pub name: String,
    /// Its language.
    pub language: TargetLanguage,
    /// Moves of a module at most; `None`: 5000 in RAPID, and those of [`KrlOptions`] and [`TpOptions`].
    pub moves_per_file: Option<u32>,
    /// The fastest that the filament goes, in mm/s: its signal has a range that holds this.
    pub max_filament_mm_s: f64,
}

impl TargetFormat {
    /// With modules as long as the language has them.
    pub fn new(name: String, language: TargetLanguage, max_filament_mm_s: f64) -> Self {
        TargetFormat { name, language, moves_per_file: None, max_filament_mm_s }
    }
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TargetProgram {
    /// The file to start.
    pub main: String,
    /// Moves in all its files.
    pub moves: u64,
    /// Those with another speed than planned, since the controller takes no such speed.
    pub speeds_clamped: u64,
}

/// Writes one program, its main file and its modules.
///
/// # Errors
/// As of [`write_rapid`], [`write_krl`] and [`write_tp`].
pub fn write_targets<O: Write>(
    steps: impl IntoIterator<Item = Step>,
    equipment: &Equipment,
    format: &TargetFormat,
    open: impl FnMut(&str) -> io::Result<O>,
) -> Result<TargetProgram, WriteError> {
    let TargetFormat { name, language, moves_per_file, max_filament_mm_s } = format;
    let filament_full_scale_mm_s = full_scale(*max_filament_mm_s);
    let name = name.clone();
    match language {
        TargetLanguage::Krl => {
            let options = KrlOptions::of_workcell(equipment);
            let moves_per_module = moves_per_file.unwrap_or(options.moves_per_module);
            let main = format!("{name}.src");
            let options = KrlOptions { name, moves_per_module, filament_full_scale_mm_s, ..options };
            let written = write_krl(steps, &options, open)?;
            Ok(TargetProgram { main, moves: written.moves, speeds_clamped: written.speeds_clamped })
        }
        TargetLanguage::Tp => {
            let options = TpOptions::of_workcell(equipment);
            let moves_per_program = moves_per_file.unwrap_or(options.moves_per_program);
            let main = format!("{name}.ls");
            let options = TpOptions { name, moves_per_program, filament_full_scale_mm_s, ..options };
            let written = write_tp(steps, &options, open)?;
            Ok(TargetProgram { main, moves: written.moves, speeds_clamped: written.speeds_clamped })
        }
        TargetLanguage::Rapid => {
            let moves_per_module = moves_per_file.unwrap_or(RAPID_MODULE_MOVES);
            let main = format!("{name}.mod");
            let options = RapidOptions { name, moves_per_module, ..RapidOptions::of_workcell(equipment) };
            let moves = write_rapid(steps, &options, open)?.moves;
            Ok(TargetProgram { main, moves, speeds_clamped: 0 })
        }
    }
}

/// The files of one program, by name.
///
/// # Errors
/// As of [`write_targets`].
pub fn target_files(
    steps: impl IntoIterator<Item = Step>,
    equipment: &Equipment,
    format: &TargetFormat,
) -> Result<BTreeMap<String, Vec<u8>>, WriteError> {
    let mut files: Vec<(String, Shared)> = Vec::new();
    write_targets(steps, equipment, format, |name| {
        let file = Shared::default();
        files.push((name.to_owned(), file.clone()));
        Ok(file)
    })?;
    Ok(files.into_iter().map(|(name, file)| (name, file.take())).collect())
}

/// Bytes that a writer fills while it is elsewhere.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn take(&self) -> Vec<u8> {
        self.0.lock().map(|mut bytes| std::mem::take(&mut *bytes)).unwrap_or_default()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().map_err(|_| io::Error::other("a writer panicked"))?.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{TABLE_CELL, programs::languages, workcell_model, workcell_of, workcell_or};
    use curvlay_kinematics::program::{Goal, Move, Speed, Zone};
    use std::path::Path;

    fn language(arm: &str) -> Result<Option<TargetLanguage>, Failure> {
        TargetLanguage::of(workcell_of(workcell_model(Path::new(arm))?, None)?.equipment())
    }

    #[test]
    fn the_language_is_that_of_the_maker_or_of_the_file() {
        let found = ["ur10e", "irb120", "kr6r900", "m20ia"].map(|arm| language(arm).unwrap());
        assert_eq!(found, [None, Some(TargetLanguage::Rapid), Some(TargetLanguage::Krl), Some(TargetLanguage::Tp)]);
        let refused = language("tx2-60").unwrap_err();
        assert!(refused.message().contains("`controller.language`"), "{}", refused.message());
        let mut model = workcell_or(None, TABLE_CELL).unwrap();
        model.controller.language = Some(ProgramLanguage::Krl);
        let cell = workcell_of(model, None).unwrap();
        assert_eq!(TargetLanguage::of(cell.equipment()).unwrap(), Some(TargetLanguage::Krl));
        assert_eq!(
            languages(cell.equipment()),
            Ok(vec![ProgramLanguage::Krl, ProgramLanguage::Rapid, ProgramLanguage::Tp])
        );
    }

    /// Files of one program, by the endings of its language.
    #[test]
    fn a_program_has_the_files_of_its_language() {
        let cell = workcell_of(workcell_or(None, TABLE_CELL).unwrap(), None).unwrap();
        let files = |language| {
            let format = TargetFormat::new("print".into(), language, 1.0);
            let goal = Goal::Joints([0.0, 0.0, 0.0, 0.0, 0.5, 0.0]);
            let home = Move { goal, table: Some([0.0; 2].into()), speed: Speed::default(), zone: Zone::Stop };
            let files = target_files([Step::Move(home)], cell.equipment(), &format).unwrap();
            files.into_keys().collect::<Vec<_>>()
        };
        assert!(files(TargetLanguage::Rapid).contains(&"print.mod".to_owned()));
        let krl = files(TargetLanguage::Krl);
        assert!(krl.contains(&"print.src".to_owned()) && krl.contains(&"print.dat".to_owned()), "{krl:?}");
        assert!(files(TargetLanguage::Tp).contains(&"print.ls".to_owned()));
    }
}
