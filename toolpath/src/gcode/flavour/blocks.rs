//! Lines of a program, taken apart by the data of its flavour.

use super::commands::{OutOfRange, command};
use super::data::{Direction, FilamentWords, Flavour};
use super::fill::{number_in, value_in};
use super::program::TIME;
use super::words::NUMBER;
use crate::gcode::direction::COMMENT;
use crate::gcode::lines::Lines;
use crate::gcode::numbers::{checksum, counted_from};
use crate::gcode::{FILAMENT, Move, ReadError, within};
use std::io::BufRead;

const FEED: [f64; 2] = [1e-9, 1e9];

/// How a program is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlavourReadOptions {
    /// Pass over lines that the flavour does not have, instead of refusing them. Those with a `G` are never passed over, for they could move. Default false.
    pub skip_others: bool,
}

/// What a line does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Line {
    /// Axes move, or the extruder alone.
    Motion { is_travel: bool, start: usize },
    /// Something while all stands still.
    Still(Move, usize),
}

/// The feed of a motion, in the units of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pace {
    /// Per minute.
    PerMinute(f64),
    /// Seconds.
    Time(f64),
    /// The program does not say.
    Unknown,
}

/// A program that is read line by line.
#[derive(Debug)]
pub(super) struct Blocks<R> {
    pub lines: Lines<R>,
    pub flavour: Flavour,
    options: FlavourReadOptions,
    /// Words of positions and directions, then those of filament, feed and time, where the flavour has them.
    words: Vec<String>,
    /// How many of them are positions and directions.
    pub places: usize,
    /// The numbers of this line, and where their words begin.
    values: Vec<Option<(f64, usize)>>,
    /// The direction in the comment of this line.
    pub comment: Option<[f64; 3]>,
    feed: Option<f64>,
    time_mode: bool,
    /// Position of the filament, in units of the file.
    position: f64,
    /// The signal of a flow, in mm/s of filament.
    pub flow: f64,
    /// The switch.
    pub on: bool,
    /// Number of the last line that had one.
    number: Option<f64>,
}

impl<R: BufRead> Blocks<R> {
    pub fn new(reader: R, flavour: &Flavour, options: FlavourReadOptions, places: Vec<String>) -> Self {
        let count = places.len();
        let mut words = places;
        words.push(match &flavour.filament {
            FilamentWords::Axis { word, .. } => word.clone(),
            _ => String::new(),
        });
        words.push(flavour.feed.word.clone());
        words.push(match &flavour.feed.time {
            Some(time) if time.word != flavour.feed.word => time.word.clone(),
            _ => String::new(),
        });
        Blocks {
            lines: Lines::new(reader),
            flavour: flavour.clone(),
            options,
            values: vec![None; words.len()],
            words,
            places: count,
            comment: None,
            feed: None,
            time_mode: false,
            position: 0.0,
            flow: 0.0,
            on: false,
            number: None,
        }
    }

    /// The next line that does anything but set a mode.
    pub fn next_line(&mut self) -> Result<Option<Line>, ReadError> {
        while self.lines.next_line()? {
            if let Some(line) = self.line()? {
                return Ok(Some(line));
            }
        }
        Ok(None)
    }

    fn line(&mut self) -> Result<Option<Line>, ReadError> {
        self.check_sum()?;
        self.number_of_line()?;
        self.skip_comments()?;
        let (start, text) = (self.lines.at(), self.plain());
        if text.is_empty() || text.starts_with('%') {
            return Ok(None);
        }
        if let Some(motion) = self.motion(&text) {
            self.lines.skip(motion);
            let ended = self.motion_words()?;
            let both = self.flavour.motion.travel.eq_ignore_ascii_case(&self.flavour.motion.print);
            let is_travel = if both {
                ended
            } else {
                text.len() >= motion && is_word(&text[..motion], &self.flavour.motion.travel)
            };
            return Ok(Some(Line::Motion { is_travel, start }));
        }
        if self.mode(&text) {
            return Ok(None);
        }
        if let Some(item) = self.still(&text, start)? {
            return Ok(Some(Line::Still(item, start)));
        }
        if self.is_own(&text) || (self.options.skip_others && !text.starts_with(['G', 'g'])) {
            return Ok(None);
        }
        let (line, column) = (self.lines.row(), start as u64 + 1);
        Err(ReadError::Command { line, column, command: self.lines.quote(start), why: "no line of this flavour" })
    }

