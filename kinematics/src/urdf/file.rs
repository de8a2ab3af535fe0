//! The links and joints of a URDF, as they stand in the file.

use super::error::UrdfError;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;

/// A URDF has lengths in metres.
const MM: f64 = 1000.0;

/// What a joint does.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    Fixed,
    /// Between these angles, or without end.
    Turning(f64, f64),
    /// Prismatic, planar, floating: by the word of the file.
    Other(String),
}

#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub name: String,
    pub kind: Kind,
    pub parent: String,
    pub child: String,
    /// The frame of the joint in the parent link, in millimetres.
    pub origin: Isometry3<f64>,
    /// Its axis in that frame.
    pub axis: UnitVector3<f64>,
    /// In rad/s; infinite where it is not said.
    pub velocity: f64,
    /// The joint that it follows.
    pub mimics: Option<String>,
}

/// The robot's name, links in the order of the file, and joints.
#[derive(Clone, Debug)]
pub(super) struct File {
    pub name: String,
    pub links: Vec<String>,
    pub joints: Vec<Joint>,
}

pub(super) fn read(text: &str) -> Result<File, UrdfError> {
    let document = Document::parse(text).map_err(|error| {
        let at = error.pos();
        let (what, place) = (error.to_string(), format!(" at {}:{}", at.row, at.col));
        // The parser quotes the end of a line as it is.
        let what = what.replace(&place, "").replace('\n', "\\n").replace('\r', "\\r");
        UrdfError::Xml { line: at.row, column: at.col, what }
    })?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(UrdfError::NotRobot { found: robot.tag_name().name().into() });
    }
    let is_macro = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|space| space.contains("xacro"));
    if let Some(node) = robot.descendants().find(is_macro) {
        return Err(UrdfError::Xacro { line: line(&node) });
    }
    let elements = |name: &'static str| robot.children().filter(move |node| node.has_tag_name(name));
    let mut links = Vec::new();
    let mut known = BTreeSet::new();
    for link in elements("link") {
        let name = attribute(&link, "link", "name")?.to_owned();
        if !known.insert(name.clone()) {
            return Err(at(&link, format!("link `{name}` is there twice")));
        }
        links.push(name);
    }
    let mut names = BTreeSet::new();
    let mut joints = Vec::new();
    for node in elements("joint") {
        let joint = joint(&node)?;
        if !names.insert(joint.name.clone()) {
            return Err(at(&node, format!("joint `{}` is there twice", joint.name)));
        }
        for (side, link) in [("parent", &joint.parent), ("child", &joint.child)] {
            if !known.contains(link) {
                return Err(at(&node, format!("joint `{}`: its {side} `{link}` is no link of the file", joint.name)));
            }
        }
        joints.push(joint);
    }
    Ok(File { name: robot.attribute("name").unwrap_or_default().to_owned(), links, joints })
}

fn line(node: &Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

fn at(node: &Node<'_, '_>, what: String) -> UrdfError {
    UrdfError::Element { line: line(node), what }
}

fn attribute<'a>(node: &Node<'a, '_>, of: &str, name: &str) -> Result<&'a str, UrdfError> {
    node.attribute(name).ok_or_else(|| at(node, format!("{of} has no `{name}`")))
}

fn child<'a, 'i>(node: &Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn joint(node: &Node<'_, '_>) -> Result<Joint, UrdfError> {
    let name = attribute(node, "joint", "name")?.to_owned();
    let of = format!("joint `{name}`");
    let link = |side: &str| {
        let element = child(node, side).ok_or_else(|| at(node, format!("{of} has no {side}")))?;
        Ok(attribute(&element, &format!("the {side} of {of}"), "link")?.to_owned())
    };
    let (parent, to) = (link("parent")?, link("child")?);
    let (xyz, rpy) = match child(node, "origin") {
        None => ([0.0; 3], [0.0; 3]),
        Some(origin) => {
            (triple(&origin, &of, "xyz")?.unwrap_or_default(), triple(&origin, &of, "rpy")?.unwrap_or_default())
        }
    };
    let rotation = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    let axis = match child(node, "axis") {
        None => [1.0, 0.0, 0.0],
        Some(axis) => triple(&axis, &of, "xyz")?.unwrap_or([1.0, 0.0, 0.0]),
    };
    let kind = kind(node, &of)?;
    let direction = UnitVector3::try_new(Vector3::from(axis), f64::MIN_POSITIVE);
    let axis = match (direction, &kind) {
        (Some(axis), _) => axis,
        // Some fixed joints have a zero axis.
        (None, Kind::Fixed) => Vector3::x_axis(),
        (None, _) => return Err(at(node, format!("{of} has the axis 0 0 0: it must be a direction"))),
    };
    let limit = child(node, "limit");
    let velocity = limit.map_or(Ok(None), |limit| number(&limit, &of, "velocity"))?;
    Ok(Joint {
        kind,
        parent,
        child: to,
        origin: Isometry3::from_parts(Translation3::from(xyz.map(|value| value * MM)), rotation),
        axis,
        // 0 stands for a speed that nobody has filled in.
        velocity: velocity.filter(|speed| *speed > 0.0).unwrap_or(f64::INFINITY),
        mimics: child(node, "mimic").map(|mimic| mimic.attribute("joint").unwrap_or("?").to_owned()),
        name,
    })
}

fn kind(node: &Node<'_, '_>, of: &str) -> Result<Kind, UrdfError> {
    match attribute(node, of, "type")? {
        "fixed" => Ok(Kind::Fixed),
        "continuous" => Ok(Kind::Turning(f64::NEG_INFINITY, f64::INFINITY)),
        "revolute" => {
            let hint = "a revolute joint needs <limit lower upper>; `continuous` turns without end";
            let limit = child(node, "limit").ok_or_else(|| at(node, format!("{of} has no limit: {hint}")))?;
            let end = |name: &str| Ok(number(&limit, of, name)?.unwrap_or(0.0));
            let (lower, upper) = (end("lower")?, end("upper")?);
            if lower >= upper {
                return Err(at(&limit, format!("{of} has no angle between its limits, {lower} and {upper}: {hint}")));
            }
            Ok(Kind::Turning(lower, upper))
        }
        other => Ok(Kind::Other(other.to_owned())),
    }
}

/// No robot is larger, in metres, and no angle, in radians: see [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE).
const MAX: f64 = 1e3;

fn parsed(node: &Node<'_, '_>, of: &str, name: &str, text: &str) -> Result<f64, UrdfError> {
    let value = text.parse::<f64>().ok().filter(|value| value.abs() <= MAX);
    value.ok_or_else(|| at(node, format!("{of}: `{text}` in `{name}` must be a number from -1000 to 1000")))
}

fn number(node: &Node<'_, '_>, of: &str, name: &str) -> Result<Option<f64>, UrdfError> {
    node.attribute(name).map(|text| parsed(node, of, name, text.trim())).transpose()
}

fn triple(node: &Node<'_, '_>, of: &str, name: &str) -> Result<Option<[f64; 3]>, UrdfError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let mut words = text.split_whitespace();
    let mut values = [0.0; 3];
    for value in &mut values {
        let word = words.next().ok_or_else(|| at(node, format!("{of}: `{name}` has fewer than three numbers")))?;
        *value = parsed(node, of, name, word)?;
    }
    match words.next() {
        Some(_) => Err(at(node, format!("{of}: `{name}` has more than three numbers"))),
        None => Ok(Some(values)),
    }
}
