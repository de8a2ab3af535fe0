//! A workcell around an arm of the catalogue, for a first plan: sizes follow the reach of the arm.

use super::controller::ControllerModel;
use super::model::{
    ArmGeometry, ArmPart, FrameModel, Held, LimitsModel, MountModel, NozzleModel, PlateModel, ShapeModel, SolidModel,
    StandModel, VERSION, WorkcellModel,
};
use crate::arm::robots::CatalogueArm;
use crate::arm::{ArmModel, Geometry};

/// Where the middle of the plate is, in reaches in front of axis 2: between folded and stretched, with room for a part.
const FORWARD: f64 = 0.75;

/// Diameter of the plate, in reaches: it begins at 0.6, nearer than which forearms are folded against their stops, and ends at 0.9.
const PLATE: f64 = 0.3;

/// Height of the pedestal, length of the nozzle from the flange, thickness of plate and table, in millimetres.
const PEDESTAL_MM: f64 = 600.0;
const TIP_MM: f64 = 150.0;
const PLATE_MM: f64 = 20.0;
const TABLE_MM: f64 = 40.0;

/// What planners assume where makers publish nothing: MoveIt's 10 rad/s2, and a tenth of a second to reach it.
const ACCELERATION_RAD_S2: f64 = 10.0;
const JERK_RAD_S3: f64 = 100.0;

/// What the name of such a workcell ends with.
const ASSUMED: &str = " (assumed workcell)";

impl WorkcellModel {
    /// Whether this is a workcell that was put [around](Self::around) an arm, and not somebody's.
    pub fn is_assumed(&self) -> bool {
        self.name.ends_with(ASSUMED)
    }

    /// A workcell around an arm, where there is none yet: the arm on a pedestal of 600 mm, a nozzle that points along axis 6 with its tip 150 mm from the
    /// flange, and a round plate in front of the arm, 0.75 reaches from axis 2 and 0.3 reaches wide (a reach is upper arm and
    /// forearm), not lower than its foot and so high that the wrist is at the height of axis 2 at least. Accelerations are 10 rad/s2 and jerks 100 rad/s3; the elbow of a UR arm turns half a turn.
    ///
    /// Real workcells differ: copy the file and put your numbers in.
    ///
    /// ```
    /// use curvlay_kinematics::workcell::{AnyWorkcell, WorkcellModel};
    /// use curvlay_kinematics::robots;
    /// let arm = robots::find("KR 6 R900-2").ok_or("unknown")?;
    /// let model = WorkcellModel::around(arm);
    /// assert_eq!((model.part.position_mm[0].round(), model.plate.diameter_mm), (682.0, Some(260.0)));
    /// assert!(AnyWorkcell::new(model).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn around(arm: &CatalogueArm) -> Self {
        let part = ArmPart::new(ArmGeometry::Named(arm.name.into()));
        WorkcellModel::around_part(arm.title, part, &arm.model, arm.mount_below_base_mm)
    }

    /// The same around any arm.
    ///
    /// # Arguments
    /// * `name`: what reports call it.
    /// * `part`: the arm as the file has it; accelerations, jerks and stops of the elbow are put in where it has none.
    /// * `model`: its numbers.
    /// * `below_mm`: how far the mounting face is below the base frame.
    pub fn around_part(name: &str, part: ArmPart, model: &ArmModel, below_mm: f64) -> Self {
        let (shoulder_mm, shoulder_z_mm, reach_mm, hand_mm) = match &model.geometry {
            Geometry::Ur(table) => (0.0, table.d[0], table.a[1].abs() + table.a[2].abs(), table.d[5]),
            Geometry::Ortho(lengths) => {
                (lengths.a1, lengths.c1, lengths.c2.abs() + lengths.a2.hypot(lengths.c3), lengths.c4)
            }
        };
        // Lower down, forearms that a parallelogram keeps level meet their stops.
        let plate_mm = (shoulder_z_mm - hand_mm - TIP_MM).max(-below_mm);
        let diameter_mm = (PLATE * reach_mm / 10.0).floor() * 10.0;
        let half_mm = 0.6 * diameter_mm;
        let block = |min_mm, max_mm| ShapeModel::Block { min_mm, max_mm };
        let floor_mm = -PEDESTAL_MM - below_mm;
        let solid =
            |name: &str, mount, shape| SolidModel { name: name.into(), mount, frame: FrameModel::default(), shape };
        WorkcellModel {
            version: VERSION,
            name: format!("{name} over a plate{ASSUMED}"),
            arm: ArmPart { limits: limits(&part.limits, model), ..part },
            held: Held::Nozzle,
            part: FrameModel {
                position_mm: [(shoulder_mm + FORWARD * reach_mm).round(), 0.0, plate_mm.round()],
                ..FrameModel::default()
            },
            nozzle: NozzleModel {
                tip_mm: [0.0, 0.0, TIP_MM],
                flow: [0.0, 0.0, 1.0],
                tip_flat_mm: 1.0,
                cone_half_angle_deg: 45.0,
                cone_height_mm: 8.0,
                block_diameter_mm: 20.0,
                block_top_mm: 61.0,
            },
            roller: None,
            plate: PlateModel { thickness_mm: PLATE_MM, diameter_mm: Some(diameter_mm), size_mm: None },
            positioner: None,
            track: None,
            home_deg: None,
            controller: ControllerModel::default(),
            stand: Some(StandModel::Pedestal { height_mm: PEDESTAL_MM, radius_mm: None }),
            solids: vec![
                solid(
                    "floor",
                    MountModel::Base,
                    block([-4000.0, -4000.0, floor_mm - 50.0], [4000.0, 4000.0, floor_mm]),
                ),
                solid(
                    "table",
                    MountModel::Part,
                    block([-half_mm, -half_mm, -PLATE_MM - TABLE_MM], [half_mm, half_mm, -PLATE_MM]),
                ),
                solid(
                    "holder",
                    MountModel::Nozzle,
                    ShapeModel::Cylinder { radius_mm: 25.0, min_z_mm: 60.0, max_z_mm: TIP_MM },
                ),
            ],
        }
    }
}

/// Accelerations and jerks, and stops of the elbow of a UR arm: no way leads past half a turn, the shoulder is in the way.
fn limits(given: &LimitsModel<6>, model: &ArmModel) -> LimitsModel<6> {
    let elbow = |ends: &[f64; 6], half_turn: f64| {
        let mut stops = ends.map(|end| end.is_finite().then(|| end.to_degrees().round()));
        stops[2] = Some(half_turn);
        stops
    };
    let is_ur = matches!(model.geometry, Geometry::Ur(_));
    LimitsModel {
        min_deg: given.min_deg.or_else(|| is_ur.then(|| elbow(&model.limits.lower, -180.0))),
        max_deg: given.max_deg.or_else(|| is_ur.then(|| elbow(&model.limits.upper, 180.0))),
        max_acceleration_rad_s2: given.max_acceleration_rad_s2.or(Some([Some(ACCELERATION_RAD_S2); 6])),
        max_jerk_rad_s3: given.max_jerk_rad_s3.or(Some([Some(JERK_RAD_S3); 6])),
        ..*given
    }
}
