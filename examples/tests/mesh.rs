//! Mesh files: sound ones in every format, and every way in which they can be unsound.
#![allow(clippy::unwrap_used)]

use curvlay_examples::mesh::{Mesh, MeshError, MeshFault, Place, Placement, Unit, Up, read_mesh};
use curvlay_examples::nalgebra::Point3;
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

fn file(name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<Mesh, MeshError> {
    read_mesh(&file(name, bytes))
}

/// The message without the path; it must be one line.
fn complaint(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = read(name, bytes).unwrap_err();
    let text = error.to_string();
    assert!(!text.contains('\n') && text.len() < 500, "{text}");
    assert!(text.starts_with(&error.path.display().to_string()), "{text}");
    error.fault.to_string()
}

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.5]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn tetrahedron() -> Mesh {
    // In the order in which STL names the corners.
    let order = [0, 2, 1, 3];
    let vertices = order.map(|v| Point3::from(CORNERS[v].map(f64::from))).to_vec();
    let place = |v: usize| order.iter().position(|&o| o == v).unwrap() as u32;
    Mesh { vertices, triangles: FACES.iter().map(|face| face.map(place)).collect() }
}

fn binary_stl(header: &str, faces: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = format!("{header:80}").into_bytes();
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(face.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend([7, 7]);
    }
    bytes
}

fn tetrahedron_stl(header: &str) -> Vec<u8> {
    binary_stl(header, &FACES.map(|face| face.map(|v| CORNERS[v])))
}

fn ascii_stl() -> String {
    let mut text = "solid a part\n".to_owned();
    for face in FACES {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for v in face {
            let [x, y, z] = CORNERS[v];
            text += &format!("      vertex {x:e} {y} {z}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid a part\n"
}

#[test]
fn stl_is_told_by_its_length_and_welded() {
    assert_eq!(read("binary.stl", tetrahedron_stl("made here")).unwrap(), tetrahedron());
    assert_eq!(read("solid.STL", tetrahedron_stl("solid binary")).unwrap(), tetrahedron());
    assert_eq!(read("ascii.stl", ascii_stl()).unwrap(), tetrahedron());
    assert_eq!(read("shouting.stl", ascii_stl().to_uppercase().replace('\n', "\r\n")).unwrap(), tetrahedron());
    let minus = binary_stl("", &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[-0.0; 3]; 3]]);
    assert_eq!(read("minus.stl", minus).unwrap().triangles, [[0, 1, 2], [0, 0, 0]]);
}

#[test]
fn stl_complaints_name_the_place() {
    assert_eq!(complaint("empty.stl", ""), "the file is empty");
    assert_eq!(complaint("none.stl", binary_stl("", &[])), "the file holds no triangles");
    assert_eq!(complaint("no-facets.stl", "solid a\nendsolid a\n"), "the file holds no triangles");
    let sound = tetrahedron_stl("");
    let cut = complaint("cut.stl", &sound[..200]);
    assert_eq!(
        cut,
        "the header promises 4 triangles, which take 284 bytes, but the file has 200: cut short, or not an STL file"
    );
    assert!(complaint("long.stl", [&sound[..], &[0]].concat()).contains("bytes were added"));
    let huge = [&sound[..80], &[0xff; 4], &sound[84..]].concat();
    assert!(complaint("huge.stl", huge).contains("4294967295 triangles, which take 214748364834 bytes"));
    assert!(complaint("text.stl", "PK".repeat(300)).contains("not an STL file"));
    assert!(complaint("short.stl", "so").contains("not an STL file"));

    let at = 84 + 50 * 2 + 12 + 12 + 4;
    let nan = [&sound[..at], &f32::NAN.to_le_bytes(), &sound[at + 4..]].concat();
    assert_eq!(complaint("nan.stl", nan), "triangle 3 (byte 184): coordinate y of corner 2 is NaN");

    let text = ascii_stl();
    assert_eq!(complaint("word.stl", text.replacen("3.5", "x\u{7}y", 1)), "line 13: `x\\u{7}y` is not a number");
    assert_eq!(complaint("inf.stl", text.replacen("3.5", "1e999", 1)), "line 13: coordinate z of corner 3 is inf");
    assert_eq!(
        complaint("two.stl", text.replacen("vertex 0e0 0 3.5\n", "", 1)),
        "line 14: the facet has 2 corners, not 3"
    );
    assert_eq!(complaint("half.stl", &text[..text.len() / 2]).split(": ").last(), Some("cut short"));
    assert!(complaint("alien.stl", "solid\nhello there\nendsolid").starts_with("line 2: `hello` has no place"));
}

#[test]
fn stl_agrees_with_stl_io() {
    let path = file("oracle.stl", tetrahedron_stl("oracle"));
    let theirs = stl_io::read_stl(&mut fs::File::open(&path).unwrap()).unwrap();
    let ours = read_mesh(&path).unwrap();
    let their_corners: Vec<_> =
        theirs.faces.iter().flat_map(|face| face.vertices).map(|v| theirs.vertices[v].0.map(f64::from)).collect();
    let our_corners: Vec<[f64; 3]> =
        ours.triangles.iter().flatten().map(|&v| ours.vertices[v as usize].coords.into()).collect();
    assert_eq!(our_corners, their_corners);
}

#[test]
fn obj_faces_of_every_kind() {
    let text = "# a box side\nmtllib none.mtl\no part\nv 0 0 0\nv 1 0 0 # corner\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvt 0 0\n\
                vn 0 0 1\nf 1/1/1 2//1 3/1 4\nf -4 -3 \\\n -1\ns off\n";
    let mesh = read("kinds.obj", text).unwrap();
    assert_eq!(mesh.vertices.len(), 4);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 3]]);
    let (theirs, _) = tobj::load_obj(
        file("kinds2.obj", text.replace("\\\n", "").replace(" # corner", "").replace(" 0.5 0.5 0.5", "")),
        &tobj::LoadOptions { triangulate: true, ..Default::default() },
    )
    .unwrap();
    let theirs: Vec<[f32; 3]> = theirs
        .iter()
        .flat_map(|model| model.mesh.indices.iter().map(|&v| model.mesh.positions.as_chunks().0[v as usize]))
        .collect();
    let ours: Vec<[f32; 3]> =
        mesh.triangles.iter().flatten().map(|&v| mesh.vertices[v as usize].coords.map(|c| c as f32).into()).collect();
    assert_eq!(ours, theirs);
}

