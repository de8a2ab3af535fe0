//! A controller that runs a program of URScript in virtual time: threads of the program are interleaved at random between any two statements, a motion takes
//! the time that it says, and a socket gives what the test lets through.

use super::language::{Expression, Statement, program};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::cmp::Ordering;
use std::collections::{HashMap, VecDeque};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;

#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Int(i64),
    Float(f64),
    Truth(bool),
    Text(String),
    List(Vec<Value>),
    Nothing,
}

impl Value {
    fn number(&self) -> f64 {
        match self {
            Value::Int(value) => *value as f64,
            Value::Float(value) => *value,
            other => panic!("{other:?} is no number"),
        }
    }

    fn truth(&self) -> bool {
        if let Value::Truth(value) = self { *value } else { panic!("{self:?} is not true or false") }
    }

    fn text(&self) -> &str {
        if let Value::Text(text) = self { text } else { panic!("{self:?} is no text") }
    }

    fn joints(&self) -> [f64; 6] {
        let Value::List(list) = self else { panic!("{self:?} is no list") };
        let joints: Vec<f64> = list.iter().map(Value::number).collect();
        joints.try_into().unwrap()
    }
}

/// What the program did.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    Servo { at: [f64; 6], seconds: f64 },
    Move([f64; 6]),
    Stop,
    Digital(i64, bool),
    Analog(i64, f64),
    Register(f64),
    Line(String),
    Popup(String),
}

/// What the test and the program share.
#[derive(Default)]
pub struct World {
    /// In milliseconds.
    pub now: f64,
    pub joints: [f64; 6],
    pub acts: Vec<(f64, Act)>,
    /// Whether a sender listens, and whether the robot is connected to it.
    pub listens: bool,
    pub connected: bool,
    /// Text that has come to the robot, and lines from it.
    pub to_robot: VecDeque<u8>,
    pub from_robot: Vec<String>,
    pub over: bool,
    globals: HashMap<String, Value>,
    random: Option<Pcg64>,
}

impl World {
    pub fn number(&self, name: &str) -> f64 {
        self.globals[name].number()
    }

    /// A frame that has come in whole.
    fn has_frame(&self) -> bool {
        self.to_robot.contains(&b')')
    }

    fn frame(&mut self, count: usize) -> Value {
        let end = self.to_robot.iter().position(|byte| *byte == b')').unwrap();
        let text: Vec<u8> = self.to_robot.drain(..=end).collect();
        let text = String::from_utf8_lossy(&text).into_owned();
        let inner = text.trim().strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).unwrap_or("");
        let numbers: Option<Vec<Value>> = inner.split(',').map(|word| word.parse().ok().map(Value::Float)).collect();
        match numbers {
            Some(numbers) if numbers.len() >= count => {
                Value::List([Value::Int(count as i64)].into_iter().chain(numbers.into_iter().take(count)).collect())
            }
            _ => nothing(count),
        }
    }
}

fn nothing(count: usize) -> Value {
    Value::List([Value::Int(0)].into_iter().chain(vec![Value::Float(f64::NAN); count]).collect())
}

/// Why a thread gives way, and until when at the latest.
enum Wait {
    Until(f64),
    Frame(f64),
    Run(String, Vec<Statement>),
    Kill(String),
    Ended,
}

/// The program is over: its threads end.
struct Over;

enum Flow {
    On,
    Back(Value),
}

/// Names of arguments, and statements.
type Functions = Arc<Mutex<HashMap<String, (Vec<String>, Vec<Statement>)>>>;

struct Runner {
    world: Arc<Mutex<World>>,
    functions: Functions,
    ask: Sender<Wait>,
    go: Receiver<()>,
    locals: Vec<HashMap<String, Value>>,
    steps: u64,
}

struct Thread {
    name: String,
    wait: Wait,
    go: Sender<()>,
    ask: Receiver<Wait>,
    handle: Option<JoinHandle<()>>,
}

pub struct Machine {
    pub world: Arc<Mutex<World>>,
    functions: Functions,
    threads: Vec<Thread>,
}

impl Machine {
    pub fn start(script: &str, joints: [f64; 6], seed: u64) -> Self {
        let random = Some(Pcg64::seed_from_u64(seed));
        let world = Arc::new(Mutex::new(World { joints, random, ..World::default() }));
        let mut machine = Machine { world, functions: Arc::default(), threads: Vec::new() };
        machine.spawn("main".to_owned(), program(script));
        machine
    }

