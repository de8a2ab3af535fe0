use super::shapes::bend;
use curvlay_layers::nalgebra::{Isometry3, Point3, Vector3};
use curvlay_layers::planar::{FlatError, MAX_LAYERS, Solid, cells_by_flat_layer, flat_layers};

/// A ring of squares: outer and inner half edges, from z = 0 to `height`; solid if `inner` is 0.
fn tube(outer: f64, inner: f64, height: f64) -> Solid {
    let square = |half: f64, z: f64| {
        [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[x, y]| Point3::new(x, y, z))
    };
    let points = [square(outer, 0.0), square(outer, height), square(inner, 0.0), square(inner, height)].concat();
    let mut faces = Vec::new();
    for k in 0..4u32 {
        let next = (k + 1) % 4;
        let mut quad = |[a, b, c, d]: [u32; 4]| faces.extend([[a, b, c], [a, c, d]]);
        quad([k, next, 4 + next, 4 + k]);
        quad([8 + next, 8 + k, 12 + k, 12 + next]);
        quad([next, k, 8 + k, 8 + next]);
        quad([4 + k, 4 + next, 12 + next, 12 + k]);
    }
    Solid::new(&points, &faces).unwrap()
}

fn area(vertices: &[Point3<f64>], triangles: &[[u32; 3]], up: &Vector3<f64>) -> f64 {
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a)).dot(up) / 2.0
    };
    triangles.iter().map(of).sum()
}

#[test]
fn layers_fill_a_part_with_a_hole_along_any_direction() {
    let part = tube(10.0, 6.0, 7.0);
    for direction in [Vector3::z(), Vector3::x() * 3.0, Vector3::new(0.3, -0.5, 0.8)] {
        let layers = flat_layers(&part, &direction, 0.5).unwrap();
        let up = direction.normalize();
        let [low, high] = part.extent(&up);
        assert_eq!(layers.layers.len(), ((high - low) / 0.5).round() as usize);
        assert!((layers.height_mm * layers.layers.len() as f64 - (high - low)).abs() < 1e-9);
        let mut volume = 0.0;
        for (k, layer) in layers.layers.iter().enumerate() {
            let height = low + (k as f64 + 0.5) * layers.height_mm;
            assert!(layer.vertices.iter().all(|p| (p.coords.dot(&up) - height).abs() < 1e-9));
            assert_eq!(layer.thickness.len(), layer.triangles.len());
            assert!(layer.thickness.iter().all(|thickness| (thickness - layers.height_mm).abs() < 1e-12));
            let of = |corners: &[u32; 3]| area(&layer.vertices, &[*corners], &up);
            assert!(layer.triangles.iter().all(|corners| of(corners) > 0.0));
            volume += area(&layer.vertices, &layer.triangles, &up) * layers.height_mm;
        }
        // The middle of each layer stands for it; outlines are simplified by a two-hundredth of a millimetre.
        assert!((volume / part.volume() - 1.0).abs() < 0.01, "{direction}: {volume} {}", part.volume());
    }
    let level = flat_layers(&part, &Vector3::z(), 0.5).unwrap();
    assert!((area(&level.layers[3].vertices, &level.layers[3].triangles, &Vector3::z()) - 256.0).abs() < 0.2);
    // In the hole there is nothing.
    assert_eq!(level.layer_at(&Point3::new(8.0, 0.0, 3.2)), Some(6));
    assert_eq!([[0.0, 0.0, 3.0], [8.0, 0.0, -0.1], [8.0, 0.0, 7.1]].map(|p| level.layer_at(&p.into())), [None; 3]);
    assert_eq!([0.0, 7.0].map(|z| level.layer_at(&Point3::new(8.0, 0.0, z))), [Some(0), Some(13)]);
}

