//! A scene: shaded triangles over a platform, seen from one side in parallel projection.

use super::colours::{INK, PLATFORM, Rgb};
use super::image::Image;
use super::raster::{Canvas, Spot, from_rgb};
use nalgebra::{Point3, Vector3};

/// From where the scene is seen. z is up in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    right: Vector3<f64>,
    up: Vector3<f64>,
    toward: Vector3<f64>,
}

impl Camera {
    /// A camera far away in this direction; its length does not matter. From straight above or below y is up in the
    /// picture; a direction that is zero or not finite is taken for the default.
    pub fn from_direction(toward: Vector3<f64>) -> Self {
        let Some(toward) = toward.try_normalize(0.0).filter(|v| v.iter().all(|c| c.is_finite())) else {
            return Self::default();
        };
        let right = Vector3::z().cross(&toward).try_normalize(1e-9).unwrap_or(Vector3::x() * toward.z.signum());
        Camera { right, up: toward.cross(&right), toward }
    }

    /// The direction to the viewer, of length 1.
    pub fn toward(&self) -> Vector3<f64> {
        self.toward
    }

    /// Right, up and towards the viewer.
    fn project(&self, p: &Vector3<f64>) -> [f64; 3] {
        [p.dot(&self.right), p.dot(&self.up), p.dot(&self.toward)]
    }

    /// How bright a surface with this normal is: a light over the viewer's left shoulder, one from the viewer, and
    /// some from all around, more from above.
    pub(super) fn brightness(&self, normal: &Vector3<f64>) -> f32 {
        let key = (self.toward * 0.75 + self.up * 0.6 - self.right * 0.5).normalize();
        let around = 0.36 + 0.07 * normal.z;
        (around + 0.50 * normal.dot(&key).max(0.0) + 0.20 * normal.dot(&self.toward).max(0.0)) as f32
    }
}

impl Default for Camera {
    /// From the front right, a little above.
    fn default() -> Self {
        Self::from_direction(Vector3::new(0.55, -1.0, 0.5))
    }
}

/// Triangles and a platform, in any one unit of length.
#[derive(Clone, Debug)]
pub struct Scene {
    camera: Camera,
    facets: Vec<Facet>,
    /// Level squares that shade the platform: their middles and half their edges.
    shading: Vec<([f32; 3], f32)>,
    platform: Option<(Vec<[f64; 2]>, f64)>,
    labels: Vec<(Point3<f64>, String)>,
    /// Of a part of a growing scene: how many facets came before it.
    earlier: usize,
}

#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [[f32; 3]; 3],
    colours: [[f32; 3]; 3],
}

/// Edges sharper than this (the cosine between the normals of two faces) stay edges; flatter ones are shaded round.
const CREASE: f64 = 0.77;

/// White around labels, in pixels.
const LABEL_RIM: u32 = 3;

/// A fall behind an outline, as a share of the size of the scene. Half of it draws the steps of cells, twice of it
/// loses the gap between a handle and its body.
const OUTLINE: f64 = 0.03;

