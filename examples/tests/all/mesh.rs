//! Mesh files: sound ones in every format, and every way in which they can be unsound.

use curvlay_examples::mesh::{Mesh, MeshError, MeshFault, Place, Placement, Unit, Up, read_mesh, read_mesh_file};
use curvlay_examples::nalgebra::{self, Point3};
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
fn stl_is_known_by_its_length_and_welded() {
    assert_eq!(read("binary.stl", tetrahedron_stl("made here")).unwrap(), tetrahedron());
    assert_eq!(read("solid.STL", tetrahedron_stl("solid binary")).unwrap(), tetrahedron());
    assert_eq!(read("ascii.stl", ascii_stl()).unwrap(), tetrahedron());
    assert_eq!(read("shouting.stl", ascii_stl().to_uppercase().replace('\n', "\r\n")).unwrap(), tetrahedron());
    let minus = binary_stl("", &[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[-0.0; 3]; 3]]);
    // The second has all corners at one place: it is left out and named.
    let minus = read_mesh_file(&file("minus.stl", minus)).unwrap();
    assert_eq!(minus.mesh.triangles, [[0, 1, 2]]);
    let said = "faces without area were left out: 1 (first: triangle 2 (byte 134))";
    assert_eq!(minus.findings.iter().map(ToString::to_string).collect::<Vec<_>>(), [said]);
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
        "the header promises 4 triangles, which take 284 bytes, but the file has 200: cut short, or not an STL file; export it \
         anew"
    );
    // Two whole facets of four.
    assert!(complaint("cut-between.stl", &sound[..184]).contains("cut short"));
    let huge_and_cut = [&sound[..80], &[0xff; 4], &sound[84..250]].concat();
    assert!(complaint("huge.stl", huge_and_cut).contains("4294967295 triangles, which take 214748364834 bytes"));
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
    assert_eq!(complaint("half.stl", &text[..text.rfind("endloop").unwrap()]).split(": ").last(), Some("cut short"));
    assert!(complaint("alien.stl", "solid\nhello there\nendsolid").starts_with("line 2: `hello` has no place"));
}

#[test]
fn where_the_lines_of_ascii_stl_end_does_not_matter() {
    let whole = tetrahedron();
    let text = ascii_stl();
    // A facet a line; all facets in one line, with the name; a word a line but for the name and the corners.
    let facets = text.replace("\n    outer", " outer").replace("\n      vertex", " vertex");
    let facets = facets.replace("\n    endloop\n  endfacet", " endloop endfacet");
    assert_eq!(facets.lines().count(), 6);
    assert_eq!(read("facets.stl", &facets).unwrap(), whole);
    assert_eq!(read("one-line.stl", text.replace('\n', " ")).unwrap(), whole);
    assert_eq!(read("old-mac.stl", text.replace('\n', "\r").replacen('\r', "\n", 1)).unwrap(), whole);
    let words = text.replace("facet normal 0 0 0", "facet\nnormal 0\n0 0").replace("outer loop", "outer\nloop");
    assert!(complaint("words.stl", words).starts_with("line 3: `normal` has no place"));
    let named = text.replace("a part", "facet vertex solid endsolid");
    assert_eq!(read("named.stl", &named).unwrap(), whole);
    let two = [&text[..], &text.replace("a part", "another")].concat();
    assert_eq!(read("two-parts.stl", &two).unwrap().triangles.len(), 8);
    assert_eq!(
        complaint("two-in-one.stl", two.replace("endsolid a part\n", "endsolid a part ").replace("another\n", "b ")),
        "line 30: facets behind `endsolid`: the next part must begin in a line of its own"
    );
    assert_eq!(complaint("more.stl", text.replacen("3.5", "3.5 red", 1)), "line 13: `red` has no place in an STL file");
}

