//! Stiffness from the lay-up beside what the dissertation measured (section 5.4), with what is assumed.

use super::arcs::{APART, Arcs};
use super::specimens::{DUMBBELL_MM, Specimen};
use curvlay_examples::args::Failure;
use curvlay_layers::elastic::{Material, Orthotropic};
use curvlay_toolpath::fiber::sandwich::SandwichLayer;
use curvlay_toolpath::fiber::stiffness::{
    LayUp, StiffnessError, TapeInSection, arch_stiffness_n_mm, three_point_rigidity_nm2,
};

/// Young's modulus of the dumbbells without and with fibre, in GPa (section 5.4.1).
pub const MEASURED_GPA: [f64; 2] = [1.25, 2.32];
/// Flexural rigidity of the bars without and with fibre, in N m^2 (section 5.4.1).
pub const MEASURED_NM2: [f64; 2] = [0.351, 0.671];
/// Force per displacement of the arcs, in N/mm: planar layers (PU), curved layers (CU), curved layers with fibre (CR) (section 5.4.2).
pub const MEASURED_N_MM: [f64; 3] = [11.35, 12.43, 16.54];

/// Force at which specimens broke, in N: PU, CU and CR (section 5.4.3). PU came apart between its layers.
pub const MEASURED_N: [f64; 3] = [80.0, 170.0, 198.0];

/// Modulus of the fibre in GPa: Pyrofil TR50S, data sheet of Mitsubishi Chemical.
pub const FIBER_GPA: f64 = 235.0;
/// Mass of a tow of 15,000 filaments, mg/m, and density of the fibre, g/cm^3: the same data sheet (TR50S 15L).
const TOW_TEX: f64 = 1000.0;
const FIBER_G_CM3: f64 = 1.82;
/// The spread tow is 15 mm wide, and split into three (section 5.3.2).
const TOW_MM: f64 = 15.0;

/// Solid fibre in the section of a tape of a width, in mm^2: what the tow has, by its share of the width.
pub fn fiber_mm2(width_mm: f64) -> f64 {
    TOW_TEX * 1e-3 / FIBER_G_CM3 * width_mm / TOW_MM
}

/// A figure of ours beside the measured one.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// What it is.
    pub what: &'static str,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// By theory.
    pub ours: f64,
    /// In the dissertation.
    pub measured: f64,
    /// What is assumed.
    pub assumed: String,
    /// What may be the reason where they differ.
    pub remark: &'static str,
}

/// The figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    /// In tension with perfect bonds, in GPa.
    pub modulus_gpa: f64,
    /// In bending, in N m^2: with perfect bonds, and with the fibre that bears.
    pub rigidity_nm2: [f64; 2],
    /// Share of the fibre that bears, by the tensile test.
    pub bearing: f64,
    /// What bonds between layers bear in MPa, by the delamination of PU.
    pub bond_mpa: f64,
    /// The arcs by the solver.
    pub arcs: Arcs,
    /// All of them, for the table.
    pub list: Vec<Prediction>,
}

/// The share of the fibre that bears: with it the rule of mixtures gives the modulus that was measured in tension.
pub fn bearing(dumbbell: &Specimen, schedule: &[SandwichLayer]) -> Result<f64, StiffnessError> {
    let share = lay_up(dumbbell, schedule, MEASURED_GPA[0]).fiber_fraction()?;
    Ok((MEASURED_GPA[1] - MEASURED_GPA[0] * (1.0 - share)) / (FIBER_GPA * share))
}

/// The modulus of the bar's thermoplastic in GPa: `EI` of a bar without fibre gives it back.
pub fn matrix_gpa(bar: &Specimen, schedule: &[SandwichLayer]) -> Result<f64, StiffnessError> {
    let plain = LayUp { tapes: Vec::new(), ..lay_up(bar, schedule, 1.0) };
    Ok(MEASURED_NM2[0] / plain.rigidity_nm2()?)
}

/// A tape of the dissertation in a thermoplastic of so many GPa: of its volume so much is fibre, and of that a share bears.
pub fn tape_law(matrix: &Material, thickness_mm: f64, bearing: f64) -> Orthotropic {
    // Per millimetre of width.
    Orthotropic::tape(matrix, 1e3 * FIBER_GPA, bearing * (fiber_mm2(1.0) / thickness_mm).min(1.0))
}