#[test]
fn cells_are_in_the_layer_of_their_middle_or_next_to_one_that_is() {
    let part = tube(4.0, 2.0, 6.0);
    let lower = flat_layers(&part, &Vector3::z(), 1.0).unwrap();
    // 9 by 9 by 6 cells from -4.5: the outermost ring of middles lies on the side, half of it outside after rounding outlines.
    let (dims, cell) = ([9u32, 9, 6], 1.0);
    let rows = vec![(1u64 << 9) - 1; 54];
    let layers = cells_by_flat_layer(std::slice::from_ref(&lower), dims, &rows, cell, &Point3::new(-4.5, -4.5, 0.0));
    assert_eq!(layers.len(), 6);
    assert_eq!(layers.iter().map(Vec::len).sum::<usize>(), 486);
    for (layer, cells) in layers.iter().enumerate() {
        assert!(cells.is_sorted());
        for &number in cells {
            let [x, y, z] = [number % 9, number / 9 % 9, number / 81].map(|c| f64::from(c) + 0.5);
            let middle = Point3::new(x - 4.5, y - 4.5, z);
            match lower.layer_at(&middle) {
                Some(own) => assert_eq!(own, layer),
                // At most three cells from the ring in between.
                None => assert!(z as usize >= layer && z as usize <= layer + 3, "{middle} {layer}"),
            }
        }
    }
    // Layers are numbered through; what nothing connects is in none.
    let two = [lower.clone(), lower];
    let layers = cells_by_flat_layer(&two, dims, &rows, cell, &Point3::new(-4.5, -4.5, 0.0));
    assert_eq!((layers.len(), layers[6..].iter().map(Vec::len).sum::<usize>()), (12, 0));
    let far = cells_by_flat_layer(&two, dims, &rows, cell, &Point3::new(100.0, 0.0, 0.0));
    assert!(far.iter().all(Vec::is_empty));
    assert!(cells_by_flat_layer(&[], dims, &rows, cell, &Point3::origin()).is_empty());
}

#[test]
fn bad_input_is_named() {
    let part = tube(4.0, 2.0, 6.0);
    for height in [0.0, -1.0, f64::NAN, 6.0 / (2.0 * MAX_LAYERS as f64)] {
        assert!(matches!(flat_layers(&part, &Vector3::z(), height), Err(FlatError::Height { .. })), "{height}");
    }
    assert_eq!(flat_layers(&part, &Vector3::zeros(), 1.0), Err(FlatError::Direction));
    assert_eq!(flat_layers(&part, &Vector3::repeat(f64::NAN), 1.0), Err(FlatError::Direction));
    // One that is lower than half a layer still has one.
    assert_eq!(flat_layers(&part, &Vector3::z(), 100.0).unwrap().layers.len(), 1);
}

#[test]
fn moved_layers_are_those_of_the_moved_part() {
    let part = bend(8.0, 12);
    let direction = Vector3::new(0.3, 0.2, 1.0).normalize();
    let layers = flat_layers(&part, &direction, 2.0).unwrap();
    let by = Isometry3::new(Vector3::new(5.0, -7.0, 11.0), Vector3::new(0.4, -0.9, 0.3));
    let moved = layers.moved(&by);
    assert!((moved.direction - by.rotation * direction).norm() < 1e-12);
    for (layer, of) in layers.layers.iter().zip(&moved.layers) {
        assert_eq!(layer.triangles, of.triangles);
        for (p, q) in layer.vertices.iter().zip(&of.vertices) {
            assert!((by * p - q).norm() < 1e-9);
            // In the middle of its layer.
            let height = q.coords.dot(&moved.direction);
            assert!((height - (of.low_mm + of.high_mm) / 2.0).abs() < 1e-9);
        }
    }
    for k in 0..2000 {
        let p = Point3::new(f64::from(k % 10) * 10.0, f64::from(k / 10 % 10) * 2.0 - 9.0, f64::from(k / 100) * 6.0);
        assert_eq!(layers.layer_at(&p), moved.layer_at(&(by * p)), "{p}");
    }
}
