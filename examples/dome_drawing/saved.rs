//! A planned print in a file (`plan.json`): all that the program is written from, so that `--plan` writes it again without planning.

use super::fault::fault;
use super::plan::Planned;
use super::platform::platform;
use super::setup::Setup;
use super::{Args, FillKind};
use curvlay_examples::args::Failure;
use curvlay_examples::input::read_text;
use curvlay_examples::json::JsonFault;
use curvlay_kinematics::nalgebra::{Point3, Unit, Vector3};
use curvlay_kinematics::program::DomeStroke;
use curvlay_kinematics::scene::Shape;
use curvlay_toolpath::drawing::{SpacePath, StrokeKind};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::Path;

/// What the file says first, and the version of the format.
const FORMAT: &str = "curvlay-dome-plan";
const VERSION: u64 = 1;

/// Largest file that is read. A point takes some 100 bytes; the plan of the thesis' design has 11 MB.
const MAX_BYTES: u64 = 1 << 28;

/// Lengths beyond are a slip, in millimetres or turns a minute.
const MOST: f64 = 1e5;

/// Normals have the length 1 within this.
const UNIT: f64 = 1e-6;

/// A planned print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    format: String,
    version: u64,
    /// Of the design.
    pub name: String,
    /// The rig, the speeds and the heights.
    pub setup: Setup,
    /// Height of a layer of beads.
    pub layer_height_mm: f64,
    /// Added to the height of the nozzle over the surface.
    pub nozzle_height_mm: f64,
    /// What the arm holds, as a body.
    platform: Platform,
    /// In the order in which they are printed.
    pub strokes: Vec<PlanStroke>,
}

/// The body of the platform, in its frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Platform {
    /// The convex hull of points.
    Hull { points: Vec<[f64; 3]> },
    /// A mesh.
    Mesh { points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]> },
}

/// A stroke on the platform.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanStroke {
    pub kind: PlanKind,
    /// Of beads, from 1.
    pub layer: u32,
    pub width_mm: f64,
    /// Whether it returns to its begin, which its points have again at the end.
    pub closed: bool,
    /// Speed of the extruder.
    pub extruder_rpm: f64,
    /// How far the nozzle is above the points.
    pub lift_mm: f64,
    /// Place and normal, along which the tool comes.
    pub points: Vec<[f64; 6]>,
}

/// What a stroke is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanKind {
    Outline,
    Fill,
    Open,
}

impl PlanKind {
    pub fn name(self) -> &'static str {
        match self {
            PlanKind::Outline => "outline",
            PlanKind::Fill => "fill",
            PlanKind::Open => "open",
        }
    }
}

