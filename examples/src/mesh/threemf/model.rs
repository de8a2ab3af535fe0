//! One model file: its objects and its build.

use super::super::fault::{MeshFault, package_fault, quoted};
use super::package::absolute;
use crate::build3mf::{OURS, unit_mm};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeMap;
use std::fmt::Display;

/// Elements that are taken from one model.
const MAX_NODES: u32 = 1 << 24;
/// Extensions that are read, or change nothing about shapes.
const KNOWN: [&str; 5] = ["/production/", "/material/", "/securecontent/", "/toolpath/", OURS];
/// Resources that hold materials.
const MATERIALS: [&str; 6] =
    ["basematerials", "colorgroup", "texture2dgroup", "compositematerials", "multiproperties", "texture2d"];

pub(super) struct Model {
    /// Millimetres in its unit.
    pub(super) unit_mm: f64,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) build: Vec<Item>,
    pub(super) has_materials: bool,
    /// Namespaces of extensions that the file calls necessary and that are not known here.
    pub(super) unknown_extensions: Vec<String>,
}

/// What an object is for.
pub(super) enum Kind {
    /// A solid part.
    Model,
    /// Support, a surface, or another thing that is not printed as it is.
    Other(String),
}

pub(super) struct Object {
    pub(super) kind: Kind,
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) components: Vec<Item>,
}

/// An object in a place: of the build, or of another object.
pub(super) struct Item {
    pub(super) object: u32,
    /// The file that it is in; the same one if there is none.
    pub(super) path: Option<String>,
    pub(super) transform: Transform,
    pub(super) printable: bool,
}

/// Four rows of three numbers; points are rows, multiplied from the left.
#[derive(Clone, Copy)]
pub(super) struct Transform([[f64; 3]; 4]);

impl Transform {
    const IDENTITY: Self = Transform([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);

    pub(super) fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = self.0;
        [0, 1, 2].map(|k| x * a[k] + y * b[k] + z * c[k] + d[k])
    }

    /// This one first, then another.
    pub(super) fn then(&self, next: &Self) -> Self {
        let origin = next.apply([0.0; 3]);
        let turned = |row: [f64; 3]| {
            let moved = next.apply(row);
            [0, 1, 2].map(|k| moved[k] - origin[k])
        };
        let [a, b, c, d] = self.0;
        Transform([turned(a), turned(b), turned(c), next.apply(d)])
    }

    pub(super) fn mirrors(&self) -> bool {
        let [a, b, c, _] = self.0;
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2] < 0.0
    }
}

impl Model {
    /// The files that its items and components are in.
    pub(super) fn paths(&self) -> impl Iterator<Item = &String> {
        let components = self.objects.values().flat_map(|object| &object.components);
        self.build.iter().chain(components).filter_map(|item| item.path.as_ref())
    }
}

pub(super) fn parse(path: &str, text: &str) -> Result<Model, MeshFault> {
    let at = |what: &dyn Display| package_fault(format!("{path}: {what}"));
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| at(&error))?;
    let root = document.root_element();
    let unit = root.attribute("unit").unwrap_or("millimeter");
    let unit_mm = unit_mm(unit).ok_or_else(|| at(&format!("the unit {} is not known", quoted(unit))))?;
    let resources = || children(root, "resources").flat_map(|resources| resources.children());
    let mut objects = BTreeMap::new();
    for node in resources().filter(|node| node.tag_name().name() == "object") {
        let id: u32 = number(node, "id").map_err(|what| at(&what))?;
        let object = object(node).map_err(|what| at(&format!("object {id}: {what}")))?;
        objects.insert(id, object);
    }
    let build = children(root, "build").flat_map(|build| children(build, "item")).map(item);
    let build = build.collect::<Result<Vec<_>, _>>().map_err(|what| at(&format!("the build: {what}")))?;
    let prefixes = root.attribute("requiredextensions").unwrap_or("").split_whitespace();
    let namespaces = prefixes.map(|prefix| root.lookup_namespace_uri(Some(prefix)).unwrap_or(prefix));
    let unknown = namespaces.filter(|uri| !KNOWN.iter().any(|known| uri.contains(known))).map(str::to_owned);
    Ok(Model {
        unit_mm,
        objects,
        build,
        has_materials: resources().any(|node| MATERIALS.contains(&node.tag_name().name())),
        unknown_extensions: unknown.collect(),
    })
}

fn object(node: Node) -> Result<Object, String> {
    let kind = match node.attribute("type").unwrap_or("model") {
        "model" => Kind::Model,
        other => Kind::Other(quoted(other)),
    };
    let mut object = Object { kind, vertices: Vec::new(), triangles: Vec::new(), components: Vec::new() };
    for vertex in
        children(node, "mesh").flat_map(|mesh| children(mesh, "vertices")).flat_map(|all| children(all, "vertex"))
    {
        object.vertices.push([number(vertex, "x")?, number(vertex, "y")?, number(vertex, "z")?]);
    }
    let all = children(node, "mesh").flat_map(|mesh| children(mesh, "triangles"));
    for (at, triangle) in all.flat_map(|all| children(all, "triangle")).enumerate() {
        let corners: [u32; 3] = [number(triangle, "v1")?, number(triangle, "v2")?, number(triangle, "v3")?];
        let count = object.vertices.len();
        if let Some(vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
            return Err(format!("triangle {} names vertex {vertex} (from 0) of {count}", at + 1));
        }
        object.triangles.push(corners);
    }
    let all = children(node, "components").flat_map(|all| children(all, "component"));
    object.components = all.map(item).collect::<Result<_, _>>()?;
    Ok(object)
}

fn item(node: Node) -> Result<Item, String> {
    let path = node.attributes().find(|attribute| attribute.name() == "path").map(|path| absolute(path.value()));
    let transform = node.attribute("transform").map_or(Ok(Transform::IDENTITY), transform)?;
    let printable = node.attributes().all(|attribute| attribute.name() != "printable" || attribute.value() != "0");
    Ok(Item { object: number(node, "objectid")?, path, transform, printable })
}

fn transform(text: &str) -> Result<Transform, String> {
    let numbers: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let rows = numbers.as_chunks::<3>().0;
    match rows {
        &[a, b, c, d] if numbers.len() == 12 && numbers.iter().all(|n| n.is_finite()) => Ok(Transform([a, b, c, d])),
        _ => Err(format!("the transform {} is not twelve numbers", quoted(text))),
    }
}

/// The children of that name, in whatever namespace.
fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// A number of an element.
fn number<T: std::str::FromStr>(node: Node, name: &str) -> Result<T, String> {
    let text = node.attribute(name).ok_or_else(|| format!("a `{}` without `{name}`", node.tag_name().name()))?;
    text.trim().parse().map_err(|_| format!("{} is not a number for `{name}`", quoted(text)))
}
