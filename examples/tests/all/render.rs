//! Pictures: the right colours in the right places, sound PNG files, the same bytes each time.

use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::render::{
    Camera, Image, LayeredCells, LayeredCellsError, MISSED, Plane, Rgb, Scene, draw_cut, layer_colour, ramp,
};
use std::io::Cursor;

const WHITE: Rgb = [255; 3];

/// Full rows of `nx < 64` cells.
fn full(dims: [u32; 3]) -> Vec<u64> {
    assert!(dims[0] < 64);
    vec![(1 << dims[0]) - 1; (dims[1] * dims[2]) as usize]
}

fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width, info.height, bytes)
}

/// Which of the colours the pixel is nearest to in hue: shading changes the brightness only.
fn looks_like(pixel: Rgb, colour: Rgb) -> bool {
    let direction = |c: Rgb| Vector3::from(c.map(f64::from)).normalize();
    direction(pixel).dot(&direction(colour)) > 0.995
}

#[test]
fn png_gives_back_every_pixel() {
    let mut image = Image::new(5, 3, WHITE);
    image.fill([1, 1], [2, 9], [10, 20, 30]);
    image.set(4, 0, [1, 2, 3]);
    image.set(5, 0, [9, 9, 9]);
    let (width, height, bytes) = decoded(&image.to_png());
    assert_eq!((width, height), (5, 3));
    for (i, pixel) in bytes.as_chunks::<3>().0.iter().enumerate() {
        assert_eq!(Some(*pixel), image.get(i as u32 % 5, i as u32 / 5));
    }
    assert_eq!((image.get(1, 2), image.get(4, 0), image.get(5, 0)), (Some([10, 20, 30]), Some([1, 2, 3]), None));
    let least = Image::new(0, 0, WHITE);
    assert_eq!(decoded(&least.to_png()), (1, 1, vec![255; 3]));
}

#[test]
fn layers_can_be_distinguished() {
    for layers in [1, 2, 10, 48] {
        for layer in 1..layers {
            assert_ne!(layer_colour(layer, layers), layer_colour(layer + 1, layers), "{layer} of {layers}");
        }
    }
    for t in 0..=100 {
        let colour = ramp(f64::from(t) / 100.0);
        let apart: i32 = colour.iter().zip(MISSED).map(|(&a, b)| (i32::from(a) - i32::from(b)).abs()).sum();
        assert!(apart > 150, "{colour:?} could be taken for a missed cell");
    }
    assert_eq!(layer_colour(0, 10), MISSED);
    assert_eq!((ramp(-1.0), ramp(f64::NAN), ramp(7.0)), (ramp(0.0), ramp(0.0), ramp(1.0)));
}

#[test]
fn a_cut_shows_the_layers_of_its_plane() {
    // Layer = x + 1 at the bottom, missed in the top row; y = 1 is empty.
    let dims = [3, 2, 2];
    let rows = [0b111, 0, 0b101, 0];
    let layers = [1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let cells = LayeredCells::new(dims, &rows, &layers).unwrap();
    assert_eq!((cells.last_layer(), cells.missed()), (3, 2));
    let image = draw_cut(&cells, Plane::Y(0), 28 + 3 * 20, 28 + 2 * 20);
    assert_eq!((image.width(), image.height()), (88, 68));
    let middle = |x: u32, z: u32| image.get(14 + 20 * x + 10, 14 + 20 * (1 - z) + 10).unwrap();
    for x in 0..3 {
        assert_eq!(middle(x, 0), layer_colour(x + 1, 3));
        assert_eq!(middle(x, 1), if x == 1 { WHITE } else { MISSED });
    }
    let side = draw_cut(&cells, Plane::X(1), 68, 68);
    assert_eq!((side.get(24, 44), side.get(44, 44)), (Some(layer_colour(2, 3)), Some(WHITE)));
    let outside = draw_cut(&cells, Plane::Y(7), 88, 68);
    assert!((0..50).all(|y| outside.get(44, y) == Some(WHITE)));
    assert_eq!(Plane::middle_y(dims), Plane::Y(1));
}

#[test]
fn the_nearest_cell_hides_the_others() {
    // Two cells in a row along y, seen from -y: only the first one shows; from +y the second one.
    let (dims, rows) = ([1, 2, 1], full([1, 2, 1]));
    let cells = LayeredCells::new(dims, &rows, &[1, 2]).unwrap();
    for (y, layer) in [(-1.0, 1), (1.0, 2)] {
        let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.0, y, 0.0)));
        let image = scene.cells(&cells, None).draw(60, 60);
        let middle = image.get(30, 30).unwrap();
        assert!(looks_like(middle, layer_colour(layer, 2)), "{middle:?}");
        assert_eq!(image.get(0, 30), Some(WHITE), "margin");
    }
}

