//! Readers of programs: of robots, of machines, and lines of connections.

use crate::Entry;
use crate::replay::judge::{Placement, Plan};
use crate::replay::program::{Dialect as PlainDialect, GcodeProgram};
use curvlay_kinematics::program::link::{LinkFrame, LinkReply};
use curvlay_kinematics::program::ur_stream::{UrFrame, UrReply};
use curvlay_kinematics::program::*;
use curvlay_toolpath::gcode::flavour::{AxisReader, Flavour, FlavourReadOptions, FlavourReader, MachineAxis};
use curvlay_toolpath::gcode::{Dialect, DirectionWords, GcodeReader, ReadOptions, RotaryTable};
use std::hint::black_box;
use std::io;
use std::sync::LazyLock;

pub const ENTRIES: &[Entry] = &[
    ("gcode", gcode),
    ("gcode_flavours", flavours),
    ("gcode_axes", axes),
    ("gcode_replay", plain),
    ("plan_csv", |data| plan(data, true)),
    ("plan_gcode", |data| plan(data, false)),
    ("urscript", |data| {
        if let Ok(reader) = UrScriptReader::new(data) {
            steps(reader);
        }
    }),
    ("rapid", |data| {
        if let Ok(part) = RapidPart::new(data) {
            steps(part);
        }
        // The module loads itself, whatever it asks for.
        if let Ok(program) = read_rapid(data, |_| Ok::<_, io::Error>(data)) {
            steps(program);
        }
    }),
    ("krl", krl),
    ("tp", |data| {
        if let Ok(program) = read_tp(data, |_| Ok::<_, io::Error>(data)) {
            steps(program);
        }
    }),
    ("tp_part", |data| {
        let main: &[u8] = include_bytes!("../../../kinematics/tests/all/programs/PRINT.ls");
        if let Ok(program) = read_tp(main, |_| Ok::<_, io::Error>(data)) {
            steps(program);
        }
    }),
    ("program_csv", |data| {
        if let Ok(reader) = CsvReader::new(data) {
            steps(reader);
        }
    }),
    ("link", link),
];

/// Steps that are read of a program: one that loads itself has no end.
const MOST: usize = 20_000;

fn steps(all: impl Iterator<Item = Result<Step, ReadError>>) {
    black_box(all.take(MOST).filter(Result::is_ok).count());
}

/// The main with its data, or a part of ours, by the first byte.
fn krl(data: &[u8]) {
    const DAT: &[u8] = include_bytes!("../../../kinematics/tests/all/programs/PRINT.dat");
    const SRC: &[u8] = include_bytes!("../../../kinematics/tests/all/programs/PRINT.src");
    for (dat, src, part) in [(data, SRC, data), (DAT, data, data), (DAT, SRC, data)] {
        if let Ok(program) = read_krl(dat, src, |_| Ok::<_, io::Error>(part)) {
            steps(program);
        }
    }
}

fn gcode(data: &[u8]) {
    let dialects = [
        Dialect::Part(DirectionWords::Comment),
        Dialect::Part(DirectionWords::Ijk),
        Dialect::Rotary(RotaryTable::default()),
    ];
    for dialect in dialects {
        for skip_other_m in [false, true] {
            let options = ReadOptions { dialect, skip_other_m, ..ReadOptions::default() };
            if let Ok(reader) = GcodeReader::new(data, options) {
                black_box(reader.filter(Result::is_ok).count());
            }
        }
    }
}

/// All flavours that come with the crate, read once.
static FLAVOURS: LazyLock<Vec<Flavour>> =
    LazyLock::new(|| Flavour::names().iter().filter_map(|name| Flavour::built_in(name)).collect());

/// A machine with two rotary axes, and the flavours for it.
static MACHINE: LazyLock<([MachineAxis; 5], Vec<Flavour>)> = LazyLock::new(|| {
    let machine = ['X', 'Y', 'Z', 'B', 'C'].map(|letter| MachineAxis { letter, is_rotary: letter < 'X' });
    let flavours = FLAVOURS.iter().map(|flavour| flavour.clone().for_machine(&machine)).collect();
    (machine, flavours)
});

fn flavours(data: &[u8]) {
    for flavour in FLAVOURS.iter() {
        if let Ok(reader) = FlavourReader::new(data, flavour, FlavourReadOptions { skip_others: true }) {
            black_box(reader.filter(Result::is_ok).count());
        }
    }
}

fn axes(data: &[u8]) {
    let (machine, flavours) = &*MACHINE;
    for flavour in flavours {
        if let Ok(reader) = AxisReader::new(data, machine, flavour, FlavourReadOptions { skip_others: true }) {
            black_box(reader.filter(Result::is_ok).count());
        }
    }
}

fn plain(data: &[u8]) {
    let dialect = PlainDialect { letters: vec!['X', 'Y', 'Z', 'B', 'C'], linear: 3, dwell_s: 0.001 };
    let mut program = GcodeProgram::new(data, 0, dialect);
    while let Ok(Some(command)) = program.next_command() {
        black_box(command);
    }
}

fn plan(data: &[u8], is_csv: bool) {
    if let Ok(plan) = Plan::new(data, is_csv, Placement::default(), 2.4) {
        black_box(plan.filter(Result::is_ok).count());
    }
}

/// What a connection may bring: lines and frames.
fn link(data: &[u8]) {
    if let Ok(frame) = LinkFrame::decode(data) {
        let _ = frame.encode();
    }
    let text = String::from_utf8_lossy(data);
    black_box(text.parse::<LinkReply>().is_ok());
    black_box(text.parse::<ExtruderCommand>().is_ok());
    black_box(text.parse::<UrReply>().is_ok());
    if let Ok(frame) = text.parse::<UrFrame>() {
        black_box(frame.encode());
    }
}
