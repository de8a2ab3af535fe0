//! Rules of RAPID, checked on text: a judge of what the writer writes that shares no code with it.
//!
//! *RAPID Kernel* (modules, declarations before routines, identifiers of 32 characters, one table of names whatever their
//! case) and *RAPID Instructions* (arguments and their types, in what order units, loads and modules are used).

use std::collections::{BTreeMap, BTreeSet};

const RESERVED: &str = "ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE \
    ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOSTEPIN NOT \
    NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY \
    WHILE WITH XOR";

/// What is installed, with its type; `!` are instructions.
const INSTALLED: &str = "tool0:tooldata wobj0:wobjdata load0:loaddata fine:zonedata robtarget:type jointtarget:type num:type \
    tooldata:type wobjdata:type loaddata:type speeddata:type zonedata:type MoveL:! MoveJ:! MoveAbsJ:! SetDO:! SetAO:! SetGO:! \
    ActUnit:! GripLoad:! ConfJ:! ConfL:! Load:! UnLoad:! AccSet:! PathAccLim:! WorldAccLim:! \
    TriggL:! TriggEquip:! triggdata:type";

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Number(f64),
    Text(String),
    Mark(char),
    Assign,
}

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let chars: Vec<char> = text.chars().collect();
    let (mut at, mut all) = (0, Vec::new());
    while at < chars.len() {
        let c = chars[at];
        let run = |from: usize, more: &dyn Fn(char) -> bool| {
            (from..chars.len()).find(|&k| !more(chars[k])).unwrap_or(chars.len())
        };
        let end = if c.is_whitespace() {
            at + 1
        } else if c == '!' {
            run(at, &|c| c != '\n')
        } else if c.is_ascii_alphabetic() {
            let end = run(at, &|c| c.is_ascii_alphanumeric() || c == '_');
            all.push(Token::Word(chars[at..end].iter().collect()));
            end
        } else if c.is_ascii_digit() || c == '-' {
            let end = run(at + 1, &|c| c.is_ascii_digit() || c == '.' || c == 'E');
            let text: String = chars[at..end].iter().collect();
            all.push(Token::Number(text.parse().map_err(|_| format!("no number: {text}"))?));
            end
        } else if c == '"' {
            let end = run(at + 1, &|c| c != '"' && c != '\n');
            if chars.get(end) != Some(&'"') || end - at > 81 {
                return Err("a text of more than 80 characters, or without end".into());
            }
            all.push(Token::Text(chars[at + 1..end].iter().collect()));
            end + 1
        } else if c == ':' && chars.get(at + 1) == Some(&'=') {
            all.push(Token::Assign);
            at + 2
        } else if "[](),;\\%".contains(c) {
            all.push(Token::Mark(c));
            at + 1
        } else {
            return Err(format!("the character {c:?}"));
        };
        at = end;
    }
    Ok(all)
}

/// A value as it stands in the text.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Word(String),
    Text(String),
    List(Vec<Value>),
}

#[derive(Clone, Debug, PartialEq)]
struct Argument {
    /// `None`: a required one; else the name behind the backslash.
    option: Option<String>,
    value: Option<Value>,
}

#[derive(Clone, Debug, PartialEq)]
enum Statement {
    Instruction(String, Vec<Argument>),
    Call(String),
    Late(String),
    Raise,
}

#[derive(Debug, Default)]
struct Routine {
    name: String,
    body: Vec<Statement>,
    handler: Option<Vec<Statement>>,
}

#[derive(Debug)]
struct Declared {
    name: String,
    kind: String,
    value: Value,
    local: bool,
}

#[derive(Debug)]
struct Module {
    name: String,
    data: Vec<Declared>,
    routines: Vec<Routine>,
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
}

