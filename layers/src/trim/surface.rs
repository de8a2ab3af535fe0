//! What is kept of a sheet: its triangles, each with its neighbours or the kind of boundary that it ends at.

use super::patch::NONE;
use super::pieces::Pieces;
use super::solid::Solid;
use super::triangle::{MIN_ALTITUDE_MM, altitude};
use super::trimmed::{BoundaryEdge, BoundaryKind, TrimmedSheet};
use nalgebra::Point3;

/// What lies across a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    /// Half-edge `3 t + k` goes back along it.
    Half(u32),
    /// Nothing.
    End(BoundaryKind),
}

#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) across: Vec<[Across; 3]>,
    pub(super) sources: Vec<u32>,
    /// Triangles that were taken out.
    pub(super) gone: Vec<bool>,
}

impl Surface {
    /// The pieces that are kept. Pieces that meet at a vertex alone get a vertex each.
    ///
    /// # Arguments
    /// * `border`, `lost`: what a side of a piece ends at on the border of the sheet, and beside a piece that is not kept.
    pub(super) fn of(
        pieces: &Pieces,
        keep: &[bool],
        border: impl Fn(usize, usize) -> BoundaryKind,
        lost: impl Fn(usize, usize) -> BoundaryKind,
    ) -> Surface {
        let mut number = vec![NONE; keep.len()];
        let kept: Vec<usize> = (0..keep.len()).filter(|&piece| keep[piece]).collect();
        kept.iter().zip(0..).for_each(|(&piece, n)| number[piece] = n);
        let mut surface = Surface { gone: vec![false; kept.len()], ..Surface::default() };
        for &piece in &kept {
            surface.triangles.push([NONE; 3]);
            surface.sources.push(pieces.sources[piece]);
            surface.across.push([0, 1, 2].map(|k| match pieces.across[piece][k] {
                NONE => Across::End(border(piece, k)),
                half if keep[half as usize / 3] => Across::Half(3 * number[half as usize / 3] + half % 3),
                _ => Across::End(lost(piece, k)),
            }));
        }
        let mut fan = Vec::new();
        for half in 0..3 * kept.len() as u32 {
            let (triangle, k) = (half as usize / 3, half as usize % 3);
            if surface.triangles[triangle][k] == NONE {
                let point = surface.points.len() as u32;
                surface.points.push(pieces.points[pieces.corners[kept[triangle]][k] as usize]);
                surface.fan(half, &mut fan);
                fan.iter().for_each(|&half| surface.triangles[half as usize / 3][half as usize % 3] = point);
            }
        }
        surface
    }

    /// All half-edges that start where one does, counter-clockwise; from the boundary on, if there is one.
    pub(super) fn fan(&self, half: u32, fan: &mut Vec<u32>) {
        fan.clear();
        let mut first = half;
        while let Across::Half(back) = self.across(first) {
            first = next(back);
            if first == half {
                break;
            }
        }
        let mut at = first;
        loop {
            fan.push(at);
            match self.across(previous(at)) {
                Across::Half(following) if following != first => at = following,
                _ => break,
            }
        }
    }

    pub(super) fn across(&self, half: u32) -> Across {
        self.across[half as usize / 3][half as usize % 3]
    }

    pub(super) fn from(&self, half: u32) -> u32 {
        self.triangles[half as usize / 3][half as usize % 3]
    }

    pub(super) fn place(&self, half: u32) -> &Point3<f64> {
        &self.points[self.from(half) as usize]
    }

    pub(super) fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|corner| self.points[corner as usize])
    }

    /// The triangles that are there.
    pub(super) fn present(&self) -> impl Iterator<Item = usize> {
        (0..self.triangles.len()).filter(|&triangle| !self.gone[triangle])
    }

    /// Numbers what is left anew and measures it.
    pub(super) fn finish(self, solid: &Solid) -> TrimmedSheet {
        let mut sheet = TrimmedSheet { holed: solid.holes.is_some(), ..TrimmedSheet::default() };
        let mut number = vec![NONE; self.points.len()];
        for triangle in self.present() {
            let corners = self.triangles[triangle].map(|corner| {
                let number = &mut number[corner as usize];
                if *number == NONE {
                    *number = sheet.vertices.len() as u32;
                    sheet.vertices.push(self.points[corner as usize]);
                }
                *number
            });
            sheet.triangles.push(corners);
            sheet.sources.push(self.sources[triangle]);
            for k in 0..3 {
                if let Across::End(kind) = self.across[triangle][k] {
                    sheet.boundary.push(BoundaryEdge { ends: [corners[k], corners[(k + 1) % 3]], kind });
                }
            }
            sheet.slivers += usize::from(altitude(&self.corners(triangle)) < MIN_ALTITUDE_MM);
        }
        let mut asked = vec![false; sheet.vertices.len()];
        for edge in &sheet.boundary {
            let [a, b] = edge.ends.map(|end| sheet.vertices[end as usize]);
            let length = (b - a).norm();
            match edge.kind {
                BoundaryKind::Mesh => {
                    sheet.mesh_mm += length;
                    let ends = edge.ends.into_iter().filter(|&end| !std::mem::replace(&mut asked[end as usize], true));
                    let places = ends.map(|end| sheet.vertices[end as usize]).chain([nalgebra::center(&a, &b)]);
                    sheet.error_mm = places.map(|p| solid.distance(&p)).fold(sheet.error_mm, f64::max);
                }
                BoundaryKind::Border => sheet.border_mm += length,
                BoundaryKind::Hole => sheet.hole_mm += length,
            }
        }
        sheet
    }
}

pub(super) fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

pub(super) fn previous(half: u32) -> u32 {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}
