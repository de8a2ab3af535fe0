//! Mesh files as other programs write them: polygons, wrong counts, loose text, 3MF; and what can only be named.

use curvlay_examples::mesh::{Mesh, MeshFault, MeshFile, read_mesh, read_mesh_file};
use curvlay_examples::nalgebra::Point3;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::{fs, iter};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fn file(name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("formats-{name}"));
    fs::write(&path, bytes).unwrap();
    path
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> MeshFile {
    read_mesh_file(&file(name, bytes)).unwrap()
}

fn said(file: &MeshFile) -> Vec<String> {
    file.findings.iter().map(ToString::to_string).collect()
}

fn complaint(name: &str, bytes: impl AsRef<[u8]>) -> String {
    read_mesh_file(&file(name, bytes)).unwrap_err().fault.to_string()
}

/// A prism over an outline, all faces polygons that begin at the given corner.
fn prism(outline: &[[i32; 2]], first: usize) -> String {
    let count = outline.len();
    let mut text = String::new();
    for z in [0, 10] {
        outline.iter().for_each(|[x, y]| writeln!(text, "v {x} {y} {z}").unwrap());
    }
    let corner = |k: usize, level: usize| 1 + level * count + (k + first) % count;
    let face = |corners: Vec<usize>| corners.iter().fold("f".to_owned(), |text, corner| format!("{text} {corner}"));
    writeln!(text, "{}", face((0..count).map(|k| corner(k, 1)).collect())).unwrap();
    writeln!(text, "{}", face((0..count).rev().map(|k| corner(k, 0)).collect())).unwrap();
    for k in 0..count {
        writeln!(text, "{}", face(vec![corner(k, 0), corner(k + 1, 0), corner(k + 1, 1), corner(k, 1)])).unwrap();
    }
    text
}

/// The same as PLY.
fn as_ply(obj: &str) -> String {
    let lines = |kind: &'static str| obj.lines().filter_map(move |line| line.strip_prefix(kind));
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        lines("v ").count(),
        lines("f ").count()
    );
    lines("v ").for_each(|line| writeln!(text, "{line}").unwrap());
    for line in lines("f ") {
        let corners: Vec<usize> = line.split(' ').map(|corner| corner.parse::<usize>().unwrap() - 1).collect();
        let words: Vec<String> = iter::once(corners.len()).chain(corners).map(|word| word.to_string()).collect();
        writeln!(text, "{}", words.join(" ")).unwrap();
    }
    text
}

/// The triangles by the places of their corners, in order.
fn places(mesh: &Mesh) -> Vec<[[u64; 3]; 3]> {
    let place = |corner: u32| [0, 1, 2].map(|axis| mesh.vertices[corner as usize][axis].to_bits());
    let mut places: Vec<_> = mesh
        .triangles
        .iter()
        .map(|t| {
            let mut corners = t.map(place);
            let least = (0..3).min_by_key(|&k| corners[k]).unwrap();
            corners.rotate_left(least);
            corners
        })
        .collect();
    places.sort_unstable();
    places
}

