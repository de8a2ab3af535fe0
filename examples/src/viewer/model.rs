//! What is shown, and how it is packed.

use super::columns::Columns;
use super::mesh::Mesh;
use super::simplify::clustered;
use crate::render::ramp;
use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::{Value, json};

/// Triangles of the part from which on it is simplified.
const PART_TRIANGLES: usize = 60_000;
/// Triangles of all layers together from which on they are.
const LAYER_TRIANGLES: usize = 250_000;
/// Cubes along the longest edge, for each.
const PART_CUBES: f64 = 160.0;
const LAYER_CUBES: f64 = 110.0;

/// Parts of a second in which time is counted.
const TICKS: f64 = 1000.0;
/// Steps between the colours of the ramp.
const RAMP: u32 = 32;

/// Parts of the largest width and height.
const SIZES: f64 = 255.0;

/// The build, in millimetres, in the frame of the part with the plate as the plane z = 0.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// What it is.
    pub name: String,
    /// The part as it was given.
    pub part: Mesh,
    /// What the part is built on, besides the plate; empty for nothing.
    pub mould: Mesh,
    /// Corners of the plate, around it.
    pub plate: Vec<Point3<f64>>,
    /// The surfaces of the layers.
    pub layers: Vec<Mesh>,
    /// Lines at which surfaces end inside the part, each with its layer, from 0.
    pub ends: Vec<(u32, [Point3<f64>; 2])>,
    /// Names of the kinds of beads; [`Step::kind`] counts them.
    pub kinds: Vec<String>,
    /// All that the nozzle does, one after the other.
    pub steps: Vec<Step>,
    /// Findings that have places.
    pub marks: Vec<Marks>,
    /// The shape of the nozzle.
    pub nozzle: Option<Nozzle>,
    /// The robot that moves it, or the part.
    pub robot: Option<Robot>,
    /// Length in millimetres and volume in cubic millimetres of all that is laid, as the rest of the report has them; without,
    /// those of the steps.
    pub laid: Option<[f64; 2]>,
    /// Density of the material in grams per cubic centimetre, for masses.
    pub density_g_cm3: Option<f64>,
}

/// A straight step of the nozzle, from where the step before ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Where the tip is at its end.
    pub tip: Point3<f64>,
    /// How the nozzle stands at its end, away from the part.
    pub direction: Vector3<f64>,
    /// Width of the bead.
    pub width: f64,
    /// Height of the bead.
    pub height: f64,
    /// The kind of bead, from 0, or [`Step::TRAVEL`].
    pub kind: u8,
    /// The layer, from 0.
    pub layer: u32,
    /// The path, from 0, in the order in which they are printed.
    pub path: u32,
    /// How long it takes.
    pub seconds: f64,
}

impl Step {
    /// The kind of a step that lays nothing.
    pub const TRAVEL: u8 = 255;
}

/// A finding in plain words, and its places.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// What is wrong.
    pub what: String,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// Where.
    pub places: Vec<Mark>,
}

/// A place of a finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Where.
    pub at: Point3<f64>,
    /// The layer, from 0, and the path there, if it is on one.
    pub path: Option<u32>,
}

/// The nozzle: a flat tip, a cone, a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nozzle {
    /// Diameter of the tip.
    pub tip: f64,
    /// Half the angle of the cone, in degrees.
    pub half_angle_deg: f64,
    /// Height of the cone.
    pub cone: f64,
    /// Diameter of the block above it.
    pub block: f64,
}

/// A robot, as bones between its joints, over time.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// What it is.
    pub name: String,
    /// Largest speed of each joint, in radians a second.
    pub speeds: Vec<f64>,
    /// Whether it is shown before anybody asks for it.
    pub is_shown: bool,
    /// How it stands, from time to time.
    pub stances: Vec<Stance>,
}

/// A robot at a time, in the frame of its base.
#[derive(Clone, Debug)]
pub struct Stance {
    /// Seconds since the first step began.
    pub seconds: f64,
    /// Joint angles in radians.
    pub joints: Vec<f64>,
    /// From joint to joint.
    pub bones: Vec<[Point3<f64>; 2]>,
    /// The frame of the part.
    pub part: Isometry3<f64>,
}

/// The cube in which places are whole numbers of 16 bits.
struct Cube {
    low: Point3<f64>,
    high: Point3<f64>,
    edge: f64,
    /// Millimetres from a number to the next.
    step: f64,
}