#[test]
fn byte_order_marks_are_passed_over_or_named() {
    let marked = |bytes: &[u8]| [b"\xef\xbb\xbf", bytes].concat();
    assert_eq!(read("marked.stl", marked(ascii_stl().as_bytes())).unwrap(), tetrahedron());
    let obj = "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n";
    assert_eq!(read("marked.obj", marked(obj.as_bytes())).unwrap(), read("plain.obj", obj).unwrap());
    assert_eq!(read("marked.obj", marked(obj.as_bytes())).unwrap().vertices.len(), 3);
    for (name, ply) in [("ascii", ascii_ply().into_bytes()), ("little", binary_ply(false)), ("big", binary_ply(true))] {
        let (with, without) = (format!("marked-{name}.ply"), format!("plain-{name}.ply"));
        assert_eq!(read(&with, marked(&ply)).unwrap(), read(&without, &ply).unwrap());
    }
    let cut = binary_ply(false);
    let place = |text: String| text.split(": ").next().unwrap().trim_start_matches("byte ").parse::<usize>().unwrap();
    let [plain, with] = [cut.clone(), marked(&cut)].map(|bytes| place(complaint("cut.ply", &bytes[..bytes.len() - 2])));
    assert_eq!(with, plain + 3);
    // A binary STL file may begin with anything.
    for mark in [&b"\xef\xbb\xbf"[..], b"\xff\xfe", b"\xfe\xff"] {
        let mut bytes = tetrahedron_stl("");
        bytes[..mark.len()].copy_from_slice(mark);
        assert_eq!(read("any-header.stl", bytes).unwrap(), tetrahedron());
    }
    let utf16 = |text: &str| [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let wide: Vec<u8> = utf16(obj);
    assert_eq!(complaint("wide.obj", wide), "the text is UTF-16: save it as UTF-8 or ASCII");
    let wide: Vec<u8> = utf16(&ascii_stl());
    assert_eq!(complaint("wide.stl", wide), "the text is UTF-16: save it as UTF-8 or ASCII");
    let wide: Vec<u8> = utf16(&ascii_ply());
    assert_eq!(complaint("wide.ply", wide), "the text is UTF-16: save it as UTF-8 or ASCII");
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
    assert_eq!(complaint("two.obj", format!("{v}f 1 2\n")), "the file holds no triangles");
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
    let two = read_mesh_file(&file("two.ply", text.replace("3 0 3 1", "2 0 3"))).unwrap();
    assert_eq!(two.findings[0].to_string(), "faces without area were left out: 1 (first: line 17)");
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
    assert!(matches!(read("part.mesh", "x").unwrap_err().fault, MeshFault::UnknownEnding));
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
    for up in [Up::X, Up::Y, Up::Z, Up::NegX, Up::NegY, Up::NegZ] {
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
            Up::NegX => [-2.0, 0.0, 0.0],
            Up::NegY => [0.0, -2.0, 0.0],
            Up::NegZ => [0.0, 0.0, -2.0],
        });
        mesh.vertices.push(top);
        let placement = Placement { unit: Unit::M, scale: 0.25, up, ..Placement::default() };
        assert_eq!(placement.apply(&mut mesh).unwrap(), <[String; 0]>::default());
        assert_eq!(mesh.vertices.pop(), Some(Point3::new(0.0, 0.0, 500.0)), "{up:?}");
        assert!((volume(&mesh) / before - 250.0_f64.powi(3)).abs() < 1e-3, "{up:?} keeps the sense of turning");
    }
}

#[test]
fn odd_sizes_are_doubted_and_huge_ones_refused() {
    // 3.5 long as it is.
    let of = |scale: f64, unit: Unit, allow_large: bool| {
        Placement { unit, scale, allow_large, ..Placement::default() }.apply(&mut tetrahedron())
    };
    let doubt = |scale: f64, unit: Unit| of(scale, unit, false).unwrap().pop();
    assert_eq!(doubt(10.0, Unit::Mm), None);
    let metres_or_inches = "is it in centimetres, metres or inches? use --unit cm, m or in";
    assert_eq!(doubt(0.01, Unit::Mm).unwrap(), format!("the longest side of the part is 0.035 mm: {metres_or_inches}"));
    // A part of 89 mm in inches.
    assert_eq!(doubt(1.0, Unit::Mm).unwrap(), format!("the longest side of the part is 3.5 mm: {metres_or_inches}"));
    assert_eq!((doubt(1.0, Unit::In), doubt(0.03, Unit::M)), (None, None));
    assert_eq!(doubt(1e-5, Unit::M).unwrap(), "the longest side of the part is 0.035 mm: is the scale right?");
    let large = "the longest side of the part is 3500 mm: is it in millimetres? leave --unit out";
    assert_eq!(doubt(1.0, Unit::M).unwrap(), large);

    for unit in [Unit::Mm, Unit::Cm, Unit::M, Unit::In] {
        let scale = 10_500.0 / 3.5 / unit.millimetres();
        let refused = of(scale, unit, false).unwrap_err();
        assert!(matches!(refused, MeshFault::TooLarge { longest_mm } if (longest_mm - 10_500.0).abs() < 1e-6));
        assert_eq!(
            refused.to_string(),
            "the longest side of the part is 10500 mm, more than 10000 mm: check --unit and --scale, or allow it with \
             --allow-large"
        );
        assert!(of(scale, unit, true).is_ok());
    }
    for scale in [1e308, 1e306] {
        assert!(matches!(of(scale, Unit::M, true), Err(MeshFault::Scale)));
    }
}

