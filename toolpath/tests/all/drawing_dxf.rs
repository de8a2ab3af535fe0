//! DXF files as people have them: damaged, hidden, binary, in code pages, and as programs export them.

// Figures that are exact by construction are compared exactly.
#![allow(clippy::float_cmp)]

use super::drawing_files::{area, contours, file, read};
use curvlay_toolpath::drawing::{Drawing, DxfError, JoinError, Place, gaps, join, read_dxf, union_area};
use curvlay_toolpath::nalgebra::Point2;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// An entity that cannot be drawn is left out and named; what is sound is drawn. Until 0.1.0 each of them refused the whole file.
#[test]
fn damaged_entities_are_left_out_and_named() {
    let sound = "0 LINE 5 2F 8 A 10 0 20 0 11 3 21 4";
    for (entities, reported) in [
        ("0 CIRCLE 8 A 10 0 20 0 40 0", "1 CIRCLE (its radius is 0): line 20"),
        ("0 CIRCLE 5 30 8 A 10 0 20 NaN 40 1", "1 CIRCLE (`NaN` is not a finite number): line 28 (handle 30)"),
        ("0 CIRCLE 8 A 10 0 20 1e999 40 1", "1 CIRCLE (`1e999` is not a finite number): line 26"),
        ("0 CIRCLE 8 FAR 10 1e9 20 0 40 1", "1 CIRCLE (a coordinate is 1.00e9 mm, beyond"),
        ("0 LINE 8 A 10 0 20 0 11 1", "1 LINE (there is no value with group code 21): line 20"),
        ("0 LINE 8 A 10 7 20 7 11 7 21 7", "1 LINE (it has no length): line 20"),
        ("0 ELLIPSE 8 A 10 0 20 0 11 0 21 0 40 1", "1 ELLIPSE (its major axis has the length 0)"),
        ("0 LWPOLYLINE 8 A 10 0 20 0", "1 LWPOLYLINE (it has fewer than two vertices): line 20"),
        ("0 LWPOLYLINE 8 A 10 1 20 1 10 1 20 1", "1 LWPOLYLINE (it has no length)"),
        ("0 POLYLINE 8 A 0 VERTEX 10 1 20 1 0 SEQEND", "1 POLYLINE (it has fewer than two vertices)"),
        ("0 SPLINE 71 3 40 0 40 1 10 0 20 0 10 1 20 1", "SPLINE (a spline of degree 3 cannot have 2 control points)"),
        ("0 SPLINE 71 1 40 0 40 1 10 0 20 0 10 1 20 1", "SPLINE (the spline needs 4 knots and has 2)"),
        ("0 SPLINE 71 1 40 0 40 0 40 0 40 0 10 0 20 0 10 1 20 1", "knots of the spline must not fall"),
        ("0 SPLINE 71 1 40 0 40 0 40 1 40 1 41 1 41 0 10 0 20 0 10 1 20 1", "weights of the spline"),
        ("0 INSERT 2 NO 10 0 20 0", "1 INSERT (there is no block `NO`, or it is within itself): line 20"),
        ("0 CIRCLE 10 0 20 0 40 1 210 0 220 0 230 0", "CIRCLE (its extrusion has the length 0)"),
    ] {
        let drawing = read(&format!("{sound} {entities}"));
        assert_eq!(drawing.entities.len(), 1, "{entities}");
        assert_eq!(drawing.skipped.len(), 1, "{entities}");
        assert!(drawing.skipped[0].to_string().contains(reported), "{entities}: {}", drawing.skipped[0]);
        // Nothing else is a drawing of nothing, which names what was found.
        let alone = read(entities);
        assert_eq!((alone.entities.len(), alone.skipped_count()), (0, 1), "{entities}");
    }
}

