//! The build as a binary glTF 2.0 file (`.glb`; Khronos, "glTF 2.0 Specification", 2021) for other viewers: a node for the part and one for
//! each layer, with its surface as triangles and its beads as lines. glTF is in metres with y up; the root node says so, and numbers
//! stay millimetres.

use super::{Model, Step};
use crate::render::ramp;
use nalgebra::Point3;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Ways of drawing.
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Types of numbers.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// What views are for.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The binary chunk, and what of it is what.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, begin: usize, target: u32) -> usize {
        self.views.push(
            json!({ "buffer": 0, "byteOffset": begin, "byteLength": self.bytes.len() - begin, "target": target }),
        );
        self.views.len() - 1
    }

    /// A primitive of these points, by their numbers; none of no points.
    fn primitive(&mut self, points: &[Point3<f64>], corners: &[u32], mode: u32, material: usize) -> Option<Value> {
        if points.is_empty() || corners.is_empty() {
            return None;
        }
        let narrow = |point: &Point3<f64>| [point.x, point.y, point.z].map(|c| c as f32);
        let begin = self.bytes.len();
        self.bytes.extend(points.iter().flat_map(narrow).flat_map(f32::to_le_bytes));
        let (mut low, mut high) = (narrow(&points[0]), narrow(&points[0]));
        for point in points.iter().map(narrow) {
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
        let view = self.view(begin, VERTICES);
        self.accessors.push(json!({ "bufferView": view, "componentType": FLOAT, "count": points.len(), "type": "VEC3", "min": low, "max": high }));
        let begin = self.bytes.len();
        self.bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        let view = self.view(begin, INDICES);
        self.accessors.push(
            json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": corners.len(), "type": "SCALAR" }),
        );
        let last = self.accessors.len() - 1;
        Some(json!({ "attributes": { "POSITION": last - 1 }, "indices": last, "mode": mode, "material": material }))
    }
}

impl Model {
    /// Writes the build as a binary glTF file.
    ///
    /// # Errors
    /// What the system says; `InvalidInput` for more than 4 GB.
    pub fn write_glb(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut file = Gltf { materials: vec![material([0.6, 0.65, 0.72, 0.3])], ..Gltf::default() };
        for (name, solid) in [("part", &self.part), ("mould", &self.mould)] {
            let primitive = file.buffer.primitive(&solid.vertices, &flat(&solid.triangles), TRIANGLES, 0);
            file.add(name.to_owned(), primitive.into_iter().collect());
        }
        let beads = self.beads();
        let last = beads.len().max(2).saturating_sub(1) as f64;
        for (layer, (points, corners)) in beads.iter().enumerate() {
            let [r, g, b] = ramp(layer as f64 / last).map(|c| linear(f64::from(c) / 255.0));
            file.materials.push(material([r, g, b, 1.0]));
            let surface = self.layers.get(layer).and_then(|sheet| {
                file.buffer.primitive(&sheet.vertices, &flat(&sheet.triangles), TRIANGLES, layer + 1)
            });
            let lines = file.buffer.primitive(points, corners, LINES, layer + 1);
            file.add(format!("layer {}", layer + 1), surface.into_iter().chain(lines).collect());
        }
        file.write(&self.name, out)
    }

    /// Points and segments of the beads of each layer.
    fn beads(&self) -> Vec<(Vec<Point3<f64>>, Vec<u32>)> {
        let layers = self.steps.iter().map(|step| step.layer as usize + 1).max().unwrap_or(0).max(self.layers.len());
        let mut beads: Vec<(Vec<Point3<f64>>, Vec<u32>)> = vec![Default::default(); layers];
        for pair in self.steps.windows(2).filter(|pair| pair[1].kind != Step::TRAVEL) {
            let (points, corners) = &mut beads[pair[1].layer as usize];
            if points.last() != Some(&pair[0].tip) {
                points.push(pair[0].tip);
            }
            points.push(pair[1].tip);
            let last = points.len() as u32 - 1;
            corners.extend([last - 1, last]);
        }
        beads
    }
}

