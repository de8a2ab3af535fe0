//! A program on its way out: what moves of the part and moves of axes have in common.

use super::data::{Flavour, TimeFeed};
use super::error::FlavourError;
use super::extruder::{Beyond, Extruder};
use super::feed::Part;
use super::fill::{Value, Values, fill};
use super::options::{FlavourWritten, ProgramOptions};
use super::output::Output;
use super::words::{NUMBER, push_plain};
use crate::gcode::fiber::{self, FIBER_DECIMALS, FiberCommand, Head};
use crate::gcode::tags::{Mark, Tagged, Tags};
use crate::gcode::text::{Text, steps};
use crate::gcode::write::{WriteOptions, check_options, number};
use crate::gcode::{CELSIUS, COORDINATE, DWELL, FEED, FILAMENT, FULL_FAN, Move, SHARE, WriteError, within};
use std::io::Write;

/// Shortest and longest time of a line, seconds.
pub(super) const TIME: [f64; 2] = [1e-4, 1e5];

/// The speed that a line says.
#[derive(Clone, Copy, Debug)]
pub(super) enum Speed {
    /// None: as fast as the controller can.
    Rapid,
    /// A feed per minute, in steps of its last digit.
    PerMinute(i64),
    /// The time that it takes, seconds.
    Time(f64),
}

/// The words of a line but for motion and feed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a> {
    pub is_travel: bool,
    pub words: &'a [u8],
    /// Behind the words; belongs to them.
    pub comment: &'a str,
    pub speed: Speed,
}

pub(super) struct Program<'a, W> {
    pub flavour: &'a Flavour,
    pub options: &'a ProgramOptions<'a>,
    pub output: Output<'a, W>,
    pub extruder: Extruder,
    pub result: FlavourWritten,
    /// A feed that says the time is on.
    time_mode: bool,
    /// The feed per minute that holds, in steps.
    feed: Option<i64>,
    head: Head,
    tagged: Tagged,
}

impl<'a, W: Write> Program<'a, W> {
    /// Checks flavour and options; nothing is written yet.
    pub fn new(flavour: &'a Flavour, options: &'a ProgramOptions<'a>, out: W) -> Result<Self, WriteError> {
        flavour.check()?;
        let ProgramOptions { name, nozzle_celsius, bed_celsius, fan, retraction, end, .. } = *options;
        check_options(&WriteOptions { nozzle_celsius, bed_celsius, fan, retraction, end, ..WriteOptions::default() })?;
        if !within(options.first_feed_mm_s, FEED) {
            let (value, need) = (options.first_feed_mm_s, "it must be from 0.001 to 1e5 mm/s");
            return Err(WriteError::Option { what: "first_feed_mm_s", value, need });
        }
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
        if name.is_empty() || name.len() > 32 || !name.bytes().all(plain) {
            let problem = "a program's name has 1 to 32 letters, digits, `-` and `_`".into();
            return Err(WriteError::Template { template: "name", line: 1, problem });
        }
        let output = Output::new(out, &flavour.lines, &flavour.comment);
        Ok(Program {
            flavour,
            options,
            output,
            extruder: Extruder::default(),
            result: FlavourWritten::default(),
            time_mode: false,
            feed: None,
            head: Head::default(),
            tagged: Tagged::default(),
        })
    }

    /// All lines before the first move.
    pub fn begin(&mut self, title: &str) -> Result<(), WriteError> {
        let flavour = self.flavour;
        // Before any other line: firmware counts from the number behind `M110`.
        if let Some(numbers) = flavour.lines.numbers.as_ref().filter(|numbers| numbers.checksum) {
            self.output.line(&format!("M110 {}{}", numbers.prefix, numbers.first))?;
        }
        self.texts("begin", &flavour.begin)?;
        self.output.comment(title)?;
        if self.has_tags() {
            for line in self.options.tags.title().into_iter().flat_map(str::lines) {
                self.output.raw_comment(line)?;
            }
        }
        match self.options.start {
            Some(text) => self.own_texts("start", text)?,
            None => {
                self.texts("heat_up", &flavour.heat_up)?;
                self.without_heat()?;
            }
        }
        self.texts("modes", &flavour.modes)?;
        self.mode_line(&flavour.feed.per_minute)?;
        if let super::data::FilamentWords::Axis { mode, zero, .. } = &flavour.filament {
            self.mode_line(mode)?;
            self.mode_line(zero)?;
        }
        self.texts("tcp.on", &flavour.tcp.on)
    }

