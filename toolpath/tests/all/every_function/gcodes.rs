//! Machine files: writers and readers of both dialects and of all flavours.

use super::numbers::{bad, each_spoilt, number, point, unit};
use curvlay_toolpath::gcode::flavour::*;
use curvlay_toolpath::gcode::*;
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;

fn moved() -> impl Strategy<Value = Move> {
    let place = || (point(), unit());
    prop_oneof![
        3 => (place(), number()).prop_map(|((tip, direction), feed_mm_s)| Move::Travel { tip, direction, feed_mm_s }),
        6 => (place(), number(), number()).prop_map(|((tip, direction), filament_mm, feed_mm_s)| Move::Print { tip, direction, filament_mm, feed_mm_s }),
        1 => (place(), number()).prop_map(|((tip, direction), feed_mm_s)| Move::Lay { tip, direction, feed_mm_s }),
        1 => (number(), number()).prop_map(|(filament_mm, feed_mm_s)| Move::Retract { filament_mm, feed_mm_s }),
        1 => (number(), number()).prop_map(|(filament_mm, feed_mm_s)| Move::Prime { filament_mm, feed_mm_s }),
        2 => still(),
    ]
}

fn still() -> impl Strategy<Value = Move> {
    (0..10usize, number(), any::<bool>(), any::<u32>()).prop_map(|(kind, value, wait, number)| match kind {
        0 => Move::Home,
        1 => Move::Dwell { seconds: value },
        2 => Move::Nozzle { celsius: value, wait },
        3 => Move::Bed { celsius: value, wait },
        4 => Move::Fan { share: value },
        5 => Move::Mark(Mark::Layer { number, z_mm: value, height_mm: value }),
        6 => Move::Mark(Mark::Bead { kind: BeadKind::Wall, width_mm: value, height_mm: 0.2 }),
        7 => Move::Fiber(FiberCommand::Tool(if wait { Tool::Roller } else { Tool::Conductor })),
        8 => Move::Fiber(FiberCommand::Feed { length_mm: value }),
        _ => Move::Fiber(if wait { FiberCommand::Cut } else { FiberCommand::Press { newtons: value } }),
    })
}

/// Moves that a machine can make, with any ones among them now and then.
fn moves() -> impl Strategy<Value = Vec<Move>> {
    let sound = |k: usize| Move::Print {
        tip: Point3::new(k as f64, 0.0, 0.4),
        direction: Vector3::z_axis(),
        filament_mm: 0.1,
        feed_mm_s: 20.0,
    };
    let start = Move::Travel { tip: Point3::origin(), direction: Vector3::z_axis(), feed_mm_s: 50.0 };
    let spoilt = (0..6usize, prop::collection::vec(moved(), 0..3)).prop_map(move |(count, odd)| {
        std::iter::once(start).chain((0..count).map(sound)).chain(odd).chain([sound(7)]).collect()
    });
    prop_oneof![3 => spoilt, 1 => prop::collection::vec(moved(), 0..6)]
}

/// Heat, retraction and end, one of them spoilt.
fn retraction(value: f64) -> Retraction {
    Retraction { filament_mm: value, ..Retraction::default() }
}