impl Cube {
    fn new([low, high]: [Point3<f64>; 2]) -> Self {
        let edge = (high - low).max().max(1e-6);
        Cube { low, high, edge, step: edge / 65535.0 }
    }

    /// Adds a column for each axis.
    fn add_points(&self, columns: &mut Columns, name: &str, points: &mut dyn Iterator<Item = Point3<f64>>) {
        let place = |at: f64, axis: usize| ((at - self.low[axis]) / self.step).round().clamp(0.0, 65535.0) as u32;
        let points: Vec<Point3<f64>> = points.collect();
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            columns.add::<2>(&format!("{name}.{letter}"), points.iter().map(|point| place(point[axis], axis)));
        }
    }
}

impl Model {
    /// The figures, and the columns deflated.
    pub(super) fn pack(&self) -> (Value, Vec<u8>) {
        let cube = Cube::new(self.bounds());
        let mut columns = Columns::default();
        let sizes = self.pack_steps(&cube, &mut columns);
        for (name, solid) in [("part", &self.part), ("mould", &self.mould)] {
            let is_fine = solid.triangles.len() > PART_TRIANGLES;
            let solid = if is_fine { &clustered(solid, cube.edge / PART_CUBES) } else { solid };
            cube.add_points(&mut columns, name, &mut solid.vertices.iter().copied());
            columns.add::<4>(&format!("{name}.corner"), solid.triangles.iter().flatten().copied());
        }
        self.pack_layers(&cube, &mut columns);
        cube.add_points(&mut columns, "end", &mut self.ends.iter().flat_map(|(_, line)| *line));
        columns.add::<4>("end.layer", self.ends.iter().map(|(layer, _)| *layer));
        let places = || self.marks.iter().flat_map(|marks| &marks.places);
        cube.add_points(&mut columns, "mark", &mut places().map(|place| place.at));
        columns.add::<4>("mark.path", places().map(|place| place.path.unwrap_or(u32::MAX)));
        let robot = self.robot.as_ref().map(|robot| robot.pack(&mut columns));
        let (names, deflated) = columns.finish();
        (self.header(&cube, sizes, &robot, &names), deflated)
    }

    /// The columns of the steps. Returns the greatest width and height of a bead, which their columns are shares of.
    fn pack_steps(&self, cube: &Cube, columns: &mut Columns) -> [f64; 2] {
        cube.add_points(columns, "step", &mut self.steps.iter().map(|step| step.tip));
        let [width, height] =
            [|s: &Step| s.width, |s: &Step| s.height].map(|of| self.steps.iter().map(of).fold(1e-9, f64::max));
        let octahedral: Vec<[u32; 2]> = self.steps.iter().map(|step| octahedral(&step.direction)).collect();
        columns.add::<1>("step.u", octahedral.iter().map(|uv| uv[0]));
        columns.add::<1>("step.v", octahedral.iter().map(|uv| uv[1]));
        columns.add::<1>("step.w", self.steps.iter().map(|step| (step.width / width * SIZES).round() as u32));
        columns.add::<1>("step.h", self.steps.iter().map(|step| (step.height / height * SIZES).round() as u32));
        columns.add::<1>("step.kind", self.steps.iter().map(|step| u32::from(step.kind)));
        // Rounded as sums, so that nothing adds up.
        let ticks = self.steps.iter().scan(0.0, |now, step| {
            *now += step.seconds;
            Some((*now * TICKS).round() as u32)
        });
        columns.add::<4>("step.t", ticks);
        columns.add::<4>("step.layer", self.steps.iter().map(|step| step.layer));
        columns.add::<4>("step.path", self.steps.iter().map(|step| step.path));
        [width, height]
    }

    /// The columns of the layers' surfaces, coarser where they have many triangles.
    fn pack_layers(&self, cube: &Cube, columns: &mut Columns) {
        let many = self.layers.iter().map(|layer| layer.triangles.len()).sum::<usize>() > LAYER_TRIANGLES;
        let fewer = |layer: &Mesh| if many { clustered(layer, cube.edge / LAYER_CUBES) } else { layer.clone() };
        let layers: Vec<Mesh> = self.layers.iter().map(fewer).collect();
        cube.add_points(columns, "sheet", &mut layers.iter().flat_map(|layer| layer.vertices.iter().copied()));
        let firsts: Vec<u32> = starts(layers.iter().map(|layer| layer.vertices.len()));
        let corners = layers
            .iter()
            .zip(&firsts)
            .flat_map(|(layer, first)| layer.triangles.iter().flatten().map(move |c| c + first));
        columns.add::<4>("sheet.corner", corners);
        columns.add::<4>("sheet.first", starts(layers.iter().map(|layer| 3 * layer.triangles.len())).into_iter());
    }