#[test]
fn obj_complaints_name_the_line() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    assert_eq!(complaint("nothing.obj", v), "the file holds no triangles");
    assert_eq!(complaint("beyond.obj", format!("{v}f 1 2 4\n")), "line 4: a face names vertex 4 of 3");
    assert_eq!(complaint("zero.obj", format!("{v}f 0 1 2\n")), "line 4: a face names vertex 0 of 3");
    assert_eq!(complaint("before.obj", format!("{v}f -4 1 2\n")), "line 4: a face names vertex -4 of 3");
    assert_eq!(complaint("least.obj", format!("{v}f -9223372036854775808 1 2\n")).split(": ").next(), Some("line 4"));
    assert_eq!(complaint("word.obj", format!("{v}f 1 2 b\n")), "line 4: `b` is not the number of a vertex");
    assert_eq!(complaint("two.obj", format!("{v}f 1 2\n")), "line 4: a face with 2 corners");
    assert_eq!(complaint("short.obj", "v 1 2\n"), "line 1: three coordinates are due");
    assert_eq!(complaint("nan.obj", "v 1 nan 2\n"), "line 1: coordinate y of corner 1 is NaN");
}

fn ply_header(format: &str, vertices: u64, faces: u64) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made here\nelement vertex {vertices}\nproperty float x\nproperty double y\n\
         property float z\nproperty uchar red\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ascii_ply() -> String {
    ply_header("ascii", 4, 2) + "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.5 9\n4 0 1 2 3\n3 0 3 1\n"
}

fn binary_ply(big: bool) -> Vec<u8> {
    let mut bytes = ply_header(if big { "binary_big_endian" } else { "binary_little_endian" }, 4, 2).into_bytes();
    let mut put = |le: &[u8]| if big { bytes.extend(le.iter().rev()) } else { bytes.extend(le) };
    for [x, y, z] in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]] {
        put(&x.to_le_bytes());
        put(&f64::from(y).to_le_bytes());
        put(&z.to_le_bytes());
        put(&[9]);
    }
    for face in [&[0_i32, 1, 2, 3][..], &[0, 3, 1]] {
        put(&[face.len() as u8]);
        face.iter().for_each(|v| put(&v.to_le_bytes()));
    }
    bytes
}