impl Scene {
    /// An empty scene.
    pub fn new(camera: Camera) -> Self {
        Scene { camera, facets: Vec::new(), shading: Vec::new(), platform: None, labels: Vec::new(), earlier: 0 }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Stands a convex polygon (counter-clockwise) with its top at the height `z` under the part.
    pub fn platform(&mut self, corners: &[[f64; 2]], z: f64) -> &mut Self {
        self.platform = Some((corners.to_vec(), z)).filter(|(corners, _)| corners.len() >= 3);
        self
    }

    /// Adds a mesh in one colour, shaded round across flat edges. Triangles that name a vertex which is not there
    /// are left out. Both sides are shown alike.
    pub fn mesh(&mut self, vertices: &[Point3<f64>], triangles: &[[u32; 3]], colour: Rgb) -> &mut Self {
        let sound: Vec<[usize; 3]> = triangles
            .iter()
            .map(|triangle| triangle.map(|v| v as usize))
            .filter(|triangle| triangle.iter().all(|&v| v < vertices.len()))
            .collect();
        // Twice the area in the length of the normal: large faces decide.
        let normals: Vec<Vector3<f64>> =
            sound.iter().map(|&[a, b, c]| (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a]))).collect();
        let mut around = vec![Vec::new(); vertices.len()];
        for (face, corners) in sound.iter().enumerate() {
            for &v in corners {
                around[v].push(face);
            }
        }
        for (face, corners) in sound.iter().enumerate() {
            let own = normals[face];
            let normal_at = |v: usize| {
                let alike =
                    |other: &&usize| normals[**other].dot(&own) >= CREASE * normals[**other].norm() * own.norm();
                let sum: Vector3<f64> = around[v].iter().filter(alike).map(|&other| normals[other]).sum();
                let normal = sum.try_normalize(0.0).unwrap_or(self.camera.toward);
                if normal.dot(&self.camera.toward) < 0.0 && own.dot(&self.camera.toward) < 0.0 {
                    -normal
                } else {
                    normal
                }
            };
            let base = from_rgb(colour);
            let colours = corners.map(|v| base.map(|c| c * self.camera.brightness(&normal_at(v))));
            self.facet(corners.map(|v| vertices[v]), colours);
            self.shade_below(corners.map(|v| vertices[v]));
        }
        self
    }

    /// Adds triangles, each in a colour of its own, shaded flat.
    pub fn triangles(&mut self, triangles: impl IntoIterator<Item = ([Point3<f64>; 3], Rgb)>) -> &mut Self {
        for (corners, colour) in triangles {
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or(self.camera.toward);
            let seen = if normal.dot(&self.camera.toward) < 0.0 { -normal } else { normal };
            let brightness = self.camera.brightness(&seen);
            self.facet(corners, [from_rgb(colour).map(|c| c * brightness); 3]);
            self.shade_below(corners);
        }
        self
    }

    /// Adds a bar between two points, open at its ends: four faces, each `2 half` wide. None when the points are one.
    pub fn bar(&mut self, from: Point3<f64>, to: Point3<f64>, half: f64, colour: Rgb) -> &mut Self {
        let Some(along) = (to - from).try_normalize(1e-9) else { return self };
        let across = if along.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let u = along.cross(&across).normalize() * half;
        let v = along.cross(&u);
        let sides = [u + v, v - u, -u - v, u - v];
        for (k, &a) in sides.iter().enumerate() {
            let b = sides[(k + 1) % 4];
            self.triangles([([from + a, from + b, to + b], colour), ([from + a, to + b, to + a], colour)]);
        }
        self
    }

    /// Adds a label (digits, a to z) with its middle where a point is seen, in front of everything.
    pub fn label(&mut self, at: Point3<f64>, text: &str) -> &mut Self {
        self.labels.push((at, text.to_owned()));
        self
    }

    /// Adds a triangle whose colours are final.
    pub(super) fn facet(&mut self, corners: [Point3<f64>; 3], colours: [[f32; 3]; 3]) {
        self.facets.push(Facet { corners: corners.map(|p| p.coords.map(|c| c as f32).into()), colours });
    }

    /// Adds a level square that darkens the platform below: its middle, and half its edge.
    pub(super) fn shading_square(&mut self, middle: [f32; 3], half: f32) {
        self.shading.push((middle, half));
    }

    fn shade_below(&mut self, corners: [Point3<f64>; 3]) {
        /// Points along an edge; enough to leave no gap under the two triangles of a box.
        const STEPS: usize = 12;
        let Some((_, z)) = &self.platform else { return };
        let [a, b, c] = corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let span = (a.z - z).abs().max(longest);
        // Small triangles are a point each.
        let steps = if self.earlier + self.facets.len() > 20_000 || span <= 0.0 { 1 } else { STEPS };
        for i in 0..steps {
            for k in 0..steps - i {
                let [s, t] = [i, k].map(|n| (n as f64 + 1.0 / 3.0) / steps as f64);
                let p = a + (b - a) * s + (c - a) * t;
                self.shading.push((p.coords.map(|c| c as f32).into(), 0.0));
            }
        }
    }

    /// The picture, on white, the scene as large as fits; each side between 1 and [`Image::MAX_SIDE`] pixels.
    pub fn draw(&self, width: u32, height: u32) -> Image {
        self.draw_growing(&[0], |_, _| (), width, height).remove(0)
    }

    /// Pictures of a scene that parts are added to: a picture of this scene and the first parts for each of the numbers `until`, which rise. All show
    /// everything in its place of the whole, as [`Scene::draw`] does.
    ///
    /// `add` adds a part to a scene, and is asked for each part twice, so that no more than one is held at a time. Labels of parts are not drawn.
    pub fn draw_growing(
        &self,
        until: &[usize],
        add: impl Fn(usize, &mut Scene),
        width: u32,
        height: u32,
    ) -> Vec<Image> {
        let [width, height] = [width, height].map(|side| side.clamp(1, Image::MAX_SIDE / 2));
        let mut canvas = Canvas::new(width, height);
        let with = |number: usize, mut part: Scene| {
            add(number, &mut part);
            part
        };
        // From below the platform would hide the part.
        let platform = self.platform.as_ref().filter(|_| self.camera.toward.z > 0.0);
        let parts = 0..until.last().copied().unwrap_or(0);
        // Without a platform nothing is kept for its shade.
        let of_parts = parts.flat_map(|number| with(number, Scene::new(self.camera)).facets);
        let of_facets = self.facets.iter().copied().chain(of_parts).flat_map(|facet| facet.corners).map(to_f64);
        let of_platform = platform.iter().flat_map(|(corners, z)| corners.iter().map(|c| Vector3::new(c[0], c[1], *z)));
        let points = of_facets.chain(of_platform).map(|p| self.camera.project(&p));
        let Some(view) = View::fit(self.camera, points, canvas.size()) else {
            return until.iter().map(|_| canvas.picture()).collect();
        };
        draw_facets(&mut canvas, &view, &self.facets);
        let (mut shading, mut drawn, mut from) = (self.shading.clone(), self.facets.len(), 0);
        let picture = |&until: &usize| {
            for number in from..until {
                let bare = Scene { platform: self.platform.clone(), earlier: drawn, ..Scene::new(self.camera) };
                let part = with(number, bare);
                draw_facets(&mut canvas, &view, &part.facets);
                drawn += part.facets.len();
                shading.extend(part.shading);
            }
            from = until;
            let mut canvas = canvas.clone();
            if let Some((corners, z)) = platform {
                self.draw_platform(&mut canvas, &view, corners, &Shade::new(&shading, *z), *z);
            }
            canvas.outline((OUTLINE * view.size) as f32);
            self.labelled(&canvas, &view)
        };
        until.iter().map(picture).collect()
    }

    /// The picture of a canvas with labels.
    fn labelled(&self, canvas: &Canvas, view: &View) -> Image {
        let mut picture = canvas.picture();
        let pixels = f64::from(picture.width()) / canvas.size()[0];
        for (at, text) in &self.labels {
            let [x, y, _] = view.spot(&at.coords).map(|samples| samples * pixels);
            let [wide, high] = Image::text_size(text);
            let corner = [x - f64::from(wide) / 2.0, y - f64::from(high) / 2.0]
                .map(|pixel| pixel.max(f64::from(LABEL_RIM)) as u32);
            picture.fill(corner.map(|pixel| pixel - LABEL_RIM), [wide + 2 * LABEL_RIM, high + 2 * LABEL_RIM], [255; 3]);
            picture.write(corner, text, INK);
        }
        picture
    }

    /// A thin plate: its side, its rim, and its top with the shade of the part on it.
    fn draw_platform(&self, canvas: &mut Canvas, view: &View, corners: &[[f64; 2]], shade: &Shade, z: f64) {
        let base = from_rgb(PLATFORM);
        let thickness = 0.012 * view.size;
        let middle = corners.iter().fold([0.0; 2], |m, c| [0, 1].map(|i| m[i] + c[i] / corners.len() as f64));
        let rim = 3.0 / view.scale;
        for (i, &p) in corners.iter().enumerate() {
            let q = corners[(i + 1) % corners.len()];
            let at = |c: [f64; 2], z: f64| Vector3::new(c[0], c[1], z);
            let normal = Vector3::new(q[1] - p[1], p[0] - q[0], 0.0).try_normalize(0.0).unwrap_or(Vector3::x());
            if normal.dot(&self.camera.toward) > 0.0 {
                let side = base.map(|c| c * (0.62 + 0.25 * self.camera.brightness(&normal)));
                let [a, b, c, d] = [at(p, z - thickness), at(q, z - thickness), at(q, z), at(p, z)];
                canvas.triangle([a, b, c].map(|p| view.spot(&p)), |_| side);
                canvas.triangle([a, c, d].map(|p| view.spot(&p)), |_| side);
            }
            // The plate proper, then a slightly smaller one on top of it: what is left of the first is the rim.
            let inset = |c: [f64; 2]| {
                let d = [0, 1].map(|i| c[i] - middle[i]);
                let share = 1.0 - rim / d[0].hypot(d[1]).max(2.0 * rim);
                [0, 1].map(|i| middle[i] + d[i] * share)
            };
            let top = |c: [f64; 2]| view.spot(&at(c, z));
            canvas.triangle([middle, p, q].map(top), |_| base.map(|c| c * 0.80));
            let inner = [middle, inset(p), inset(q)];
            let above = |c: [f64; 2]| {
                let [x, y, depth] = top(c);
                [x, y, depth + 1e-4 * view.size]
            };
            canvas.triangle(inner.map(above), |w| {
                let place = [0, 1].map(|i| w[0] * inner[0][i] + w[1] * inner[1][i] + w[2] * inner[2][i]);
                let light = 1.0 - 0.42 * shade.at(place);
                base.map(|c| c * light)
            });
        }
    }
}

