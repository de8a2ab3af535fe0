//! SVG files: fill rules, layers, sizes, encodings, and what is not drawn.

// Figures that are exact by construction are compared exactly.
#![allow(clippy::float_cmp)]

use curvlay_toolpath::drawing::*;
use proptest::prelude::*;
use std::io::Write;

/// A drawing of 100 by 100 mm.
fn file(content: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
        xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" width="100mm" height="100mm" viewBox="0 0 100 100">{content}</svg>"#
    )
}

fn read(content: &str) -> Drawing {
    read_svg(file(content).as_bytes(), SvgOptions::default()).unwrap()
}

fn contours(drawing: &Drawing) -> Vec<Contour> {
    join(&drawing.contours(|_| true, Flatten::Tolerance(1e-3)).unwrap(), 0.005).unwrap().contours
}

/// The area that is printed.
fn area(drawing: &Drawing) -> f64 {
    let contours = contours(drawing);
    let overlaps = remove_overlaps(&contours, 0.0, 0.0).unwrap();
    let area = overlaps.regions.iter().map(Region::area).sum::<f64>();
    assert!((area - union_area(&contours).unwrap()).abs() < 1e-6 * area.max(1.0));
    area
}

fn reported(drawing: &Drawing) -> String {
    drawing.skipped.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

#[test]
fn outlines_of_a_path_are_filled_by_its_rule() {
    let squares = |rule: &str, inner: &str| format!(r#"<path {rule} d="M10 10H90V90H10Z {inner}"/>"#);
    // Down, then right: the other way round.
    let (same, reversed) = ("M30 30H70V70H30Z", "M30 30V70H70V30Z");
    for (rule, inner, expected) in [
        (r#"fill-rule="evenodd""#, same, 4800.0),
        (r#"fill-rule="evenodd""#, reversed, 4800.0),
        (r#"style="fill-rule:evenodd""#, same, 4800.0),
        ("", reversed, 4800.0),
        ("", same, 6400.0),
        // Without a fill each outline is filled by itself, as in DXF.
        (r#"fill="none" stroke="black""#, reversed, 6400.0),
    ] {
        let drawing = read(&squares(rule, inner));
        assert!((area(&drawing) - expected).abs() < 1e-2, "{rule} {inner}: {}", area(&drawing));
        if expected < 5000.0 {
            assert!((area_sum(&contours(&drawing)).unwrap() - expected).abs() < 1e-2);
        }
    }
    // A disc in the hole of another path stays, and so does what is in the disc.
    let disc = r#"<rect x="30" y="30" width="40" height="40"/>"#;
    assert!((area(&read(&(squares(r#"fill-rule="evenodd""#, same) + disc))) - 6400.0).abs() < 1e-2);
    // A star that crosses itself: its middle is open by one rule.
    let star =
        |rule: &str| area(&read(&format!(r#"<polygon fill-rule="{rule}" points="50,5 76,85 8,36 92,36 24,85"/>"#)));
    assert!(star("nonzero") > 1.3 * star("evenodd"));
}

#[test]
fn filled_paths_are_closed() {
    let drawing = read(
        r#"<path d="M10 10H90V90H10"/><polyline points="0,0 9,0 9,9"/><path fill="none" stroke="red" d="M0 0H9V9"/>
        <line x1="1" y1="1" x2="5" y2="5" stroke="red"/><path stroke="red" d="M0 50H9H20"/>"#,
    );
    let closed: Vec<bool> = drawing.entities.iter().map(|entity| entity.closed).collect();
    assert_eq!(closed, [true, true, false, false, false]);
    let kinds: Vec<&str> = drawing.entities.iter().map(|entity| entity.kind.as_str()).collect();
    assert_eq!(kinds, ["path", "polyline", "path", "line", "path"]);
    assert_eq!(drawing.entities[2].line, 2);
}

#[test]
fn layers_have_the_names_that_inkscape_shows() {
    let rect = |x: u32| format!(r#"<rect x="{x}" y="10" width="10" height="10"/>"#);
    let layer =
        |attributes: &str, content: &str| format!(r#"<g inkscape:groupmode="layer" {attributes}>{content}</g>"#);
    let inner = layer(r#"id="layer3" inkscape:label="Tür""#, &rect(30));
    let drawing = read(
        &[
            layer(r#"id="layer1" inkscape:label="Wand""#, &format!(r#"<g id="g7">{}</g>{inner}"#, rect(10))),
            layer(r#"id="layer2" inkscape:label="Hilfslinien" style="display:none""#, &rect(50)),
            layer(r#"inkscape:label="Boden""#, &rect(70)),
            format!(r#"<g id="plain">{}</g>{}"#, rect(20), rect(40)),
            format!(r#"<g id="other" display="none">{}</g>"#, rect(20)),
        ]
        .concat(),
    );
    let names: Vec<String> = drawing.layers().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["0", "Boden", "Tür", "Wand", "plain"]);
    assert_eq!(reported(&drawing), "1 rect (hidden): line 2; 1 rect (layer `Hilfslinien` is hidden): line 2");
}

/// Squares of 50 mm by programs that take other pixels for an inch: read too large or too small, and said so.
#[test]
fn sizes_in_pixels_are_named() {
    let size = |text: &str, scale: SvgScale| {
        let drawing = read_svg(text.as_bytes(), SvgOptions { scale }).unwrap();
        let points: Vec<f64> = contours(&drawing).iter().flat_map(|contour| &contour.points).map(|p| p.x).collect();
        let width = points.iter().copied().fold(f64::MIN, f64::max) - points.iter().copied().fold(f64::MAX, f64::min);
        (width, drawing.unit_mm.is_some(), drawing.notes.join(" "))
    };
    let svg = |attributes: &str, side: f64| {
        format!(r#"<svg xmlns="http://www.w3.org/2000/svg" {attributes}><rect width="{side}" height="{side}"/></svg>"#)
    };
    let at = |dpi: f64| 50.0 * dpi / 25.4;
    let adobe = svg(r#"width="283.465px" height="283.465px" viewBox="0 0 283.465 283.465""#, at(72.0));
    let (width, stated, note) = size(&adobe, SvgScale::Css);
    assert!((width - 37.5).abs() < 1e-3 && !stated);
    assert!(note.contains("in pixels") && note.contains("72 of Adobe Illustrator it is 100.0 x 100.0 mm"), "{note}");
    assert!((size(&adobe, SvgScale::Dpi(72.0)).0 - 50.0).abs() < 1e-3);
    assert!((size(&adobe, SvgScale::UnitMm(25.4 / 72.0)).0 - 50.0).abs() < 1e-3);
    let named = adobe.replace("<svg", "<!-- Generator: Adobe Illustrator 24.0 --><svg");
    assert!(size(&named, SvgScale::Css).2.contains("Adobe Illustrator, which wrote it, has 72"));

    let inkscape = r#"xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" inkscape:version="0.91 r13725""#;
    let old = svg(&format!(r#"{inkscape} width="354.33" height="354.33""#), at(90.0));
    let (width, stated, note) = size(&old, SvgScale::Css);
    assert!(
        (width - 46.875).abs() < 1e-3 && !stated && note.contains("Inkscape 0.91, which wrote it, has 90"),
        "{note}"
    );
    assert!((size(&old, SvgScale::Dpi(90.0)).0 - 50.0).abs() < 1e-3);
    // In millimetres, but its coordinates are pixels; one of today says so by a view box.
    let mixed = svg(&format!(r#"{inkscape} width="100mm" height="100mm""#), at(90.0));
    assert!(size(&mixed, SvgScale::Css).2.contains("its coordinates are in pixels"));
    let stated = svg(r#"width="10cm" height="100mm" viewBox="0 0 100 100""#, 50.0);
    let (width, is_stated, note) = size(&stated, SvgScale::Css);
    assert!((width - 50.0).abs() < 1e-3 && is_stated && note.is_empty(), "{note}");
    assert!((size(&stated, SvgScale::Dpi(72.0)).0 - 50.0).abs() < 1e-3);

    for attributes in [r#"viewBox="0 0 100 100""#, r#"width="100%" height="100%" viewBox="0 0 100 100""#] {
        let (width, stated, note) = size(&svg(attributes, 50.0), SvgScale::Css);
        assert!((width - 50.0 * 25.4 / 96.0).abs() < 1e-3 && !stated && note.contains("not stated"), "{note}");
        assert!((size(&svg(attributes, 50.0), SvgScale::UnitMm(1.0)).0 - 50.0).abs() < 1e-3);
    }
    for scale in [SvgScale::Dpi(0.0), SvgScale::Dpi(f64::NAN), SvgScale::UnitMm(-1.0), SvgScale::UnitMm(1e308)] {
        assert!(matches!(read_svg(stated.as_bytes(), SvgOptions { scale }), Err(SvgError::Scale { .. })));
    }
}

#[test]
fn what_is_not_drawn_is_named() {
    let drawing = read(
        r##"<defs><text>no</text><clipPath id="c"><rect width="5" height="5"/></clipPath></defs>
        <text id="t1">ABC</text><circle id="c1" cx="5" cy="5" r="0"/><path id="p1" d="M0 0"/><rect width="9" height="9" fill="none"/>
        <g clip-path="url(#c)"><rect width="9" height="9"/></g><style>.off { display: none }</style><rect class="off" width="3" height="3"/>
        <use xlink:href="#gone"/>"##,
    );
    let reported = reported(&drawing);
    for part in [
        "1 text (convert it to paths): line 3 (id t1)",
        "1 circle (without extent, damaged, or hidden): line 3 (id c1)",
        "1 path (without extent, damaged, or hidden): line 3 (id p1)",
        "1 rect (invisible): line 3",
        "1 rect (without extent, damaged, or hidden): line 4",
    ] {
        assert!(reported.contains(part), "{part}: {reported}");
    }
    assert_eq!((drawing.entities.len(), drawing.skipped_count()), (1, 5), "{reported}");
    assert_eq!(drawing.notes, ["clip paths and masks are not applied, what they cut off is drawn: 1"]);
}

/// An image that refers to something outside of the file: it is not opened, however it is written.
#[test]
fn nothing_outside_is_opened() {
    for target in ["/dev/zero", "file:///dev/zero", "/dev/stdin"] {
        for attribute in ["href", "xlink:href"] {
            let drawing = read(&format!(
                r#"<circle cx="50" cy="50" r="30"/><image width="10" height="10" {attribute}="{target}"/>"#
            ));
            assert_eq!((drawing.entities.len(), reported(&drawing).as_str()), (1, "1 image: line 2"));
        }
    }
}

#[test]
fn encodings_and_compression_are_read() {
    let group = r#"<g id="Gehäuse"><rect width="9" height="9"/></g>"#;
    let text = file(group);
    let options = SvgOptions::default();
    let named = |bytes: &[u8]| read_svg(bytes, options).unwrap().layers();
    let expected = [("Gehäuse".to_owned(), 1)];
    let latin1 = |text: &str| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<u8>>();
    for name in ["ISO-8859-1", "latin1", "windows-1252"] {
        let declared = format!("<?xml version=\"1.0\" encoding=\"{name}\"?>\n{text}");
        assert_eq!(named(&latin1(&declared)), expected, "{name}");
        assert_eq!(
            named(&latin1(&declared.replace('"', "'").replace("='Gehäuse'", "=\"Gehäuse\""))),
            expected,
            "{name}"
        );
    }
    let utf16: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(named(&utf16), expected);
    let mut zip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    zip.write_all(text.as_bytes()).unwrap();
    let zipped = zip.finish().unwrap();
    assert_eq!(named(&zipped), expected);
    assert!(read_svg(&zipped[..zipped.len() / 2], options).unwrap_err().to_string().contains("its compression"));
    // Latin-1 that calls itself nothing; a name that there is not.
    assert!(read_svg(&latin1(&text), options).unwrap_err().to_string().contains("bytes that are not UTF-8"));
    let martian = format!("<?xml version=\"1.0\" encoding=\"martian\"?>{text}");
    assert!(matches!(read_svg(martian.as_bytes(), options), Err(SvgError::Encoding { name }) if name == "martian"));
    // 100 MB of blanks in 100 kB.
    let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    (0..100).for_each(|_| bomb.write_all(&[b' '; 1 << 20]).unwrap());
    assert!(matches!(read_svg(&bomb.finish().unwrap(), options), Err(SvgError::TooLarge { .. })));
}

/// Found: such an arc was taken apart into curves until the memory was full.
#[test]
fn numbers_without_end_are_refused() {
    let far = "2".repeat(70);
    for shape in [
        &*format!(r#"<path d="M0 0 V{far} A2 2 0 1 1 9 9"/>"#),
        r#"<path d="M0 0 a1e99 1e99 0 1 1 9 9"/>"#,
        r#"<path d="M0 0 h1e308 h1e308 A2 2 0 1 1 9 9"/>"#,
        r#"<circle r="1e30"/>"#,
        r#"<ellipse rx="1e30" ry="2"/>"#,
        r#"<g font-size="1e30"><rect width="1e30" height="1" rx="1em"/></g>"#,
        r#"<symbol viewBox="0 0 1e30 9"><circle r="9%"/></symbol>"#,
    ] {
        let refused = read_svg(file(&format!("\n{shape}")).as_bytes(), SvgOptions::default());
        assert!(matches!(refused, Err(SvgError::TooFar { line: 3, .. })), "{shape}: {refused:?}");
    }
    for way in ["M9 1e99", "L1e99 9", "H1e99", "C1e99 9 9 9 9 9", "S9 9 9 1e99", "Q9 9 1e99 9", "T9 1e99"] {
        let shape = format!(r#"<path d="M0 0 {way} A2 2 0 1 1 9 9"/>"#);
        let refused = read_svg(file(&shape).as_bytes(), SvgOptions::default());
        assert!(matches!(refused, Err(SvgError::TooFar { line: 2, .. })), "{shape}: {refused:?}");
    }
    // What is drawn up to an error, and large numbers elsewhere, do no harm.
    for shape in [r#"<path d="M0 0 A2 2 0 1 1 9 9 x1e99"/>"#, r#"<circle r="2" id="p1e99"/>"#] {
        assert_eq!(read(shape).entities.len(), 1, "{shape}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Whatever a file contains, it is read or refused, and what is read can be drawn.
    #[test]
    fn no_file_panics(parts in proptest::collection::vec(r##"(<g( id="a"| display="none")?>|</g>|<path d="[MLHVCQAZ0-9. -]{0,20}"/>|<use href="#a"/>|<circle r="(0|1e30|nan|5)"/>|<text>x</text>|<!--x-->|&lt;)"##, 0..12)) {
        if let Ok(drawing) = read_svg(file(&parts.concat()).as_bytes(), SvgOptions::default()) {
            let flat = drawing.contours(|_| true, Flatten::default());
            prop_assert!(drawing.entities.is_empty() || flat.is_ok(), "{:?}", flat);
        }
    }
}

/// A drawing as Inkscape 1.2 writes it.
#[test]
fn an_export_of_inkscape_is_read() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/drawings/inkscape-1.svg");
    let drawing = read_svg(&std::fs::read(path).unwrap(), SvgOptions::default()).unwrap();
    assert_eq!(drawing.layers(), [("Text".to_owned(), 1), ("Umriß".to_owned(), 3)]);
    // A frame, a disc, and a triangle without Z, which its clip path would cut off.
    let expected = 3600.0 - 1600.0 + 25.0 * std::f64::consts::PI + 50.0;
    assert!((area(&drawing) - expected).abs() < 0.1, "{}", area(&drawing));
    let expected =
        "1 rect (layer `Notizen` is hidden): line 59 (id rect9); 1 text (convert it to paths): line 70 (id text21)";
    assert_eq!(reported(&drawing), expected);
    assert!(drawing.unit_mm.is_some() && drawing.notes.len() == 1, "{:?}", drawing.notes);
}