#[test]
fn ply_in_its_three_encodings() {
    let mesh = read("ascii.ply", ascii_ply()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
    assert_eq!(mesh.vertices[3], Point3::new(0.0, 1.0, 0.5));
    assert_eq!(read("little.ply", binary_ply(false)).unwrap(), mesh);
    assert_eq!(read("big.ply", binary_ply(true)).unwrap(), mesh);
}

#[test]
fn ply_complaints_name_the_place() {
    let text = ascii_ply();
    assert_eq!(
        complaint("beyond.ply", text.replace("3 0 3 1", "3 0 4 1")),
        "line 17: face 2 names vertex 4 (from 0) of 4"
    );
    assert_eq!(
        complaint("under.ply", text.replace("3 0 3 1", "3 0 -1 1")),
        "line 17: face 2 names vertex -1 (from 0) of 4"
    );
    assert_eq!(complaint("two.ply", text.replace("3 0 3 1", "2 0 3")), "line 17: face 2 has 2 corners");
    assert_eq!(
        complaint("nan.ply", text.replace("1 1 0 9", "1 nan 0 9")),
        "line 14: Couldn't read element line: `1 nan 0 9`"
    );
    assert_eq!(
        complaint("inf.ply", text.replace("1 1 0 9", "1 1e999 0 9")),
        "line 14: coordinate y of corner 3 is inf"
    );
    assert!(complaint("cut.ply", &text[..text.len() - 8]).starts_with("line 17: "));
    assert!(complaint("word.ply", text.replace("1 1 0 9", "1 b 0 9")).starts_with("line 14: "));
    assert!(complaint("other.ply", "hello\nthere").starts_with("line 1: "));
    assert!(complaint("headless.ply", "ply\nformat ascii 1.0\n").contains("end_header"));
    let binary = binary_ply(false);
    assert!(complaint("cut-binary.ply", &binary[..binary.len() - 2]).starts_with("byte "));
    let start = ply_header("binary_little_endian", 4, 2).len();
    let nan = [&binary[..start + 29], &f32::NAN.to_le_bytes(), &binary[start + 33..]].concat();
    let place = Place::Byte(start as u64);
    assert_eq!(complaint("nan-binary.ply", nan), format!("{place}: coordinate z of corner 2 is NaN"));
    let bytes = text.len() - ply_header("ascii", 4, 2).len();
    let lies = text.replace("element vertex 4", "element vertex 4294967295");
    assert_eq!(
        complaint("lies.ply", lies),
        format!("line 1: the header promises 4294967295 of `vertex` in {bytes} bytes")
    );
    let flat = text.replace("property float z\n", "");
    assert_eq!(complaint("flat.ply", flat), "line 1: the header has no number `z` of `vertex`");
    let strips = text.replace("vertex_indices", "strip");
    assert_eq!(
        complaint("strips.ply", strips),
        "line 1: the header has no list of whole numbers `vertex_indices` of `face`"
    );
    let bare = text.replace("element face 2", "element edge 9\nelement face 2");
    assert_eq!(complaint("bare.ply", bare), "line 1: the header gives `edge` no properties");
    let float = text.replace("list uchar int", "list uchar float");
    assert!(complaint("float.ply", float).contains("no list of whole numbers"));
    let listed = text.replace("property float z", "property list uchar float z");
    assert!(complaint("listed.ply", listed).contains("no number `z`"));
    let backwards = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\n\
                     property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
    assert!(complaint("backwards.ply", backwards).contains("faces before vertices"));
}

#[test]
fn what_is_no_mesh_file_is_refused() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("folder.stl");
    fs::create_dir_all(&folder).unwrap();
    assert!(matches!(read_mesh(&folder).unwrap_err().fault, MeshFault::NotAFile));
    let missing = read_mesh(Path::new("no/such/part.stl")).unwrap_err();
    assert!(matches!(missing.fault, MeshFault::Unreadable(_)), "{missing}");
    assert!(missing.to_string().starts_with("no/such/part.stl: cannot be read: "), "{missing}");
    assert!(matches!(read("part.step", "x").unwrap_err().fault, MeshFault::UnknownEnding));
    assert!(matches!(read("part", "x").unwrap_err().fault, MeshFault::UnknownEnding));
    assert_eq!(Place::Triangle(3, 184).to_string(), "triangle 3 (byte 184)");
}

