//! Robot programs read: what was written, cut or spoilt, and any text.

use super::programs::steps;
use crate::common::programs::written_files;
use crate::common::{ROBOTS, arm};
use curvlay_kinematics::program::*;
use curvlay_kinematics::urdf::{LinkNames, UrdfArm};
use proptest::prelude::*;

const WORDS: [&str; 12] = [
    "MODULE m\nPROC main()\nMoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,t;\n",
    "def m():\n  movel(p[0,0,0,0,0,0], a=1, v=1)\nend\n",
    "DEF m()\nLIN {X 1, Y 2, Z 3, A 0, B 0, C 0}\nEND\n",
    "/PROG M\n/MN\n 1:L P[1] 100mm/sec CNT100 ;\n/POS\nP[1]{\n",
    "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1e999 0 0'/></joint></robot>",
    "GLOBAL ",
    "[",
    "]",
    "{",
    "}",
    "9E999",
    "\n",
];

fn text() -> impl Strategy<Value = String> {
    let word = prop_oneof![3 => prop::sample::select(WORDS.to_vec()).prop_map(String::from), 1 => "[a-zA-Z0-9 ,.:;=(){}\n\"!-]{0,30}"];
    prop::collection::vec(word, 0..6).prop_map(|words| words.concat())
}

fn read_all(text: &[u8]) {
    let open = |_: &str| Ok(text);
    if let Ok(reader) = CsvReader::new(text) {
        reader.for_each(drop);
    }
    if let Ok(reader) = UrScriptReader::new(text) {
        let _ = (reader.name(), reader.part_in_hand(), reader.payload(), reader.tool(), reader.work());
        reader.for_each(drop);
    }
    if let Ok(mut part) = RapidPart::new(text) {
        part.by_ref().for_each(drop);
        let _ = (part.acceleration(), part.procedure(), part.warnings());
    }
    let _ = RapidMain::read(text);
    if let Ok(mut program) = read_rapid(text, open) {
        program.by_ref().take(1000).for_each(drop);
        let _ = (program.main(), program.acceleration(), program.warnings());
    }
    if let Ok(mut program) = read_krl(text, text, open) {
        program.by_ref().take(1000).for_each(drop);
        let _ = (program.name(), program.frames(), program.kinematic(), program.part_in_hand());
    }
    if let Ok(mut program) = read_tp(text, open) {
        program.by_ref().take(1000).for_each(drop);
        let _ = (program.name(), program.part_in_hand());
    }
    let name = Some(String::from_utf8_lossy(&text[..text.len().min(5)]).into_owned());
    for names in [LinkNames::default(), LinkNames { base: name.clone(), flange: name }] {
        let _ = UrdfArm::read(&String::from_utf8_lossy(text), &names);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn readers_take_anything(steps in steps(), text in text(), any in prop::collection::vec(any::<u8>(), 0..90), cut in 0..2000usize, byte in any::<u8>(), robot in 0..6usize) {
        let mut csv = Vec::new();
        // Writers refuse steps that no robot makes.
        let _ = write_csv(steps.iter().copied(), &ProgramLimits::default(), &mut csv);
        let mut ur = Vec::new();
        let _ = write_urscript(steps.iter().copied(), &UrScriptOptions::default(), &mut ur);
        let rapid = written_files(|open| write_rapid(steps.iter().copied(), &RapidOptions::default(), open));
        let krl = KrlOptions { arm: Some(arm(ROBOTS[robot].1)), ..KrlOptions::default() };
        let krl = written_files(|open| write_krl(steps.iter().copied(), &krl, open));
        let tp = written_files(|open| write_tp(steps.iter().copied(), &TpOptions::default(), open));
        let files = [rapid.map(|(files, _)| files), krl.map(|(files, _)| files), tp.map(|(files, _)| files)];
        let files = files.into_iter().flatten().flat_map(|files| files.into_values()).map(String::into_bytes);
        for mut text in [csv, ur, text.into_bytes(), any].into_iter().chain(files) {
            read_all(&text);
            read_all(&text[..cut.min(text.len())]);
            if let Some(place) = text.get_mut(cut) {
                *place = byte;
                read_all(&text);
            }
        }
    }
}