    /// What the viewer knows besides the columns.
    fn header(&self, cube: &Cube, [width, height]: [f64; 2], robot: &Option<Value>, names: &Value) -> Value {
        let [low, high] = [cube.low, cube.high];
        let nozzle = self.nozzle.map(|nozzle| [nozzle.tip, nozzle.half_angle_deg, nozzle.cone, nozzle.block]);
        let [mm, mm3] = self.laid.unwrap_or_else(|| self.laid_by_steps());
        // What is framed: what is built, with room for the nozzle on it; travels of a robot to its home are far away.
        let built = self.built();
        let [least, most] = built.unwrap_or([low, high]);
        let (middle, diagonal) = (least + (most - least) / 2.0, (most - least).norm());
        let nozzle_mm =
            self.nozzle.filter(|_| built.is_some() && !self.steps.is_empty()).map_or(0.0, |nozzle| nozzle.cone);
        let around_mm = (diagonal + 2.0 * nozzle_mm).max(1e-6);
        json!({
            "name": self.name,
            "low": [low.x, low.y, low.z],
            "high": [high.x, high.y, high.z],
            "built": built.is_some(),
            "middle": [middle.x, middle.y, middle.z],
            "around": around_mm,
            "unit": cube.step,
            "width": width / SIZES,
            "height": height / SIZES,
            "tick": 1.0 / TICKS,
            "steps": self.steps.len(),
            "layers": self.steps.iter().map(|step| step.layer as usize + 1).max().unwrap_or(0).max(self.layers.len()),
            "kinds": self.kinds,
            "marks": self.marks.iter().map(|marks| json!([marks.what, marks.colour, marks.places.len()])).collect::<Vec<_>>(),
            "plate": self.plate.iter().map(|corner| [corner.x, corner.y, corner.z]).collect::<Vec<_>>(),
            "nozzle": nozzle,
            "robot": robot,
            "metres": mm / 1e3,
            "volume": mm3 / 1e3,
            "density": self.density_g_cm3,
            "ramp": (0..=RAMP).map(|at| ramp(f64::from(at) / f64::from(RAMP))).collect::<Vec<_>>(),
            "columns": names,
        })
    }

    /// Length in millimetres and volume in cubic millimetres of all beads, by the steps.
    pub fn laid_by_steps(&self) -> [f64; 2] {
        let laid = self.steps.windows(2).filter(|pair| pair[1].kind != Step::TRAVEL).map(|pair| {
            let mm = (pair[1].tip - pair[0].tip).norm();
            [mm, mm * pair[1].width * pair[1].height]
        });
        laid.fold([0.0; 2], |sum, [mm, mm3]| [sum[0] + mm, sum[1] + mm3])
    }

    /// The box around all that has a place, but for the plate and the robot.
    fn bounds(&self) -> [Point3<f64>; 2] {
        let meshes = [&self.part, &self.mould].into_iter().chain(&self.layers).flat_map(|mesh| &mesh.vertices);
        let marks = self.marks.iter().flat_map(|marks| &marks.places).map(|place| place.at);
        let all = meshes.copied().chain(self.steps.iter().map(|step| step.tip)).chain(marks);
        box_around(all.chain(self.ends.iter().flat_map(|(_, line)| *line))).unwrap_or_default()
    }

    /// The box around the part, what it is built on and its layers; without their meshes around the beads, and none without any.
    fn built(&self) -> Option<[Point3<f64>; 2]> {
        let meshes = [&self.part, &self.mould].into_iter().chain(&self.layers);
        let beads = || self.steps.iter().filter(|step| step.kind != Step::TRAVEL).map(|step| step.tip);
        box_around(meshes.flat_map(|mesh| &mesh.vertices).copied()).or_else(|| box_around(beads()))
    }
}

/// The box around points; none without any.
fn box_around(points: impl Iterator<Item = Point3<f64>>) -> Option<[Point3<f64>; 2]> {
    points.fold(None, |bounds, point| {
        let [low, high] = bounds.unwrap_or([point; 2]);
        Some([low.inf(&point), high.sup(&point)])
    })
}

