//! Continuous fibre on a layer: tapes along a field of directions.
//!
//! Dai 2020, chapter 5, presses tapes of carbon fibre onto layers along paths that were drawn by hand. Here they are planned: from a direction at each
//! place of a layer to lines of even spacing, and from lines to tapes with their ends.
//!
//! * `files`: stresses from CSV, VTK and CalculiX. `stress`: stresses at the vertices of a layer; `samples`: the nearest samples.
//! * `direction`: fields of line directions, from a function, from stresses, or along guide curves; `frame`: directions as numbers.
//! * `stripes`: lines along a field (Knöppel et al. 2015); `lines`: level lines of whole numbers.
//! * `offsets`: guide curves and their geodesic offsets; `insert`: a curve as edges of the mesh.
//! * `plan`: tapes along lines; `station`: lines in small steps; `strip`: tapes in cells. `measure`: what tapes cover.
//! * `sandwich`: which layers carry tapes; `head`: the moves of a tape head; `bedding`: what tapes lie on, and what lies on them.
//! * `near`: nearest points and normals. `walk`: straight ways over a layer.

mod bedding;
mod conductor;
mod direction;
mod files;
mod frame;
mod head;
mod insert;
mod lines;
mod measure;
mod near;
mod offsets;
mod plan;
mod samples;
mod sandwich;
mod station;
mod stiffness;
mod stress;
mod strip;
mod stripes;
mod tape;
mod walk;

pub use bedding::{BeddingError, Roller, TapeBedding, TapePlace, bedded_surface, tape_bedding};
pub use conductor::{ConductorError, ConductorOptions, conductor};
pub use direction::{DirectionError, DirectionField, Singularity};
pub use files::{
    STRESS_CSV_HEADER, StressFileError, read_stress_csv, read_stress_frd, read_stress_vtk, write_stress_csv,
};
pub use head::{LayerTapes, TapeHead, TapeHeadError, with_tapes};
pub use lines::CentreLine;
pub use measure::{PrincipalAngle, TapeCover, angle_to_principal};
pub use offsets::{OffsetError, offset_lines};
pub use plan::{
    EmptyPlan, LeftOutTape, TapeError, TapeLimit, TapeOptions, TapePlan, lay_tapes, lay_tapes_along, plan_tapes,
};
pub use sandwich::{SandwichError, SandwichLayer, SandwichOptions, raise, sandwich, sandwich_on};
pub use stiffness::{LayUp, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2};
pub use stress::{LayerStress, Principal, StressError, StressOptions, StressSample};
pub use stripes::{StripeError, Stripes, stripes};
pub use tape::Tape;