#[test]
fn a_half_shows_what_the_whole_hides() {
    // A block of layer 1 with a core of missed cells.
    let dims = [9, 9, 9];
    let inner = |c: u32| (3..6).contains(&c);
    let at = |i: u32| [i % 9, i / 9 % 9, i / 81];
    let layers: Vec<u32> = (0..729).map(|i| u32::from(!at(i).into_iter().all(inner))).collect();
    let rows = full(dims);
    let cells = LayeredCells::new(dims, &rows, &layers).unwrap();
    assert_eq!(cells.missed(), 27);
    for (direction, plane) in [
        (Vector3::new(0.1, -1.0, 0.1), Plane::Y(4)),
        (Vector3::new(0.1, 1.0, 0.1), Plane::Y(5)),
        (Vector3::new(1.0, 0.1, 0.1), Plane::X(5)),
        (Vector3::new(-1.0, 0.1, 0.1), Plane::X(4)),
    ] {
        let middle = |cut| {
            let mut scene = Scene::new(Camera::from_direction(direction));
            scene.cells(&cells, cut).draw(90, 90).get(45, 45).unwrap()
        };
        assert!(looks_like(middle(None), layer_colour(1, 1)), "{:?}", middle(None));
        assert!(looks_like(middle(Some(plane)), MISSED), "{:?}", middle(Some(plane)));
    }
}

#[test]
fn wide_grids_cross_word_borders() {
    // 130 cells in a row seen from the side: no gap, and from the end only one face.
    let rows = [u64::MAX, u64::MAX, 0b11];
    let layers: Vec<u32> = (1..=130).collect();
    let cells = LayeredCells::new([130, 1, 1], &rows, &layers).unwrap();
    let side = Scene::new(Camera::from_direction(-Vector3::y())).cells(&cells, None).draw(1300, 40);
    assert!((60..1240).all(|x| side.get(x, 20) != Some(WHITE)));
    for (x, layer) in [(-1.0, 1), (1.0, 130)] {
        let end = Scene::new(Camera::from_direction(Vector3::x() * x)).cells(&cells, None).draw(40, 40);
        assert!(looks_like(end.get(20, 20).unwrap(), layer_colour(layer, 130)), "{:?}", end.get(20, 20));
    }
    let half = Scene::new(Camera::from_direction(Vector3::x())).cells(&cells, Some(Plane::X(65))).draw(40, 40);
    assert!(looks_like(half.get(20, 20).unwrap(), layer_colour(65, 130)), "{:?}", half.get(20, 20));
}

#[test]
fn meshes_and_triangles_are_drawn_from_both_sides() {
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]].map(Point3::from);
    for y in [-1.0, 1.0] {
        let camera = Camera::from_direction(Vector3::new(0.0, y, 0.0));
        let mut scene = Scene::new(camera);
        // The triangle that names vertex 9 is left out.
        let mesh = scene.mesh(&corners, &[[0, 1, 2], [0, 1, 9]], [200, 100, 50]).draw(50, 50);
        let flat = Scene::new(camera).triangles([(corners, [200, 100, 50])]).draw(50, 50);
        let x = if y < 0.0 { 15 } else { 35 };
        for image in [mesh, flat] {
            let pixel = image.get(x, 35).unwrap();
            assert!(looks_like(pixel, [200, 100, 50]) && pixel[0] > 90, "{pixel:?}");
            assert_eq!(image.get(50 - x, 5), Some(WHITE));
        }
    }
}