#[test]
fn polygons_give_the_same_mesh_wherever_they_begin() {
    let l = [[0, 0], [24, 0], [24, 8], [8, 8], [8, 20], [0, 20]];
    let c = [[0, 0], [20, 0], [20, 6], [6, 6], [6, 14], [20, 14], [20, 20], [0, 20]];
    let u = [[0, 0], [20, 0], [20, 14], [15, 14], [15, 5], [5, 5], [5, 14], [0, 14]];
    let star = [[0, 20], [-4, 6], [-18, 6], [-7, -3], [-11, -16], [0, -8], [11, -16], [7, -3], [18, 6], [4, 6]];
    let area = |outline: &[[i32; 2]]| {
        let next = outline.iter().cycle().skip(1);
        f64::from(outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<i32>()) / 2.0
    };
    for (name, outline) in [("l", &l[..]), ("c", &c[..]), ("u", &u[..]), ("star", &star[..])] {
        let whole = read(&format!("{name}.obj"), prism(outline, 0));
        assert!(whole.findings.is_empty());
        assert!((whole.mesh.volume() - 10.0 * area(outline)).abs() < 1e-9, "{name}: {}", whole.mesh.volume());
        for first in 1..outline.len() {
            let text = prism(outline, first);
            assert_eq!(places(&read(&format!("{name}{first}.obj"), &text).mesh), places(&whole.mesh));
            assert_eq!(places(&read(&format!("{name}{first}.ply"), as_ply(&text)).mesh), places(&whole.mesh));
        }
    }
    let bow = prism(&[[0, 0], [20, 15], [20, 0], [0, 10]], 0);
    let found = said(&read("bow.obj", bow));
    assert!(found[0].starts_with("faces cross themselves") && found[0].contains(": 2 (first: line 9)"), "{found:?}");
}

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.5]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary_stl(count: u32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(count.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|&v| CORNERS[v]).flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

#[test]
fn the_length_of_a_binary_stl_file_decides() {
    let sound = read("sound.stl", binary_stl(4));
    assert!(sound.findings.is_empty());
    for count in [0, u32::MAX, 5, 3, 1] {
        let other = read(&format!("count{count}.stl"), binary_stl(count));
        assert_eq!(other.mesh, sound.mesh, "{count}");
        let amount = format!(": the header says {count}, the length of the file 4");
        assert!(said(&other)[0].ends_with(&amount), "{:?}", said(&other));
    }
    for (name, tail) in [("two.stl", &[7; 2][..]), ("fifty.stl", &[0; 50][..]), ("more.stl", &[1; 333][..])] {
        let other = read(name, [&binary_stl(4)[..], tail].concat());
        assert_eq!(other.mesh, sound.mesh);
        assert_eq!(said(&other), [format!("bytes behind the last triangle were passed over: {}", tail.len())]);
    }
    assert!(complaint("cut.stl", &binary_stl(4)[..270]).contains("cut short"));
    assert!(complaint("cut5.stl", &binary_stl(5)[..270]).contains("cut short"));
}

#[test]
fn loose_text_is_read_with_a_note() {
    let mut facets = String::new();
    for face in FACES {
        facets += "facet normal 0 0 0\nouter loop\n";
        face.iter()
            .for_each(|&v| writeln!(facets, "vertex {} {} {}", CORNERS[v][0], CORNERS[v][1], CORNERS[v][2]).unwrap());
        facets += "endloop\nendfacet\n";
    }
    let sound = read("sound-text.stl", format!("solid a\n{facets}endsolid a\n"));
    assert!(sound.findings.is_empty());
    let endless = read("endless.stl", format!("solid a\n{facets}"));
    assert_eq!((&endless.mesh, endless.findings.len()), (&sound.mesh, 1));
    let comment = read("comment.stl", format!("# exported today\n\n; by hand\nsolid a\n{facets}endsolid a\n"));
    assert_eq!(comment.mesh, sound.mesh);
    assert_eq!(said(&comment), ["lines before `solid` were passed over: 2"]);
    let bare = read("bare.stl", &facets);
    assert_eq!(bare.mesh, sound.mesh);
    assert!(complaint("cut-text.stl", format!("solid a\n{}", &facets[..facets.len() - 17])).contains("cut short"));
    // A backslash at the end of a comment is part of it.
    let slash = read(
        "slash.obj",
        "# C:\\models\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 \\\n3\nf 1 2 2 4\nf 1 2\nf 3 3 1\n",
    );
    assert_eq!((slash.mesh.vertices.len(), slash.mesh.triangles.len()), (4, 2));
    let found = said(&slash);
    assert_eq!(found[0], "faces without area were left out: 2 (first: line 9)");
    assert_eq!(found[1], "faces that name a corner twice in a row were read without the repeat: 1 (first: line 8)");
}

#[test]
fn strips_of_triangles_are_read_and_point_clouds_named() {
    let points = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let places = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    let strip = format!(
        "{points}element tristrips 1\nproperty list int int vertex_indices\nend_header\n{places}10 0 1 2 3 -1 0 2 3 1 -1\n"
    );
    let strip = read("strip.ply", strip);
    assert_eq!(strip.mesh.triangles, [[0, 1, 2], [2, 1, 3], [0, 2, 3], [3, 2, 1]]);
    let cloud = complaint("cloud.ply", format!("{points}end_header\n{places}"));
    assert_eq!(cloud, "this is a point cloud: 4 points without faces; export a mesh with faces");
    let empty = format!("{points}element face 0\nproperty list uchar int vertex_indices\nend_header\n{places}");
    assert!(complaint("faceless.ply", empty).contains("point cloud"));
}

/// Triangles without area: loose ones are left out by number, one that fills a slit stays.
#[test]
fn triangles_without_area_are_left_out_and_named() {
    let points = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nv 2 0 0\n";
    let loose = read("loose.obj", format!("{points}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 1 5 2\n"));
    assert_eq!(loose.mesh.triangles.len(), 4);
    assert_eq!(said(&loose), ["triangles without area were left out: 1 (first: triangle 5 of the mesh)"]);
    let slit = read("slit.obj", format!("{points}f 1 3 2\nf 1 5 4\nf 5 2 4\nf 1 4 3\nf 2 3 4\nf 1 2 5\n"));
    assert_eq!((slit.mesh.triangles.len(), slit.findings.len()), (6, 0));
}

const HEAD: &str = "<?xml version=\"1.0\"?><model unit=\"UNIT\" \
    xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
    xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\">";

/// A tetrahedron as an object.
fn object(id: u32) -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")).collect();
    let faces: String = FACES.iter().map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")).collect();
    format!("<object id=\"{id}\"><mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh></object>")
}