    /// A comment for each thing that should be set before the print and has no line.
    fn without_heat(&mut self) -> Result<(), WriteError> {
        let ProgramOptions { nozzle_celsius, bed_celsius, fan, .. } = *self.options;
        let wanted = [("nozzle", nozzle_celsius, " C"), ("bed", bed_celsius, " C"), ("fan", fan, " of 1")];
        for (name, value, unit) in wanted {
            let has = self.flavour.heat_up.iter().any(|line| line.contains(&format!("{{{name}")));
            if let (Some(value), false) = (value, has) {
                self.result.without_words += 1;
                self.output.comment(&format!("{name} {value}{unit}: no words in this flavour"))?;
            }
        }
        Ok(())
    }

    /// All lines behind the last move.
    pub fn finish(mut self) -> Result<FlavourWritten, WriteError> {
        if self.result.written.moves == 0 {
            return Err(WriteError::Empty);
        }
        let flavour = self.flavour;
        self.stop()?;
        self.set_time_mode(false)?;
        self.texts("tcp.off", &flavour.tcp.off)?;
        match self.options.finish {
            Some(text) => self.own_texts("finish", text)?,
            None => self.texts("cool_down", &flavour.cool_down)?,
        }
        self.texts("end", &flavour.end)?;
        self.output.finish()?;
        (self.result.written.lines, self.result.written.bytes) = (self.output.lines, self.output.bytes);
        Ok(self.result)
    }

    /// Lines of the flavour with names in braces.
    fn texts(&mut self, template: &'static str, lines: &[String]) -> Result<(), WriteError> {
        let values = self.values(template);
        lines.iter().enumerate().try_for_each(|(row, line)| self.filled(template, row, line, &values))
    }

    /// Lines of the caller's.
    fn own_texts(&mut self, template: &'static str, text: &str) -> Result<(), WriteError> {
        let values = self.values(template);
        text.lines().enumerate().try_for_each(|(row, line)| self.filled(template, row, line, &values))
    }

    fn filled(
        &mut self,
        template: &'static str,
        row: usize,
        line: &str,
        values: &Values<'_>,
    ) -> Result<(), WriteError> {
        let wrong = |problem| WriteError::Template { template, line: row + 1, problem };
        match fill(line, values).map_err(wrong)? {
            Some(line) => self.output.line(&line),
            None => Ok(()),
        }
    }

    fn values(&self, template: &str) -> Vec<(&'static str, Value)> {
        let set = |value: Option<f64>, decimals| value.map_or(Value::Unset, |value| Value::Number(value, decimals));
        let ProgramOptions { name, nozzle_celsius, bed_celsius, fan, .. } = *self.options;
        let sums = self.result.written;
        let mut values = vec![
            ("name", Value::Text(name.to_owned())),
            ("nozzle", set(nozzle_celsius, 1)),
            ("bed", set(bed_celsius, 1)),
            ("fan", set(fan.map(|share| share * FULL_FAN), 0)),
            ("fan_share", set(fan, 3)),
        ];
        if matches!(template, "cool_down" | "finish" | "end") {
            values.push(("moves", Value::Number(sums.moves as f64, 0)));
            values.push(("filament_mm", Value::Number(sums.filament_mm, 1)));
            values.push(("seconds", Value::Number(sums.seconds, 0)));
        }
        values
    }

    /// A line of a mode, where the flavour has one.
    fn mode_line(&mut self, line: &str) -> Result<(), WriteError> {
        if line.is_empty() { Ok(()) } else { self.output.line(line) }
    }

    fn has_tags(&self) -> bool {
        self.flavour.comment.open == ";" && self.flavour.comment.close.is_empty()
    }

    /// Follows what the tool may do now.
    pub fn follow(&mut self, index: u64, item: &Move) -> Result<(), WriteError> {
        self.head.follow(item).map_err(|problem| WriteError::Fiber { index, problem })
    }

    /// The line of a move, with what changes the extruder before it.
    pub fn go(&mut self, block: Block<'_>) -> Result<(), WriteError> {
        let motion = &self.flavour.motion;
        let mut text = Text::default();
        text.word(if block.is_travel { &motion.travel } else { &motion.print });
        text.0.extend_from_slice(block.words);
        self.speed(block.speed, &mut text)?;
        let end = if block.is_travel { &motion.travel_end } else { &motion.print_end };
        if !end.is_empty() {
            text.word(" ").word(end);
        }
        self.output.whole(&String::from_utf8_lossy(&text.0), block.comment)
    }

    /// The feed word, and the mode that it needs.
    fn speed(&mut self, speed: Speed, text: &mut Text) -> Result<(), WriteError> {
        let flavour = self.flavour;
        match (speed, &flavour.feed.time) {
            (Speed::Rapid, _) => {}
            (Speed::Time(seconds), Some(TimeFeed { word, seconds: is_seconds, .. })) => {
                self.set_time_mode(true)?;
                let number = if *is_seconds { seconds } else { 60.0 / seconds };
                push_plain(text, word, steps(number, flavour.numbers.time).max(1), flavour.numbers.time, flavour);
            }
            // Nothing asks for a time where the flavour cannot say it.
            (Speed::Time(_), None) => unreachable!("a time without a word for it"),
            (Speed::PerMinute(feed), _) => {
                self.set_time_mode(false)?;
                if self.feed != Some(feed) {
                    self.feed = Some(feed);
                    push_plain(text, &flavour.feed.word, feed, flavour.numbers.feed, flavour);
                }
            }
        }
        Ok(())
    }

