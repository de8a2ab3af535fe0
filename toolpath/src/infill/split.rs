//! The refined mesh of a layer, cut where walls end and where skins end.
//!
//! Both functions are linear over triangles, so the cuts are straight there. A cut that would pass very near a vertex is moved away from
//! it a little: pieces are then no slivers beyond what the mesh had.

use crate::level_set::LevelField;
use crate::mesh::{MeshError, SurfaceMesh, on_mesh_triangle};
use nalgebra::Point3;
use std::collections::BTreeMap;

/// Cuts keep this share of an edge from its ends. Much less makes slivers, much more moves cuts by what can be seen.
const NEAR_END: f64 = 1e-3;

/// What a triangle is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// It is under a wall, or too narrow for any bead.
    Wall,
    Skin,
    Sparse,
}

/// Triangles, each in one region.
pub(super) struct Sheet {
    pub points: Vec<Point3<f64>>,
    /// At each point how far it is inward of the walls, and how far inside of a skin.
    pub values: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
    /// The triangle of the mesh of the layer that has each.
    pub parents: Vec<u32>,
    /// Whether each is inward of the walls, and inside of a skin.
    sides: Vec<[bool; 2]>,
    pub classes: Vec<Class>,
}

impl Sheet {
    /// Cuts the mesh of a field. `inside`: by vertex of the field; `skin`: by vertex of its mesh; what is sparse reaches `overlap` into both.
    pub fn new(field: &LevelField, inside: &[f64], skin: &[f64], overlap: f64) -> Sheet {
        let mesh = field.distance().mesh();
        let mut values: Vec<[f64; 2]> = inside.iter().map(|&inside| [inside + overlap, 0.0]).collect();
        for (corners, &parent) in field.triangles.iter().zip(field.parents()) {
            let at = mesh.triangles()[parent as usize].map(|v| skin[v as usize] - overlap);
            for &v in corners {
                let (_, weights) = on_mesh_triangle(mesh, parent, field.points[v as usize]);
                values[v as usize][1] = at[0] * weights[0] + at[1] * weights[1] + at[2] * weights[2];
            }
        }
        let mut sheet = Sheet {
            points: field.points.clone(),
            values,
            triangles: field.triangles.clone(),
            parents: field.parents().to_vec(),
            sides: vec![[false; 2]; field.triangles.len()],
            classes: Vec::new(),
        };
        sheet.cut(0);
        sheet.cut(1);
        let class = |&[inside, skin]: &[bool; 2]| match (inside, skin) {
            (false, _) => Class::Wall,
            (true, true) => Class::Skin,
            (true, false) => Class::Sparse,
        };
        sheet.classes = sheet.sides.iter().map(class).collect();
        sheet
    }

    /// Cuts all triangles where a value is 0.
    fn cut(&mut self, k: usize) {
        let whole = std::mem::take(&mut self.triangles);
        let (parents, sides) = (std::mem::take(&mut self.parents), std::mem::take(&mut self.sides));
        let mut on_edge: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for ((corners, parent), side) in whole.into_iter().zip(parents).zip(sides) {
            let above = corners.map(|v| self.values[v as usize][k] > 0.0);
            let mut add = |corners: [u32; 3], above: bool| {
                let mut side = side;
                side[k] = above;
                self.triangles.push(corners);
                self.parents.push(parent);
                self.sides.push(side);
            };
            let Some(alone) = (0..3).find(|&c| above[c] != above[(c + 1) % 3] && above[c] != above[(c + 2) % 3]) else {
                add(corners, above[0]);
                continue;
            };
            let [a, b, c] = [0, 1, 2].map(|turn| corners[(alone + turn) % 3]);
            let mut on = |from: u32, to: u32| {
                // Always from the lower number, so that both triangles have the same point.
                let ends @ [from, to] = [from.min(to), from.max(to)];
                *on_edge.entry(ends).or_insert_with(|| {
                    let [one, other] = [from, to].map(|v| self.values[v as usize]);
                    let share = (one[k] / (one[k] - other[k])).clamp(NEAR_END, 1.0 - NEAR_END);
                    let [p, q] = [from, to].map(|v| self.points[v as usize]);
                    self.points.push(p + (q - p) * share);
                    self.values.push([0, 1].map(|n| one[n] + (other[n] - one[n]) * share));
                    self.points.len() as u32 - 1
                })
            };
            let (p, q) = (on(a, b), on(c, a));
            add([a, p, q], above[alone]);
            add([p, b, c], !above[alone]);
            add([p, c, q], !above[alone]);
        }
    }

    /// Gives sparse parts that reach no farther than `none` from what is solid to the walls, and those that reach no farther than
    /// `solid` to the skins.
    pub fn classify(&mut self, none: f64, solid: f64) -> Result<(), MeshError> {
        let numbers: Vec<usize> = (0..self.classes.len()).filter(|&t| self.classes[t] == Class::Sparse).collect();
        let Some((mesh, _)) = self.part(|class| class == Class::Sparse)? else { return Ok(()) };
        let regions = mesh.regions();
        let mut reach = vec![0.0_f64; regions.count];
        for (&t, &region) in numbers.iter().zip(&regions.of_triangle) {
            for v in self.triangles[t] {
                let [inside, skin] = self.values[v as usize];
                reach[region as usize] = reach[region as usize].max(inside.min(-skin));
            }
        }
        for (&t, &region) in numbers.iter().zip(&regions.of_triangle) {
            match reach[region as usize] {
                reach if reach <= none => self.classes[t] = Class::Wall,
                reach if reach <= solid => self.classes[t] = Class::Skin,
                _ => {}
            }
        }
        Ok(())
    }

    /// Corners and parent of each triangle of a class.
    pub fn of(&self, class: Class) -> impl Iterator<Item = ([Point3<f64>; 3], u32)> + '_ {
        let all = self.triangles.iter().zip(&self.parents).zip(&self.classes);
        let wanted = all.filter(move |(_, of)| **of == class);
        wanted.map(|((corners, &parent), _)| (corners.map(|v| self.points[v as usize]), parent))
    }

    /// The triangles of some classes as a surface, and the triangle of the mesh of the layer that has each.
    pub fn part(&self, keep: impl Fn(Class) -> bool) -> Result<Option<(SurfaceMesh, Vec<u32>)>, MeshError> {
        let mut number = vec![u32::MAX; self.points.len()];
        let (mut points, mut triangles, mut parents) = (Vec::new(), Vec::new(), Vec::new());
        for ((corners, &parent), _) in
            self.triangles.iter().zip(&self.parents).zip(&self.classes).filter(|(_, class)| keep(**class))
        {
            triangles.push(corners.map(|v| {
                let number = &mut number[v as usize];
                if *number == u32::MAX {
                    *number = points.len() as u32;
                    points.push(self.points[v as usize]);
                }
                *number
            }));
            parents.push(parent);
        }
        if triangles.is_empty() { Ok(None) } else { Ok(Some((SurfaceMesh::new(points, triangles)?, parents))) }
    }
}