fn draw_facets(canvas: &mut Canvas, view: &View, facets: &[Facet]) {
    for facet in facets {
        let [a, b, c] = facet.colours;
        canvas.triangle(facet.corners.map(|p| view.spot(&to_f64(p))), |w| {
            let w = w.map(|w| w as f32);
            [0, 1, 2].map(|i| w[0] * a[i] + w[1] * b[i] + w[2] * c[i])
        });
    }
}

fn to_f64(p: [f32; 3]) -> Vector3<f64> {
    Vector3::from(p.map(f64::from))
}

/// Where things come to lie on the canvas.
struct View {
    camera: Camera,
    /// Samples a unit of length.
    scale: f64,
    /// Added to the place on the canvas.
    shift: [f64; 2],
    /// Greatest extent of the scene, in its unit.
    size: f64,
}

impl View {
    /// The largest view that shows all points with a little margin; `None` without points, or with unusable ones.
    fn fit(camera: Camera, points: impl Iterator<Item = [f64; 3]>, canvas: [f64; 2]) -> Option<Self> {
        const MARGIN: f64 = 0.04;
        let (low, high) = points.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
            ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
        });
        let range = |axis: usize| (high[axis] - low[axis]).is_finite().then_some([low[axis], high[axis]]);
        let [[left, right], [low, high], [far, near]] = [range(0)?, range(1)?, range(2)?];
        let room = canvas.map(|side| side * (1.0 - 2.0 * MARGIN));
        let scale = (room[0] / (right - left)).min(room[1] / (high - low));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let shift = [canvas[0] / 2.0 - scale * (left + right) / 2.0, canvas[1] / 2.0 + scale * (low + high) / 2.0];
        Some(View { camera, scale, shift, size: (right - left).max(high - low).max(near - far) })
    }

    fn spot(&self, p: &Vector3<f64>) -> Spot {
        let [x, y, depth] = self.camera.project(p);
        [self.shift[0] + self.scale * x, self.shift[1] - self.scale * y, depth]
    }
}

