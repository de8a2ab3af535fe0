//! The build in a page: orbit, layers, time. A section of `report.html` that needs no network and no library from elsewhere; WebGL2 does
//! the drawing (`viewer.js`), and where there is none the pictures of the report remain.
//!
//! A [`Model`] is plain data in millimetres. [`Model::to_html`] gives the section: the controls (`viewer.html`), the figures as JSON, the
//! numbers as columns that are quantised and deflated (`columns`), and the script.

mod columns;
mod gltf;
mod mesh;
mod model;
mod simplify;

pub use mesh::Mesh;
pub use model::{Mark, Marks, Model, Nozzle, Robot, Stance, Step};

use crate::html::{base64, escaped};
use std::fmt::Write;

/// The script, which is embedded as it is.
pub const SCRIPT: &str = include_str!("viewer.js");
/// The style of its controls.
pub(crate) const STYLE: &str = include_str!("viewer.css");
/// The controls.
const CONTROLS: &str = include_str!("viewer.html");

impl Model {
    /// The section of a page that shows it.
    ///
    /// # Cost
    /// `O(n)` for `n` steps and triangles; some 8 bytes of the page a step.
    ///
    /// # Example
    /// ```
    /// use curvlay_examples::nalgebra::{Point3, Vector3};
    /// use curvlay_examples::viewer::{Model, Step};
    /// let at = |x| Step { tip: Point3::new(x, 0.0, 0.3), direction: Vector3::z(), width: 0.5, height: 0.3, kind: 0, layer: 0, path: 0, seconds: 1.0 };
    /// let model = Model { name: "Jug".into(), kinds: vec!["wall".into()], steps: vec![at(0.0), at(10.0)], ..Model::default() };
    /// assert!(model.to_html().contains("\"steps\":2"));
    /// ```
    pub fn to_html(&self) -> String {
        let (header, columns) = self.pack();
        // `<` in JSON would end the element early.
        let header = header.to_string().replace('<', "\\u003c");
        // Without steps there is no time to go through.
        let still = if self.steps.is_empty() { " data-still" } else { "" };
        let mut html = format!("<section class=\"viewer\"{still} aria-label=\"the build\">\n");
        let _ = write!(
            html,
            "{CONTROLS}<script type=\"application/json\" class=\"view-header\">{header}</script>\n\
             <script type=\"text/plain\" class=\"view-columns\">{}</script>\n<script>\n{SCRIPT}</script>\n\
             <noscript><p>{}</p></noscript>\n</section>",
            base64(&columns),
            escaped("The build can be turned and played where scripts are allowed; pictures follow.")
        );
        html
    }
}