/// Blocks: bad ones that nobody inserts are nobody's business; names without regard to case; cycles are left out wherever one enters
/// them.
#[test]
fn blocks_that_cannot_be_are_left_out() {
    let sound = "0 BLOCK 2 Leaf 0 CIRCLE 8 0 10 0 20 0 40 1 0 ENDBLK";
    let read = |blocks: &str, entities: &str| read_dxf(file(blocks, entities).as_bytes()).unwrap();
    let reported = |drawing: &Drawing| drawing.skipped.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    for blocks in [
        "0 BLOCK 2 BAD 10 x 20 0 0 CIRCLE 8 0 10 0 20 0 40 0 0 ENDBLK",
        "0 BLOCK 2 BAD 0 INSERT 2 NO 10 0 20 0 0 ENDBLK",
        "0 BLOCK 2 BAD 0 INSERT 2 BAD 10 0 20 0 0 ENDBLK",
    ] {
        let drawing = read(&format!("{blocks} {sound}"), "0 INSERT 2 LEAF 10 5 20 0 0 INSERT 2 leaf 10 9 20 0");
        assert_eq!((drawing.entities.len(), reported(&drawing)), (2, String::new()), "{blocks}");
    }
    let bad = read(
        &format!("0 BLOCK 2 BAD 10 x 20 0 0 LINE 10 0 20 0 11 1 21 1 0 ENDBLK {sound}"),
        "0 INSERT 2 BAD 10 0 20 0 0 INSERT 2 LEAF 10 0 20 0",
    );
    assert_eq!(bad.entities.len(), 1);
    assert!(
        reported(&bad).contains("INSERT (base point of the block `BAD`: `x` is not a finite number)"),
        "{}",
        reported(&bad)
    );
    // A and B in each other, C with one of them and a line of its own.
    let circle = "0 BLOCK 2 A 0 INSERT 2 B 10 0 20 0 0 LINE 8 0 10 0 20 0 11 1 21 1 0 ENDBLK 0 BLOCK 2 B 0 INSERT 2 A 10 0 20 0 0 ENDBLK \
                  0 BLOCK 2 C 0 INSERT 2 A 10 0 20 0 0 LINE 8 0 10 0 20 0 11 1 21 1 0 ENDBLK";
    for (name, drawn) in [("A", 1), ("B", 0), ("C", 1)] {
        let drawing = read(circle, &format!("0 INSERT 2 {name} 10 0 20 0"));
        assert_eq!(drawing.entities.len(), drawn, "{name}");
        assert!(reported(&drawing).contains("or it is within itself"), "{name}: {}", reported(&drawing));
    }
    // Scaled to nothing.
    let flat = read(sound, "0 INSERT 2 Leaf 10 0 20 0 41 0 42 0 0 INSERT 2 Leaf 10 0 20 0");
    assert_eq!((flat.entities.len(), reported(&flat).contains("CIRCLE (the radius is 0)")), (1, true));
    // 40 blocks in each other: the outermost are left out.
    let deep: String = (0..40)
        .map(|k| format!("0 BLOCK 2 B{k} 0 INSERT 2 B{} 10 0 20 0 0 LINE 8 0 10 0 20 0 11 1 21 1 0 ENDBLK ", k + 1))
        .collect();
    let deep = format!("{deep} 0 BLOCK 2 B40 0 LINE 8 0 10 0 20 0 11 1 21 1 0 ENDBLK");
    assert!(reported(&read(&deep, "0 INSERT 2 B0 10 0 20 0")).contains("more than 32 blocks in each other"));
    assert_eq!(read(&deep, "0 INSERT 2 B10 10 0 20 0").entities.len(), 31);
}