/// A part far away is the same part, to the last bit where its numbers allow.
#[test]
fn far_parts_are_moved_before_they_are_scaled() {
    let placement = Placement { unit: Unit::In, scale: 7.0, ..Placement::default() };
    let centred = |mut mesh: Mesh, by: [f64; 3]| {
        mesh.vertices.iter_mut().for_each(|p| *p += nalgebra::Vector3::from(by));
        let warnings = placement.apply(&mut mesh).unwrap();
        (mesh, warnings)
    };
    // The middle of the tetrahedron in x and y, at once and after a way.
    let (near, warnings) = centred(tetrahedron(), [-0.5, -1.0, 0.0]);
    assert!(warnings.is_empty());
    for by in [[1e8, 0.0, 0.0], [0.0, -1e8, 3e7], [0.0, 0.0, 1e8]] {
        let (far, warnings) = centred(tetrahedron(), by);
        assert_eq!(far, near);
        assert!(
            warnings[0].starts_with("the part lay ") && warnings[0].ends_with("it was moved there"),
            "{warnings:?}"
        );
    }
    // Within ten metres a part stays where it is.
    let (beside, warnings) = centred(tetrahedron(), [50.0, 0.0, 0.0]);
    assert!(warnings.is_empty());
    assert_eq!(beside.bounds().unwrap()[0], Point3::new(50.0 * (25.4 * 7.0), 0.0, 0.0));
}

#[test]
fn turned_facets_are_turned_back_and_one_sided_surfaces_refused() {
    let mut mesh = tetrahedron();
    mesh.triangles[2].swap(0, 1);
    mesh.triangles[3].swap(0, 1);
    let report = mesh.orient().unwrap();
    assert_eq!((report.turned_triangles, report.disagreeing_edges), (2, 4));
    let volume = curvlay_voxel::inspect::inspect(&mesh.vertices, &mesh.triangles).unwrap().signed_volume_mm3;
    assert!((volume - 3.5 / 3.0).abs() < 1e-12);
    // Five triangles in a ring with a half turn.
    let at = |k: u32| Point3::new(f64::from(k).cos(), f64::from(k).sin(), f64::from(k * k));
    let ring = (0..5).map(|k| [k, (k + 1) % 5, (k + 2) % 5]).collect();
    let refused = Mesh { vertices: (0..5).map(at).collect(), triangles: ring }.oriented().unwrap_err();
    assert!(
        matches!(refused, MeshFault::Orientation(_)) && refused.to_string().contains("one side alone"),
        "{refused}"
    );
}

#[test]
fn the_spacing_of_single_precision_is_that_at_the_farthest_corner() {
    let moved = |by: f64| {
        let mut mesh = tetrahedron();
        mesh.vertices.iter_mut().for_each(|p| p.x += by);
        mesh.float32_spacing()
    };
    assert_eq!(moved(0.0), Some(2.0_f64.powi(-22)));
    assert_eq!(moved(65_536.0), Some(2.0_f64.powi(-7)));
    assert_eq!(moved(1e8), None, "1e8 + 1 is no number of single precision");
    assert_eq!(moved(0.1), None);
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn the_bad_models_get_what_they_should() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/bad-models");
    let refused = [
        ("truncated.stl", "cut short"),
        ("nan-coords.stl", "coordinate"),
        ("empty.stl", "the file is empty"),
        ("not-an-stl.stl", "ZIP archive cannot be read"),
    ];
    for (name, part) in refused {
        let text = read_mesh(&folder.join(name)).unwrap_err().to_string();
        assert!(text.contains(part) && text.contains(name) && !text.contains('\n'), "{text}");
    }
    let loaded = ["wrong-count", "solid-header", "hole", "self-intersecting", "zero-area", "inside-out", "metres"];
    for name in loaded {
        let path = folder.join(name).with_extension("stl");
        let mut mesh = read_mesh(&path).unwrap();
        let triangles = (fs::metadata(&path).unwrap().len() - 84) / 50;
        let useless = if name == "zero-area" { 120 } else { 0 };
        assert_eq!(mesh.triangles.len() as u64, triangles - useless, "{name}");
        let warnings = Placement::default().apply(&mut mesh).unwrap();
        assert_eq!(!warnings.is_empty(), name == "metres", "{name}: {warnings:?}");
    }
}