    pub fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap()
    }

    fn spawn(&mut self, name: String, body: Vec<Statement>) {
        let ((go, gone), (ask, asked)) = (channel(), channel());
        let (world, functions) = (self.world.clone(), self.functions.clone());
        let handle = std::thread::spawn(move || {
            let mut runner = Runner { world, functions, ask, go: gone, locals: vec![HashMap::new()], steps: 0 };
            if runner.go.recv().is_ok() && runner.block(&body).is_ok() {
                let _ = runner.ask.send(Wait::Ended);
            }
        });
        let now = self.world().now;
        self.threads.push(Thread { name, wait: Wait::Until(now), go, ask: asked, handle: Some(handle) });
    }

    /// Runs all that is due by a time.
    pub fn run_until(&mut self, until: f64) {
        loop {
            let due = |thread: &Thread, world: &World| match thread.wait {
                Wait::Until(at) => Some(at),
                Wait::Frame(_) if world.has_frame() || !world.connected => Some(world.now),
                Wait::Frame(at) => Some(at),
                _ => None,
            };
            let mut world = self.world();
            let next = (0..self.threads.len()).filter_map(|k| Some((due(&self.threads[k], &world)?, k)));
            let Some((at, k)) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if at > until || world.over {
                break;
            }
            world.now = world.now.max(at);
            drop(world);
            self.threads[k].go.send(()).unwrap();
            let wait = self.threads[k].ask.recv().expect("a thread of the program has failed");
            match wait {
                Wait::Run(name, body) => {
                    let now = self.world().now;
                    self.threads[k].wait = Wait::Until(now);
                    self.spawn(name, body);
                }
                Wait::Kill(name) => {
                    let now = self.world().now;
                    self.threads[k].wait = Wait::Until(now);
                    self.threads.retain(|thread| thread.name != name);
                }
                Wait::Ended => {
                    assert_eq!(self.threads[k].name, "main", "a thread ends before the program");
                    self.world().over = true;
                    self.threads[k].wait = wait;
                }
                wait => self.threads[k].wait = wait,
            }
        }
        let mut world = self.world();
        world.now = world.now.max(until);
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        for thread in &mut self.threads {
            // Without an answer it ends.
            let (go, _) = channel();
            thread.go = go;
            if let Some(handle) = thread.handle.take() {
                let _ = handle.join();
            }
        }
    }
}

