//! Stresses from files: what is read, what is refused, and where.

use curvlay_toolpath::fiber::stress::StressSample;
use curvlay_toolpath::fiber::stress_files::{
    StressFileError, read_stress_csv, read_stress_frd, read_stress_vtk, write_stress_csv,
};
use curvlay_toolpath::nalgebra::{Matrix3, Point3};
use proptest::prelude::*;

/// Two nodes, as CalculiX writes them.
const FRD: &str = "    1C
    1UUSER
    2C                             2                                     1
 -1        10 0.00000E+00 1.00000E+00-2.00000E+00
 -1        20 4.00000E+00 5.00000E+00 6.00000E+00
 -3
    3C                             1                                     1
 -1         1    1    0    1
 -2        10        20
 -3
  100CL  101 1.000000000           2                     0    1           1
 -4  DISP        4    1
 -5  D1          1    2    1    0
 -1        10 0.00000E+00 0.00000E+00 0.00000E+00
 -3
  100CL  101 1.000000000           2                     0    1           1
 -4  STRESS      6    1
 -5  SXX         1    4    1    1
 -5  SYY         1    4    2    2
 -5  SZZ         1    4    3    3
 -5  SXY         1    4    1    2
 -5  SYZ         1    4    2    3
 -5  SZX         1    4    3    1
 -1        20 1.00000E+00-2.00000E+00 3.00000E+00-4.00000E+00 5.00000E+00-6.00000E+00
 -1        10 1.50000E+00 0.00000E+00 0.00000E+00 0.00000E+00 0.00000E+00 0.00000E+00
 -3
 9999
";

const VTK: &str = "# vtk DataFile Version 3.0
a plate
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 2 1 2
ORIGIN 1 2 3
SPACING 0.5 1 2
CELL_DATA 1
FIELD cells 1
s 6 1 double
9 9 9 9 9 9
POINT_DATA 4
SCALARS temperature float 1
LOOKUP_TABLE default
1 2 3
4
FIELD results 2
displacement 3 4 float
0 0 0 0 0 0
0 0 0 0 0 0
S 6 4 float
1 2 3 4 5 6 0 0 0 0 0 0 0 0 0 0
0 0 7 8 9 1 2 3
";

#[test]
fn nodes_of_calculix_have_their_stresses() {
    let samples = read_stress_frd(FRD.as_bytes()).unwrap();
    let stress = Matrix3::new(1.0, -4.0, -6.0, -4.0, -2.0, 5.0, -6.0, 5.0, 3.0);
    assert_eq!(samples[0], StressSample { point: Point3::new(4.0, 5.0, 6.0), stress });
    assert_eq!((samples[1].point, samples[1].stress[(0, 0)]), (Point3::new(0.0, 1.0, -2.0), 1.5));
    // Of two steps the last one counts.
    let second =
        FRD.replace(" 9999\n", "") + &FRD[FRD.find("  100CL").unwrap()..].replace("1.50000E+00", "2.50000E+00");
    assert!((read_stress_frd(second.as_bytes()).unwrap()[1].stress[(0, 0)] - 2.5).abs() < 1e-12);
    // The short format has five columns for a node.
    let short: String = FRD
        .lines()
        .map(|line| match line {
            _ if line.contains("2C  ") || line.contains("100CL") => line[..line.len() - 1].to_owned() + "0\n",
            _ if line.starts_with(" -1  ") && line.contains('.') => format!(" -1{}\n", &line[8..]),
            _ => line.to_owned() + "\n",
        })
        .collect();
    assert_eq!(read_stress_frd(short.as_bytes()).unwrap(), samples);
}

#[test]
fn arrays_of_vtk_have_their_points() {
    let samples = read_stress_vtk(VTK.as_bytes(), None).unwrap();
    let at: Vec<_> = samples.iter().map(|s| [s.point.x, s.point.y, s.point.z]).collect();
    assert_eq!(at, [[1.0, 2.0, 3.0], [1.5, 2.0, 3.0], [1.0, 2.0, 5.0], [1.5, 2.0, 5.0]]);
    assert_eq!(samples[0].stress, Matrix3::new(1.0, 4.0, 6.0, 4.0, 2.0, 5.0, 6.0, 5.0, 3.0));
    assert_eq!(samples[3].stress, Matrix3::new(7.0, 1.0, 3.0, 1.0, 8.0, 2.0, 3.0, 2.0, 9.0));
    assert_eq!(read_stress_vtk(VTK.as_bytes(), Some("S")).unwrap(), samples);
    let other = read_stress_vtk(VTK.as_bytes(), Some("displacement"));
    assert!(matches!(other, Err(StressFileError::Columns { found: 3, wanted: 6, .. })));
    assert!(matches!(read_stress_vtk(VTK.as_bytes(), Some("T")), Err(StressFileError::NoStress { .. })));
}

