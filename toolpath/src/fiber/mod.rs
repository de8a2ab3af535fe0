//! Continuous fibre on a layer: tapes along a field of directions.
//!
//! Takes the mesh of a layer, and stresses or guide curves; gives tapes and the moves of the head that lays them.
//!
//! Dai 2020, chapter 5, presses tapes of carbon fibre onto layers along paths that were drawn by hand. Here they are planned: from a direction at each
//! place of a layer to lines of even spacing, and from lines to tapes with their ends.
//!
//! * `stress_files`: stresses from CSV, VTK and CalculiX. `stress`: stresses at the vertices of a layer; `samples`: the nearest samples.
//! * `direction`: fields of line directions, from a function, from stresses, or along guide curves; `frame`: directions as numbers.
//! * `stripes`: lines along a field (Knöppel et al. 2015); `lines`: level lines of whole numbers.
//! * `offsets`: guide curves and their geodesic offsets; `insert`: a curve as edges of the mesh.
//! * `tapes`: tapes along lines; `station`: lines in small steps; `strip`: tapes in cells. `measure`: what tapes cover.
//! * `sandwich`: which layers carry tapes; `head`: the moves of a tape head; `bedding`: what tapes lie on, and what lies on them.
//! * `near`: nearest points and normals. `walk`: straight ways over a layer.

pub mod bedding;
pub mod conductor;
pub mod direction;
mod frame;
pub mod head;
mod insert;
pub mod lines;
pub mod measure;
mod near;
pub mod offsets;
mod sample;
mod samples;
pub mod sandwich;
mod station;
pub mod stiffness;
pub mod stress;
pub mod stress_files;
mod strip;
pub mod stripes;
mod tape;
pub mod tapes;
mod walk;