/// Why a file is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// It says another format, or none.
    #[error("not a plan: its `format` must be `{FORMAT}`")]
    Format,
    /// Of another version.
    #[error("it has version {found}: this program reads version {VERSION}")]
    Version { found: u64 },
    /// JSON that cannot be, a field that is missing or unknown.
    #[error("{0}")]
    Json(JsonFault),
    /// The setup has a value that cannot be.
    #[error("`setup.{key}` {what}")]
    Setup { key: &'static str, what: String },
    /// A value that cannot be.
    #[error("`{field}` is {value}: it must be {must}")]
    Value { field: String, value: f64, must: &'static str },
    /// Nothing is printed.
    #[error("it has no strokes")]
    Empty,
    /// A stroke has fewer than two points.
    #[error("stroke {stroke} has {points} points: it must have two or more")]
    Short { stroke: usize, points: usize },
    /// A layer comes after a higher one.
    #[error("stroke {stroke} is in layer {layer}, after one in layer {before}: layers must be printed from 1 upwards")]
    Order { stroke: usize, layer: u32, before: u32 },
    /// A closed stroke does not end where it begins.
    #[error("stroke {stroke} is closed, but its last point is not its first")]
    Closed { stroke: usize },
    /// A triangle of the platform names a point that does not exist.
    #[error("triangle {triangle} of the platform names point {point} of {points}")]
    Triangle { triangle: usize, point: u32, points: usize },
}

/// What is read of any version.
#[derive(Deserialize)]
struct Head {
    format: Option<String>,
    version: Option<u64>,
}

impl From<serde_json::Error> for PlanError {
    fn from(error: serde_json::Error) -> Self {
        PlanError::Json(JsonFault::from(&error))
    }
}

impl Plan {
    /// The plan of a drawing.
    pub fn of(args: &Args, planned: &Planned) -> Self {
        let stroke = |on_surface: &super::plan::OnSurface| {
            let stroke = planned.flat(on_surface);
            let separate = stroke.kind == StrokeKind::Fill && args.fill != FillKind::Spiral;
            PlanStroke {
                kind: match stroke.kind {
                    StrokeKind::Outline => PlanKind::Outline,
                    StrokeKind::Fill => PlanKind::Fill,
                    StrokeKind::Open => PlanKind::Open,
                },
                layer: on_surface.layer + 1,
                width_mm: stroke.width,
                closed: stroke.closed,
                extruder_rpm: args.setup.rpm_per_mm() * stroke.width,
                lift_mm: if separate { args.setup.fill_lift_mm() } else { 0.0 },
                points: on_surface
                    .points
                    .iter()
                    .map(|at| {
                        let (p, n) = (at.position, at.normal);
                        [p.x, p.y, p.z, n.x, n.y, n.z]
                    })
                    .collect(),
            }
        };
        Plan {
            format: FORMAT.to_owned(),
            version: VERSION,
            name: planned.name.clone(),
            setup: args.setup.clone(),
            layer_height_mm: args.layer_height_mm,
            nozzle_height_mm: args.nozzle_height_mm,
            platform: match platform(args, planned) {
                Shape::Mesh { points, triangles } => {
                    Platform::Mesh { points: points.into_iter().map(Into::into).collect(), triangles }
                }
                Shape::Hull { points, .. } => Platform::Hull { points: points.into_iter().map(Into::into).collect() },
                _ => unreachable!("a platform is a hull or a mesh"),
            },
            strokes: planned.strokes.iter().map(stroke).collect(),
        }
    }

    /// Reads the plan of a file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = read_text(path, MAX_BYTES)?;
        Plan::from_json(&text).map_err(|error| fault(path, error))
    }

    /// Reads a plan.
    fn from_json(text: &str) -> Result<Self, PlanError> {
        let head: Head = serde_json::from_str(text)?;
        if head.format.as_deref() != Some(FORMAT) {
            return Err(PlanError::Format);
        }
        match head.version {
            Some(VERSION) | None => {}
            Some(found) => return Err(PlanError::Version { found }),
        }
        let plan: Plan = serde_json::from_str(text)?;
        plan.check()?;
        Ok(plan)
    }

    fn check(&self) -> Result<(), PlanError> {
        self.setup.check().map_err(|(key, what)| PlanError::Setup { key, what })?;
        let value = |field: String, value: f64, low: f64, must: &'static str| {
            if (low..=MOST).contains(&value) { Ok(()) } else { Err(PlanError::Value { field, value, must }) }
        };
        let above = |field: String, number: f64| value(field, number, f64::MIN_POSITIVE, "above 0, and at most 1e5");
        let any = |field: String, number: f64| value(field, number, -MOST, "from -1e5 to 1e5");
        above("layer_height_mm".to_owned(), self.layer_height_mm)?;
        any("nozzle_height_mm".to_owned(), self.nozzle_height_mm)?;
        let points = match &self.platform {
            Platform::Hull { points } | Platform::Mesh { points, .. } => points,
        };
        for (k, point) in points.iter().enumerate() {
            point.iter().try_for_each(|&c| any(format!("platform: point {k}"), c))?;
        }
        if let Platform::Mesh { triangles, .. } = &self.platform {
            for (triangle, corners) in triangles.iter().enumerate() {
                if let Some(&point) = corners.iter().find(|&&point| point as usize >= points.len()) {
                    return Err(PlanError::Triangle { triangle, point, points: points.len() });
                }
            }
        }
        let mut before = 1;
        if self.strokes.is_empty() {
            return Err(PlanError::Empty);
        }
        for (k, stroke) in self.strokes.iter().enumerate() {
            let PlanStroke { layer, closed, ref points, .. } = *stroke;
            above(format!("strokes[{k}].width_mm"), stroke.width_mm)?;
            value(format!("strokes[{k}].extruder_rpm"), stroke.extruder_rpm, 0.0, "from 0 to 1e5")?;
            any(format!("strokes[{k}].lift_mm"), stroke.lift_mm)?;
            if points.len() < 2 {
                return Err(PlanError::Short { stroke: k, points: points.len() });
            }
            if layer < before {
                return Err(PlanError::Order { stroke: k, layer, before });
            }
            before = layer;
            for (at, point) in points.iter().enumerate() {
                let [x, y, z, nx, ny, nz] = *point;
                [x, y, z].into_iter().try_for_each(|c| any(format!("strokes[{k}].points[{at}]"), c))?;
                let length = Vector3::new(nx, ny, nz).norm();
                if length.is_nan() || (length - 1.0).abs() > UNIT {
                    let field = format!("length of the normal of strokes[{k}].points[{at}]");
                    return Err(PlanError::Value { field, value: length, must: "1" });
                }
            }
            let ends = [0, points.len() - 1].map(|at| Point3::new(points[at][0], points[at][1], points[at][2]));
            if closed && ends[0] != ends[1] {
                return Err(PlanError::Closed { stroke: k });
            }
        }
        Ok(())
    }

    /// As a file has it: a stroke a line.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let head = serde_json::to_string(&self.without_strokes()).map_err(io::Error::other)?;
        let head = head.strip_suffix("]}").unwrap_or(&head);
        writeln!(out, "{head}")?;
        for (k, stroke) in self.strokes.iter().enumerate() {
            let end = if k + 1 < self.strokes.len() { "," } else { "" };
            writeln!(out, "{}{end}", serde_json::to_string(stroke).map_err(io::Error::other)?)?;
        }
        writeln!(out, "]}}")
    }

    fn without_strokes(&self) -> Plan {
        Plan {
            format: self.format.clone(),
            version: self.version,
            name: self.name.clone(),
            setup: self.setup.clone(),
            platform: self.platform.clone(),
            strokes: Vec::new(),
            ..*self
        }
    }

    /// The strokes for the robot.
    pub fn dome_strokes(&self) -> Vec<DomeStroke> {
        let at = |&[x, y, z, nx, ny, nz]: &[f64; 6]| {
            // As it was written, to the last bit.
            (Point3::new(x, y, z), Unit::new_unchecked(Vector3::new(nx, ny, nz)))
        };
        let stroke = |stroke: &PlanStroke| DomeStroke {
            points: stroke.points.iter().map(at).collect(),
            closed: stroke.closed,
            feed: stroke.extruder_rpm,
            above: stroke.lift_mm,
        };
        self.strokes.iter().map(stroke).collect()
    }

    /// The body of the platform.
    pub fn shape(&self) -> Shape {
        let placed = |points: &[[f64; 3]]| points.iter().map(|&p| Point3::from(p)).collect();
        match &self.platform {
            Platform::Hull { points } => Shape::Hull { points: placed(points), radius: 0.0 },
            Platform::Mesh { points, triangles } => {
                Shape::Mesh { points: placed(points), triangles: triangles.clone() }
            }
        }
    }

    /// Points of outlines and open contours, and of fill.
    pub fn points(&self) -> [usize; 2] {
        let mut counts = [0, 0];
        for stroke in &self.strokes {
            counts[usize::from(stroke.kind == PlanKind::Fill)] += stroke.points.len();
        }
        counts
    }

    /// A line for each point.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "stroke,kind,layer,width_mm,x_mm,y_mm,z_mm,nx,ny,nz")?;
        for (number, stroke) in self.strokes.iter().enumerate() {
            for [x, y, z, nx, ny, nz] in &stroke.points {
                write!(out, "{number},{},{},{:.4}", stroke.kind.name(), stroke.layer, stroke.width_mm)?;
                writeln!(out, ",{x:.4},{y:.4},{z:.4},{nx:.6},{ny:.6},{nz:.6}")?;
            }
        }
        Ok(())
    }

    /// The strokes in space, a layer of a DXF file for each kind and layer of beads.
    pub fn in_space(&self) -> Vec<SpacePath> {
        let path = |stroke: &PlanStroke| {
            let mut points: Vec<Point3<f64>> = stroke.points.iter().map(|p| Point3::new(p[0], p[1], p[2])).collect();
            points.truncate(points.len() - usize::from(stroke.closed));
            SpacePath { layer: format!("{} {}", stroke.kind.name(), stroke.layer), points, closed: stroke.closed }
        };
        self.strokes.iter().map(path).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Plan {
        let third = 1.0 / 3.0;
        let normal = Vector3::new(0.1, third, 0.9).normalize();
        let at = |x: f64| [x, third, 149.6, normal.x, normal.y, normal.z];
        let stroke = |kind, layer, closed| PlanStroke {
            kind,
            layer,
            width_mm: 3.2,
            closed,
            extruder_rpm: 4.0 * third,
            lift_mm: 0.2,
            points: vec![at(0.1 + 0.2), at(5e-324), at(0.1 + 0.2)],
        };
        Plan {
            format: FORMAT.to_owned(),
            version: VERSION,
            name: "rosette \"a\"".to_owned(),
            setup: Setup::default(),
            layer_height_mm: 1.0,
            nozzle_height_mm: -0.1,
            platform: Platform::Mesh { points: vec![[0.0, third, 1.0]; 3], triangles: vec![[0, 1, 2]] },
            strokes: vec![stroke(PlanKind::Outline, 1, true), stroke(PlanKind::Fill, 2, false)],
        }
    }

    fn text(plan: &Plan) -> String {
        let mut bytes = Vec::new();
        plan.write(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn a_plan_comes_back_bit_for_bit() {
        for platform in [plan().platform, Platform::Hull { points: vec![[0.1 + 0.2, 1e-300, 0.0]] }] {
            let plan = Plan { platform, ..plan() };
            let written = text(&plan);
            let back = Plan::from_json(&written).unwrap();
            assert_eq!(back, plan);
            assert_eq!(text(&back), written);
            let bits = |plan: &Plan| -> Vec<u64> {
                plan.strokes.iter().flat_map(|s| &s.points).flatten().map(|c| c.to_bits()).collect()
            };
            assert_eq!(bits(&back), bits(&plan));
            // A foreign reader takes it as well.
            let value: serde_json::Value = serde_json::from_str(&written).unwrap();
            assert_eq!(value["strokes"][1]["kind"], "fill");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let of = |change: &dyn Fn(&mut Plan)| {
            let mut plan = plan();
            change(&mut plan);
            Plan::from_json(&text(&plan)).unwrap_err()
        };
        assert_eq!(Plan::from_json("{\"version\": 1}"), Err(PlanError::Format));
        assert_eq!(of(&|plan| plan.version = 2), PlanError::Version { found: 2 });
        assert_eq!(of(&|plan| plan.strokes.clear()), PlanError::Empty);
        assert_eq!(of(&|plan| plan.strokes[1].points.truncate(1)), PlanError::Short { stroke: 1, points: 1 });
        assert_eq!(of(&|plan| plan.strokes[0].layer = 3), PlanError::Order { stroke: 1, layer: 2, before: 3 });
        assert_eq!(of(&|plan| plan.strokes[0].layer = 0), PlanError::Order { stroke: 0, layer: 0, before: 1 });
        assert_eq!(of(&|plan| plan.strokes[0].points.truncate(2)), PlanError::Closed { stroke: 0 });
        let triangle = of(&|plan| {
            plan.platform = Platform::Mesh { points: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 3]] };
        });
        assert_eq!(triangle, PlanError::Triangle { triangle: 0, point: 3, points: 3 });
        let field = |error: PlanError| match error {
            PlanError::Value { field, .. } => field,
            other => panic!("{other}"),
        };
        assert_eq!(field(of(&|plan| plan.strokes[1].width_mm = 0.0)), "strokes[1].width_mm");
        assert_eq!(field(of(&|plan| plan.layer_height_mm = -1.0)), "layer_height_mm");
        assert_eq!(field(of(&|plan| plan.strokes[1].points[2][0] = 1e6)), "strokes[1].points[2]");
        assert_eq!(
            field(of(&|plan| plan.strokes[1].points[0][4] = 0.9)),
            "length of the normal of strokes[1].points[0]"
        );
        // What is no number is written as null.
        let line = |error: PlanError| match error {
            PlanError::Json(JsonFault { line, what, .. }) => (line, what),
            other => panic!("{other}"),
        };
        let (at, what) = line(of(&|plan| plan.strokes[0].points[1][2] = f64::NAN));
        assert!(at == 2 && what.contains("null"), "{at} {what}");
        let broken = |from: &str, to: &str| line(Plan::from_json(&text(&plan()).replace(from, to)).unwrap_err());
        assert!(broken("\"lift_mm\":0.2,", "").1.contains("missing field `lift_mm`"));
        assert!(broken("\"version\":1,\"name\"", "\"name\"").1.contains("missing field `version`"));
        assert!(broken("\"closed\":false", "\"shut\":false").1.contains("unknown field `shut`"));
        assert!(broken("\n]}", "").1.contains("EOF"));
        let setup = text(&plan()).replace("\"hop_mm\":", "\"hop_mm\":-");
        assert!(matches!(Plan::from_json(&setup), Err(PlanError::Setup { key: "hop_mm", .. })));
    }
}