impl Runner {
    fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap()
    }

    fn wait(&mut self, wait: Wait) -> Result<(), Over> {
        self.steps = 0;
        self.ask.send(wait).map_err(|_| Over)?;
        self.go.recv().map_err(|_| Over)
    }

    fn sleep(&mut self, ms: f64) -> Result<(), Over> {
        let until = self.world().now + ms;
        self.wait(Wait::Until(until))
    }

    fn block(&mut self, statements: &[Statement]) -> Result<Flow, Over> {
        for statement in statements {
            // Another thread may run here.
            let now = self.world().now;
            let gives_way = self.world().random.as_mut().unwrap().random_range(0..50) == 0;
            self.steps += 1;
            assert!(self.steps < 100_000, "a loop without waiting");
            if gives_way {
                let steps = self.steps;
                self.wait(Wait::Until(now))?;
                self.steps = steps;
            }
            if let Flow::Back(value) = self.statement(statement)? {
                return Ok(Flow::Back(value));
            }
        }
        Ok(Flow::On)
    }

    fn statement(&mut self, statement: &Statement) -> Result<Flow, Over> {
        match statement {
            Statement::Function { name, arguments, body } => {
                self.functions.lock().unwrap().insert(name.clone(), (arguments.clone(), body.clone()));
            }
            Statement::Assign { scope, name, value } => {
                let value = self.value(value)?;
                let is_local = match scope.as_deref() {
                    Some("local") => true,
                    Some(_) => false,
                    None => {
                        let is_local = self.locals.last().unwrap().contains_key(name);
                        assert!(is_local || self.world().globals.contains_key(name), "{name} is not declared");
                        is_local
                    }
                };
                match is_local {
                    true => self.locals.last_mut().unwrap().insert(name.clone(), value),
                    false => self.world().globals.insert(name.clone(), value),
                };
            }
            Statement::AssignAt { name, at, value } => {
                let (at, value) = (self.value(at)?, self.value(value)?);
                let Value::Int(at) = at else { panic!("{at:?} is no index") };
                let mut world = self.world();
                let Some(Value::List(list)) = world.globals.get_mut(name) else { panic!("{name} is no list") };
                list[usize::try_from(at).unwrap()] = value;
            }
            Statement::Run { name, thread } => {
                let body = self.functions.lock().unwrap()[thread].1.clone();
                self.wait(Wait::Run(name.clone(), body))?;
            }
            Statement::Kill(name) => self.wait(Wait::Kill(name.clone()))?,
            Statement::Do(call) => _ = self.value(call)?,
            Statement::If(cases, otherwise) => {
                for (test, body) in cases {
                    if self.value(test)?.truth() {
                        return self.block(body);
                    }
                }
                return self.block(otherwise);
            }
            Statement::While(test, body) => {
                while self.value(test)?.truth() {
                    if let Flow::Back(value) = self.block(body)? {
                        return Ok(Flow::Back(value));
                    }
                }
            }
            Statement::Return(value) => return Ok(Flow::Back(self.value(value)?)),
        }
        Ok(Flow::On)
    }

    fn value(&mut self, expression: &Expression) -> Result<Value, Over> {
        Ok(match expression {
            Expression::Number(value, true) => Value::Int(*value as i64),
            Expression::Number(value, false) => Value::Float(*value),
            Expression::Text(text) => Value::Text(text.clone()),
            Expression::Truth(truth) => Value::Truth(*truth),
            Expression::Name(name) => {
                let local = self.locals.last().unwrap().get(name).cloned();
                local.or_else(|| self.world().globals.get(name).cloned()).unwrap_or_else(|| panic!("{name}?"))
            }
            Expression::List(list) => {
                Value::List(list.iter().map(|value| self.value(value)).collect::<Result<_, _>>()?)
            }
            Expression::At(list, at) => {
                let (Value::List(list), Value::Int(at)) = (self.value(list)?, self.value(at)?) else { panic!() };
                list[usize::try_from(at).unwrap()].clone()
            }
            Expression::Not(inner) => Value::Truth(!self.value(inner)?.truth()),
            Expression::Minus(inner) => match self.value(inner)? {
                Value::Int(value) => Value::Int(-value),
                other => Value::Float(-other.number()),
            },
            // Both sides are worked out: the manual does not say that the second one is left out.
            Expression::Two(operator, a, b) => two(operator, &self.value(a)?, &self.value(b)?),
            Expression::Call(name, arguments) => {
                let arguments = arguments.iter().map(|value| self.value(value)).collect::<Result<Vec<_>, _>>()?;
                self.call(name, arguments)?
            }
        })
    }

    fn call(&mut self, name: &str, arguments: Vec<Value>) -> Result<Value, Over> {
        let known = self.functions.lock().unwrap().get(name).cloned();
        if let Some((names, body)) = known {
            assert_eq!(names.len(), arguments.len());
            self.locals.push(names.into_iter().zip(arguments).collect());
            let flow = self.block(&body)?;
            self.locals.pop();
            return Ok(if let Flow::Back(value) = flow { value } else { Value::Nothing });
        }
        let act = |runner: &Self, act| {
            let mut world = runner.world();
            let now = world.now;
            world.acts.push((now, act));
        };
        let arguments = &arguments[..];
        Ok(match (name, arguments) {
            ("set_tcp" | "set_payload", _) => Value::Nothing,
            ("get_actual_joint_positions", []) => Value::List(self.world().joints.map(Value::Float).to_vec()),
            ("servoj", [at, seconds, _, _]) => {
                let (at, seconds) = (at.joints(), seconds.number());
                act(self, Act::Servo { at, seconds });
                self.world().joints = at;
                self.sleep(1e3 * seconds)?;
                Value::Nothing
            }
            ("movej", [to, acceleration, speed]) => {
                assert!(acceleration.number() > 0.0);
                let (to, from) = (to.joints(), self.world().joints);
                let turn = (0..6).map(|k| (to[k] - from[k]).abs()).fold(0.0, f64::max);
                act(self, Act::Move(to));
                self.sleep(1e3 * turn / speed.number())?;
                self.world().joints = to;
                Value::Nothing
            }
            ("stopj", [_]) => {
                act(self, Act::Stop);
                self.sleep(20.0)?;
                Value::Nothing
            }
            ("sync", []) => {
                self.sleep(8.0)?;
                Value::Nothing
            }
            ("sleep", [seconds]) => {
                self.sleep(1e3 * seconds.number())?;
                Value::Nothing
            }
            ("floor", [value]) => Value::Int(value.number().floor() as i64),
            ("sqrt", [value]) => Value::Float(value.number().sqrt()),
            ("to_str", [Value::Int(value)]) => Value::Text(value.to_string()),
            ("to_str", [Value::Float(value)]) => Value::Text(value.to_string()),
            ("str_cat", [a, b]) => Value::Text(format!("{}{}", a.text(), b.text())),
            ("popup", [text, ..]) => {
                act(self, Act::Popup(text.text().to_owned()));
                Value::Nothing
            }
            ("set_standard_digital_out", [number, Value::Truth(on)]) => {
                act(self, Act::Digital(number.number() as i64, *on));
                Value::Nothing
            }
            ("set_standard_analog_out", [number, share]) => {
                assert!((0.0..=1.0).contains(&share.number()));
                act(self, Act::Analog(number.number() as i64, share.number()));
                Value::Nothing
            }
            ("modbus_add_signal" | "modbus_set_signal_update_frequency", _) => Value::Nothing,
            ("modbus_set_output_signal", [_, Value::Truth(on)]) => {
                act(self, Act::Digital(-1, *on));
                Value::Nothing
            }
            ("modbus_set_output_register", [_, Value::Int(count), Value::Truth(false)]) => {
                act(self, Act::Register(*count as f64));
                Value::Nothing
            }
            ("socket_open", [_, _, name]) if name.text() == "extruder" => Value::Truth(true),
            ("socket_send_line", [line, name]) if name.text() == "extruder" => {
                act(self, Act::Line(line.text().to_owned()));
                Value::Truth(true)
            }
            ("socket_close", [name]) => {
                if name.text() == "stream" {
                    let mut world = self.world();
                    world.connected = false;
                    world.to_robot.clear();
                }
                Value::Truth(true)
            }
            ("socket_open", _) => {
                self.sleep(5.0)?;
                let mut world = self.world();
                world.connected = world.listens;
                world.to_robot.clear();
                Value::Truth(world.listens)
            }
            ("socket_send_line", [line, _]) => {
                let mut world = self.world();
                if world.connected {
                    world.from_robot.push(line.text().to_owned());
                }
                Value::Truth(world.connected)
            }
            ("socket_read_ascii_float", [Value::Int(count), _, seconds]) => {
                assert!((1..=30).contains(count));
                let until = self.world().now + 1e3 * seconds.number();
                self.wait(Wait::Frame(until))?;
                let mut world = self.world();
                if world.connected && world.has_frame() {
                    world.frame(*count as usize)
                } else {
                    nothing(*count as usize)
                }
            }
            _ => panic!("{name} with {arguments:?}"),
        })
    }
}

fn two(operator: &str, a: &Value, b: &Value) -> Value {
    match (operator, a, b) {
        ("and", a, b) => Value::Truth(a.truth() & b.truth()),
        ("or", a, b) => Value::Truth(a.truth() | b.truth()),
        ("+", Value::Int(a), Value::Int(b)) => Value::Int(a + b),
        ("-", Value::Int(a), Value::Int(b)) => Value::Int(a - b),
        ("*", Value::Int(a), Value::Int(b)) => Value::Int(a * b),
        ("/", Value::Int(a), Value::Int(b)) => Value::Int(a / b),
        _ => {
            let (a, b) = (a.number(), b.number());
            match operator {
                "+" => Value::Float(a + b),
                "-" => Value::Float(a - b),
                "*" => Value::Float(a * b),
                "/" => Value::Float(a / b),
                "<" => Value::Truth(a < b),
                ">" => Value::Truth(a > b),
                "<=" => Value::Truth(a <= b),
                ">=" => Value::Truth(a >= b),
                "==" => Value::Truth(a.partial_cmp(&b) == Some(Ordering::Equal)),
                "!=" => Value::Truth(a.partial_cmp(&b) != Some(Ordering::Equal)),
                other => panic!("{other}"),
            }
        }
    }
}