impl Parser {
    fn next(&mut self) -> Result<Token, String> {
        self.at += 1;
        self.tokens.get(self.at - 1).cloned().ok_or_else(|| "the file ends too early".to_owned())
    }

    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn mark(&mut self, mark: char) -> Result<(), String> {
        match self.next()? {
            Token::Mark(found) if found == mark => Ok(()),
            other => Err(format!("{other:?} where {mark} belongs")),
        }
    }

    fn word(&mut self) -> Result<String, String> {
        match self.next()? {
            Token::Word(word) => Ok(word),
            other => Err(format!("{other:?} where a word belongs")),
        }
    }

    fn keyword(&mut self, keyword: &str) -> Result<(), String> {
        let word = self.word()?;
        if word == keyword { Ok(()) } else { Err(format!("{word} where {keyword} belongs")) }
    }

    fn is_keyword(&self, keyword: &str) -> bool {
        matches!(self.peek(), Some(Token::Word(word)) if word == keyword)
    }

    fn value(&mut self) -> Result<Value, String> {
        match self.next()? {
            Token::Number(value) => Ok(Value::Number(value)),
            Token::Word(word) => Ok(Value::Word(word)),
            Token::Text(text) => Ok(Value::Text(text)),
            Token::Mark('[') => {
                let mut all = vec![self.value()?];
                while self.peek() == Some(&Token::Mark(',')) {
                    self.next()?;
                    all.push(self.value()?);
                }
                self.mark(']')?;
                Ok(Value::List(all))
            }
            other => Err(format!("{other:?} where a value belongs")),
        }
    }

    fn module(&mut self) -> Result<Module, String> {
        self.keyword("MODULE")?;
        let name = identifier(self.word()?)?;
        let (mut data, mut routines) = (Vec::new(), Vec::new());
        loop {
            let local = self.is_keyword("LOCAL");
            self.at += usize::from(local);
            match self.word()?.as_str() {
                "CONST" | "PERS" | "VAR" if routines.is_empty() => {
                    let (kind, name) = (self.word()?, identifier(self.word()?)?);
                    // Only the data of a trigger are declared without a value.
                    let value = if kind == "triggdata" {
                        Value::Number(0.0)
                    } else if self.next()? == Token::Assign {
                        self.value()?
                    } else {
                        return Err(format!("{name} has no value"));
                    };
                    self.mark(';')?;
                    data.push(Declared { name, kind, value, local });
                }
                "PROC" => routines.push(self.routine()?),
                "ENDMODULE" if !local => break,
                other => return Err(format!("{other} in the module {name}, behind routines or before them")),
            }
        }
        if self.at < self.tokens.len() {
            return Err("something behind ENDMODULE".into());
        }
        Ok(Module { name, data, routines })
    }

    fn routine(&mut self) -> Result<Routine, String> {
        let mut routine = Routine { name: identifier(self.word()?)?, ..Routine::default() };
        self.mark('(')?;
        self.mark(')')?;
        loop {
            if self.is_keyword("ENDPROC") {
                self.next()?;
                return Ok(routine);
            }
            if self.is_keyword("ERROR") {
                self.next()?;
                if routine.handler.replace(Vec::new()).is_some() {
                    return Err(format!("{} has two handlers", routine.name));
                }
                continue;
            }
            let statement = self.statement()?;
            routine.handler.as_mut().unwrap_or(&mut routine.body).push(statement);
        }
    }