    fn set_time_mode(&mut self, on: bool) -> Result<(), WriteError> {
        let flavour = self.flavour;
        let Some(time) = flavour.feed.time.as_ref().filter(|time| !time.on.is_empty()) else { return Ok(()) };
        if self.time_mode != on {
            self.time_mode = on;
            self.feed = None;
            self.mode_line(if on { &time.on } else { &flavour.feed.per_minute })?;
        }
        Ok(())
    }

    /// What changes the flow or the switch before a move.
    pub fn change(&mut self, filament_mm: f64, seconds: f64) -> Result<(), WriteError> {
        match self.extruder.change(self.flavour, filament_mm, seconds).map_err(self.beyond())? {
            Some(line) => self.output.line(&line),
            None => Ok(()),
        }
    }

    /// Nothing leaves the extruder any more.
    fn stop(&mut self) -> Result<(), WriteError> {
        self.at_once(0.0)
    }

    fn at_once(&mut self, mm_s: f64) -> Result<(), WriteError> {
        match self.extruder.at_once(self.flavour, mm_s).map_err(self.beyond())? {
            Some(line) => self.output.line(&line),
            None => Ok(()),
        }
    }

    pub fn zero(&mut self) -> Result<(), WriteError> {
        match self.extruder.zero(self.flavour) {
            Some(line) => self.output.line(line),
            None => Ok(()),
        }
    }

    /// The word of the extruder, if it is an axis.
    pub fn extruded(&mut self, by_mm: f64, words: &mut Text) -> Result<Option<Part>, WriteError> {
        self.extruder.word(self.flavour, by_mm, words).map_err(self.beyond())
    }

    /// The error of an extruder that this move takes too far.
    fn beyond(&self) -> impl Fn(Beyond) -> WriteError + use<W> {
        let index = self.result.written.moves.saturating_sub(1);
        move |Beyond(value)| WriteError::Extruder { index, value, most: NUMBER[1] }
    }

    /// Filament that is moved while all axes stand still.
    pub fn stroke(&mut self, by_mm: f64, feed_mm_s: f64) -> Result<(), WriteError> {
        let flavour = self.flavour;
        let seconds = (by_mm.abs() / feed_mm_s).clamp(TIME[0], TIME[1]);
        self.zero()?;
        let mut words = Text::default();
        if let Some(part) = self.extruded(by_mm, &mut words)? {
            let length = super::feed::length(flavour.feed.of, std::iter::once(part));
            let speed = self.speed_of(length, by_mm.abs() / feed_mm_s);
            self.go(Block { is_travel: false, words: &words.0, comment: "", speed })?;
        } else if matches!(flavour.filament, super::data::FilamentWords::Flow { .. }) {
            self.at_once(by_mm.signum() * by_mm.abs() / seconds)?;
            if self.extruder.runs() {
                self.dwell(seconds)?;
                self.stop()?;
            }
        } else {
            self.stop()?;
            self.result.without_words += 1;
        }
        self.result.written.seconds += by_mm.abs() / feed_mm_s;
        Ok(())
    }

    /// How a line says that it takes so long over such a length.
    pub fn speed_of(&mut self, length: f64, seconds: f64) -> Speed {
        let (feed, seconds) = (&self.flavour.feed, seconds.clamp(TIME[0], TIME[1]));
        let (per_minute, says) = super::feed::per_minute(length, seconds, feed.max, self.flavour.numbers.feed);
        if feed.time.is_some() && (feed.prefer_time || !says) {
            return Speed::Time(seconds);
        }
        self.result.capped += u64::from(60.0 * length / seconds > feed.max);
        self.result.untimed += u64::from(!says);
        // Where the feed says nothing, the one that holds stays, as any other would do.
        match self.feed {
            Some(held) if length <= 0.0 => Speed::PerMinute(held),
            _ => Speed::PerMinute(per_minute),
        }
    }

    fn dwell(&mut self, seconds: f64) -> Result<(), WriteError> {
        let values = [("seconds", Value::Number(seconds, 6)), ("milliseconds", Value::Number(seconds * 1e3, 0))];
        self.command("dwell", &self.flavour.commands.dwell, &values)
    }