/// What a reader says of a file with one change.
fn changed<T: std::fmt::Debug>(
    file: &str,
    from: &str,
    to: &str,
    read: impl Fn(&[u8]) -> Result<T, StressFileError>,
) -> String {
    assert!(file.contains(from), "{from}");
    read(file.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
}

#[test]
fn bad_files_are_refused_with_the_line() {
    let frd = |from, to| changed(FRD, from, to, |file| read_stress_frd(file));
    assert_eq!(frd("-6.00000E+00\n -1", "\n -1"), "line 24: 5 columns; there must be 6");
    assert_eq!(
        frd("-6.00000E+00\n -1", "         NaN\n -1"),
        "line 24: `         NaN` is not a number between -1e100 and 1e100"
    );
    assert_eq!(frd(" -1        10 1.5", " -1        30 1.5"), "line 25: expected a node of the file, found `30`");
    assert_eq!(
        frd(" -1        10 1.5", " -1       x10 1.5"),
        "line 25: expected the number of a node, found `       x10`"
    );
    assert!(frd("SXY", "SYX").starts_with("line 24: expected components SXX SYY SZZ SXY SYZ SZX"));
    assert!(frd("  1\n -1        10 0", "  2\n -1        10 0").starts_with("line 3: expected a block of text"));
    assert!(frd("-4  STRESS", "-4  STRAIN").starts_with("the file has no stresses"));
    assert_eq!(frd(" -3\n 9999\n", ""), "line 25: the file ends; expected the end -3 of a block of results");
    assert_eq!(
        frd(" -3\n    3C", "    3C").split(',').next().unwrap(),
        "line 6: expected a node (-1) or the end of the block (-3)"
    );

    let vtk = |from, to| changed(VTK, from, to, |file| read_stress_vtk(file, None));
    assert_eq!(vtk("ASCII", "BINARY"), "line 3: expected `ASCII`: only text can be read, found `BINARY`");
    assert_eq!(vtk("# vtk", "# vts"), "line 1: expected `# vtk DataFile Version`, found `# vts DataFile Version 3.0`");
    assert_eq!(vtk("7 8 9 1 2 3", "7 8 9 1 2"), "line 23: the file ends; expected a number");
    assert_eq!(vtk("7 8 9", "7 inf 9"), "line 23: `inf` is not a number between -1e100 and 1e100");
    assert_eq!(vtk("DIMENSIONS 2 1 2", "DIMENSIONS 2 2 2"), "line 23: 4 columns; there must be 8");
    assert!(vtk("S 6 4", "S 5 4").starts_with("the file has no stresses"));
    let tensors = "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n0 0 0\nPOINT_DATA 1\nTENSORS t float\n1 2 3 2 4 5 3 9 6\n";
    let skew = read_stress_vtk(tensors.as_bytes(), None).unwrap_err().to_string();
    assert_eq!(skew, "line 9: the stress tensor of point 0 is not symmetric");
    // Counts that no memory holds are not believed.
    let endless = tensors.replace("POINTS 1", "POINTS 18446744073709551615");
    assert!(matches!(read_stress_vtk(endless.as_bytes(), None), Err(StressFileError::Number { line: 7, .. })));

    let csv = |file: &str| read_stress_csv(file.as_bytes()).unwrap_err().to_string();
    assert_eq!(csv("# none\n\n"), "the file has no stresses: no line has a position and six components");
    assert_eq!(csv("1,2,3,4,5,6,7,8\n"), "line 1: 8 columns; there must be 9");
    assert_eq!(
        csv("a,b,c,d,e,f,g,h,i\n\n1,2,3,4,5,6,7,8,nan"),
        "line 3: `nan` is not a number between -1e100 and 1e100"
    );
    assert_eq!(csv("1,2,3,4,5,6,7,8,9\nx,y,z,a,b,c,d,e,f"), "line 2: `x` is not a number between -1e100 and 1e100");
    assert!(csv(&"1".repeat(1 << 21)).starts_with("line 1: expected a line of text"));
}

fn samples() -> impl Strategy<Value = Vec<StressSample>> {
    let number = prop_oneof![-1e3..1e3, Just(0.0), -1e-300..1e-300];
    prop::collection::vec(prop::array::uniform9(number), 1..6).prop_map(|rows| {
        let of = |[x, y, z, a, b, c, d, e, f]: [f64; 9]| StressSample {
            point: Point3::new(x, y, z),
            stress: Matrix3::new(a, d, f, d, b, e, f, e, c),
        };
        rows.into_iter().map(of).collect()
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(samples in samples()) {
        let mut file = Vec::new();
        write_stress_csv(&samples, &mut file).unwrap();
        prop_assert_eq!(read_stress_csv(&file[..]).unwrap(), samples);
    }

    #[test]
    fn no_file_makes_a_reader_panic(cut in 0usize..1200, at in 0usize..1200, byte in any::<u8>()) {
        for file in [FRD, VTK] {
            let mut bytes = file.as_bytes()[..cut.min(file.len())].to_vec();
            if let Some(place) = bytes.get_mut(at) {
                *place = byte;
            }
            let _ = (read_stress_csv(&bytes[..]), read_stress_frd(&bytes[..]), read_stress_vtk(&bytes[..], None));
        }
    }
}