/// How dark the platform is under the part: near points darken it, then everything is blurred.
struct Shade {
    low: [f64; 2],
    step: f64,
    dark: Vec<f32>,
}

impl Shade {
    /// Cells of the map along each side.
    const SIDE: usize = 96;
    /// Part of the map that is left free around the points for the blur.
    const BORDER: f64 = 0.22;

    fn new(squares: &[([f32; 3], f32)], z: f64) -> Self {
        let bound = |axis: usize| {
            let low = squares.iter().map(|(p, half)| f64::from(p[axis] - half)).fold(f64::INFINITY, f64::min);
            let high = squares.iter().map(|(p, half)| f64::from(p[axis] + half)).fold(f64::NEG_INFINITY, f64::max);
            [low, high]
        };
        let [x, y, height] = [bound(0), bound(1), bound(2)];
        let wide = (x[1] - x[0]).max(y[1] - y[0]);
        if !(wide.is_finite() && wide > 0.0) {
            return Shade { low: [0.0; 2], step: 1.0, dark: Vec::new() };
        }
        let step = wide / (Self::SIDE as f64 * (1.0 - 2.0 * Self::BORDER));
        let low = [x, y].map(|[low, high]| (low + high) / 2.0 - step * Self::SIDE as f64 / 2.0);
        let mut shade = Shade { low, step, dark: vec![0.0; Self::SIDE * Self::SIDE] };
        // What is a third of the part's height up hardly darkens the plate.
        let fade = ((height[1] - z) / 3.0).max(step);
        for &(p, half) in squares {
            let range = |axis: usize| {
                let cell = |c: f32| (((f64::from(c) - low[axis]) / step) as usize).min(Self::SIDE - 1);
                cell(p[axis] - half)..=cell(p[axis] + half)
            };
            let darkness = (-((f64::from(p[2]) - z).max(0.0) / fade)).exp() as f32;
            for row in range(1) {
                for column in range(0) {
                    let dark = &mut shade.dark[column + Self::SIDE * row];
                    *dark = dark.max(darkness);
                }
            }
        }
        for _ in 0..3 {
            shade.blur();
        }
        shade
    }

