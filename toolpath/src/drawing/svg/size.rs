//! How large a pixel of an SVG file is, and what else it may be.

use usvg::Tree;
use usvg::roxmltree::Document;

/// What a unit of an SVG file is in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SvgScale {
    /// The file says it; a pixel is 25.4 / 96 mm, as in CSS.
    Css,
    /// As many pixels are an inch, from 1 to 100,000. Lengths in millimetres, inches or points do not change.
    Dpi(f64),
    /// A unit of the drawing's coordinates is as many millimetres, above 0 and at most 1e6, whatever the file says.
    UnitMm(f64),
}

/// Pixels of an inch, by CSS.
pub(super) const CSS_DPI: f64 = 96.0;

/// Pixels of an inch that programs took, and which.
const OTHERS: [(f64, &str); 2] = [(72.0, "Adobe Illustrator"), (90.0, "Inkscape before 0.92")];

/// The size of a pixel.
pub(super) struct Found {
    pub pixel_mm: f64,
    /// Whether the file or the caller says so.
    pub is_stated: bool,
    /// What was assumed.
    pub note: Option<String>,
}

pub(super) fn find(document: &Document, tree: &Tree, scale: SvgScale) -> Found {
    let root = document.root_element();
    let view_box: Vec<f64> = root
        .attribute("viewBox")
        .map(|text| text.split([' ', ',']).filter_map(|word| word.trim().parse().ok()).collect())
        .unwrap_or_default();
    let [width, height] = [tree.size().width(), tree.size().height()].map(f64::from);
    match scale {
        SvgScale::Dpi(dpi) => Found { pixel_mm: 25.4 / dpi, is_stated: true, note: None },
        SvgScale::UnitMm(unit_mm) => {
            // Units of the view box that a pixel is, on the side that is not filled up.
            let units = match view_box[..] {
                [_, _, w, h] if w > 0.0 && h > 0.0 => (w / width).max(h / height),
                _ => 1.0,
            };
            Found { pixel_mm: unit_mm * units, is_stated: true, note: None }
        }
        SvgScale::Css => {
            let program = program_dpi(document);
            let pixels = view_box.len() != 4;
            let note = match [root.attribute("width"), root.attribute("height")].map(stated) {
                [None, _] | [_, None] => Some("its size is not stated"),
                [Some(true), Some(true)] if pixels && program.is_some() => Some("its coordinates are in pixels"),
                [Some(true), Some(true)] => None,
                _ => Some("its size is in pixels"),
            };
            let note = note.map(|what| assumed(what, [width, height], program));
            Found { pixel_mm: 25.4 / CSS_DPI, is_stated: note.is_none(), note }
        }
    }
}

/// Whether a length is stated in units of the world; `None`: it is not stated.
fn stated(length: Option<&str>) -> Option<bool> {
    let length = length?.trim();
    if length.ends_with('%') || !length.starts_with(|c: char| c.is_ascii_digit() || ['.', '+'].contains(&c)) {
        return None;
    }
    Some(["mm", "cm", "in", "pt", "pc", "Q", "q"].iter().any(|unit| length.ends_with(unit)))
}

/// The pixels of an inch that the program takes which wrote the file, if it is known for others than 96, and its name.
fn program_dpi(document: &Document) -> Option<(f64, String)> {
    let text = document.input_text();
    let begin: String = text.chars().take(2000).collect();
    if begin.contains("Adobe Illustrator") {
        return Some((72.0, "Adobe Illustrator".to_owned()));
    }
    let attribute = document.root_element().attributes().find(|attribute| {
        attribute.name() == "version" && attribute.namespace().is_some_and(|space| space.contains("inkscape"))
    });
    let comment = begin.split_once("Created with Inkscape").map(|(_, rest)| rest.trim_start());
    let version = attribute.map(|attribute| attribute.value()).or(comment)?;
    let minor: String = version.strip_prefix("0.")?.chars().take_while(char::is_ascii_digit).collect();
    (minor.parse::<u32>().ok()? < 92).then(|| (90.0, format!("Inkscape 0.{minor}")))
}

fn assumed(what: &str, pixels: [f64; 2], program: Option<(f64, String)>) -> String {
    let size = |dpi: f64| format!("{:.1} x {:.1} mm", pixels[0] * 25.4 / dpi, pixels[1] * 25.4 / dpi);
    let mut text = format!("{what}: 96 pixels were taken as an inch, which makes it {}", size(CSS_DPI));
    match program {
        Some((dpi, name)) => text += &format!("; {name}, which wrote it, has {dpi}, which makes it {}", size(dpi)),
        None => {
            for (dpi, name) in OTHERS {
                text += &format!("; with the {dpi} of {name} it is {}", size(dpi));
            }
        }
    }
    text
}
