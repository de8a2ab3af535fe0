//! Whether a flavour can be: each field for itself, and together.

use super::data::{Direction, FilamentWords, Flavour};
use super::error::FlavourError;
use super::fill::{Value, fill};
use crate::gcode::LONGEST_LINE;

/// Digits behind the point that a number may have: more than any controller reads.
const MAX_DECIMALS: usize = 8;
/// Factors of numbers: what is beyond loses the number's digits.
const SCALE: [f64; 2] = [1e-6, 1e6];
/// Shortest line that is of any use: three coordinates.
const MIN_LENGTH: usize = 32;

/// Names that a text of the flavour may have.
const HEAT: &[&str] = &["nozzle", "bed", "fan", "fan_share"];
const SUMS: &[&str] = &["moves", "filament_mm", "seconds"];

impl Flavour {
    /// Whether the flavour can be used.
    ///
    /// # Errors
    /// [`FlavourError`] with the first field that cannot be, or that contradicts another one.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::gcode::flavour::Flavour;
    /// let mut flavour = Flavour::built_in("linuxcnc").ok_or("not built in")?;
    /// flavour.check()?;
    /// flavour.lines.max_length = 5;
    /// let error = flavour.check().unwrap_err().to_string();
    /// assert_eq!(error, "the flavour `linuxcnc`: `lines.max_length`: 5 is not from 32 to 16384");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check(&self) -> Result<(), FlavourError> {
        let numbers = self.check_numbers();
        let problem = numbers.and_then(|()| self.check_texts()).and_then(|()| self.check_words());
        problem.and_then(|()| self.check_filament()).map_err(|(field, problem)| FlavourError {
            flavour: self.name.clone(),
            field,
            problem,
        })
    }

    /// Every text is a line, of characters that controllers read, with names that it may have.
    fn check_texts(&self) -> Result<(), (String, String)> {
        let (c, both) = (&self.commands, [HEAT, SUMS].concat());
        let name: &[&str] = &["name"];
        let at_end = [name, SUMS].concat();
        let lists: [(&str, &[String], &[&str]); 19] = [
            ("begin", &self.begin, name),
            ("heat_up", &self.heat_up, HEAT),
            ("modes", &self.modes, &[]),
            ("cool_down", &self.cool_down, &both),
            ("end", &self.end, &at_end),
            ("tcp.on", &self.tcp.on, &[]),
            ("tcp.off", &self.tcp.off, &[]),
            ("commands.home", &c.home, &[]),
            ("commands.dwell", &c.dwell, &["seconds", "milliseconds"]),
            ("commands.nozzle", &c.nozzle, &["celsius"]),
            ("commands.nozzle_wait", &c.nozzle_wait, &["celsius"]),
            ("commands.bed", &c.bed, &["celsius"]),
            ("commands.bed_wait", &c.bed_wait, &["celsius"]),
            ("commands.fan", &c.fan, &["share", "byte"]),
            ("commands.tool", &c.tool, &["tool"]),
            ("commands.tape_feed", &c.tape_feed, &["mm"]),
            ("commands.press", &c.press, &["newtons"]),
            ("commands.roller", &c.roller, &["celsius"]),
            ("commands.roller_wait", &c.roller_wait, &["celsius"]),
        ];
        for (field, lines, names) in lists {
            for (row, line) in lines.iter().enumerate() {
                self.check_line(&format!("{field}[{row}]"), line, names)?;
            }
        }
        for (row, line) in c.cut.iter().enumerate() {
            self.check_line(&format!("commands.cut[{row}]"), line, &[])?;
        }
        let f = &self.feed;
        let time = f.time.as_ref().map_or("", |time| &time.on);
        for (field, line) in [("feed.per_minute", f.per_minute.as_str()), ("feed.time.on", time)] {
            self.check_line(field, line, &[])?;
        }
        if self.name.is_empty() || !self.name.bytes().all(|byte| byte.is_ascii_graphic() || byte == b' ') {
            return Err(("name".into(), "it must have ASCII characters, and not none".into()));
        }
        Ok(())
    }

    fn check_line(&self, field: &str, line: &str, names: &[&'static str]) -> Result<(), (String, String)> {
        let wrong = |problem: String| Err((field.to_owned(), problem));
        if !line.bytes().all(|byte| byte.is_ascii_graphic() || byte == b' ' || byte == b'\t') {
            return wrong("it must be one line of ASCII characters".into());
        }
        if line.len() > self.lines.max_length {
            return wrong(format!(
                "the line has {} bytes; `lines.max_length` allows {}",
                line.len(),
                self.lines.max_length
            ));
        }
        let values: Vec<_> = names.iter().map(|&name| (name, Value::Unset)).collect();
        fill(line, &values).map(|_| ()).or_else(wrong)
    }

    /// Words that stand before numbers, and those of motion.
    fn check_words(&self) -> Result<(), (String, String)> {
        let wrong = |field: &str, problem: &str| Err((field.to_owned(), problem.to_owned()));
        let open = self.comment.open.as_str();
        if open.is_empty() || !open.bytes().all(|byte| byte.is_ascii_punctuation()) {
            return wrong("comment.open", "it must be one or more ASCII signs, such as `;` or `(`");
        }
        if !self.comment.close.bytes().all(|byte| byte.is_ascii_punctuation()) {
            return wrong("comment.close", "it must be ASCII signs, such as `)`, or nothing");
        }
        let motion = [("motion.travel", &self.motion.travel), ("motion.print", &self.motion.print)];
        for (field, word) in motion {
            if !is_word(word) {
                return wrong(field, "it must be a word that begins with a letter, such as `G1` or `L`");
            }
        }
        for (field, text) in
            [("motion.travel_end", &self.motion.travel_end), ("motion.print_end", &self.motion.print_end)]
        {
            if !text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b' ') {
                return wrong(field, "it must be words of letters and digits, or nothing");
            }
        }
        if self.motion.travel_feed && !self.motion.travel_end.is_empty() {
            return wrong(
                "motion.travel_end",
                "a travel has a feed (`motion.travel_feed`), or ends with a word; not both",
            );
        }
        self.check_numbered()?;
        self.check_time()
    }

    /// Words that stand before numbers: no two of them are the same.
    fn check_numbered(&self) -> Result<(), (String, String)> {
        let wrong = |field: &str, problem: &str| Err((field.to_owned(), problem.to_owned()));
        let mut words: Vec<(String, &str)> = vec![("feed.word".into(), &self.feed.word)];
        if self.direction != Direction::Axes {
            words.extend(["X", "Y", "Z"].map(|word| ("the tip".to_owned(), word)));
        }
        for (row, axis) in self.axes.iter().enumerate() {
            words.push((format!("axes[{row}].word"), &axis.word));
            if !axis.axis.is_ascii_uppercase() {
                return wrong(&format!("axes[{row}].axis"), "it must be a letter, A to Z");
            }
            if self.axes[..row].iter().any(|other| other.axis == axis.axis) {
                return wrong(&format!("axes[{row}].axis"), "the axis is there twice");
            }
            scale(&format!("axes[{row}].scale"), axis.scale)?;
        }
        if let Direction::Vector { words: vector } = &self.direction {
            words.extend(vector.iter().enumerate().map(|(k, word)| (format!("direction.words[{k}]"), word.as_str())));
        }
        if let FilamentWords::Axis { word, .. } = &self.filament {
            words.push(("filament.word".into(), word));
        }
        for (index, (field, word)) in words.iter().enumerate() {
            if let Some(letter) = reserved_letter(word).filter(|_| field != "feed.word") {
                return wrong(
                    field,
                    &format!("controllers read {letter} as something else than an axis; take another word"),
                );
            }
            if !is_word(word) {
                return wrong(field, "it must be a word that begins with a letter, such as `F` or `A3=`");
            }
            if let Some((other, _)) = words[..index].iter().find(|(_, other)| other.eq_ignore_ascii_case(word)) {
                return wrong(field, &format!("the word `{word}` is that of `{other}`, too"));
            }
        }
        Ok(())
    }

    fn check_time(&self) -> Result<(), (String, String)> {
        let wrong = |field: &str, problem: &str| Err((field.to_owned(), problem.to_owned()));
        match &self.feed.time {
            Some(time) if !is_word(&time.word) => {
                wrong("feed.time.word", "it must be a word that begins with a letter, such as `F`")
            }
            // Else a number could be either.
            Some(time) if time.on.is_empty() && time.word == self.feed.word => {
                wrong("feed.time.word", "without a line that switches the mode it must differ from `feed.word`")
            }
            Some(time) if !time.on.is_empty() && self.feed.per_minute.is_empty() => wrong(
                "feed.per_minute",
                "a mode that is switched on (`feed.time.on`) needs a line that leads back, such as `G94`",
            ),
            None if self.feed.prefer_time => wrong("feed.prefer_time", "there is no `feed.time`"),
            _ => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), (String, String)> {
        let n = &self.numbers;
        let decimals = [
            ("position", n.position),
            ("angle", n.angle),
            ("direction", n.direction),
            ("filament", n.filament),
            ("feed", n.feed),
            ("time", n.time),
        ];
        for (field, count) in decimals {
            if count > MAX_DECIMALS {
                return Err((format!("numbers.{field}"), format!("{count} digits are not from 0 to {MAX_DECIMALS}")));
            }
        }
        if !(MIN_LENGTH..=LONGEST_LINE).contains(&self.lines.max_length) {
            let problem = format!("{} is not from {MIN_LENGTH} to {LONGEST_LINE}", self.lines.max_length);
            return Err(("lines.max_length".into(), problem));
        }
        if !(self.feed.max > 0.0 && self.feed.max <= 1e9) {
            return Err(("feed.max".into(), format!("{} is not above 0 and up to 1e9", self.feed.max)));
        }
        let Some(numbers) = &self.lines.numbers else { return Ok(()) };
        if numbers.step == 0 || numbers.step > 1000 || numbers.first > 1_000_000 {
            return Err(("lines.numbers".into(), "`first` must be up to 1000000 and `step` from 1 to 1000".into()));
        }
        if !numbers.prefix.bytes().all(|byte| byte.is_ascii_alphabetic()) {
            return Err(("lines.numbers.prefix".into(), "it must be letters, or nothing".into()));
        }
        if numbers.checksum && (self.comment.open != ";" || !self.comment.close.is_empty()) {
            return Err((
                "lines.numbers.checksum".into(),
                "RepRap's checksums go with comments that begin with `;`".into(),
            ));
        }
        Ok(())
    }

    fn check_filament(&self) -> Result<(), (String, String)> {
        let plain = |field: &str, line: &str| self.check_line(field, line, &[]);
        match &self.filament {
            FilamentWords::None => Ok(()),
            FilamentWords::Axis { close, scale: factor, mode, zero, reset_mm, .. } => {
                scale("filament.scale", *factor)?;
                plain("filament.mode", mode)?;
                plain("filament.zero", zero)?;
                if close.bytes().any(|byte| !byte.is_ascii_punctuation()) {
                    return Err(("filament.close".into(), "it must be ASCII signs, such as `)`, or nothing".into()));
                }
                match reset_mm {
                    Some(_) if zero.is_empty() => Err((
                        "filament.reset_mm".into(),
                        "there is no line that sets the position to 0 (`filament.zero`)".into(),
                    )),
                    Some(reset) if !(10.0..=1e6).contains(reset) => {
                        Err(("filament.reset_mm".into(), format!("{reset} is not from 10 to 1e6")))
                    }
                    _ => Ok(()),
                }
            }
            FilamentWords::Flow { change, at_once, scale: factor } => {
                scale("filament.scale", *factor)?;
                for (field, line) in [("filament.change", change), ("filament.at_once", at_once)] {
                    self.check_line(field, line, &["flow"])?;
                    if !line.contains("{flow}") {
                        return Err((field.into(), "the line must have `{flow}` where the number stands".into()));
                    }
                }
                if self.commands.dwell.is_empty() {
                    return Err(("commands.dwell".into(), "a flow needs it: retractions are a dwell at a flow".into()));
                }
                Ok(())
            }
            FilamentWords::Switch { on, off } => {
                plain("filament.on", on)?;
                plain("filament.off", off)?;
                match on.trim().is_empty() || off.trim().is_empty() || on == off {
                    true => Err(("filament.on".into(), "`on` and `off` must be two different lines".into())),
                    false => Ok(()),
                }
            }
        }
    }
}

