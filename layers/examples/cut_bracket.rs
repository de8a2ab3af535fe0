//! A bracket that overhangs is cut by a plane into two closed solids, each printed along a direction of its own: how much area hangs over
//! before and after.
//!
//! ```sh
//! cargo run -p curvlay-layers --example cut_bracket
//! ```

use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::{CutPlane, Partition, PlaneFrame, Solid, slice};
use std::error::Error;

/// An L lying on its short leg: a post 60 mm high, and an arm that reaches 60 mm to the side at its top; 20 mm thick.
fn bracket() -> Result<Solid, Box<dyn Error>> {
    let outline =
        [[0.0, 0.0], [20.0, 0.0], [20.0, 40.0], [80.0, 40.0], [80.0, 60.0], [20.0, 60.0], [0.0, 60.0], [0.0, 40.0]];
    let sides = outline.len() as u32;
    let vertices: Vec<_> = [-10.0, 10.0].iter().flat_map(|&y| outline.map(|[x, z]| Point3::new(x, y, z))).collect();
    let mut triangles = Vec::new();
    for [a, b, c, d] in [[0, 1, 2, 7], [7, 2, 5, 6], [2, 3, 4, 5]] {
        // The near cap looks along -y, where the outline turns counter-clockwise.
        triangles.extend([[a, b, c], [a, c, d]]);
        let far = |corner: u32| corner + sides;
        triangles.extend([[far(a), far(c), far(b)], [far(a), far(d), far(c)]]);
    }
    for a in 0..sides {
        let b = (a + 1) % sides;
        triangles.extend([[a, b + sides, b], [a, a + sides, b + sides]]);
    }
    Ok(Solid::new(&vertices, &triangles)?)
}

/// Area that looks more than 45 degrees down when printed along `up`, the foot left out.
fn hanging(solid: &Solid, up: &Vector3<f64>) -> f64 {
    let foot = solid.extent(up)[0];
    let area = |triangle: usize| {
        let [a, b, c] = solid.corners(triangle);
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let stands = [a, b, c].iter().all(|corner| corner.coords.dot(up) - foot < 1e-6);
        if normal.dot(up) < -normal.norm() * 0.5f64.sqrt() && !stands { normal.norm() } else { 0.0 }
    };
    (0..solid.triangles().len()).map(area).sum()
}

fn main() -> Result<(), Box<dyn Error>> {
    let solid = bracket()?;
    println!("whole, printed upwards: {:.0} mm3, hanging {:.0} mm2", solid.volume(), hanging(&solid, &Vector3::z()));

    let plane = CutPlane::through(&Point3::new(20.0, 0.0, 0.0), &Vector3::x())?;
    let mut partition = Partition::new(&solid);
    let cut = partition.cut(&[0], &plane);
    let [post, arm] = [partition.part(cut.below[0])?, partition.part(cut.above[0])?];
    println!("post, upwards:          {:.0} mm3, hanging {:.0} mm2", post.volume(), hanging(&post, &Vector3::z()));
    println!("arm, sideways:          {:.0} mm3, hanging {:.0} mm2", arm.volume(), hanging(&arm, &Vector3::x()));
    println!("seam between them:      {:.0} mm2", partition.shared_area(cut.below[0], cut.above[0]));

    // The arm in flat layers of 10 mm along its own direction.
    for x in [25.0, 35.0, 45.0] {
        let layer = CutPlane::through(&Point3::new(x, 0.0, 0.0), &Vector3::x())?;
        let area: f64 = slice(&arm, &layer, &PlaneFrame::of(&layer)).iter().map(|polygon| polygon.area()).sum();
        println!("layer of the arm at x = {x} mm: {area:.0} mm2");
    }
    Ok(())
}