/// Files of a few lines that ask for any number of entities. What they would become is counted first: nothing here takes a time or memory
/// that could be measured.
#[test]
fn bombs_are_refused_before_they_are_placed() {
    let nested = |inner: &str| -> String {
        let blocks = (1..=12)
            .map(|k| format!("0 BLOCK 2 B{k} 0 INSERT 2 B{} 10 0 20 0 70 1000 71 900 44 1 45 1 0 ENDBLK ", k - 1));
        format!("0 BLOCK 2 B0 {inner} 0 ENDBLK {}", blocks.collect::<String>())
    };
    let insert = "0 INSERT 2 B12 10 0 20 0";
    let read = |inner: &str, entities: &str| read_dxf(file(&nested(inner), entities).as_bytes());
    let empty = read("", insert).unwrap();
    assert!(empty.entities.is_empty() && empty.skipped[0].what == "INSERT (the block `B0` is empty)", "{empty:?}");
    let texts = read("0 TEXT 1 x", insert).unwrap();
    assert_eq!((texts.entities.len(), texts.skipped[0].count), (0, usize::MAX));
    assert!(texts.skipped[0].to_string().starts_with("more than 1000000 TEXT"), "{}", texts.skipped[0]);
    let error = read("0 CIRCLE 8 0 10 0 20 0 40 1", insert).unwrap_err().to_string();
    assert!(error.contains("more than 1000000 segments, arcs and control points"), "{error}");
    let grid = "0 INSERT 2 B0 10 0 20 0 70 30000 71 30000";
    assert!(matches!(read("0 CIRCLE 8 0 10 0 20 0 40 1", grid), Err(DxfError::TooMany { .. })));
    // A long polyline in an array is no single entity.
    let corners: String = (0..2000).map(|k| format!("10 {k} 20 {} ", k % 2)).collect();
    let polyline = format!("0 LWPOLYLINE 8 0 {corners}");
    assert!(matches!(read(&polyline, "0 INSERT 2 B0 10 0 20 0 70 1000"), Err(DxfError::TooMany { .. })));
    assert_eq!(read(&polyline, "0 INSERT 2 B0 10 0 20 0 70 100 44 3000").unwrap().entities.len(), 100);
    // On a frozen layer it is nothing.
    let tables = "0 SECTION 2 TABLES 0 LAYER 2 F 70 1 0 ENDSEC".split(' ').collect::<Vec<_>>().join("\n");
    let frozen = format!("{tables}\n{}", file(&nested("0 CIRCLE 8 0 10 0 20 0 40 1"), "0 INSERT 8 F 2 B12 10 0 20 0"));
    assert_eq!(read_dxf(frozen.as_bytes()).unwrap().entities.len(), 0);
}

#[test]
fn damaged_files_are_refused_with_their_line() {
    let whole = file("", "0 LINE 8 A 10 0 20 0 11 1 21 1");
    for lines in 1..whole.lines().count() - 3 {
        let cut: String = whole.lines().take(lines).map(|line| line.to_owned() + "\n").collect();
        assert!(read_dxf(cut.as_bytes()).is_err(), "{lines}");
    }
    assert!(matches!(read_dxf("hello\nworld\n".as_bytes()), Err(DxfError::NoDxf { at: Place::Line(1) })));
    assert!(matches!(read_dxf("".as_bytes()), Err(DxfError::NoEntities)));
    assert!(read_dxf("1".repeat(200_000).as_bytes()).is_err());
}

