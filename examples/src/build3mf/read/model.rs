//! The model part: profiles, layers and items of the build.

use super::attributes::Element;
use super::data::LayerPart;
use super::error::ReadBuildError;
use super::package::parse;
use crate::build3mf::names::{OURS, PRODUCTION, TOOLPATH, kind_of, unit_mm};
use crate::build3mf::profile::{Profile, Range};
use roxmltree::Node;
use std::collections::BTreeSet;

/// What layers refer to.
pub(super) struct Model {
    /// Millimetres of a step of a coordinate.
    pub(super) step_mm: f64,
    pub(super) profiles: Vec<Profile>,
    /// Attribute and granularity of each factor of each profile.
    pub(super) modifiers: Vec<Modifiers>,
    pub(super) layers: Vec<LayerPart>,
    /// UUIDs of the items of the build.
    pub(super) items: BTreeSet<String>,
}

/// What the factors `e`, `f`, `g` and `h` of a profile stand for.
pub(super) type Modifiers = [Option<Modifier>; 4];

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Modifier {
    pub(super) of: Quantity,
    /// Whether lines may give two values.
    pub(super) is_linear: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Width,
    Height,
    Speed,
}

const QUANTITIES: [(&str, Quantity); 4] = [
    ("beadwidth", Quantity::Width),
    ("beadheight", Quantity::Height),
    ("depositionspeed", Quantity::Speed),
    ("jumpspeed", Quantity::Speed),
];

pub(super) const FACTORS: [&str; 4] = ["e", "f", "g", "h"];

pub(super) fn read(part: &str, text: &str) -> Result<Model, ReadBuildError> {
    let document = parse(part, text)?;
    let root = document.root_element();
    for prefix in root.attribute("requiredextensions").unwrap_or("").split_whitespace() {
        let namespace = root.lookup_namespace_uri(Some(prefix)).unwrap_or(prefix);
        if ![PRODUCTION, TOOLPATH, OURS].contains(&namespace) {
            return Err(ReadBuildError::Extension { part: part.to_owned(), namespace: namespace.to_owned() });
        }
    }
    let unit = root.attribute("unit").unwrap_or("millimeter");
    let unit_mm = unit_mm(unit).ok_or_else(|| {
        let root = Element { part, node: root, place: &|| "model".to_owned() };
        root.wrong("unit", Some(unit), "a unit of the core specification")
    })?;
    let resource = resource(part, root)?;
    let element = Element { part, node: resource, place: &|| "toolpathresource".to_owned() };
    match element.node.attribute("toolpathtype") {
        Some("6axis") => {}
        other => {
            let what = format!("a toolpath of type `{}`", other.unwrap_or("planar"));
            return Err(ReadBuildError::Unsupported { part: part.to_owned(), what });
        }
    }
    let factor = element.optional("unitfactor", "above 0", |value| value > 0.0)?;
    let factor = factor.ok_or_else(|| element.wrong("unitfactor", None, "above 0"))?;
    let (mut profiles, mut modifiers) = (Vec::new(), Vec::new());
    for (at, node) in children(resource, "toolpathprofiles", "toolpathprofile").enumerate() {
        let (profile, of) = profile(part, at, node)?;
        profiles.push(profile);
        modifiers.push(of);
    }
    let mut layers = Vec::new();
    for (at, node) in children(resource, "toolpathlayers", "toolpathlayer").enumerate() {
        let layer = Element { part, node, place: &|| format!("toolpathlayer {}", at + 1) };
        let is_layer = |n: f64| (1.0..=2f64.powi(32)).contains(&n) && n.fract().abs() <= 0.0;
        let number = layer.optional((OURS, "layer"), "an integer from 1", is_layer)?;
        layers.push(LayerPart { path: layer.text("path")?.to_owned(), layer: number.map(|n| (n - 1.0) as u32) });
    }
    let build = root.children().filter(|node| node.tag_name().name() == "build");
    let items = build.flat_map(|build| build.children()).filter_map(|item| item.attribute((PRODUCTION, "UUID")));
    let items = items.map(str::to_ascii_lowercase).collect();
    Ok(Model { step_mm: factor * unit_mm, profiles, modifiers, layers, items })
}

