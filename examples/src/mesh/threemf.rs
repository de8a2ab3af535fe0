//! 3MF packages: the mesh objects of the build, placed as its items and components say, in millimetres. Materials are passed
//! over. (3MF core specification 1.3, sections 3 to 5; production extension 1.1 for objects in files of their own.)

mod model;
mod package;

use super::fault::{MeshFault, Place, finite, package_fault};
use super::weld::Welder;
use model::{Kind, Model, Object, Transform};
use package::Package;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Triangles that are taken from a package, copies of objects counted each time.
const MAX_TRIANGLES: u64 = 1 << 26;
/// Objects within objects; more is a file that means harm.
const MAX_DEPTH: usize = 32;

pub(super) fn parse(bytes: &[u8]) -> Result<Welder, MeshFault> {
    let mut package = Package::open(bytes)?;
    let root = package.root()?;
    let scene = Scene::read(&mut package, &root)?;
    let main = scene.model(&root)?;
    let mut welder = Welder::default();
    welder.states_unit = true;
    let scale = main.unit_mm;
    let mut left_out: Vec<String> = Vec::new();
    let (mut items, mut triangles, mut counts) = (0, 0, BTreeMap::new());
    for item in &main.build {
        let path = item.path.as_ref().unwrap_or(&root);
        let object = scene.object(path, item.object)?;
        if let Kind::Other(kind) = &object.kind {
            left_out.push(format!("object {} ({kind})", item.object));
        } else if !item.printable {
            left_out.push(format!("object {} (not to be printed)", item.object));
        } else {
            triangles += scene.triangles(path, item.object, &mut Vec::new(), &mut counts)?;
            if triangles > MAX_TRIANGLES {
                return Err(MeshFault::TooMuch {
                    what: "the objects of the build".into(),
                    limit: "67,108,864 triangles",
                });
            }
            items += 1;
            scene.place(path, item.object, &item.transform, scale, &mut welder)?;
        }
    }
    if items == 0 && left_out.is_empty() {
        return Err(package_fault("the build holds no objects"));
    }
    if items > 1 {
        welder.note("the objects of the build were taken as one part", items.to_string(), "");
    }
    if !left_out.is_empty() {
        welder.note(
            "objects that are not to be printed were left out",
            left_out.len().to_string(),
            left_out.join(", "),
        );
    }
    if scene.models.values().any(|model| model.has_materials) {
        welder.note("materials and colours of the 3MF file were ignored", "", "");
    }
    for extension in &main.unknown_extensions {
        welder.warn("the 3MF file needs an extension that is not read: the part may lack something", extension, "");
    }
    if package.has_modifiers() {
        let what = "the 3MF file has modifiers or negative volumes of a slicer, read as if they were solid";
        welder.warn(what, "", "export the part alone");
    }
    Ok(welder)
}

/// All model files that the build needs, by their paths.
struct Scene {
    models: BTreeMap<String, Model>,
}

impl Scene {
    /// Reads the root model and those that it names.
    fn read(package: &mut Package, root: &str) -> Result<Self, MeshFault> {
        let mut models = BTreeMap::new();
        let mut wanted = vec![root.to_owned()];
        while let Some(path) = wanted.pop() {
            if let Entry::Vacant(place) = models.entry(path) {
                let model = model::parse(place.key(), &package.text(place.key())?)?;
                wanted.extend(model.paths().cloned());
                place.insert(model);
            }
        }
        Ok(Scene { models })
    }

    fn model(&self, path: &str) -> Result<&Model, MeshFault> {
        self.models.get(path).ok_or_else(|| package_fault(format!("there is no {path}")))
    }

    fn object(&self, path: &str, id: u32) -> Result<&Object, MeshFault> {
        let objects = &self.model(path)?.objects;
        objects.get(&id).ok_or_else(|| package_fault(format!("{path} has no object {id}")))
    }

    /// How many triangles an object has with all that it is made of; `within` are the objects around it, `known` the counts so far.
    fn triangles(
        &self,
        path: &str,
        id: u32,
        within: &mut Vec<(String, u32)>,
        known: &mut BTreeMap<(String, u32), u64>,
    ) -> Result<u64, MeshFault> {
        let object = self.object(path, id)?;
        let here = (path.to_owned(), id);
        if let Some(&count) = known.get(&here) {
            return Ok(count);
        }
        if within.contains(&here) || within.len() >= MAX_DEPTH {
            return Err(package_fault(format!("{path}: object {id} is part of itself, or nested too deep")));
        }
        within.push(here.clone());
        let mut count = object.triangles.len() as u64;
        for component in &object.components {
            let path = component.path.as_deref().unwrap_or(path);
            count = count.saturating_add(self.triangles(path, component.object, within, known)?);
        }
        within.pop();
        // An object without triangles still costs a visit.
        known.insert(here, count.max(1));
        Ok(count.max(1))
    }

    /// Adds an object where it belongs.
    fn place(
        &self,
        path: &str,
        id: u32,
        transform: &Transform,
        scale: f64,
        welder: &mut Welder,
    ) -> Result<(), MeshFault> {
        let object = self.object(path, id)?;
        let mut corners = Vec::with_capacity(object.vertices.len());
        for (number, vertex) in object.vertices.iter().enumerate() {
            let at = transform.apply(*vertex).map(|c| c * scale);
            corners.push(welder.vertex(finite(at, Place::Vertex(number + 1), number + 1)?)?);
        }
        let mirrors = transform.mirrors();
        for (number, &[a, b, c]) in object.triangles.iter().enumerate() {
            let [a, b, c] = [a, b, c].map(|corner| corners[corner as usize]);
            welder.polygon(&if mirrors { [a, c, b] } else { [a, b, c] }, Place::ObjectTriangle(id, number + 1));
        }
        for component in &object.components {
            let path = component.path.as_deref().unwrap_or(path);
            self.place(path, component.object, &component.transform.then(transform), scale, welder)?;
        }
        Ok(())
    }
}