fn lay_up(specimen: &Specimen, schedule: &[SandwichLayer], matrix_gpa: f64) -> LayUp {
    let [width_mm, height_mm] = specimen.section_mm();
    let tape = |(number, layer): (usize, &SandwichLayer)| {
        let at_mm = (number as f64 + 1.0) * specimen.layer_mm;
        layer.carries_tape.then(|| TapeInSection { at_mm, fiber_mm2: fiber_mm2(specimen.tape_mm[1]) })
    };
    let tapes = schedule.iter().enumerate().filter_map(tape).collect();
    LayUp { width_mm, height_mm, matrix_gpa, fiber_gpa: FIBER_GPA, tapes }
}

/// Predicts what the tests of the dissertation would show.
///
/// The modulus of the thermoplastic is that of the specimens without fibre in the same test, so what is compared is what the fibre does. How much of the fibre
/// bears is not known beforehand: tow is ironed on dry. It is taken from the tensile test and used in the others.
///
/// # Arguments
/// * `arcs`: what the solver finds with the tapes of [`tape_law`] and the thermoplastic of [`matrix_gpa`].
pub fn predict(specimens: &[(Specimen, &[SandwichLayer]); 3], arcs: Arcs) -> Result<Predictions, Failure> {
    let [(dumbbell, in_tension), (bar, in_bending), (arc, curved)] = specimens;
    let tension = lay_up(dumbbell, in_tension, MEASURED_GPA[0]);
    let matrix_gpa = matrix_gpa(bar, in_bending)?;
    let bending = lay_up(bar, in_bending, matrix_gpa);
    let bearing = bearing(dumbbell, in_tension)?;
    let loaded = LayUp { fiber_gpa: bearing * FIBER_GPA, ..bending.clone() };
    let arch = LayUp { fiber_gpa: bearing * FIBER_GPA, ..lay_up(arc, curved, matrix_gpa) };
    let (modulus_gpa, rigidity_nm2) = (tension.modulus_gpa()?, [bending.rigidity_nm2()?, loaded.rigidity_nm2()?]);
    let fiber = format!(
        "{:.3} mm² of fibre a tape (TR50S 15K: 1000 tex, 1.82 g/cm³, a third of the tow), {FIBER_GPA} GPa",
        fiber_mm2(5.0)
    );
    let bears = format!("of the fibre {:.1} % bears, as in the tensile test", 100.0 * bearing);
    let mut list = vec![
        Prediction {
            what: "tensile modulus of the reinforced dumbbell, perfect bonds",
            unit: "GPa",
            ours: modulus_gpa,
            measured: MEASURED_GPA[1],
            assumed: format!(
                "rule of mixtures; thermoplastic {} GPa as measured without fibre; section {} x {DUMBBELL_MM} mm (ASTM D638 type I: the dissertation gives none); {fiber}; {:.1} % fibre",
                MEASURED_GPA[0],
                tension.width_mm,
                100.0 * tension.fiber_fraction()?
            ),
            remark: "the dry tow is ironed on by hand: most filaments have no thermoplastic around them and slip or are slack, and grips strain the ends; perfect bonds are an upper bound",
        },
        Prediction {
            what: "flexural rigidity of the reinforced bar, perfect bonds",
            unit: "N m²",
            ours: rigidity_nm2[0],
            measured: MEASURED_NM2[1],
            assumed: format!(
                "layered beam; thermoplastic {matrix_gpa:.2} GPa from the rigidity without fibre ({} N m²); tapes between layers of {} mm; {fiber}",
                MEASURED_NM2[0], bar.layer_mm
            ),
            remark: "perfect bonds are an upper bound, as in tension",
        },
        Prediction {
            what: "flexural rigidity of the reinforced bar",
            unit: "N m²",
            ours: rigidity_nm2[1],
            measured: MEASURED_NM2[1],
            assumed: format!("the same; {bears}"),
            remark: "slack filaments are pressed straight on one side of a bent bar and pulled straight on the other, so more of them may bear than in tension",
        },
    ];
    let bond_mpa = MEASURED_N[0] / arcs.planar.apart_n_mpa;
    list.extend(stiff_arches(arc, &arch, &arcs, &bears)?);
    list.extend(apart(&arcs, bond_mpa));
    Ok(Predictions { modulus_gpa, rigidity_nm2, bearing, bond_mpa, arcs, list })
}

