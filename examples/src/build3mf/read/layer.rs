//! A part with a layer.

use super::attributes::Element;
use super::data::ReadSegment;
use super::error::ReadBuildError;
use super::model::{FACTORS, Model, Modifiers, Quantity};
use super::package::parse;
use crate::build3mf::names::{OURS, TOOLPATH};
use crate::build3mf::profile::Profile;
use crate::build3mf::{Line, Section};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use roxmltree::Node;
use std::collections::BTreeMap;

/// How far a quaternion may be from unit length: what a few digits round away. The extension has a consumer normalise what is further off as well;
/// here it is a fault, since a file of ours has none.
const MAX_STRETCH: f64 = 1e-3;

pub(super) fn read(part: &str, text: &str, model: &Model) -> Result<Vec<ReadSegment>, ReadBuildError> {
    let document = parse(part, text)?;
    let root = document.root_element();
    if !root.has_tag_name((TOOLPATH, "layer")) {
        let what = format!("an element `{}` in the namespace of something else", root.tag_name().name());
        return Err(ReadBuildError::Unsupported { part: part.to_owned(), what });
    }
    let known = |uuid: &str| model.profiles.iter().position(|profile| profile.uuid == uuid);
    let profiles = ids(part, root, "profiles", "profile", "profile", known)?;
    let known = |uuid: &str| model.items.contains(uuid).then_some(());
    let parts = ids(part, root, "parts", "part", "build item", known)?;
    let mut segments = Vec::new();
    for (at, node) in children(root, "segments").flat_map(|list| children(list, "segment")).enumerate() {
        let number = at + 1;
        let element = Element { part, node, place: &|| format!("segment {number}") };
        let kind = element.text("type")?;
        if kind != "polyline6d" {
            return Err(ReadBuildError::Unsupported {
                part: part.to_owned(),
                what: format!("a segment of type `{kind}`"),
            });
        }
        let (id, of) = (element.id("profileid")?, element.id("partid")?);
        let unknown = || ReadBuildError::UnknownProfile { part: part.to_owned(), segment: number, id };
        let profile = *profiles.get(&id).ok_or_else(unknown)?;
        if !parts.contains_key(&of) {
            return Err(ReadBuildError::UnknownPart { part: part.to_owned(), segment: number, id: of });
        }
        let poses = points(part, number, node, model.step_mm)?;
        let Some(((start, _), others)) = poses.split_first().filter(|(_, others)| !others.is_empty()) else {
            return Err(ReadBuildError::FewPoints { part: part.to_owned(), segment: number, points: poses.len() });
        };
        let lines =
            Lines { part, segment: number, profile: &model.profiles[profile], modifiers: &model.modifiers[profile] };
        segments.push(segment(&element, profile, *start, lines.read(start, others)?)?);
    }
    Ok(segments)
}

/// A segment with what it says beside its lines.
fn segment(
    element: &Element,
    profile: usize,
    start: Isometry3<f64>,
    lines: Vec<Line>,
) -> Result<ReadSegment, ReadBuildError> {
    let natural =
        |name| element.optional(name, "an integer from 0", |value| value >= 0.0 && value.fract().abs() <= 0.0);
    let amount = |name| element.optional((OURS, name), "a number", |_| true);
    Ok(ReadSegment {
        profile,
        tag: natural("tag")?.map(|tag| tag as u32),
        seconds: natural("timeprediction")?.map(|time| time * 1e-6),
        jump_s: natural("jumpprediction")?.map(|time| time * 1e-6),
        start,
        lines,
        filament_mm: amount("filament")?.unwrap_or(0.0),
        prime_mm: amount("prime")?.unwrap_or(0.0),
        retract_mm: amount("retract")?.unwrap_or(0.0),
    })
}

/// Places and quaternions of all points.
fn points<'a, 'i>(
    part: &str,
    segment: usize,
    node: Node<'a, 'i>,
    step_mm: f64,
) -> Result<Vec<(Isometry3<f64>, Node<'a, 'i>)>, ReadBuildError> {
    let mut poses = Vec::new();
    for (at, node) in node.children().filter(Node::is_element).enumerate() {
        let point = at + 1;
        if !node.has_tag_name((TOOLPATH, "point6d")) {
            let what = format!("`{}` in a segment of type `polyline6d`", node.tag_name().name());
            return Err(ReadBuildError::Unsupported { part: part.to_owned(), what });
        }
        let element = Element { part, node, place: &|| format!("segment {segment}, point {point}") };
        let place = [element.integer("x")?, element.integer("y")?, element.integer("z")?];
        let [x, y, z] = place.map(|steps| f64::from(steps) * step_mm);
        let number = |name| element.number(name, "a number");
        let turn = Quaternion::new(number("w")?, number("i")?, number("j")?, number("k")?);
        let length = turn.norm();
        // False for NaN, which digits beyond the range of numbers would make.
        let is_unit = (length - 1.0).abs() <= MAX_STRETCH;
        if !is_unit {
            return Err(ReadBuildError::Quaternion { part: part.to_owned(), segment, point, length });
        }
        let pose = Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(turn));
        poses.push((pose, node));
    }
    Ok(poses)
}

