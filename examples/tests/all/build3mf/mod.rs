//! Builds in 3MF: written, read back, judged by the rules of the format, and damaged.

mod faults;
mod package;
mod plan;
mod round_trip;
mod rules;

use curvlay_examples::build3mf::{
    BuildOptions, BuildReader, Line, Profile, ReadBuildError, Section, Segment, SegmentKind, frame_at, write_build,
};
use curvlay_examples::mesh::Mesh;
use curvlay_toolpath::nalgebra::{Isometry3, Point3, UnitVector3, Vector3, distance};
use curvlay_toolpath::path::BeadKind;
use proptest::prelude::*;
use std::io::{Cursor, Read, Write};
use zip::{ZipArchive, ZipWriter};

/// A tetrahedron whose corners have many digits.
fn mesh() -> Mesh {
    let corners = [[0.1, 0.2, 0.0], [10.0 / 3.0, 0.0, 1e-9], [-1.7, 12.345678901234567, 0.0], [0.3, 0.4, 5.5]];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    Mesh { vertices: corners.map(Point3::from).to_vec(), triangles }
}

fn written(segments: &[Segment], travels: bool) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = BuildOptions { name: "a <part> & \"more\"", travels };
    let counts = write_build(&mesh(), || segments.iter().cloned(), &options, &mut file).unwrap();
    let kept: Vec<&Segment> =
        segments.iter().filter(|segment| travels || segment.kind != SegmentKind::Travel).collect();
    let lines: usize = kept.iter().map(|segment| segment.lines.len()).sum();
    assert_eq!((counts.segments, counts.lines), (kept.len(), lines));
    file.into_inner()
}

/// All segments of a file, with its profiles.
fn read(bytes: &[u8]) -> Result<(Vec<Profile>, Vec<Segment>), ReadBuildError> {
    let mut reader = BuildReader::open(Cursor::new(bytes))?;
    let (profiles, layers) = (reader.profiles().to_vec(), reader.layers().to_vec());
    let mut all = Vec::new();
    for (at, part) in layers.iter().enumerate() {
        let segments = reader.read_layer(at)?.unwrap();
        all.extend(segments.into_iter().map(|segment| {
            let profile = profiles[segment.profile].clone();
            segment.as_written(&profile, part).unwrap()
        }));
    }
    assert!(reader.read_layer(layers.len()).unwrap().is_none());
    Ok((profiles, all))
}

/// Names and texts of the parts of a package, by the ZIP reader alone.
fn parts(bytes: &[u8]) -> Vec<(String, String)> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let part = |at| {
        let mut file = archive.by_index(at).unwrap();
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        (file.name().unwrap().into_owned(), text)
    };
    (0..ZipArchive::new(Cursor::new(bytes)).unwrap().len()).map(part).collect()
}

/// A package of these parts.
fn package_of(parts: &[(String, String)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in parts {
        archive.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(text.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A segment of one wall of two lines, of different sizes and speeds.
fn wall() -> Segment {
    let at = |x: f64| frame_at(Point3::new(x, 2.0, 0.3), UnitVector3::new_normalize(Vector3::new(0.1 * x, 0.2, 1.0)));
    let section = |width_mm| Section { width_mm, height_mm: 0.3 };
    let line = |x, from, to, speed: f64| Line {
        end: at(x),
        bead: Some([section(from), section(to)]),
        speed_mm_s: Some(speed),
        seconds: 1.0 / speed,
    };
    Segment {
        layer: 0,
        path: 0,
        kind: SegmentKind::Bead(BeadKind::Wall),
        start: at(0.0),
        lines: vec![line(1.0, 0.4, 0.5, 10.0), line(2.0, 0.5, 0.5, 20.0)],
        filament_mm: 0.1,
        prime_mm: 1.0,
        retract_mm: 2.0,
    }
}

/// A travel behind it, with a turn on the spot.
fn travel() -> Segment {
    let from = wall().lines[1].end;
    let up = |z, lean| frame_at(Point3::new(2.0, 2.0, z), UnitVector3::new_normalize(Vector3::new(lean, 0.0, 1.0)));
    let lines = vec![
        Line { end: up(5.0, 0.0), bead: None, speed_mm_s: Some(80.0), seconds: 4.7 / 80.0 },
        Line { end: up(5.0, 0.7), bead: None, speed_mm_s: None, seconds: 0.25 },
    ];
    Segment {
        layer: 1,
        path: 1,
        kind: SegmentKind::Travel,
        start: from,
        lines,
        filament_mm: 0.0,
        prime_mm: 0.0,
        retract_mm: 0.0,
    }
}

fn kinds() -> impl Strategy<Value = SegmentKind> {
    use BeadKind::*;
    let beads = prop::sample::select(vec![Wall, Solid, Skin, Bridge, Infill, Support, SparseSupport, SupportBridge]);
    prop_oneof![1 => Just(SegmentKind::Travel), 4 => beads.prop_map(SegmentKind::Bead)]
}

fn direction() -> impl Strategy<Value = UnitVector3<f64>> {
    let vector = [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_map(Vector3::from);
    let some = vector.prop_filter_map("no direction", |vector| UnitVector3::try_new(vector, 1e-3));
    prop_oneof![8 => some, 1 => Just(Vector3::z_axis()), 1 => Just(-Vector3::z_axis()), 1 => Just(Vector3::x_axis())]
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    let reach = 1000.0;
    ([-reach..reach, -reach..reach, -10.0..reach], direction())
        .prop_map(|(place, direction)| frame_at(Point3::from(place), direction))
}

/// What a line is made of: its end, sizes, speed, and whether the tip stands.
type Drawn = (Isometry3<f64>, [f64; 4], f64, bool);

fn drawn() -> impl Strategy<Value = Drawn> {
    let size = || prop_oneof![Just(0.5), 0.01..5.0_f64];
    (pose(), [size(), size(), size(), size()], prop_oneof![Just(30.0), 0.01..500.0_f64], prop::bool::weighted(0.1))
}

fn lines(kind: SegmentKind, start: Isometry3<f64>, drawn: Vec<Drawn>) -> Vec<Line> {
    let mut at = start;
    let mut lines = Vec::new();
    for (end, [w1, h1, w2, h2], speed, stands) in drawn {
        let end = if stands { Isometry3::from_parts(at.translation, end.rotation) } else { end };
        let bead = [(w1, h1), (w2, h2)].map(|(width_mm, height_mm)| Section { width_mm, height_mm });
        let bead = (kind != SegmentKind::Travel).then_some(bead);
        let length = distance(&Point3::from(at.translation.vector), &Point3::from(end.translation.vector));
        let (speed_mm_s, seconds) = if stands { (None, speed / 100.0) } else { (Some(speed), length / speed) };
        lines.push(Line { end, bead, speed_mm_s, seconds });
        at = end;
    }
    lines
}

/// Segments of a print: layers that go up now and then, filament that comes and goes.
fn print() -> impl Strategy<Value = Vec<Segment>> {
    let amount = || prop_oneof![2 => Just(0.0), 1 => 0.0..9.0_f64];
    let one = (kinds(), pose(), prop::collection::vec(drawn(), 1..12), 0..3_u32, [amount(), amount(), amount()]);
    prop::collection::vec(one, 1..12).prop_map(|all| {
        let mut layer = 0;
        let mut segments = Vec::new();
        for (path, (kind, start, drawn, up, [filament_mm, prime_mm, retract_mm])) in (0..).zip(all) {
            layer += up;
            let lines = lines(kind, start, drawn);
            segments.push(Segment { layer, path, kind, start, lines, filament_mm, prime_mm, retract_mm });
        }
        segments
    })
}