fn scale(field: &str, factor: f64) -> Result<(), (String, String)> {
    // False for NaN.
    match factor.abs() >= SCALE[0] && factor.abs() <= SCALE[1] {
        true => Ok(()),
        false => Err((field.to_owned(), format!("{factor} is not from 1e-6 to 1e6, of either sign"))),
    }
}

/// Letters whose numbers are something else to controllers: feed, preparatory and miscellaneous functions, programs and jumps, line numbers,
/// parameters, speed of the spindle, tools (T. Kramer, F. Proctor, E. Messina, NISTIR 6556, 2000, table 3; `L` and `O`: as Siemens, Heidenhain and
/// LinuxCNC name subprograms and lines).
const RESERVED: &str = "FGLMNOPST";

/// The letter of a word that controllers take for something else than an axis: `G`, `M3`, `S1=`; not of names such as `FEED=`.
pub(super) fn reserved_letter(word: &str) -> Option<char> {
    let letters = word.bytes().take_while(u8::is_ascii_alphabetic).count();
    let letter = word.chars().next()?.to_ascii_uppercase();
    (letters == 1 && RESERVED.contains(letter)).then_some(letter)
}

/// A word before a number: a letter, then letters and digits, at last perhaps `=` or `=IC(`.
fn is_word(word: &str) -> bool {
    let name = word.split_once('=').map_or(word, |(name, _)| name);
    word.len() <= 16
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric())
        && word.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'=' || byte == b'(')
}