/// Reads the lines of a segment.
struct Lines<'p> {
    part: &'p str,
    segment: usize,
    profile: &'p Profile,
    modifiers: &'p Modifiers,
}

impl Lines<'_> {
    fn read(&self, start: &Isometry3<f64>, others: &[(Isometry3<f64>, Node)]) -> Result<Vec<Line>, ReadBuildError> {
        let mut from = *start;
        let mut lines = Vec::with_capacity(others.len());
        for (at, (end, node)) in others.iter().enumerate() {
            let place = || format!("segment {}, point {}", self.segment, at + 2);
            let element = Element { part: self.part, node: *node, place: &place };
            lines.push(self.line(&from, *end, &element)?);
            from = *end;
        }
        Ok(lines)
    }

    fn line(&self, from: &Isometry3<f64>, end: Isometry3<f64>, element: &Element) -> Result<Line, ReadBuildError> {
        if element.node.children().any(|child| child.has_tag_name((TOOLPATH, "sub"))) {
            let what = "a `sub` where no modifier is nonlinear".to_owned();
            return Err(ReadBuildError::Unsupported { part: self.part.to_owned(), what });
        }
        let [width, height, speed] =
            [Quantity::Width, Quantity::Height, Quantity::Speed].map(|of| self.ends(of, element));
        let bead = match (width?, height?) {
            (Some([w1, w2]), Some([h1, h2])) => {
                Some([(w1, h1), (w2, h2)].map(|(width_mm, height_mm)| Section { width_mm, height_mm }))
            }
            _ => None,
        };
        let length = (end.translation.vector - from.translation.vector).norm();
        // Where the tip stands, its time stands in place of a speed.
        let standing = element.optional((OURS, "seconds"), "from 0", |value| value >= 0.0)?;
        let speed = speed?.map(|[at, _]| at).filter(|_| standing.is_none());
        let seconds = standing.or_else(|| speed.map(|speed| length / speed)).unwrap_or(0.0);
        Ok(Line { end, bead, speed_mm_s: speed, seconds })
    }

    /// A number at both ends of a line: by its factor, else as the profile has it.
    fn ends(&self, of: Quantity, element: &Element) -> Result<Option<[f64; 2]>, ReadBuildError> {
        let range = match of {
            Quantity::Width => self.profile.width_mm,
            Quantity::Height => self.profile.height_mm,
            Quantity::Speed => self.profile.speed_mm_s,
        };
        let Some(range) = range else { return Ok(None) };
        let modifier = self.modifiers.iter().zip(FACTORS).find_map(|(slot, name)| {
            slot.filter(|modifier| modifier.of == of).map(|modifier| (name, modifier.is_linear))
        });
        let Some((name, is_linear)) = modifier else { return Ok(Some([range.max; 2])) };
        let factor = |name: &str| element.optional(name, "from 0 to 1", |value| (0.0..=1.0).contains(&value));
        let [first, second] = [format!("{name}1"), format!("{name}2")];
        let ends = match (factor(name)?, factor(&first)?, factor(&second)?) {
            (Some(both), None, None) => [both; 2],
            (None, Some(from), Some(to)) if is_linear => [from, to],
            // Without a factor the profile's own value holds; of ranges of ours that is the greatest.
            (None, None, None) => [1.0; 2],
            _ => return Err(element.wrong(&first, element.node.attribute(&first[..]), "as granular as its modifier")),
        };
        Ok(Some(ends.map(|share| range.at(share))))
    }
}

/// What a layer calls its profiles or parts: by UUIDs that the model must have.
fn ids<T>(
    part: &str,
    root: Node,
    list: &'static str,
    name: &'static str,
    what: &'static str,
    known: impl Fn(&str) -> Option<T>,
) -> Result<BTreeMap<u32, T>, ReadBuildError> {
    let mut all = BTreeMap::new();
    for (at, node) in children(root, list).flat_map(|list| children(list, name)).enumerate() {
        let element = Element { part, node, place: &|| format!("{name} {}", at + 1) };
        let id = element.id("id")?;
        let uuid = element.text("uuid")?.to_ascii_lowercase();
        let unknown = || ReadBuildError::UnknownUuid { part: part.to_owned(), what, uuid: uuid.clone() };
        if all.insert(id, known(&uuid).ok_or_else(unknown)?).is_some() {
            return Err(element.wrong("id", node.attribute("id"), "of its own in the layer"));
        }
    }
    Ok(all)
}

fn children<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name((TOOLPATH, name)))
}