    fn statement(&mut self) -> Result<Statement, String> {
        if self.peek() == Some(&Token::Mark('%')) {
            self.next()?;
            let Value::Text(name) = self.value()? else { return Err("a late call without a text".into()) };
            self.mark('%')?;
            self.mark(';')?;
            return Ok(Statement::Late(name));
        }
        let word = self.word()?;
        if word == "RAISE" {
            self.mark(';')?;
            return Ok(Statement::Raise);
        }
        if self.peek() == Some(&Token::Mark(';')) {
            self.next()?;
            return Ok(Statement::Call(word));
        }
        let mut arguments = Vec::new();
        // Between required arguments there is a comma, before options there is none.
        let mut fresh = true;
        loop {
            match self.peek() {
                Some(Token::Mark('\\')) => {
                    self.next()?;
                    let option = Some(self.word()?);
                    let value = if self.peek() == Some(&Token::Assign) {
                        self.next()?;
                        Some(self.value()?)
                    } else {
                        None
                    };
                    arguments.push(Argument { option, value });
                    fresh = false;
                }
                Some(Token::Mark(',')) if !fresh => {
                    self.next()?;
                    fresh = true;
                }
                Some(Token::Mark(';')) if !fresh => {
                    self.next()?;
                    return Ok(Statement::Instruction(word, arguments));
                }
                _ if fresh => {
                    arguments.push(Argument { option: None, value: Some(self.value()?) });
                    fresh = false;
                }
                other => return Err(format!("{other:?} in {word}")),
            }
        }
    }
}

fn identifier(name: String) -> Result<String, String> {
    if name.len() > 32 {
        return Err(format!("{name} has more than 32 characters"));
    }
    if RESERVED.split_whitespace().any(|word| word.eq_ignore_ascii_case(&name)) {
        return Err(format!("{name} is reserved"));
    }
    let numbered =
        |head: char| name.to_ascii_lowercase().strip_prefix(head).is_some_and(|rest| rest.parse::<u32>().is_ok());
    let installed =
        INSTALLED.split_whitespace().any(|entry| entry.split(':').next().unwrap().eq_ignore_ascii_case(&name));
    if installed || numbered('v') || numbered('z') {
        return Err(format!("{name} is installed"));
    }
    Ok(name)
}

/// The names of a task: what each stands for.
struct Names(BTreeMap<String, (String, Option<Value>)>);

impl Names {
    fn add(&mut self, name: &str, kind: &str, value: Option<Value>) -> Result<(), String> {
        match self.0.insert(name.to_ascii_lowercase(), (kind.to_owned(), value)) {
            None => Ok(()),
            Some((before, _)) => Err(format!("{name} is {kind} and {before}")),
        }
    }

    fn kind(&self, name: &str) -> Result<&str, String> {
        let entry = self.0.get(&name.to_ascii_lowercase());
        entry.map(|(kind, _)| kind.as_str()).ok_or_else(|| format!("{name} is not declared"))
    }

    fn expect(&self, value: &Value, kind: &str) -> Result<Option<Value>, String> {
        let Value::Word(name) = value else { return Err(format!("{value:?} where a {kind} belongs")) };
        match self.0.get(&name.to_ascii_lowercase()) {
            Some((found, value)) if found == kind => Ok(value.clone()),
            other => Err(format!("{name} is {other:?}, not a {kind}")),
        }
    }
}

fn numbers(value: &Value, count: usize) -> Result<Vec<f64>, String> {
    let Value::List(all) = value else { return Err(format!("{value:?} is no list")) };
    if all.len() != count {
        return Err(format!("{} entries, not {count}", all.len()));
    }
    all.iter()
        .map(|entry| if let Value::Number(value) = entry { Ok(*value) } else { Err(format!("{entry:?} is no number")) })
        .collect()
}

fn parts(value: &Value, count: usize) -> Result<&[Value], String> {
    match value {
        Value::List(all) if all.len() == count => Ok(all),
        other => Err(format!("{other:?} has not {count} parts")),
    }
}

fn truth(value: &Value) -> Result<bool, String> {
    match value {
        Value::Word(word) if word == "TRUE" || word == "FALSE" => Ok(word == "TRUE"),
        other => Err(format!("{other:?} is no truth")),
    }
}

fn quaternion(value: &Value) -> Result<(), String> {
    let q = numbers(value, 4)?;
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (length - 1.0).abs() > 1e-6 || q[0] < 0.0 {
        return Err(format!("the quaternion {q:?}"));
    }
    Ok(())
}