/// The resource that the build names, or the only one.
fn resource<'a, 'i>(part: &str, root: Node<'a, 'i>) -> Result<Node<'a, 'i>, ReadBuildError> {
    let mut all = root.descendants().filter(|node| node.has_tag_name((TOOLPATH, "toolpathresource")));
    let build = root.children().find(|node| node.tag_name().name() == "build");
    let found = match build.and_then(|build| build.attribute((TOOLPATH, "toolpathid"))) {
        Some(id) => all.find(|node| node.attribute("id") == Some(id)),
        None => all.next(),
    };
    found.ok_or_else(|| ReadBuildError::NoToolpath { part: part.to_owned() })
}

fn profile(part: &str, at: usize, node: Node) -> Result<(Profile, Modifiers), ReadBuildError> {
    let element = Element { part, node, place: &|| format!("toolpathprofile {}", at + 1) };
    let positive = |name| element.optional(name, "above 0", |value| value > 0.0);
    let constant = |value: Option<f64>| value.map(|value| Range { min: value, max: value });
    let speed = positive("depositionspeed")?.or(positive("jumpspeed")?);
    let mut profile = Profile {
        uuid: element.text("uuid")?.to_ascii_lowercase(),
        name: element.text("name")?.to_owned(),
        kind: node.attribute((OURS, "kind")).and_then(kind_of),
        width_mm: constant(positive("beadwidth")?),
        height_mm: constant(positive("beadheight")?),
        speed_mm_s: constant(speed),
    };
    let mut modifiers = Modifiers::default();
    for child in node.children().filter(|child| child.has_tag_name((TOOLPATH, "modifier"))) {
        let element = Element { part, node: child, place: &|| format!("modifier of toolpathprofile {}", at + 1) };
        let (attribute, kind) = (element.text("attribute")?, element.text("type")?);
        let unsupported = |what: String| ReadBuildError::Unsupported { part: part.to_owned(), what };
        // The extension has a consumer reject what it cannot do.
        let of = QUANTITIES.iter().find(|(name, _)| *name == attribute && node.attribute(*name).is_some());
        let (_, of) = of.ok_or_else(|| unsupported(format!("a modifier of `{attribute}`")))?;
        let is_linear = match kind {
            "linear" => true,
            "constant" => false,
            other => return Err(unsupported(format!("a modifier of type `{other}`"))),
        };
        let (min, max) = (element.number("minvalue", "above 0")?, element.number("maxvalue", "above `minvalue`")?);
        if min <= 0.0 {
            return Err(element.wrong("minvalue", child.attribute("minvalue"), "above 0"));
        }
        if min >= max {
            return Err(element.wrong("maxvalue", child.attribute("maxvalue"), "above `minvalue`"));
        }
        let factor = element.text("factor")?;
        let slot = FACTORS.iter().position(|name| *name == factor).filter(|slot| modifiers[*slot].is_none());
        let slot = slot.ok_or_else(|| element.wrong("factor", Some(factor), "one of e, f, g and h, each once"))?;
        modifiers[slot] = Some(Modifier { of: *of, is_linear });
        let range = match of {
            Quantity::Width => &mut profile.width_mm,
            Quantity::Height => &mut profile.height_mm,
            Quantity::Speed => &mut profile.speed_mm_s,
        };
        *range = Some(Range { min, max });
    }
    Ok((profile, modifiers))
}

/// The children of a list of a resource.
fn children<'a, 'i: 'a>(
    resource: Node<'a, 'i>,
    list: &'static str,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    let lists = resource.children().filter(move |node| node.has_tag_name((TOOLPATH, list)));
    lists.flat_map(|list| list.children()).filter(move |node| node.has_tag_name((TOOLPATH, name)))
}