/// Layers that are off or frozen, by colour and flag, without regard to case; blocks on them.
#[test]
fn hidden_layers_are_left_out_and_named() {
    let tables = "0 SECTION 2 TABLES 0 TABLE 2 LAYER 70 3 0 LAYER 2 CUT 70 0 62 7 0 LAYER 2 Hidden 70 0 62 -3 \
                  0 LAYER 2 FROZEN 70 1 62 2 0 ENDTAB 0 ENDSEC";
    let tables: String = tables.split_whitespace().map(|word| word.to_owned() + "\n").collect();
    let blocks = "0 BLOCK 2 B 0 CIRCLE 8 0 10 0 20 0 40 1 0 CIRCLE 8 CUT 10 0 20 0 40 2 0 CIRCLE 8 FROZEN 10 0 20 0 40 3 0 ENDBLK";
    let read = |entities: &str| {
        let drawing = read_dxf((tables.clone() + &file(blocks, entities)).as_bytes()).unwrap();
        let reported =
            drawing.skipped.iter().map(|skipped| format!("{} {}", skipped.count, skipped.what)).collect::<Vec<_>>();
        (drawing.layers(), reported.join(", "))
    };
    let line = |layer: &str| format!("0 LINE 8 {layer} 10 0 20 0 11 1 21 1 ");
    let (layers, reported) = read(&(line("CUT") + &line("HIDDEN") + &line("HIDDEN") + &line("frozen")));
    assert_eq!(layers, [("CUT".to_owned(), 1)]);
    assert_eq!(reported, "2 LINE (layer `HIDDEN` is off), 1 LINE (layer `frozen` is frozen)");
    let (layers, reported) = read("0 INSERT 8 CUT 2 B 10 0 20 0");
    assert_eq!((layers, reported.as_str()), (vec![("CUT".to_owned(), 2)], "1 CIRCLE (layer `FROZEN` is frozen)"));
    // On a layer that is off what is on other layers is shown; on a frozen one nothing.
    let (layers, reported) = read("0 INSERT 8 HIDDEN 2 B 10 0 20 0");
    assert_eq!(layers, [("CUT".to_owned(), 1)]);
    assert_eq!(reported, "1 CIRCLE (layer `FROZEN` is frozen), 1 CIRCLE (layer `HIDDEN` is off)");
    let (layers, reported) = read("0 INSERT 8 FROZEN 2 B 10 0 20 0");
    assert_eq!((layers, reported.as_str()), (Vec::new(), "1 INSERT (layer `FROZEN` is frozen)"));
}

/// Names in the code page of the header, in a text and a binary file.
#[test]
fn code_pages_are_decoded() {
    let text = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$DWGCODEPAGE\n3\nANSI_1252\n0\nENDSEC\n\
                0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n?ffnung\n10\n0\n20\n0\n11\n40\n21\n0\n0\nENDSEC\n0\nEOF\n";
    let bytes: Vec<u8> = text.bytes().map(|byte| if byte == b'?' { 0xd6 } else { byte }).collect();
    assert_eq!(read_dxf(bytes.as_slice()).unwrap().layers(), [("Öffnung".to_owned(), 1)]);
    let unknown = read_dxf(text.replace("ANSI_1252", "MARTIAN").as_bytes()).unwrap();
    assert_eq!(unknown.notes, ["the code page `MARTIAN` is unknown: names may be misread"]);
    // A byte order mark of UTF-8.
    assert!(read_dxf(("\u{feff}".to_owned() + text).as_bytes()).is_ok());
}

/// The oval of 80 by 60 mm through nine points, the last of which is the first.
#[test]
fn splines_by_fit_points_pass_through_them() {
    let points = |n: u32, repeat: bool| -> String {
        let place = |k: u32| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
            format!("11 {:.6} 21 {:.6} ", 40.0 * cos, 30.0 * sin)
        };
        (0..n + u32::from(repeat)).map(place).collect()
    };
    for (flags, repeat) in [(8, true), (9, true), (9, false)] {
        let spline = format!("0 SPLINE 8 0 70 {flags} 71 3 72 0 73 0 74 9 {}", points(8, repeat));
        let found = contours(&read(&spline), 1e-3);
        assert!((area(&found) - 1200.0 * PI).abs() < 0.01 * 1200.0 * PI, "{flags}: {}", area(&found));
        for k in 0..8 {
            let (sin, cos) = (TAU * f64::from(k) / 8.0).sin_cos();
            let at = Point2::new(40.0 * cos, 30.0 * sin);
            let nearest = found[0].points.iter().map(|p| (p - at).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-5, "{nearest}");
        }
    }
    // Open, with tangents: a half circle that begins upwards and ends downwards.
    let half = "0 SPLINE 8 0 70 8 71 3 74 5 12 0 22 1 13 0 23 -1 11 10 21 0 11 7.0710678 21 7.0710678 11 0 21 10 \
                11 -7.0710678 21 7.0710678 11 -10 21 0";
    let found = contours(&read(half), 1e-3);
    assert!(!found[0].closed);
    for p in &found[0].points {
        assert!((p.coords.norm() - 10.0).abs() < 0.05, "{p}");
    }
}