fn pose(value: &Value) -> Result<(), String> {
    let [place, turn] = parts(value, 2)? else { return Err("no pose".into()) };
    numbers(place, 3)?;
    quaternion(turn)
}

fn load(value: &Value) -> Result<(), String> {
    let all = parts(value, 6)?;
    let Value::Number(mass) = all[0] else { return Err("no mass".into()) };
    if mass < 0.001 {
        return Err(format!("a mass of {mass} kg"));
    }
    numbers(&all[1], 3)?;
    quaternion(&all[2])
}

/// The state of a run.
struct Run<'a> {
    names: Names,
    /// Signals and units of the controller's configuration.
    configured: &'a [(&'a str, &'a str)],
    active: BTreeSet<String>,
    loaded: Option<Module>,
    used_signals: BTreeSet<String>,
    /// Triggers that are set up.
    triggers: BTreeSet<String>,
    last_zone_is_fine: bool,
}

impl Run<'_> {
    fn declare(&mut self, module: &Module) -> Result<(), String> {
        self.names.add(&module.name, "module", None)?;
        for data in &module.data {
            match data.kind.as_str() {
                "tooldata" => {
                    let [hold, frame, mass] = parts(&data.value, 3)? else { return Err("no tooldata".into()) };
                    truth(hold)?;
                    pose(frame)?;
                    load(mass)?;
                }
                "wobjdata" => {
                    let all = parts(&data.value, 5)?;
                    let (hold, fixed) = (truth(&all[0])?, truth(&all[1])?);
                    let Value::Text(unit) = &all[2] else { return Err("no unit".into()) };
                    if fixed != unit.is_empty() || (hold && !fixed) {
                        return Err(format!("fixed {fixed}, in hand {hold}, on the unit {unit:?}"));
                    }
                    if !fixed && self.names.kind(unit)? != "mecunit" {
                        return Err(format!("{unit} is no unit"));
                    }
                    pose(&all[3])?;
                    pose(&all[4])?;
                }
                "loaddata" => load(&data.value)?,
                "triggdata" => {}
                "num" if matches!(data.value, Value::Number(_)) => {}
                other => return Err(format!("data of the type {other}")),
            }
            self.names.add(&data.name, &data.kind, Some(data.value.clone()))?;
        }
        for routine in &module.routines {
            self.names.add(&routine.name, "PROC", None)?;
        }
        Ok(())
    }

    fn forget(&mut self, module: &Module) {
        let routines = module.routines.iter().map(|routine| &routine.name);
        for name in routines.chain(module.data.iter().map(|data| &data.name)).chain([&module.name]) {
            self.names.0.remove(&name.to_ascii_lowercase());
            self.triggers.remove(&name.to_ascii_lowercase());
        }
    }

    fn signal(&mut self, value: &Value, kind: &str) -> Result<(), String> {
        self.names.expect(value, kind)?;
        if let Value::Word(name) = value {
            self.used_signals.insert(name.to_ascii_lowercase());
        }
        Ok(())
    }

    fn instruction(&mut self, word: &str, arguments: &[Argument]) -> Result<(), String> {
        let required: Vec<&Value> =
            arguments.iter().filter(|a| a.option.is_none()).filter_map(|a| a.value.as_ref()).collect();
        let option = |name: &str| arguments.iter().find(|a| a.option.as_deref() == Some(name));
        let options = arguments.iter().filter(|a| a.option.is_some()).count();
        match (word, required.as_slice()) {
            ("MoveL" | "MoveJ" | "MoveAbsJ", [target, speed, zone, tool]) => {
                let work = option("WObj").and_then(|a| a.value.clone()).unwrap_or(Value::Word("wobj0".into()));
                if options > 1 || (options == 1 && option("WObj").is_none()) {
                    return Err(format!("options of {word}"));
                }
                self.target(word, target)?;
                match speed {
                    Value::Word(name) => {
                        let named = name.strip_prefix('v').and_then(|rest| rest.parse::<u32>().ok());
                        named.filter(|v| (5..=7000).contains(v)).ok_or_else(|| format!("the speed {name}"))?;
                    }
                    list => {
                        if numbers(list, 4)?.iter().any(|&v| v <= 0.0) {
                            return Err("a speed of 0".into());
                        }
                    }
                }
                self.last_zone_is_fine = *zone == &Value::Word("fine".into());
                match zone {
                    Value::Word(name) if name == "fine" => {}
                    Value::Word(name) => {
                        let named = name.strip_prefix('z').and_then(|rest| rest.parse::<u32>().ok());
                        named.filter(|z| *z <= 200).ok_or_else(|| format!("the zone {name}"))?;
                    }
                    list => {
                        truth(&parts(list, 7)?[0])?;
                    }
                }
                let (tool, work) = (self.names.expect(tool, "tooldata")?, self.names.expect(&work, "wobjdata")?);
                let in_hand = |value: &Option<Value>, installed: bool| match value {
                    Some(Value::List(all)) => truth(&all[0]),
                    _ => Ok(installed),
                };
                if in_hand(&tool, true)? == in_hand(&work, false)? {
                    return Err("both or neither in the hand".into());
                }
                if let Some(Value::List(all)) = &work
                    && let (false, Value::Text(unit)) = (truth(&all[1])?, &all[2])
                    && !self.active.contains(&unit.to_ascii_lowercase())
                {
                    return Err(format!("{unit} is not active"));
                }
                Ok(())
            }
            ("TriggL", [target, speed, first, zone, tool]) => {
                let mut names = BTreeSet::new();
                let mut others = 1;
                for trigger in std::iter::once(Some(*first))
                    .chain((2..=8).map_while(|k| option(&format!("T{k}")).map(|argument| argument.value.as_ref())))
                {
                    let Some(Value::Word(name)) = trigger else { return Err("no trigger".into()) };
                    self.names.expect(&Value::Word(name.clone()), "triggdata")?;
                    if !self.triggers.contains(&name.to_ascii_lowercase()) || !names.insert(name.clone()) {
                        return Err(format!("{name} is not set up, or twice on a line"));
                    }
                    others += 1;
                }
                let is_trigger = |a: &Argument| {
                    a.option.as_ref().is_some_and(|name| name.starts_with('T')) || a.value.as_ref() == Some(*first)
                };
                let move_alone: Vec<Argument> = arguments.iter().filter(|a| !is_trigger(a)).cloned().collect();
                if move_alone.len() + others - 1 != arguments.len() || [target, speed, zone, tool].contains(&first) {
                    return Err(format!("arguments of {word}: {arguments:?}"));
                }
                self.instruction("MoveL", &move_alone)
            }
            ("TriggEquip", [trigger, Value::Number(distance), Value::Number(lag), Value::Number(value)])
                if *distance == 0.0 && (0.0..=0.5).contains(lag) =>
            {
                self.names.expect(trigger, "triggdata")?;
                let mut outputs = 0;
                for (name, kind) in [("DOp", "signaldo"), ("AOp", "signalao"), ("GOp", "signalgo")] {
                    let Some(argument) = option(name) else { continue };
                    self.signal(argument.value.as_ref().ok_or("no signal")?, kind)?;
                    outputs += 1;
                    let fits = match name {
                        "DOp" => *value == 0.0 || *value == 1.0,
                        "AOp" => *value >= 0.0,
                        _ => *value >= 0.0 && *value < 8_388_608.0 && value.fract() == 0.0,
                    };
                    if !fits {
                        return Err(format!("{name} of {value}"));
                    }
                }
                if outputs != 1 || options != 1 + usize::from(option("Start").is_some()) {
                    return Err(format!("options of {word}"));
                }
                if let Value::Word(name) = trigger {
                    self.triggers.insert(name.to_ascii_lowercase());
                }
                Ok(())
            }
            ("SetDO", [signal, Value::Number(value)]) if *value == 0.0 || *value == 1.0 => {
                self.signal(signal, "signaldo")
            }
            ("SetAO", [signal, Value::Number(value)]) if *value >= 0.0 => self.signal(signal, "signalao"),
            ("SetGO", [signal, Value::Number(value)])
                if *value >= 0.0 && *value < 8_388_608.0 && value.fract() == 0.0 =>
            {
                self.signal(signal, "signalgo")
            }
            ("ActUnit", [Value::Word(unit)]) if self.names.kind(unit)? == "mecunit" => {
                self.active.insert(unit.to_ascii_lowercase());
                Ok(())
            }
            ("GripLoad", [load]) => self.names.expect(load, "loaddata").map(|_| ()),
            ("AccSet", [Value::Number(share), Value::Number(ramp)])
                if options == 0 && (20.0..=100.0).contains(share) && (10.0..=100.0).contains(ramp) =>
            {
                Ok(())
            }
            ("PathAccLim", [accelerates, brakes]) if options == 2 => {
                let limits = [("AccMax", accelerates), ("DecelMax", brakes)].map(|(name, is_on)| {
                    truth(is_on) == Ok(true)
                        && matches!(option(name).and_then(|a| a.value.as_ref()), Some(Value::Number(x)) if *x >= 0.1)
                });
                if limits == [true; 2] { Ok(()) } else { Err(format!("{word} with {arguments:?}")) }
            }
            ("WorldAccLim", []) if options == 1 => match option("On").and_then(|a| a.value.as_ref()) {
                Some(Value::Number(limit)) if *limit >= 0.1 => Ok(()),
                _ => Err(format!("{word} with {arguments:?}")),
            },
            ("ConfJ" | "ConfL", []) if options == 1 && (option("On").is_some() || option("Off").is_some()) => Ok(()),
            _ => Err(format!("{word} with {arguments:?}")),
        }
    }

    fn target(&self, word: &str, target: &Value) -> Result<(), String> {
        let axes = |value: &Value| {
            let within = |x: &f64| x.abs() < 1e6 || (*x - 9e9).abs() < 1.0;
            if numbers(value, 6)?.iter().all(within) { Ok(()) } else { Err("external axes".to_owned()) }
        };
        if word == "MoveAbsJ" {
            let [joints, external] = parts(target, 2)? else { return Err("no jointtarget".into()) };
            numbers(joints, 6)?;
            return axes(external);
        }
        let [place, turn, conf, external] = parts(target, 4)? else { return Err("no robtarget".into()) };
        numbers(place, 3)?;
        quaternion(turn)?;
        let conf = numbers(conf, 4)?;
        if conf.iter().any(|c| c.fract() != 0.0) || !(0.0..=7.0).contains(&conf[3]) {
            return Err(format!("the configuration {conf:?}"));
        }
        axes(external)
    }
}

