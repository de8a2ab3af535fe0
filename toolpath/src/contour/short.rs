//! Curves that are too short to be worth a start.

use crate::mesh::SurfaceMesh;
use crate::path::SurfacePath;

/// The curves that stay, and those that are left out: shorter than `least` mm, and not the longest of their connected part of the
/// mesh.
pub(super) fn without_short(
    mesh: &SurfaceMesh,
    paths: Vec<SurfacePath>,
    least: f64,
) -> (Vec<SurfacePath>, Vec<SurfacePath>) {
    let parts = mesh.regions();
    let part_of = |path: &SurfacePath| path.points.first().map(|p| parts.of_triangle[p.at.triangle as usize] as usize);
    let mut longest: Vec<Option<(f64, usize)>> = vec![None; parts.count];
    for (number, path) in paths.iter().enumerate() {
        let length = path.length();
        if let Some(longest) = part_of(path).map(|part| &mut longest[part])
            && longest.is_none_or(|(longest, _)| length > longest)
        {
            *longest = Some((length, number));
        }
    }
    let stays = |number: usize, path: &SurfacePath| {
        let is_longest = part_of(path).is_some_and(|part| longest[part].is_some_and(|(_, longest)| longest == number));
        is_longest || path.length() >= least
    };
    let (kept, short): (Vec<_>, Vec<_>) =
        paths.into_iter().enumerate().partition(|(number, path)| stays(*number, path));
    let unnumbered = |paths: Vec<(usize, SurfacePath)>| paths.into_iter().map(|(_, path)| path).collect();
    (unnumbered(kept), unnumbered(short))
}