const WRITE: [fn(&mut WriteOptions<'static>, f64); 6] = [
    |options, value| options.nozzle_celsius = Some(value),
    |options, value| options.bed_celsius = Some(value),
    |options, value| options.fan = Some(value),
    |options, value| options.retraction = Some(retraction(value)),
    |options, value| options.retraction = Some(Retraction { min_travel_mm: value, ..Retraction::default() }),
    |options, value| options.end = Some(EndLift { lift_mm: value, ..EndLift::default() }),
];
const PROGRAM: [fn(&mut ProgramOptions<'static>, f64); 6] = [
    |options, value| options.nozzle_celsius = Some(value),
    |options, value| options.bed_celsius = Some(value),
    |options, value| options.fan = Some(value),
    |options, value| options.first_feed_mm_s = value,
    |options, value| options.retraction = Some(Retraction { feed_mm_s: value, ..Retraction::default() }),
    |options, value| options.end = Some(EndLift { feed_mm_s: value, ..EndLift::default() }),
];
const NUMBERS: [fn(&mut Flavour, usize); 9] = [
    |flavour, value| flavour.numbers.position = value,
    |flavour, value| flavour.numbers.angle = value,
    |flavour, value| flavour.numbers.direction = value,
    |flavour, value| flavour.numbers.filament = value,
    |flavour, value| flavour.numbers.feed = value,
    |flavour, value| flavour.numbers.time = value,
    |flavour, value| flavour.lines.max_length = value,
    |flavour, value| {
        flavour.lines.numbers = Some(LineNumbers {
            prefix: "N".into(),
            first: u64::MAX,
            step: value as u64,
            comments: true,
            checksum: true,
        })
    },
    |flavour, _| flavour.axes.clear(),
];
const TABLE: [fn(&mut RotaryTable, f64); 8] = [
    |table, value| table.pole_rad = value,
    |table, value| table.tolerance_mm = Some(value),
    |table, value| table.tilt.limits[0] = value,
    |table, value| table.turn.limits = [value, -1.0],
    |table, value| table.turn.speed_rad_s = value,
    |table, value| table.tilt.centre.x = value,
    |table, value| table.turn.axis = UnitVector3::new_unchecked(Vector3::new(value, 0.0, 1.0)),
    |table, value| table.nozzle = UnitVector3::new_unchecked(Vector3::new(0.0, 0.0, value)),
];

/// Reads a file as each dialect has it.
fn read_all(text: &[u8], tables: &[RotaryTable], home: Option<Point3<f64>>) {
    let directions = [DirectionWords::Comment, DirectionWords::Ijk, DirectionWords::Dissertation].map(Dialect::Part);
    for dialect in directions.into_iter().chain(tables.iter().map(|&table| Dialect::Rotary(table))) {
        for skip_other_m in [false, true] {
            let Ok(mut reader) = GcodeReader::new(text, ReadOptions { dialect, home, skip_other_m }) else { continue };
            reader.by_ref().for_each(drop);
            assert!(reader.lines() <= text.len() as u64 + 1);
        }
    }
}

fn flavours(count: usize, word: &str, value: f64) -> Vec<Flavour> {
    let named = Flavour::names().iter().filter_map(|name| Flavour::built_in(name));
    let spoilt = Flavour::names().iter().take(3).filter_map(|name| Flavour::built_in(name)).flat_map(|flavour| {
        let mut odd = flavour.clone();
        (odd.motion.print, odd.feed.word) = (word.into(), word.into());
        let mut slow = flavour.clone();
        slow.feed.max = value;
        slow.axes.iter_mut().for_each(|axis| axis.scale = value);
        each_spoilt(&flavour, &NUMBERS, count).into_iter().chain([odd, slow])
    });
    named.chain(spoilt).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn dialects_take_anything(moves in moves(), value in bad(), angles in [number(), number()], at in point(), direction in unit(), text in "[GMXYZBCEFN0-9. ;\n*-]{0,80}", any in prop::collection::vec(any::<u8>(), 0..60), cut in 0..300usize) {
        let tables = each_spoilt(&RotaryTable::default(), &TABLE, value);
        for table in &tables {
            let _ = (table.machine_point(&at, angles), table.part_point(&at, angles), table.angles(&direction, angles), table.angles(&direction, [value; 2]));
        }
        let mut texts = vec![text.into_bytes(), any];
        let rotary = tables.iter().map(|&table| WriteOptions { dialect: Dialect::Rotary(table), ..WriteOptions::default() });
        let tagged = [Tags::Prusa, Tags::Cura].map(|tags| WriteOptions { tags, line_numbers: true, header: "M82\n\u{e9}\n", extrusion: Extrusion::Relative, ..WriteOptions::default() });
        for options in each_spoilt(&WriteOptions::default(), &WRITE, value).into_iter().chain(rotary).chain(tagged) {
            let mut out = Vec::new();
            if write_gcode(moves.iter().copied(), &options, &mut out).is_ok() && texts.len() < 8 {
                texts.push(out[..cut.min(out.len())].to_vec());
                texts.push(out);
            }
        }
        for text in &texts {
            read_all(text, &tables[..2], (cut % 2 == 0).then_some(at));
        }
    }

    #[test]
    fn flavours_take_anything(
        moves in moves(), value in bad(), count in prop::sample::select(vec![0, 1, 9, 400, usize::MAX]), word in "[A-Z{}a-z=\n ]{0,8}", name in "[a-zA-Z\n(){}]{0,9}", letters in [any::<char>(), prop::char::range('A', 'Z')], axes in prop::collection::vec(([number(), number(), number(), number(), number()], number(), number()), 0..4), text in "[GMXYZBCEFN0-9. ;\n=()-]{0,80}", stills in prop::collection::vec(still(), 0..3),
    ) {
        let machine = [MachineAxis::linear('X'), MachineAxis::linear('Y'), MachineAxis::linear('Z'), MachineAxis::rotary('B'), MachineAxis::rotary('C')];
        let odd = [machine[0], machine[1], machine[2], MachineAxis::linear(letters[0]), MachineAxis::rotary(letters[1])];
        let mut plan: Vec<AxisMove<5>> = vec![AxisMove::Travel { axes: [0.0; 5], seconds: 1.0 }, AxisMove::Print { axes: [1.0, 0.0, 0.0, 0.1, 0.2], seconds: 0.5, filament_mm: 0.1 }];
        plan.extend(axes.iter().map(|&(axes, seconds, filament_mm)| AxisMove::Print { axes, seconds, filament_mm }));
        plan.extend(axes.iter().map(|&(axes, seconds, _)| AxisMove::Lay { axes, seconds }));
        plan.extend(stills.into_iter().map(AxisMove::Still));
        prop_assert!(Flavour::built_in(&name).is_none_or(|flavour| flavour.check().is_ok()));
        let options = ProgramOptions { start: Some("M1\n{nozzle}\n{x"), finish: Some("M30"), tags: Tags::Cura, ..ProgramOptions::default() };
        let all: Vec<ProgramOptions<'_>> = each_spoilt(&ProgramOptions::default(), &PROGRAM, value).into_iter().chain([options, ProgramOptions { name: &name, ..ProgramOptions::default() }]).collect();
        for (number, flavour) in flavours(count, &word, value).into_iter().enumerate() {
            let _ = (flavour.check(), flavour.check_machine(&machine), flavour.check_machine(&odd));
            let options = &all[number % all.len()];
            let mut texts = vec![text.clone().into_bytes()];
            for flavour in [flavour.clone(), flavour.clone().for_machine(&machine), flavour.clone().for_machine(&odd)] {
                let mut outs = [Vec::new(), Vec::new(), Vec::new()];
                let [part, axis, strange] = &mut outs;
                let _ = write_flavour(moves.iter().copied(), &flavour, options, part);
                let _ = write_axis_moves(&machine, plan.iter().copied(), &flavour, options, axis);
                let _ = write_axis_moves(&odd, plan.iter().copied(), &flavour, &all[0], strange);
                texts.extend(outs);
                for (text, skip_others) in texts.iter().flat_map(|text| [(text, false), (text, true)]) {
                    let read = FlavourReadOptions { skip_others };
                    if let Ok(mut reader) = FlavourReader::new(&text[..], &flavour, read) {
                        reader.by_ref().take(99).for_each(drop);
                        reader.lines();
                    }
                    for machine in [&machine, &odd] {
                        if let Ok(mut reader) = AxisReader::new(&text[..], machine, &flavour, read) {
                            reader.by_ref().take(99).for_each(drop);
                            reader.lines();
                        }
                    }
                }
                texts.truncate(1);
            }
        }
    }
}