fn model(unit: &str, resources: &str, build: &str) -> String {
    let head = HEAD.replace("UNIT", unit);
    format!("{head}<resources>{resources}</resources><build>{build}</build></model>")
}

fn package(files: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, text) in files {
        zip.start_file(*name, options).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn threemf(model: &str) -> Vec<u8> {
    let rels = "<Relationships><Relationship Target=\"/3D/a.model\" Id=\"r\" \
                Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    package(&[("_rels/.rels", rels), ("3D/a.model", model)])
}

#[test]
fn packages_are_placed_as_they_say() {
    let plain = read("plain.3mf", threemf(&model("inch", &object(1), "<item objectid=\"1\"/>")));
    assert!(plain.states_unit && plain.findings.is_empty());
    let volume = 7.0 / 6.0 * 25.4_f64.powi(3);
    assert!((plain.mesh.volume() - volume).abs() < 1e-6 * volume);
    // By its content, whatever its name.
    let renamed = read("renamed.stl", threemf(&model("inch", &object(1), "<item objectid=\"1\"/>")));
    assert_eq!(renamed.mesh, plain.mesh);

    // A component that is turned and moved, in an item that mirrors it; a second item; one that is not to be printed.
    let group = "<object id=\"7\"><components><component objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 10 0 0\"/>\
                 </components></object><basematerials id=\"3\"/>";
    let build = "<item objectid=\"7\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 5\"/><item objectid=\"1\"/>\
                 <item objectid=\"1\" printable=\"0\"/>";
    let placed = read("placed.3mf", threemf(&model("millimeter", &(object(1) + group), build)));
    let corner = |at: [f64; 3]| placed.mesh.vertices.contains(&Point3::from(at));
    assert!(
        corner([-10.0, 1.0, 5.0]) && corner([-8.0, 0.0, 5.0]) && corner([-10.0, 0.0, 8.5]) && corner([0.0, 0.0, 3.5])
    );
    assert!((placed.mesh.volume() - 2.0 * 7.0 / 6.0).abs() < 1e-9, "the mirrored one looks outwards, too");
    let found = said(&placed);
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(
        found[1].contains("left out: 1 (object 1 (not to be printed))") && found[2].contains("materials"),
        "{found:?}"
    );

    // Objects in a file of their own.
    let build = "<item objectid=\"2\"/>";
    let parts = "<object id=\"2\"><components><component p:path=\"/3D/b.model\" objectid=\"1\"/></components></object>";
    let (outer, inner) = (model("millimeter", parts, build), model("millimeter", &object(1), ""));
    let spread = read("spread.3mf", package(&[("3D/a.model", &outer), ("3D/b.model", &inner)]));
    assert_eq!(spread.mesh.triangles.len(), 4);
}

#[test]
fn packages_that_mean_harm_are_refused() {
    let mut bomb = ZipWriter::new(Cursor::new(Vec::new()));
    bomb.start_file("3D/a.model", SimpleFileOptions::default()).unwrap();
    let blanks = vec![b' '; 1 << 20];
    (0..300).for_each(|_| bomb.write_all(&blanks).unwrap());
    let bomb = complaint("bomb.3mf", bomb.finish().unwrap().into_inner());
    assert_eq!(bomb, "/3D/a.model of the 3MF package would take more than 256 MiB");

    // Ten objects, each ten times the one before: ten thousand million triangles.
    let mut resources = object(1);
    for id in 2..=12 {
        let copies = format!("<component objectid=\"{}\"/>", id - 1).repeat(10);
        write!(resources, "<object id=\"{id}\"><components>{copies}</components></object>").unwrap();
    }
    let copies = complaint("copies.3mf", threemf(&model("millimeter", &resources, "<item objectid=\"12\"/>")));
    assert_eq!(copies, "the objects of the build would take more than 67,108,864 triangles");

    let itself = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    let itself = complaint("itself.3mf", threemf(&model("millimeter", itself, "<item objectid=\"1\"/>")));
    assert!(itself.contains("object 1 is part of itself"), "{itself}");
    let beyond = object(1).replace("v3=\"3\"", "v3=\"4\"");
    let beyond = complaint("beyond.3mf", threemf(&model("millimeter", &beyond, "<item objectid=\"1\"/>")));
    assert!(beyond.contains("object 1: triangle 2 names vertex 4 (from 0) of 4"), "{beyond}");
    let unit = complaint("unit.3mf", threemf(&model("cubit", &object(1), "<item objectid=\"1\"/>")));
    assert!(unit.contains("the unit `cubit` is not known"), "{unit}");
    let none = complaint("none.3mf", threemf(&model("millimeter", &object(1), "<item objectid=\"9\"/>")));
    assert!(none.contains("has no object 9"), "{none}");
    assert!(
        complaint("empty.3mf", threemf(&model("millimeter", &object(1), ""))).contains("the build holds no objects")
    );
    assert!(complaint("zip.3mf", package(&[("part.txt", "a")])).contains("unpack it first"));
    assert!(complaint("cut.3mf", &threemf(&model("millimeter", &object(1), ""))[..200]).contains("cannot be read"));
    assert!(complaint("text.3mf", "hello").contains("no 3MF file"));
}

#[test]
fn other_formats_are_named_by_their_content() {
    let cases: [(&str, &[u8], &str); 10] = [
        ("a.step", b"ISO-10303-21;\nHEADER;", "a STEP file"),
        ("step.stl", b"ISO-10303-21;\nHEADER;", "a STEP file"),
        ("a.amf", b"<?xml version=\"1.0\"?>\n<!-- made -->\n<amf unit=\"mm\">", "an AMF file"),
        ("a.off", b"OFF\n4 4 0\n", "an OFF file"),
        ("off.obj", b"OFF\n4 4 0\n", "an OFF file"),
        ("a.stl.gz", b"\x1f\x8b\x08\0\0\0", "a gzip archive: unpack it first"),
        ("html.stl", b"<!DOCTYPE html>\n<html>404</html>", "a web page"),
        ("page.stl", b"\xef\xbb\xbf\n <HTML><body>", "a web page"),
        ("pointer.stl", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a Git LFS pointer"),
        ("a.igs", &[&[b' '; 72][..], b"S      1\n"].concat(), "an IGES file"),
    ];
    for (name, bytes, what) in cases {
        let error = read_mesh(&file(name, bytes)).unwrap_err();
        assert!(matches!(error.fault, MeshFault::OtherFormat { .. }), "{name}: {error}");
        assert!(error.to_string().contains(what) && !error.to_string().contains('\n'), "{name}: {error}");
    }
}
