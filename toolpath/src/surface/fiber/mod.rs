//! Continuous fibre on a layer: tapes along a field of directions.

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
pub use sandwich::{SandwichError, SandwichLayer, SandwichOptions, raise, sandwich};
pub use stiffness::{LayUp, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2};
pub use stress::{LayerStress, Principal, StressError, StressOptions, StressSample};
pub use stripes::{StripeError, Stripes, stripes};
pub use tape::Tape;
