//! Random moves, and files in memory.

use curvlay_toolpath::gcode::{
    Dialect, DirectionWords, GcodeReader, Move, ReadError, ReadOptions, WriteError, WriteOptions, write_gcode,
};
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;

/// Moves alone: no header, no footer, nothing behind the last one.
pub const BARE: fn() -> WriteOptions<'static> =
    || WriteOptions { header: "", footer: "", end: None, ..WriteOptions::default() };

pub const COMMENT: Dialect = Dialect::Part(DirectionWords::Comment);
pub const IJK: Dialect = Dialect::Part(DirectionWords::Ijk);
pub const DISSERTATION: Dialect = Dialect::Part(DirectionWords::Dissertation);

/// All dialects in the frame of the part.
pub const DIALECTS: [Dialect; 3] = [COMMENT, IJK, DISSERTATION];

pub fn written(moves: &[Move], options: &WriteOptions<'_>) -> Result<String, WriteError> {
    let mut file = Vec::new();
    let written = write_gcode(moves.iter().copied(), options, &mut file)?;
    assert_eq!((written.bytes, written.moves), (file.len() as u64, moves.len() as u64));
    let file = String::from_utf8(file).unwrap();
    assert_eq!(written.lines, file.lines().count() as u64);
    Ok(file)
}

pub fn read_as(file: &str, dialect: Dialect) -> Result<Vec<Move>, ReadError> {
    GcodeReader::new(file.as_bytes(), ReadOptions { dialect, ..ReadOptions::default() })?.collect()
}

pub fn read(file: &str) -> Result<Vec<Move>, ReadError> {
    read_as(file, Dialect::default())
}

pub fn unit(x: f64, y: f64, z: f64) -> UnitVector3<f64> {
    UnitVector3::new_normalize(Vector3::new(x, y, z))
}

pub fn travel(tip: [f64; 3], direction: UnitVector3<f64>, feed_mm_s: f64) -> Move {
    Move::Travel { tip: tip.into(), direction, feed_mm_s }
}

pub fn print(tip: [f64; 3], direction: UnitVector3<f64>, filament_mm: f64, feed_mm_s: f64) -> Move {
    Move::Print { tip: tip.into(), direction, filament_mm, feed_mm_s }
}

pub fn place(item: &Move) -> Option<(Point3<f64>, UnitVector3<f64>)> {
    match *item {
        Move::Travel { tip, direction, .. } | Move::Print { tip, direction, .. } => Some((tip, direction)),
        _ => None,
    }
}

/// Directions over the whole sphere, the poles and the axes among them.
pub fn direction() -> impl Strategy<Value = UnitVector3<f64>> {
    let ball = prop::array::uniform3(-1.0..1.0f64).prop_filter("too short", |v| Vector3::from(*v).norm() > 0.1);
    let near_pole = (-1e-6..1e-6f64, -1e-6..1e-6f64, prop::sample::select(vec![1.0, -1.0]));
    prop_oneof![
        6 => ball.prop_map(|[x, y, z]| unit(x, y, z)),
        1 => near_pole.prop_map(|(x, y, z)| unit(x, y, z)),
        1 => prop::sample::select(vec![Vector3::x_axis(), -Vector3::y_axis(), Vector3::z_axis(), -Vector3::z_axis()]),
    ]
}

pub fn moves(reach: f64) -> impl Strategy<Value = Vec<Move>> {
    let tip = move || prop::array::uniform3(-reach..reach);
    let feed = || prop_oneof![0.001..1.0f64, 1.0..500.0f64, Just(30.0), Just(1e5)];
    let stroke = || prop_oneof![0.001..20.0f64, Just(0.001), 1e3..1e4f64];
    let bead = prop_oneof![8 => 0.0..3.0f64, 1 => Just(0.0), 1 => 0.0..1e-5f64, 1 => 500.0..2e3f64];
    let travels = move || (tip(), direction(), feed()).prop_map(|(tip, direction, feed)| travel(tip, direction, feed));
    let any = prop_oneof![
        8 => (tip(), direction(), bead, feed()).prop_map(|(tip, direction, by, feed)| print(tip, direction, by, feed)),
        3 => travels(),
        1 => (stroke(), feed()).prop_map(|(filament_mm, feed_mm_s)| Move::Retract { filament_mm, feed_mm_s }),
        1 => (stroke(), feed()).prop_map(|(filament_mm, feed_mm_s)| Move::Prime { filament_mm, feed_mm_s }),
        1 => (0.0..1e3f64).prop_map(|seconds| Move::Dwell { seconds }),
        1 => (0.0..500.0f64, any::<bool>()).prop_map(|(celsius, wait)| Move::Nozzle { celsius, wait }),
        1 => (0.0..200.0f64, any::<bool>()).prop_map(|(celsius, wait)| Move::Bed { celsius, wait }),
        1 => (0.0..=1.0f64).prop_map(|share| Move::Fan { share }),
    ];
    let later = prop::collection::vec((any, 0..20usize, travels()), 0..60);
    (travels(), later).prop_map(|(first, later)| {
        let mut all = vec![first];
        for (item, chance, first) in later {
            // Once in a while home, and from there on.
            if chance == 0 {
                all.extend([Move::Home, first]);
            }
            all.push(item);
        }
        all
    })
}