    /// Whatever is done while all axes stand still.
    pub fn still(&mut self, index: u64, item: &Move) -> Result<(), WriteError> {
        let check = |what, value, range| number(index, what, value, range);
        let commands = &self.flavour.commands;
        match *item {
            Move::Travel { .. } | Move::Print { .. } | Move::Lay { .. } => {
                let problem = "a move of the part among moves of axes: turn it into axes first";
                Err(WriteError::Kind { index, problem })
            }
            Move::Retract { filament_mm, feed_mm_s } | Move::Prime { filament_mm, feed_mm_s } => {
                check("filament_mm", filament_mm, FILAMENT)?;
                check("feed_mm_s", feed_mm_s, FEED)?;
                let is_back = matches!(item, Move::Retract { .. });
                self.stroke(if is_back { -filament_mm } else { filament_mm }, feed_mm_s)
            }
            Move::Home => self.waiting("home", &commands.home, &[]),
            Move::Dwell { seconds } => {
                check("seconds", seconds, DWELL)?;
                self.stop()?;
                self.result.written.seconds += seconds;
                self.dwell(seconds)
            }
            Move::Nozzle { celsius, wait } | Move::Bed { celsius, wait } => {
                check("celsius", celsius, CELSIUS)?;
                let (name, lines) = match (matches!(item, Move::Nozzle { .. }), wait) {
                    (true, false) => ("nozzle temperature", &commands.nozzle),
                    (true, true) => ("wait for nozzle temperature", &commands.nozzle_wait),
                    (false, false) => ("plate temperature", &commands.bed),
                    (false, true) => ("wait for plate temperature", &commands.bed_wait),
                };
                let values = [("celsius", Value::Number(celsius, 1))];
                if wait { self.waiting(name, lines, &values) } else { self.command(name, lines, &values) }
            }
            Move::Fan { share } => {
                check("share", share, SHARE)?;
                let values = [("share", Value::Number(share, 4)), ("byte", Value::Number(share * FULL_FAN, 0))];
                self.command("fan", &commands.fan, &values)
            }
            Move::Fiber(command) => self.fiber(index, command),
            Move::Mark(mark) => self.mark(index, &mark),
        }
    }

    /// A command during which nothing may leave the extruder.
    fn waiting(&mut self, name: &str, lines: &[String], values: &Values<'_>) -> Result<(), WriteError> {
        self.stop()?;
        self.command(name, lines, values)
    }

    fn command(&mut self, name: &str, lines: &[String], values: &Values<'_>) -> Result<(), WriteError> {
        if lines.is_empty() {
            self.result.without_words += 1;
            let number = values.iter().find_map(|(_, value)| match *value {
                Value::Number(value, _) => Some(format!(" {value}")),
                _ => None,
            });
            return self.output.comment(&format!("{name}{}: no words in this flavour", number.unwrap_or_default()));
        }
        // The check of the flavour has seen to the names.
        lines.iter().enumerate().try_for_each(|(row, line)| self.filled("command", row, line, values))
    }

    fn fiber(&mut self, index: u64, command: FiberCommand) -> Result<(), WriteError> {
        let (code, value) = command.words();
        let value = value.unwrap_or_default();
        let (what, range) = fiber::range(code);
        number(index, what, value, range)?;
        let commands = &self.flavour.commands;
        let (field, lines, name) = match code {
            fiber::TOOL => ("tool", &commands.tool, "tool"),
            fiber::FEED_TAPE => ("tape_feed", &commands.tape_feed, "mm"),
            fiber::PRESS => ("press", &commands.press, "newtons"),
            fiber::HEAT => ("roller", &commands.roller, "celsius"),
            fiber::HEAT_WAIT => ("roller_wait", &commands.roller_wait, "celsius"),
            _ => ("cut", &commands.cut, ""),
        };
        if lines.is_empty() {
            let problem = format!("move {index} needs it, and it has no line");
            let field = format!("commands.{field}");
            return Err(FlavourError { flavour: self.flavour.name.clone(), field, problem }.into());
        }
        self.result.written.cuts += u64::from(command == FiberCommand::Cut);
        self.waiting(field, lines, &[(name, Value::Number(value, FIBER_DECIMALS))])
    }

    fn mark(&mut self, index: u64, mark: &Mark) -> Result<(), WriteError> {
        let (Mark::Layer { z_mm: size, height_mm, .. } | Mark::Bead { width_mm: size, height_mm, .. }) = *mark;
        number(index, "size of a mark", size, COORDINATE)?;
        number(index, "height_mm of a mark", height_mm, FILAMENT)?;
        if self.options.tags == Tags::None {
            return Ok(());
        }
        if !self.has_tags() {
            let Mark::Layer { number, .. } = mark else { return Ok(()) };
            return self.output.comment(&format!("layer {}", number + 1));
        }
        let mut text = Text::default();
        self.tagged.write(self.options.tags, mark, &mut text);
        let text = String::from_utf8_lossy(&text.0);
        text.lines().try_for_each(|line| self.output.raw_comment(line))
    }
}
