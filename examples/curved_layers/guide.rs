//! What the user guides the order by, in place of one that is searched: a surface (`--base`), directions (`--directions`), or the overhang of the skin (`--max-overhang`).

use crate::complete::LayersBy;
use crate::{Args, failure};
use curvlay_examples::args::Failure;
use curvlay_examples::findings::Findings;
use curvlay_examples::findings::Severity::Warning;
use curvlay_examples::mesh::Mesh;
use curvlay_examples::waypoints::{fault, read_waypoints};
use curvlay_layers::curved::{DirectionAt, LayerOptions, Workpiece};
use nalgebra::{Point3, Vector3};

/// Directions are steeper than the limit from so much on, in degrees: files are rounded.
const ROUNDED_DEG: f64 = 0.01;

/// What layers are guided by.
pub enum Guide {
    /// They are parallel to a surface.
    Base { name: String, mesh: Mesh },
    /// They follow directions.
    Directions { name: String, places: Vec<DirectionAt> },
    /// They are as level as this overhang of the skin allows, in radians.
    Overhang(f64),
}

/// A guide, cell by cell.
#[derive(Default)]
pub struct Guided {
    pub heights: Option<Vec<f64>>,
    pub directions: Option<Vec<Vector3<f64>>>,
    /// Those that were given.
    pub given: Option<GivenDirections>,
}

/// How far directions that were given are followed.
#[derive(Clone, Debug)]
pub struct GivenDirections {
    pub name: String,
    pub places: usize,
    /// How many lie in no cell of the part.
    pub outside: usize,
    /// How many lean from upright by more than layers may lean, and what that is, in degrees.
    pub too_steep: usize,
    pub max_tilt_deg: f64,
}

impl Guide {
    /// What the arguments ask for, read.
    pub fn of(args: &Args) -> Result<Option<Self>, Failure> {
        if let Some(path) = &args.base {
            let name = path.display().to_string();
            return Ok(Some(Guide::Base { name, mesh: args.mesh.load_surface(path)? }));
        }
        if let Some(path) = &args.directions {
            let (name, placement) = (path.display().to_string(), args.mesh.placement());
            let places = read_waypoints(path)?.into_iter().map(|line| {
                let [x, y, z, i, j, k] = line.values;
                let direction = Vector3::from(placement.up.turned([i, j, k]));
                if line.values.iter().any(|value| !value.is_finite()) || direction.norm() == 0.0 {
                    let why = "six finite numbers `x y z i j k`, and a direction that is longer than 0";
                    return Err(fault(path, &format!("line {} must have {why}", line.number)));
                }
                Ok(DirectionAt { place: placement.place([x, y, z]), direction })
            });
            return Ok(Some(Guide::Directions { name, places: places.collect::<Result<_, _>>()? }));
        }
        Ok(args.max_overhang_deg.map(|degrees| Guide::Overhang(degrees.to_radians())))
    }

    /// The order that it guides.
    pub fn layers_by(args: &Args) -> Option<LayersBy> {
        let directed = args.directions.is_some() || args.max_overhang_deg.is_some();
        args.base.as_ref().map(|_| LayersBy::Distance).or(directed.then_some(LayersBy::Directed))
    }

    /// What layers do, in words for people; nothing where they are not guided.
    pub fn words(args: &Args) -> Option<String> {
        let [base, directions] = [&args.base, &args.directions].map(|path| path.as_ref().map(|path| path.display()));
        let base = base.map(|name| format!("layers parallel to {name}"));
        let directions = directions.map(|name| format!("layers across the directions of {name}"));
        let overhang = args.max_overhang_deg;
        base.or(directions)
            .or(overhang.map(|degrees| format!("layers as level as an overhang of {degrees} degrees allows")))
    }

    /// As it holds for the cells of a part, whose file lay elsewhere by `shift`.
    pub fn in_cells(&self, part: &Workpiece, shift: Vector3<f64>, options: &LayerOptions) -> Result<Guided, Failure> {
        match self {
            Guide::Base { name, mesh } => {
                let vertices: Vec<Point3<f64>> = mesh.vertices.iter().map(|vertex| vertex + shift).collect();
                let heights = part.heights_over(&vertices, &mesh.triangles);
                let heights = heights.map_err(|error| failure(format!("{name}: {error}")))?;
                Ok(Guided { heights: Some(heights), ..Guided::default() })
            }
            Guide::Directions { name, places } => {
                let shifted: Vec<DirectionAt> =
                    places.iter().map(|at| DirectionAt { place: at.place + shift, ..*at }).collect();
                let found = part.directions_at(&shifted).map_err(|error| failure(format!("{name}: {error}")))?;
                let max_tilt = options.directed.tilt_for(&options.rule)?;
                let is_too_steep =
                    |at: &&DirectionAt| at.direction.angle(&Vector3::z()) > max_tilt + ROUNDED_DEG.to_radians();
                let given = GivenDirections {
                    name: name.clone(),
                    places: places.len(),
                    outside: found.outside,
                    too_steep: places.iter().filter(is_too_steep).count(),
                    max_tilt_deg: max_tilt.to_degrees(),
                };
                Ok(Guided { directions: Some(found.directions), given: Some(given), ..Guided::default() })
            }
            &Guide::Overhang(angle) => {
                Ok(Guided { directions: Some(part.upright_directions(angle)?), ..Guided::default() })
            }
        }
    }
}

impl GivenDirections {
    /// Says which of them are not followed.
    pub fn find(&self, findings: &mut Findings) {
        let GivenDirections { name, places, outside, too_steep, max_tilt_deg } = self;
        let of_all = |count: &usize| format!("{count} of {places}");
        if *outside > 0 {
            findings.add(
                Warning,
                format!("{name}: places lie outside of the part, and count for nothing"),
                of_all(outside),
                "",
            );
        }
        if *too_steep > 0 {
            let limit = "layers follow them up to that tilt";
            let what = format!(
                "{name}: directions lean from upright by more than {max_tilt_deg:.0} degrees: {limit} (--max-layer-tilt)"
            );
            findings.add(Warning, what, of_all(too_steep), "");
        }
    }
}