/// Runs through a program as a controller would, from `main` on.
///
/// # Errors
/// In words, the first rule that is broken.
pub fn check(
    main: &str,
    files: &BTreeMap<String, Vec<u8>>,
    folder: &str,
    configured: &[(&str, &str)],
) -> Result<(), String> {
    let parse = |file: &str| {
        let text = files.get(file).ok_or_else(|| format!("no file {file}"))?;
        let text = std::str::from_utf8(text).map_err(|_| format!("{file} is no text"))?;
        let module = Parser { tokens: tokens(text)?, at: 0 }.module().map_err(|error| format!("{file}: {error}"))?;
        if format!("{}.mod", module.name) != file { Err(format!("{file} holds {}", module.name)) } else { Ok(module) }
    };
    let mut run = Run {
        names: Names(BTreeMap::new()),
        configured,
        active: BTreeSet::new(),
        loaded: None,
        used_signals: BTreeSet::new(),
        triggers: BTreeSet::new(),
        last_zone_is_fine: true,
    };
    for entry in INSTALLED.split_whitespace() {
        let (name, kind) = entry.split_once(':').unwrap();
        run.names.add(name, kind, None)?;
    }
    for (name, kind) in run.configured {
        identifier((*name).to_owned())?;
        run.names.add(name, kind, None)?;
    }
    let module = parse(main)?;
    run.declare(&module)?;
    let find = |name: &str| module.routines.iter().find(|routine| routine.name.eq_ignore_ascii_case(name));
    let start = find("main").ok_or("no procedure main")?;
    let mut seen = BTreeSet::new();
    for statement in &start.body {
        match statement {
            Statement::Instruction(word, arguments) if word == "Load" || word == "UnLoad" => {
                let texts: Vec<&String> = arguments
                    .iter()
                    .filter_map(|a| if let Some(Value::Text(text)) = &a.value { Some(text) } else { None })
                    .collect();
                let [place, file] = texts[..] else { return Err(format!("{word} of {texts:?}")) };
                if place != folder {
                    return Err(format!("the folder {place}"));
                }
                if word == "Load" {
                    if run.loaded.is_some() || !seen.insert(file.clone()) {
                        return Err(format!("{file} is loaded twice, or beside another"));
                    }
                    let part = parse(file)?;
                    if let Some(data) = part.data.iter().find(|data| !data.local) {
                        return Err(format!("{} is known outside of {file}, which is unloaded", data.name));
                    }
                    run.declare(&part)?;
                    run.loaded = Some(part);
                } else {
                    let part = run.loaded.take().ok_or("nothing to unload")?;
                    if format!("{}.mod", part.name) != *file || !run.last_zone_is_fine {
                        return Err(format!("{file} is unloaded under way"));
                    }
                    run.forget(&part);
                }
            }
            Statement::Instruction(word, arguments) => run.instruction(word, arguments)?,
            Statement::Call(name) => {
                let routine = find(name).ok_or_else(|| format!("no procedure {name}"))?;
                for statement in &routine.body {
                    let Statement::Instruction(word, arguments) = statement else { return Err("a deep call".into()) };
                    run.instruction(word, arguments)?;
                }
            }
            Statement::Late(name) => {
                let part = run.loaded.take().ok_or("a late call without a module")?;
                let routine = part.routines.iter().find(|routine| routine.name == *name);
                for statement in &routine.ok_or_else(|| format!("no procedure {name}"))?.body {
                    let Statement::Instruction(word, arguments) = statement else {
                        return Err("a call in a part".into());
                    };
                    run.instruction(word, arguments)?;
                }
                run.loaded = Some(part);
            }
            Statement::Raise => return Err("RAISE outside of a handler".into()),
        }
    }
    if run.loaded.is_some() || seen.len() + 1 != files.len() {
        return Err(format!("{} modules loaded of {}", seen.len(), files.len() - 1));
    }
    let routine = |statement: Option<&Statement>| match statement {
        Some(Statement::Call(name)) => find(name).map(|routine| &routine.body),
        _ => None,
    };
    if !run.used_signals.is_empty() {
        // What is used is off at the begin, at the end, and behind an error.
        let handler = start.handler.as_deref().unwrap_or_default();
        if handler.last() != Some(&Statement::Raise) {
            return Err("an error is not passed on".into());
        }
        for statement in [start.body.first(), start.body.last(), handler.first()] {
            let body = routine(statement).ok_or("signals are not switched off")?;
            let off: BTreeSet<String> = body
                .iter()
                .filter_map(|statement| match statement {
                    Statement::Instruction(_, arguments) => match [&arguments[0].value, &arguments[1].value] {
                        [Some(Value::Word(name)), Some(Value::Number(value))] if *value == 0.0 => {
                            Some(name.to_ascii_lowercase())
                        }
                        _ => None,
                    },
                    _ => None,
                })
                .collect();
            if off != run.used_signals {
                return Err(format!("{off:?} are switched off, not {:?}", run.used_signals));
            }
        }
    }
    Ok(())
}