    /// A line with a checksum has the one of its bytes.
    fn check_sum(&mut self) -> Result<(), ReadError> {
        let rest = self.lines.rest();
        let words = rest.iter().position(|&byte| byte == b';').unwrap_or(rest.len());
        let has = self.flavour.lines.numbers.as_ref().is_some_and(|numbers| numbers.checksum);
        let Some(star) = rest[..words].iter().position(|&byte| byte == b'*').filter(|_| has) else { return Ok(()) };
        let expected = checksum(&rest[..star]);
        let given =
            std::str::from_utf8(rest[star + 1..words].trim_ascii()).ok().and_then(|text| text.parse::<u8>().ok());
        match given {
            Some(given) if given == expected => Ok(()),
            Some(given) => {
                Err(ReadError::Checksum { line: self.lines.row(), column: star as u64 + 1, given, expected })
            }
            None => Err(self.lines.unexpected(star + 1, "a checksum, 0 to 255")),
        }
    }

    /// Passes over the number that a line begins with.
    fn number_of_line(&mut self) -> Result<(), ReadError> {
        self.lines.skip_spaces();
        let prefix = self.flavour.lines.numbers.as_ref().map_or("N", |numbers| &numbers.prefix).to_owned();
        let rest = self.lines.rest();
        let is_prefix = rest.len() >= prefix.len() && rest[..prefix.len()].eq_ignore_ascii_case(prefix.as_bytes());
        let mut given = None;
        if is_prefix && rest.get(prefix.len()).is_some_and(u8::is_ascii_digit) {
            self.lines.skip(prefix.len());
            given = Some(self.lines.number()?);
            self.lines.skip_spaces();
        }
        self.follow_number(given)
    }

    /// Where the flavour numbers lines, numbers ascend. With checksums each is one step above the one before, and `M110` sets the number that lines
    /// count from: the one behind it, else that of its line.
    fn follow_number(&mut self, given: Option<f64>) -> Result<(), ReadError> {
        let Some(numbers) = &self.flavour.lines.numbers else { return Ok(()) };
        if let Some(from) = counted_from(self.lines.rest(), &numbers.prefix).filter(|_| numbers.checksum) {
            self.number = from.or(given).or(self.number);
            return Ok(());
        }
        let Some(given) = given else { return Ok(()) };
        let line = self.lines.row();
        match self.number.replace(given) {
            Some(before) if numbers.checksum && (given - before - numbers.step as f64).abs() > 0.0 => {
                Err(ReadError::LineNumber { line, given, expected: before + numbers.step as f64 })
            }
            Some(before) if given <= before => Err(ReadError::Descending { line, given, before }),
            _ => Ok(()),
        }
    }

    /// Passes over spaces, and comments before the end of the line; at a checksum or a comment up to the end, the line is over.
    fn skip_comments(&mut self) -> Result<(), ReadError> {
        loop {
            self.lines.skip_spaces();
            let (comment, rest) = (&self.flavour.comment, self.lines.rest());
            if !rest.starts_with(comment.open.as_bytes()) || comment.close.is_empty() {
                return Ok(());
            }
            match find(rest, comment.close.as_bytes()) {
                Some(at) => {
                    let whole = at + comment.close.len();
                    self.lines.skip(whole);
                }
                None => return Err(self.lines.unexpected(self.lines.at(), "a comment that ends in its line")),
            }
        }
    }

    /// What is left of the line without comments and checksum.
    fn plain(&self) -> String {
        let comment = &self.flavour.comment;
        let has_sum = self.flavour.lines.numbers.as_ref().is_some_and(|numbers| numbers.checksum);
        let mut text = String::from_utf8_lossy(self.lines.rest()).into_owned();
        while let Some(at) = text.find(&comment.open) {
            match text[at..].find(&comment.close).filter(|_| !comment.close.is_empty()) {
                Some(close) => text.replace_range(at..at + close + comment.close.len(), ""),
                None => text.truncate(at),
            }
        }
        if let Some(star) = text.find('*').filter(|_| has_sum) {
            text.truncate(star);
        }
        text.trim_end().to_owned()
    }

    /// Length of the word of motion that a line begins with, if it is one.
    fn motion(&self, text: &str) -> Option<usize> {
        let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
        // `G1X5` has the word `G1`, `LX5` has not.
        let digits = text.bytes().skip(letters).take_while(u8::is_ascii_digit).count();
        let word = &text[..letters + digits];
        let motion = &self.flavour.motion;
        (is_word(word, &motion.travel) || is_word(word, &motion.print)).then_some(word.len())
    }