/// A file that is being made: a mesh and a node for each name, all below one root.
#[derive(Default)]
struct Gltf {
    buffer: Buffer,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Gltf {
    /// Adds a mesh with its node; an empty one is left out, which glTF does not allow.
    fn add(&mut self, name: String, primitives: Vec<Value>) {
        if !primitives.is_empty() {
            self.meshes.push(json!({ "name": name, "primitives": primitives }));
            self.nodes.push(json!({ "name": name, "mesh": self.meshes.len() - 1 }));
        }
    }

    /// The JSON chunk, padded to whole words.
    fn json(&mut self, name: &str) -> Vec<u8> {
        let children: Vec<usize> = (0..self.nodes.len()).collect();
        // Millimetres with z up to metres with y up.
        let matrix = [1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, -1e-3, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let root = self.nodes.len();
        self.nodes.push(if children.is_empty() {
            json!({ "name": name })
        } else {
            json!({ "name": name, "children": children, "matrix": matrix })
        });
        let mut file = json!({
            "asset": { "version": "2.0", "generator": "curvlay" },
            "scene": 0,
            "scenes": [{ "nodes": [root] }],
            "nodes": self.nodes,
        });
        if !self.meshes.is_empty() {
            file["meshes"] = json!(self.meshes);
            file["materials"] = json!(self.materials);
            file["accessors"] = json!(self.buffer.accessors);
            file["bufferViews"] = json!(self.buffer.views);
            file["buffers"] = json!([{ "byteLength": self.buffer.bytes.len() }]);
        }
        let mut text = file.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        text
    }

    /// Writes header and chunks; a file without meshes has no binary one.
    fn write(mut self, name: &str, out: &mut dyn Write) -> io::Result<()> {
        let text = self.json(name);
        let chunks = [(&text, b"JSON"), (&self.buffer.bytes, b"BIN\0")];
        let chunks = || chunks.iter().filter(|(bytes, _)| !bytes.is_empty());
        let total = 12 + chunks().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
        let total = u32::try_from(total).map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more than 4 GB"))?;
        out.write_all(b"glTF")?;
        out.write_all(&2u32.to_le_bytes())?;
        out.write_all(&total.to_le_bytes())?;
        chunks().try_for_each(|(bytes, name)| {
            out.write_all(&(bytes.len() as u32).to_le_bytes())?;
            out.write_all(*name)?;
            out.write_all(bytes)
        })
    }
}

/// The corners of triangles in a row.
fn flat(triangles: &[[u32; 3]]) -> Vec<u32> {
    triangles.iter().flatten().copied().collect()
}

fn material([r, g, b, a]: [f64; 4]) -> Value {
    let mut material = json!({
        "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, a], "metallicFactor": 0.0, "roughnessFactor": 0.9 },
    });
    if a < 1.0 {
        material["alphaMode"] = json!("BLEND");
    }
    material
}

/// From sRGB to linear.
fn linear(c: f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::*;
    use nalgebra::Vector3;

    /// Both chunks of a file.
    fn read(file: &[u8]) -> (Value, Vec<u8>) {
        let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|k| file[at + k])) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let length = word(12);
        assert_eq!((&file[16..20], length % 4), (&b"JSON"[..], 0));
        let rest = &file[20 + length..];
        let binary = if rest.is_empty() { Vec::new() } else { rest[8..].to_vec() };
        (serde_json::from_slice(&file[20..20 + length]).unwrap(), binary)
    }

    #[test]
    fn each_layer_is_a_node_with_its_surface_and_its_beads() {
        let triangle = |z| Mesh {
            vertices: [[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]].map(|[x, y]| Point3::new(x, y, z)).to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        let at = |x, layer, kind| Step {
            tip: Point3::new(x, 1.0, f64::from(layer)),
            direction: Vector3::z(),
            width: 1.0,
            height: 1.0,
            kind,
            layer,
            path: layer,
            seconds: 1.0,
        };
        let steps =
            vec![at(0.0, 0, Step::TRAVEL), at(1.0, 0, 0), at(2.0, 0, 0), at(0.0, 1, Step::TRAVEL), at(5.0, 1, 0)];
        let model = Model { name: "two".into(), layers: [1.0, 2.0].map(triangle).to_vec(), steps, ..Model::default() };
        let mut file = Vec::new();
        model.write_glb(&mut file).unwrap();
        let (json, binary) = read(&file);
        let names: Vec<&str> =
            json["nodes"].as_array().unwrap().iter().map(|node| node["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["layer 1", "layer 2", "two"]);
        let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
        assert_eq!((primitives.len(), &primitives[0]["mode"], &primitives[1]["mode"]), (2, &json!(4), &json!(1)));
        // Two beads of layer 1 share a point: three points, four ends.
        let accessor = |at: &Value| &json["accessors"][at.as_u64().unwrap() as usize];
        let points = accessor(&primitives[1]["attributes"]["POSITION"]);
        assert_eq!(
            (&points["count"], &points["min"], &points["max"]),
            (&json!(3), &json!([0.0, 1.0, 0.0]), &json!([2.0, 1.0, 0.0]))
        );
        let ends = accessor(&primitives[1]["indices"]);
        let view = &json["bufferViews"][ends["bufferView"].as_u64().unwrap() as usize];
        let begin = view["byteOffset"].as_u64().unwrap() as usize;
        let numbers: Vec<u32> =
            binary[begin..begin + 16].chunks(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(numbers, [0, 1, 1, 2]);
        assert_eq!(json["buffers"][0]["byteLength"], binary.len());
    }

    #[test]
    fn an_empty_build_has_a_root_and_nothing_else() {
        let mut file = Vec::new();
        Model::default().write_glb(&mut file).unwrap();
        let (json, binary) = read(&file);
        assert_eq!((json["nodes"].as_array().unwrap().len(), json.get("meshes"), binary.len()), (1, None, 0));
    }
}