#[test]
fn pictures_of_a_growing_scene_have_the_view_of_the_whole() {
    let triangle = |x: f64| [[x, 0.0, 0.0], [x + 2.0, 0.0, 0.0], [x, 0.0, 2.0]].map(Point3::from);
    let camera = Camera::from_direction(Vector3::new(0.0, -1.0, 0.2));
    let platform = [[-1.0, -1.0], [7.0, -1.0], [7.0, 1.0], [-1.0, 1.0]];
    let mut scene = Scene::new(camera);
    scene.platform(&platform, -0.5);
    let add = |part: usize, scene: &mut Scene| _ = scene.triangles([(triangle(4.0 * part as f64), [200, 100, 50])]);
    let [first, last] = scene.draw_growing(&[1, 2], add, 200, 80).try_into().unwrap();
    (0..2).for_each(|part| add(part, &mut scene));
    assert_eq!(last.to_png(), scene.draw(200, 80).to_png());
    // The second triangle is missing from the first picture; the first one is where it is in the other.
    let drawn = |image: &Image, range: std::ops::Range<u32>| {
        range
            .flat_map(|x| (0..80).map(move |y| (x, y)))
            .filter(|&(x, y)| looks_like(image.get(x, y).unwrap(), [200, 100, 50]))
            .count()
    };
    assert!(drawn(&first, 100..200) == 0 && drawn(&last, 100..200) > 100);
    assert!(drawn(&first, 0..100) > 100 && drawn(&first, 0..100) == drawn(&last, 0..100));
}

#[test]
fn bars_are_as_thick_from_every_side() {
    let (from, to) = (Point3::new(0.0, 0.0, -3.0), Point3::new(0.0, 0.0, 3.0));
    for (x, y) in [(0.0, -1.0), (0.0, 1.0), (1.0, 0.0), (-1.0, 0.0)] {
        let mut scene = Scene::new(Camera::from_direction(Vector3::new(x, y, 0.0)));
        let image = scene.bar(from, to, 0.5, [200, 100, 50]).draw(100, 100);
        // Six times as long as it is thick: 92 pixels and a sixth of them.
        let thick = (0..100).filter(|&x| image.get(x, 30) != Some(WHITE)).count();
        let long = (0..100).filter(|&y| image.get(50, y) != Some(WHITE)).count();
        assert!(thick.abs_diff(15) <= 1 && long.abs_diff(92) <= 1, "{thick} {long}");
        assert!(looks_like(image.get(50, 30).unwrap(), [200, 100, 50]));
    }
    // Lying bars have a width as well; a bar from a point to itself is not drawn.
    let mut scene = Scene::new(Camera::from_direction(Vector3::z()));
    let lying = scene.bar(Point3::new(-3.0, 0.0, 0.0), Point3::new(3.0, 0.0, 0.0), 0.5, MISSED).draw(100, 100);
    assert!((0..100).filter(|&y| lying.get(30, y) != Some(WHITE)).count().abs_diff(15) <= 1);
    let mut scene = Scene::new(Camera::default());
    assert_eq!(scene.bar(from, from, 0.5, MISSED).draw(9, 9), Image::new(9, 9, WHITE));
}

#[test]
fn the_platform_is_under_the_part() {
    let square = [[-4.0, -4.0], [5.0, -4.0], [5.0, 5.0], [-4.0, 5.0]];
    let rows = full([1, 1, 1]);
    let cells = LayeredCells::new([1, 1, 1], &rows, &[1]).unwrap();
    let draw = |z: f64| {
        let mut scene = Scene::new(Camera::from_direction(Vector3::new(0.0, -0.01, z)));
        scene.platform(&square, 0.0).cells(&cells, None).draw(90, 90)
    };
    let above = draw(1.0);
    assert!(looks_like(above.get(45, 45).unwrap(), layer_colour(1, 1)));
    let plate = above.get(20, 20).unwrap();
    assert!(plate != WHITE && plate.iter().all(|&c| c > 180), "{plate:?} is light");
    assert!(above.get(39, 45).unwrap()[0] < plate[0], "the part shades the plate beside it");
    let below = Scene::new(Camera::from_direction(Vector3::new(0.0, -0.01, -1.0))).cells(&cells, None).draw(90, 90);
    assert_eq!(draw(-1.0), below, "no platform from below");
}