    /// The mean over five cells along both axes.
    fn blur(&mut self) {
        const REACH: usize = 2;
        for stride in [1, Self::SIDE] {
            let before = self.dark.clone();
            for (i, dark) in self.dark.iter_mut().enumerate() {
                let along = i / stride % Self::SIDE;
                let first = i - along.min(REACH) * stride;
                let last = i + (Self::SIDE - 1 - along).min(REACH) * stride;
                *dark = (first..=last).step_by(stride).map(|k| before[k]).sum::<f32>() / (2 * REACH + 1) as f32;
            }
        }
    }

    /// Darkness at a place, 0 to 1, between the middles of four cells.
    fn at(&self, p: [f64; 2]) -> f32 {
        let [u, v] = [0, 1].map(|axis| (p[axis] - self.low[axis]) / self.step - 0.5);
        let inside = 0.0..(Self::SIDE - 1) as f64;
        if self.dark.is_empty() || !inside.contains(&u) || !inside.contains(&v) {
            return 0.0;
        }
        let (column, row) = (u as usize, v as usize);
        let [s, t] = [u.fract() as f32, v.fract() as f32];
        let cell = |dx: usize, dy: usize| self.dark[column + dx + Self::SIDE * (row + dy)];
        let along = |dy: usize| cell(0, dy) * (1.0 - s) + cell(1, dy) * s;
        along(0) * (1.0 - t) + along(1) * t
    }
}