    /// The words of a motion. Says whether the line ends as a travel does.
    fn motion_words(&mut self) -> Result<bool, ReadError> {
        self.values.fill(None);
        self.comment = None;
        let motion = self.flavour.motion.clone();
        let mut ended = false;
        loop {
            self.skip_comments()?;
            let (at, rest) = (self.lines.at(), self.lines.rest());
            let open = self.flavour.comment.open.as_bytes();
            if rest.is_empty() || rest.starts_with(b"*") || rest.starts_with(open) {
                break;
            }
            let is_end = |text: &str| !text.is_empty() && rest.trim_ascii_end().eq_ignore_ascii_case(text.as_bytes());
            if is_end(&motion.travel_end) || is_end(&motion.print_end) {
                ended = is_end(&motion.travel_end);
                break;
            }
            self.word(at)?;
        }
        if self.flavour.direction == Direction::Comment {
            self.direction_comment()?;
        }
        Ok(ended)
    }

    /// A word and its number.
    fn word(&mut self, at: usize) -> Result<(), ReadError> {
        let rest = self.lines.rest();
        let fits = |word: &&String| {
            let after = rest.get(word.len()).copied().unwrap_or(b' ');
            !word.is_empty()
                && rest.len() >= word.len()
                && rest[..word.len()].eq_ignore_ascii_case(word.as_bytes())
                && (after.is_ascii_digit() || b"+-. ".contains(&after))
        };
        // Of `C` and `C1=` the longer one.
        let fitting = self.words.iter().enumerate().filter(|(_, word)| fits(word));
        let Some((slot, _)) = fitting.max_by_key(|(_, word)| word.len()) else {
            return Err(self.lines.unexpected(at, "a word of this flavour"));
        };
        self.lines.skip(self.words[slot].len());
        self.lines.skip_spaces();
        let value = self.lines.number()?;
        if !within(value, NUMBER) {
            let [least, most] = NUMBER;
            return Err(self.out_of_range(slot, at, value, [least, most]));
        }
        if let (true, FilamentWords::Axis { close, .. }) = (slot == self.places, &self.flavour.filament) {
            self.lines.skip_spaces();
            if !self.lines.rest().starts_with(close.as_bytes()) {
                return Err(self.lines.unexpected(self.lines.at(), "the end of a word"));
            }
            self.lines.skip(close.len());
        }
        if self.values[slot].is_some() {
            let (line, column, word) = (self.lines.row(), at as u64 + 1, self.words[slot].clone());
            return Err(ReadError::Repeated { line, column, word });
        }
        self.values[slot] = Some((value, at));
        Ok(())
    }

    /// The direction in the comment at the end of the line, if it has one.
    fn direction_comment(&mut self) -> Result<(), ReadError> {
        let open = self.flavour.comment.open.clone();
        let tag = format!("{open}{}", &COMMENT[1..]);
        // A checksum may stand before it.
        let Some(at) = find(self.lines.rest(), tag.as_bytes()) else { return Ok(()) };
        self.lines.skip(at + tag.len());
        let mut direction = [0.0; 3];
        for number in &mut direction {
            self.lines.skip_spaces();
            *number = self.lines.number()?;
        }
        self.comment = Some(direction);
        Ok(())
    }

    /// Obeys a line that sets a mode or a signal; false for other lines.
    fn mode(&mut self, text: &str) -> bool {
        let is = |line: &str| !line.is_empty() && text.eq_ignore_ascii_case(line.trim());
        let time = self.flavour.feed.time.as_ref();
        if time.is_some_and(|time| is(&time.on)) || is(&self.flavour.feed.per_minute) {
            let on = time.is_some_and(|time| is(&time.on));
            // A feed per minute does not outlive a mode of times.
            self.feed = self.feed.filter(|_| self.time_mode == on);
            self.time_mode = on;
            return true;
        }
        match &self.flavour.filament {
            FilamentWords::Axis { zero, .. } if is(zero) => self.position = 0.0,
            FilamentWords::Axis { mode, .. } if is(mode) => {}
            FilamentWords::Flow { change, at_once, scale } => {
                let flow = number_in(text, change).or_else(|| number_in(text, at_once));
                let Some(flow) = flow.filter(|&flow| within(flow, NUMBER)) else { return false };
                self.flow = flow / scale;
            }
            FilamentWords::Switch { on, .. } if is(on) => self.on = true,
            FilamentWords::Switch { off, .. } if is(off) => self.on = false,
            _ => return false,
        }
        true
    }

    /// The command of a line, if it is one.
    fn still(&self, text: &str, start: usize) -> Result<Option<Move>, ReadError> {
        let item = command(&self.flavour.commands, text).transpose();
        item.map_err(|OutOfRange { name, value, range: [least, most] }| {
            let (line, column) = (self.lines.row(), start as u64 + 1);
            ReadError::Number { line, column, word: name.to_owned(), value, least, most }
        })
    }