proptest! {
    #[test]
    fn damaged_files_end_in_a_mesh_or_one_line(
        format in 0_usize..6,
        cut in 0_usize..2000,
        hits in prop::collection::vec((0_usize..2000, any::<u8>()), 0..4),
    ) {
        let (name, mut bytes) = match format {
            0 => ("damaged-0.stl", tetrahedron_stl("x")),
            1 => ("damaged-1.stl", ascii_stl().into_bytes()),
            2 => ("damaged-2.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//2 3\nf -1 -2 -3\n".to_vec()),
            3 => ("damaged-3.ply", ascii_ply().into_bytes()),
            4 => ("damaged-4.ply", binary_ply(false)),
            _ => ("damaged-5.ply", binary_ply(true)),
        };
        for (at, byte) in hits {
            let len = bytes.len();
            bytes[at % len] = byte;
        }
        // Every other case keeps its length.
        if cut % 2 == 0 {
            bytes.truncate(cut % bytes.len());
        }
        match read(name, &bytes) {
            Ok(mesh) => {
                prop_assert!(mesh.vertices.iter().all(|v| v.iter().all(|c| c.is_finite())));
                prop_assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.vertices.len()));
            }
            Err(error) => prop_assert!(!error.to_string().contains('\n') && error.to_string().len() < 500),
        }
    }
}

#[test]
fn placement_turns_right_handed() {
    for up in [Up::X, Up::Y, Up::Z] {
        let mut mesh = tetrahedron();
        let volume = |mesh: &Mesh| {
            let signed = mesh.triangles.iter().map(|t| {
                let [a, b, c] = t.map(|v| mesh.vertices[v as usize].coords);
                a.dot(&b.cross(&c)) / 6.0
            });
            signed.sum::<f64>()
        };
        let before = volume(&mesh);
        let top = Point3::from(match up {
            Up::X => [2.0, 0.0, 0.0],
            Up::Y => [0.0, 2.0, 0.0],
            Up::Z => [0.0, 0.0, 2.0],
        });
        mesh.vertices.push(top);
        let warning = Placement { unit: Unit::M, scale: 0.5, up }.apply(&mut mesh).unwrap();
        assert_eq!(warning, None);
        assert_eq!(mesh.vertices.pop(), Some(Point3::new(0.0, 0.0, 1000.0)), "{up:?}");
        assert!((volume(&mesh) / before - 500.0_f64.powi(3)).abs() < 1e-3, "{up:?} keeps the sense of turning");
    }
}

#[test]
fn odd_sizes_are_doubted() {
    let doubt =
        |factor: f64, unit: Unit| Placement { unit, scale: factor, up: Up::Z }.apply(&mut tetrahedron()).unwrap();
    assert_eq!(doubt(1.0, Unit::Mm), None);
    let small = doubt(0.01, Unit::Mm).unwrap();
    assert_eq!(small, "the longest side of the part is 0.035 mm: is it in metres or inches? use --unit m or --unit in");
    assert_eq!(doubt(1e-5, Unit::M).unwrap(), "the longest side of the part is 0.035 mm: is the scale right?");
    let large = doubt(3.0, Unit::M).unwrap();
    assert_eq!(large, "the longest side of the part is 10500 mm: is it in millimetres? leave --unit out");
    assert!(doubt(3000.0, Unit::Mm).unwrap().contains("is the scale right?"));
    let infinite = Placement { unit: Unit::M, scale: 1e308, up: Up::Z }.apply(&mut tetrahedron());
    assert!(matches!(infinite, Err(MeshFault::Scale)));
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn the_bad_models_get_what_they_should() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/bad-models");
    let refused = [
        ("truncated.stl", "cut short"),
        ("nan-coords.stl", "coordinate"),
        ("empty.stl", "the file is empty"),
        ("wrong-count.stl", "4294967295 triangles"),
        ("not-an-stl.stl", "not an STL file"),
    ];
    for (name, part) in refused {
        let text = read_mesh(&folder.join(name)).unwrap_err().to_string();
        assert!(text.contains(part) && text.contains(name) && !text.contains('\n'), "{text}");
    }
    let loaded = ["solid-header", "hole", "self-intersecting", "zero-area", "inside-out", "metres"];
    for name in loaded {
        let path = folder.join(name).with_extension("stl");
        let mut mesh = read_mesh(&path).unwrap();
        let triangles = (fs::metadata(&path).unwrap().len() - 84) / 50;
        assert_eq!(mesh.triangles.len() as u64, triangles, "{name}");
        let warning = Placement::default().apply(&mut mesh).unwrap();
        assert_eq!(warning.is_some(), name == "metres", "{name}: {warning:?}");
    }
}