/// The stiffness of the arcs: by the theory of arches without fibre, their ratios by the solver.
fn stiff_arches(arc: &Specimen, arch: &LayUp, arcs: &Arcs, bears: &str) -> Result<Vec<Prediction>, StiffnessError> {
    let Some((radius, half)) = arc.arc() else { return Ok(Vec::new()) };
    let plain = LayUp { tapes: Vec::new(), ..arch.clone() }.rigidity_nm2()?;
    // The tapes end before the ends of the arc.
    let taped = (arc.tape_mm[0] / 2.0 / radius).min(half);
    let curved = arch_stiffness_n_mm(radius, half, &[(half, plain)])?;
    let reinforced = arch_stiffness_n_mm(radius, half, &[(taped, arch.rigidity_nm2()?), (half, plain)])?;
    let [planar_n_mm, curved_n_mm, reinforced_n_mm] = MEASURED_N_MM;
    let modulus = format!("thermoplastic {:.2} GPa as in the bar", arch.matrix_gpa);
    let bond = "the arcs are printed at 210 °C, the bar at 230 °C; the edges sink in, and the table yields";
    Ok(vec![
        Prediction {
            what: "stiffness of the curved arc, CU",
            unit: "N/mm",
            ours: arcs.curved.stiffness_n_mm,
            measured: curved_n_mm,
            assumed: format!(
                "solver, ends slide, pressed at the crown; {modulus}; a thin arch of theory has {curved:.1} N/mm; with the {} GPa of the tensile test it would be {:.1} N/mm",
                MEASURED_GPA[0],
                arcs.curved.stiffness_n_mm * MEASURED_GPA[0] / arch.matrix_gpa
            ),
            remark: bond,
        },
        Prediction {
            what: "curved layers with fibre to without, CR/CU",
            unit: "",
            ours: arcs.curved_taped.stiffness_n_mm / arcs.curved.stiffness_n_mm,
            measured: reinforced_n_mm / curved_n_mm,
            assumed: format!(
                "solver, tapes over {:.0} of {:.0} degrees; {bears}; a thin arch of theory has {:.2}",
                2.0 * taped.to_degrees(),
                2.0 * half.to_degrees(),
                reinforced / curved
            ),
            remark: "another share of the fibre may bear in bending than in tension",
        },
        Prediction {
            what: "planar layers to curved layers, PU/CU",
            unit: "",
            ours: arcs.planar.stiffness_n_mm / arcs.curved.stiffness_n_mm,
            measured: planar_n_mm / curved_n_mm,
            assumed: "the same modulus along and across layers: no test of the dissertation gives that across"
                .to_owned(),
            remark: "the seams between planar layers, and their steps",
        },
    ])
}

/// The forces at which layers come apart.
fn apart(arcs: &Arcs, bond_mpa: f64) -> Vec<Prediction> {
    let [_, curved_n, reinforced_n] = MEASURED_N;
    let assumed = format!(
        "solver; bonds bear {bond_mpa:.2} MPa in peel and in shear, with which {:.0} % of those of the planar arc are apart at {} N, where PU came apart",
        100.0 * APART,
        MEASURED_N[0]
    );
    let remark = "the measured ones were bent flat and beyond before they broke, where stresses are no longer those of a small load, and the dissertation does not say \
                  that they broke between layers";
    let row = |what, ours, measured| Prediction { what, unit: "N", ours, measured, assumed: assumed.clone(), remark };
    vec![
        row(
            "force at which curved layers come apart, CU; measured: broke",
            bond_mpa * arcs.curved.apart_n_mpa,
            curved_n,
        ),
        row(
            "force at which curved layers with fibre come apart, CR; measured: broke",
            bond_mpa * arcs.curved_taped.apart_n_mpa,
            reinforced_n,
        ),
    ]
}

/// `P L^3 / (48 d)` of the bar as the dissertation tests it, for the report: the deflection that the predicted rigidity stands for.
pub fn deflection_mm(rigidity_nm2: f64) -> Result<f64, StiffnessError> {
    const FORCE_N: f64 = 7.27;
    const SPAN_MM: f64 = 200.0;
    // The rigidity falls with one over the deflection.
    Ok(three_point_rigidity_nm2(FORCE_N, SPAN_MM, 1.0)? / rigidity_nm2)
}