/// A text file as a binary one: by the table of the reference, and with the short codes of R12.
fn binary(text: &str, wide: bool) -> Vec<u8> {
    let mut out = b"AutoCAD Binary DXF\r\n\x1a\0".to_vec();
    let lines: Vec<&str> = text.lines().collect();
    for pair in lines.chunks(2) {
        let code: i16 = pair[0].parse().unwrap();
        match (wide, code) {
            (true, _) => out.extend(code.to_le_bytes()),
            (false, 0..255) => out.push(code as u8),
            (false, _) => {
                out.push(255);
                out.extend(code.to_le_bytes());
            }
        }
        match code {
            10..=59 | 210..=239 => out.extend(pair[1].parse::<f64>().unwrap().to_le_bytes()),
            60..=79 => out.extend(pair[1].parse::<i16>().unwrap().to_le_bytes()),
            90..=99 => out.extend(pair[1].parse::<i32>().unwrap().to_le_bytes()),
            160..=169 => out.extend(pair[1].parse::<i64>().unwrap().to_le_bytes()),
            290..=299 => out.push(pair[1].parse().unwrap()),
            310..=319 => {
                out.push(pair[1].len() as u8);
                out.extend(pair[1].bytes());
            }
            _ => {
                out.extend(pair[1].bytes());
                out.push(0);
            }
        }
    }
    out
}

#[test]
fn binary_files_are_read() {
    let blocks = "0 BLOCK 2 B 70 0 10 1 20 1 0 CIRCLE 5 2A 8 0 10 1 20 1 40 3 0 ENDBLK";
    let entities = "0 LWPOLYLINE 5 2B 8 A 90 3 70 1 10 0 20 0 42 1.5 10 4.25 20 0 10 4 20 -3 0 INSERT 8 TOP 2 b 10 7 20 8 41 2 \
                    0 TEXT 1 hello 160 99999999999 290 1 310 ABCD 1071 5 210 0 220 0 230 1 0 CIRCLE 5 2C 8 A 10 0 20 0 40 0";
    let entities = entities.replace("1071 5 ", "");
    let header = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n5\n0\nENDSEC\n";
    let text = header.to_owned() + &file(blocks, &entities);
    let expected = read_dxf(text.as_bytes()).unwrap();
    assert_eq!((expected.entities.len(), expected.unit_mm), (2, Some(10.0)));
    for wide in [true, false] {
        let bytes = binary(&text, wide);
        let drawing = read_dxf(bytes.as_slice()).unwrap();
        assert_eq!(drawing.layers(), expected.layers());
        for (a, b) in drawing.entities.iter().zip(&expected.entities) {
            assert_eq!((&a.kind, &a.curves, a.closed), (&b.kind, &b.curves, b.closed));
        }
        let reported: Vec<String> = drawing.skipped.iter().map(ToString::to_string).collect();
        assert!(
            reported[0].starts_with("1 CIRCLE (its radius is 0): byte ") && reported[0].ends_with("(handle 2C)"),
            "{reported:?}"
        );
        // Cut anywhere it is refused, but for its last pair.
        for length in 0..bytes.len() - 6 {
            assert!(read_dxf(&bytes[..length]).is_err(), "{wide} {length}");
        }
    }
    assert!(matches!(read_dxf(&b"AutoCAD Binary DXF\r\n\x1a\0"[..]), Err(DxfError::NoEntities)));
    let junk = [&b"AutoCAD Binary DXF\r\n\x1a\0"[..], &[7; 100_000]].concat();
    assert!(matches!(read_dxf(junk.as_slice()), Err(DxfError::NoDxf { at: Place::Byte(_) })));
}