    /// Whether a line is one of the flavour's own texts.
    fn is_own(&self, text: &str) -> bool {
        let (f, c) = (&self.flavour, &self.flavour.commands);
        let lists = [&f.begin, &f.heat_up, &f.modes, &f.tcp.on, &f.tcp.off, &f.cool_down, &f.end];
        let commands = [&c.home, &c.dwell, &c.nozzle_wait, &c.bed_wait, &c.tool, &c.press, &c.roller_wait, &c.cut];
        let without_comment = |line: &str| line.split(&f.comment.open).next().unwrap_or("").trim_end().to_owned();
        let numbers = f.lines.numbers.as_ref().filter(|numbers| numbers.checksum);
        numbers.is_some_and(|numbers| counted_from(text.as_bytes(), &numbers.prefix).is_some())
            || lists.into_iter().chain(commands).flatten().any(|line| value_in(text, &without_comment(line)).is_some())
    }

    /// The number of a word of this line.
    pub fn value(&self, slot: usize) -> Option<f64> {
        self.values[slot].map(|(value, _)| value)
    }

    pub fn missing(&self, start: usize, word: &str) -> ReadError {
        ReadError::Missing { line: self.lines.row(), column: start as u64 + 1, word: word.to_owned() }
    }

    /// The word of a slot.
    pub fn name(&self, slot: usize) -> &str {
        &self.words[slot]
    }

    /// A number of this line that is out of its range.
    pub fn beyond(&self, slot: usize, value: f64, range: [f64; 2]) -> ReadError {
        self.out_of_range(slot, self.values[slot].map_or(0, |(_, at)| at), value, range)
    }

    fn out_of_range(&self, slot: usize, at: usize, value: f64, [least, most]: [f64; 2]) -> ReadError {
        let (line, column, word) = (self.lines.row(), at as u64 + 1, self.words[slot].clone());
        ReadError::Number { line, column, word, value, least, most }
    }

    /// Filament of this line, in mm; `None` without a word for it.
    pub fn filament(&mut self) -> Result<Option<f64>, ReadError> {
        let Some((value, at)) = self.values[self.places] else { return Ok(None) };
        let FilamentWords::Axis { scale, relative, .. } = &self.flavour.filament else { return Ok(None) };
        let (scale, relative) = (*scale, *relative);
        let by = if relative { value } else { value - std::mem::replace(&mut self.position, value) } / scale;
        let size = by.abs();
        match within(size, FILAMENT) {
            true => Ok(Some(by)),
            false => Err(self.out_of_range(self.places, at, by, [-FILAMENT[1], FILAMENT[1]])),
        }
    }

    /// Where the word of the filament begins.
    pub fn filament_start(&self) -> usize {
        self.values[self.places].map_or(0, |(_, at)| at)
    }

    /// The pace of this line. A travel without a feed of its own is as fast as the controller can, if the flavour's travels are.
    pub fn pace(&mut self, is_travel: bool, start: usize) -> Result<Pace, ReadError> {
        let (feed, own_time) = (self.values[self.places + 1], self.values[self.places + 2]);
        let time = self.flavour.feed.time.as_ref();
        for (slot, word) in [(self.places + 1, feed), (self.places + 2, own_time)] {
            if let Some((value, at)) = word.filter(|(value, _)| !within(*value, FEED)) {
                return Err(self.out_of_range(slot, at, value, FEED));
            }
        }
        let seconds = |value: f64| if time.is_some_and(|time| time.seconds) { value } else { 60.0 / value };
        let timed = if self.time_mode { own_time.or(feed) } else { own_time };
        if let Some((value, _)) = timed {
            return Ok(Pace::Time(seconds(value).clamp(TIME[0] * 0.5, TIME[1] * 2.0)));
        }
        if is_travel && !self.flavour.motion.travel_feed {
            return Ok(Pace::Unknown);
        }
        if self.time_mode {
            return Err(self.missing(start, &self.words[self.places + 1]));
        }
        self.feed = feed.map(|(value, _)| value).or(self.feed);
        self.feed.map(Pace::PerMinute).ok_or_else(|| self.missing(start, &self.words[self.places + 1]))
    }
}

/// Whether two words of motion are the same: `G01` is `G1`.
fn is_word(word: &str, motion: &str) -> bool {
    let plain = |word: &str| {
        let letters = word.bytes().take_while(u8::is_ascii_alphabetic).count();
        let digits = word[letters..].trim_start_matches('0');
        let digits = if digits.is_empty() && word.len() > letters { "0" } else { digits };
        format!("{}{digits}", word[..letters].to_ascii_uppercase())
    };
    plain(word) == plain(motion)
}

/// Where a text begins in another one.
fn find(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len()).position(|window| window == part)
}