impl Robot {
    /// Adds its columns; places in the frame of the base are written in hundredths of a millimetre, turns as quaternions in 30000ths.
    fn pack(&self, columns: &mut Columns) -> Value {
        let hundredths = |mm: f64| ((mm * 100.0).round() as i32) as u32;
        let parts = |value: f64| ((value * 30000.0).round() as i32) as u32;
        let stances = || self.stances.iter();
        columns.add::<4>("robot.t", stances().map(|stance| (stance.seconds * TICKS).round() as u32));
        let (bones, joints) = self.stances.first().map_or((0, 0), |stance| (stance.bones.len(), stance.joints.len()));
        for joint in 0..joints {
            columns.add::<4>(&format!("robot.q{joint}"), stances().map(move |stance| parts(stance.joints[joint])));
        }
        for (bone, end, axis) in (0..bones).flat_map(|bone| (0..6).map(move |k| (bone, k / 3, k % 3))) {
            let name = format!("robot.a{bone}.{end}.{axis}");
            columns.add::<4>(&name, stances().map(move |stance| hundredths(stance.bones[bone][end][axis])));
        }
        for axis in 0..3 {
            columns.add::<4>(
                &format!("robot.p{axis}"),
                stances().map(move |stance| hundredths(stance.part.translation.vector[axis])),
            );
        }
        for axis in 0..4 {
            columns.add::<4>(
                &format!("robot.r{axis}"),
                stances().map(move |stance| parts(stance.part.rotation.coords[axis])),
            );
        }
        json!({ "name": self.name, "shown": self.is_shown, "speeds": self.speeds, "joints": joints, "bones": bones, "stances": self.stances.len() })
    }
}

/// Where each of these begins when they are written one after the other, and where the last ends.
fn starts(lengths: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut starts = vec![0];
    for length in lengths {
        starts.push(starts[starts.len() - 1] + length as u32);
    }
    starts
}

/// A direction as two numbers from 0 to 254: the octahedral map (Z. Cigolle et al., "A survey of efficient representations for independent
/// unit vectors", 2014). No direction is more than a degree off.
fn octahedral(direction: &Vector3<f64>) -> [u32; 2] {
    let sum = direction.abs().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return [127; 2];
    }
    let [x, y] = [direction.x / sum, direction.y / sum];
    let sign = |c: f64| if c < 0.0 { -1.0 } else { 1.0 };
    let [u, v] = if direction.z < 0.0 { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] } else { [x, y] };
    [u, v].map(|c| (c * 127.0 + 127.0).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the script does.
    fn unfolded([u, v]: [u32; 2]) -> Vector3<f64> {
        let [u, v] = [u, v].map(|c| f64::from(c) / 127.0 - 1.0);
        let z = 1.0 - u.abs() - v.abs();
        let fold = (-z).max(0.0);
        let back = |c: f64| if c < 0.0 { c + fold } else { c - fold };
        Vector3::new(back(u), back(v), z).normalize()
    }

    proptest! {
        #[test]
        fn directions_come_back_to_a_degree(x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64) {
            let direction = Vector3::new(x, y, z);
            prop_assume!(direction.norm() > 1e-3);
            prop_assert!(unfolded(octahedral(&direction)).angle(&direction).to_degrees() < 1.0);
        }
    }

    #[test]
    fn an_empty_model_and_no_direction_are_packed() {
        let (header, _) = Model::default().pack();
        assert_eq!((&header["layers"], &header["steps"]), (&json!(0), &json!(0)));
        assert_eq!(octahedral(&Vector3::zeros()), [127; 2]);
    }

    #[test]
    fn a_million_steps_take_less_than_15_megabytes_of_a_page() {
        // A bead along a spiral on a dome, whose steps are as long as those of a print.
        let at = |i: usize| {
            let turn = (i as f64 * 0.5).sqrt() * 0.4;
            let radius = 0.03 * turn;
            let tip = Point3::new(radius * turn.cos(), radius * turn.sin(), 30.0 - 0.01 * radius * radius);
            let direction = Vector3::new(0.02 * tip.x, 0.02 * tip.y, 1.0).normalize();
            let width = 0.5 + 0.05 * (turn * 3.0).sin();
            Step {
                tip,
                direction,
                width,
                height: 0.3,
                kind: 1,
                layer: (i / 10_000) as u32,
                path: (i / 1000) as u32,
                seconds: 0.02 + 1e-3 * turn.sin(),
            }
        };
        let model = Model { steps: (0..1_000_000).map(at).collect(), ..Model::default() };
        let (_, deflated) = model.pack();
        assert!(deflated.len() * 4 / 3 < 15_000_000, "{}", deflated.len());
    }
}