/// Gaps that keep contours open are found with their width, and closed by joining with it.
#[test]
fn gaps_are_found_with_their_width() {
    let sides = "0 LINE 8 0 10 0 20 0 11 39.98 21 0 0 LINE 8 0 10 40 20 0 11 40 21 39.98 \
                 0 LINE 8 0 10 40 20 40 11 0.02 21 40 0 LINE 8 0 10 0 20 40 11 0 21 0.02";
    let pieces = contours(&read(sides), 0.01);
    let joined = join(&pieces, 0.005).unwrap().contours;
    let found = gaps(&joined, 0.5).unwrap();
    assert_eq!(found.len(), 4);
    assert!(found.iter().all(|gap| (gap.width - 0.02).abs() < 1e-9), "{found:?}");
    assert!(gaps(&joined, 0.019).unwrap().is_empty());
    let closed = join(&pieces, 0.021).unwrap().contours;
    assert!(closed.len() == 1 && closed[0].closed && gaps(&closed, 0.5).unwrap().is_empty());
    assert!(matches!(gaps(&joined, f64::NAN), Err(JoinError::Tolerance { .. })));
}

/// A file of `tests/fixtures/drawings`: written by hand as the program writes them.
fn export(name: &str) -> Drawing {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/drawings").join(name);
    read_dxf(std::fs::read(path).unwrap().as_slice()).unwrap()
}

/// What drawings look like that programs export: all their entities, areas by their formulas, and names of what is not drawn.
#[test]
fn exports_of_programs_are_read() {
    let reported = |drawing: &Drawing| drawing.skipped.iter().map(ToString::to_string).collect::<Vec<_>>();
    let printed = |drawing: &Drawing| {
        let joined = join(&contours(drawing, 1e-3), 0.005).unwrap().contours;
        assert!(joined.iter().all(|contour| contour.closed), "{joined:?}");
        (joined.len(), union_area(&joined).unwrap())
    };
    let near = |(count, area): (usize, f64), expected: (usize, f64), share: f64| {
        assert!(count == expected.0 && (area - expected.1).abs() < share * expected.1, "{count} {area}: {expected:?}");
    };
    // A rounded rectangle; each piece begins with a polyline of one vertex.
    let inkscape = export("inkscape-r14.dxf");
    near(printed(&inkscape), (1, 800.0 - (4.0 - PI) * 25.0), 1e-3);
    assert_eq!((inkscape.unit_mm, inkscape.layers().len()), (Some(1.0), 1));
    assert!(
        reported(&inkscape)[0].starts_with("5 LWPOLYLINE (it has fewer than two vertices): line "),
        "{:?}",
        reported(&inkscape)
    );

    let librecad = export("librecad-2007.dxf");
    near(printed(&librecad), (3, 1800.0 + PI * 225.0 + PI * 100.0 + PI * 50.0), 1e-3);
    assert_eq!(librecad.layers(), [("Außen".to_owned(), 4)]);
    let names = ["1 CIRCLE (its radius is 0): ", "1 LINE (layer `Hilfe` is frozen): ", "1 MTEXT: "];
    assert!(
        reported(&librecad).iter().zip(names).all(|(found, name)| found.starts_with(name)),
        "{:?}",
        reported(&librecad)
    );

    // Leaves of two arcs, inserted in another case; a frame that nobody inserts has a block that is missing.
    let r12 = export("cad-r12.dxf");
    let (count, _) = printed(&r12);
    assert_eq!((count, r12.unit_mm, reported(&r12).len()), (6, None, 1));
    assert!(reported(&r12)[0].starts_with("1 POINT: "), "{:?}", reported(&r12));

    // In inches.
    let today = export("cad-2018.dxf");
    near(printed(&today), (2, (2.0 * PI + PI) * 25.4 * 25.4), 0.01);
    let names = ["1 DIMENSION: ", "1 HATCH: ", "1 LINE (it has no length): ", "1 VIEWPORT (in paper space): "];
    assert!(reported(&today).iter().zip(names).all(|(found, name)| found.starts_with(name)), "{:?}", reported(&today));
    assert!(reported(&today)[2].ends_with("(handle B5)"));
}