#[test]
fn odd_scenes_are_white_or_sound() {
    assert!(Scene::new(Camera::default()).draw(20, 10).to_png().len() > 20);
    assert_eq!(Scene::new(Camera::default()).draw(20, 10), Image::new(20, 10, WHITE));
    let nan = [Point3::new(f64::NAN, 0.0, 0.0); 3];
    assert_eq!(Scene::new(Camera::default()).triangles([(nan, WHITE)]).draw(9, 9).get(4, 4), Some(WHITE));
    let point = [Point3::origin(); 3];
    assert_eq!(Scene::new(Camera::default()).triangles([(point, MISSED)]).draw(9, 9), Image::new(9, 9, WHITE));
    for odd in [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0), Vector3::new(f64::INFINITY, 0.0, 0.0)] {
        assert_eq!(Camera::from_direction(odd), Camera::default());
    }
    let top = Camera::from_direction(Vector3::z() * 5.0);
    assert_eq!(top.toward(), Vector3::z());
    let no_cells = LayeredCells::new([3, 1, 1], &[0], &[0; 3]).unwrap();
    assert_eq!(Scene::new(top).cells(&no_cells, None).draw(9, 9), Image::new(9, 9, WHITE));
    assert!(draw_cut(&no_cells, Plane::Y(0), 0, 0).with_legend(0, 0).width() > 3);
}

#[test]
fn cells_that_do_not_fit_are_refused() {
    let error =
        |dims, words: usize, layers: usize| LayeredCells::new(dims, &vec![0; words], &vec![0; layers]).unwrap_err();
    assert_eq!(error([0, 1, 1], 0, 0), LayeredCellsError::Dims { dims: [0, 1, 1] });
    assert_eq!(error([u32::MAX; 3], 0, 0), LayeredCellsError::Dims { dims: [u32::MAX; 3] });
    assert_eq!(error([65, 1, 1], 1, 65), LayeredCellsError::Words { words: 1, expected: 2 });
    assert_eq!(error([2, 2, 1], 2, 3), LayeredCellsError::Layers { layers: 3, expected: 4 });
}

#[test]
fn the_legend_shows_first_and_last_layer_and_missed_cells() {
    let plain = Image::new(40, 300, WHITE);
    for layers in [1, 2, 7, 128, 5000] {
        let with = plain.with_legend(layers, 12);
        assert!(with.width() > 40 && with.height() == 300);
        let colours: Vec<Rgb> = (0..300).filter_map(|y| with.get(50, y)).collect();
        for colour in [layer_colour(1, layers), layer_colour(layers, layers), MISSED] {
            assert!(colours.contains(&colour), "{layers}");
        }
        let none = plain.with_legend(layers, 0);
        assert!((0..300).all(|y| none.get(50, y) != Some(MISSED)));
    }
    assert_eq!(Image::new(4, 4, WHITE).with_legend(9, 1).height(), 4);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let rows = full([20, 20, 20]);
    let layers: Vec<u32> = (0..8000).map(|i| i / 400).collect();
    let cells = LayeredCells::new([20, 20, 20], &rows, &layers).unwrap();
    let png = || {
        let mut scene = Scene::new(Camera::default());
        scene.platform(&[[-9.0, -9.0], [29.0, -9.0], [10.0, 39.0]], 0.0).cells(&cells, Some(Plane::X(9)));
        scene.draw(200, 150).with_legend(19, 400).to_png()
    };
    assert_eq!(png(), png());
}
