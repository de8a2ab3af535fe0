#!/usr/bin/env python3
"""Seeds for the fuzzers: seeds.py FOLDER [FOLDER OF CURVED_LAYERS]... makes FOLDER/ENTRY/* from files of the repository, small meshes made here,
and files that runs of curved_layers left. Only small files: large ones are slow and find nothing more."""
import shutil
import struct
import sys
import zipfile
from pathlib import Path

LARGEST = 40_000
ROOT = Path(__file__).resolve().parents[2]
FILES = {
    "gcode": ["toolpath/tests/golden/*.gcode"],
    "gcode_flavours": ["toolpath/tests/golden/flavours/*"],
    "gcode_axes": ["toolpath/tests/golden/flavours/*"],
    "gcode_replay": ["toolpath/tests/golden/flavours/*", "toolpath/tests/golden/rotary.gcode"],
    "plan_gcode": ["toolpath/tests/golden/*.gcode"],
    "urscript": ["kinematics/tests/golden/*.script", "kinematics/tests/all/programs/*.script", "kinematics/src/program/urscript/stream/*.txt"],
    "rapid": ["kinematics/tests/golden/*.mod", "kinematics/tests/all/program_rapid/*.mod"],
    "krl": ["kinematics/tests/all/programs/*.src", "kinematics/tests/all/programs/*.dat"],
    "tp": ["kinematics/tests/all/programs/*.ls"],
    "tp_part": ["kinematics/tests/all/programs/PRINT_001.ls"],
    "program_csv": ["kinematics/tests/golden/*.csv"],
    "dxf": ["toolpath/tests/fixtures/drawings/*.dxf"],
    "svg": ["toolpath/tests/fixtures/drawings/*.svg"],
    "profile": ["examples/profiles/*.json"],
    "machine": ["examples/machines/*.json"],
    "workcell": ["examples/cells/*.json"],
    "workcell_file": ["examples/cells/*.json"],
    "grid": ["examples/boge_objects/*.txt"],
}
# What a folder of curved_layers has for which entry.
OF_RUN = {
    "field": "field.txt", "order": "field.csv", "build3mf": "build.3mf", "plan_csv": "toolpath.csv", "workcell": "workcell.json",
    "obj": "layers.obj", "stress_vtk": "layers.vtk",
}
TEXTS = {
    "wires": ["0,0,1\n5,0,1\n5,5,1.5\n\n1 2 3\n2\t3\t4\n"],
    "waypoints": ["px py pz nx ny nz\n0 0 1 0 0 1\n1, 0, 1, 0, 0.6, 0.8\n"],
    "order": [
        "x,y,z,layer\n0,0,0,1\n1,0,0,1\n0,0,1,2\n",
        "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\nCELL_DATA 2\n"
        "SCALARS layer int 1\nLOOKUP_TABLE default\n1 2\n",
    ],
    "stress_csv": ["x_mm,y_mm,z_mm,xx,yy,zz,xy,yz,zx\n0,0,0,1,2,3,4,5,6\n"],
    "stress_vtk": [
        "# vtk DataFile Version 3.0\ns\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n0 0 0\n1 0 0\nCELLS 1 3\n2 0 1\nCELL_TYPES 1\n3\n"
        "POINT_DATA 2\nTENSORS stress double\n1 0 0\n0 2 0\n0 0 3\n1 0 0\n0 2 0\n0 0 3\n",
    ],
    "stress_frd": [
        "    1C\n    2C                             2                                     1\n -1         1 0.00000E+00 0.00000E+00 0.00000E+00\n"
        " -1         2 1.00000E+00 0.00000E+00 0.00000E+00\n -3\n  100CL  101 1.00000E+00           2                     0    1           1\n"
        " -4  STRESS      6    1\n -5  SXX         1    4    1    1\n -1         1 1.00000E+00 2.00000E+00 3.00000E+00 4.00000E+00 5.00000E+00 6.00000E+00\n"
        " -1         2 1.00000E+00 2.00000E+00 3.00000E+00 4.00000E+00 5.00000E+00 6.00000E+00\n -3\n 9999\n",
    ],
    "urdf": [
        '<robot name="a"><link name="base_link"/>'
        + "".join(
            f'<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="{"base_link" if k == 1 else f"l{k - 1}"}"/><child link="l{k}"/>'
            f'<origin xyz="{x} 0 {z}" rpy="0 0 0"/><axis xyz="{a}"/><limit lower="-3" upper="3" velocity="3" effort="9"/></joint>'
            for k, x, z, a in [(1, 0, 0.2, "0 0 1"), (2, 0, 0.1, "0 1 0"), (3, 0, 0.3, "0 1 0"), (4, 0.1, 0.1, "1 0 0"), (5, 0.2, 0, "0 1 0"), (6, 0.1, 0, "1 0 0")]
        )
        + '<link name="tool0"/><joint name="t" type="fixed"><parent link="l6"/><child link="tool0"/></joint></robot>'
    ],
    "ur_calibration": [
        "kinematics:\n"
        + "".join(
            f"  {name}:\n    x: {x}\n    y: {y}\n    z: {z}\n    roll: {roll}\n    pitch: 0\n    yaw: {yaw}\n"
            for name, x, y, z, roll, yaw in [
                ("shoulder", 0, 0, 0.1807, 0, 0), ("upper_arm", 0, 0, 0, 1.570796327, 0), ("forearm", -0.6127, 0, 0, 0, 0),
                ("wrist_1", -0.57155, 0, 0.17415, 0, 0), ("wrist_2", 0, -0.11985, 0, 1.570796327, 0), ("wrist_3", 0, 0.11655, 0, 1.570796326, 3.141592653),
            ]
        )
        + "  hash: calib_1\n"
    ],
    "measurements": [
        "kind,joint1_deg,joint2_deg,joint3_deg,joint4_deg,joint5_deg,joint6_deg,x_mm,y_mm,z_mm\ntouch,0,-90,90,0,90,0,,,\npose,10,-80,70,5,60,20,812.3,-40.1,655.0\n",
        '{"version": 1, "touches": [{"joints_deg": [0, 1, 2, 3, 4, 5]}, {"flange": {"position_mm": [1, 2, 3], "rpy_deg": [0, 0, 90]}}], "poses": []}',
    ],
    "drawing": [],
    "link": ["OK 1 2 3\n", "RPM,4.5", "7       E   RPM,4.5 " + " " * 139 + "\n"],
    "plan_csv": [
        "kind,x_mm,y_mm,z_mm,i,j,k,filament_mm,feed_mm_s,seconds,layer,bead,width_mm,height_mm\ntravel,0,0,1,0,0,1,0,10,1,,,,\n"
        "print,10,0,1,0,0,1,2,10,1,1,wall,0.5,0.3\n",
    ],
    "svg": ['<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><g id="rim"><circle cx="5" cy="5" r="4"/></g><path d="M0 0 L10 0 C1 2 3 4 5 6 A1 2 0 1 1 9 9 z" stroke="black"/></svg>'],
    "dxf": ["0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n0\n11\n5\n21\n5\n0\nCIRCLE\n8\n0\n10\n1\n20\n2\n40\n3\n0\nENDSEC\n0\nEOF\n"],
}
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 3, 0), (0, 3, 0), (0, 0, 1), (2, 0, 1), (2, 3, 1), (0, 3, 1)]
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
TRIANGLES = [t for a, b, c, d in SIDES for t in [(a, b, c), (a, c, d)]]


def meshes(folder):
    words = lambda rows: "".join(" ".join(map(str, row)) + "\n" for row in rows)
    made = {}
    made["obj/box.obj"] = words([("v", *p) for p in CORNERS] + [("f", *(k + 1 for k in side)) for side in SIDES])
    made["stl/box.stl"] = "solid box\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + words([("vertex", *CORNERS[k]) for k in t]) + "endloop\nendfacet\n" for t in TRIANGLES) + "endsolid box\n"
    head = "ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    made["ply/box.ply"] = head.format("ascii") + words(CORNERS) + words([(4, *side) for side in SIDES])
    binary = b"".join(struct.pack("<3f", *p) for p in CORNERS) + b"".join(struct.pack("<B4i", 4, *side) for side in SIDES)
    made["ply/binary.ply"] = head.format("binary_little_endian").encode() + binary
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for k in t for x in CORNERS[k]), 0) for t in TRIANGLES)
    made["stl/binary.stl"] = b" " * 80 + struct.pack("<I", len(TRIANGLES)) + facets
    for name, content in made.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    model = '<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model"><mesh><vertices>'
    model += "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS) + "</vertices><triangles>"
    model += "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in TRIANGLES) + "</triangles></mesh></object>"
    model += '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object></resources><build><item objectid="2"/></build></model>'
    relation = '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    for name, method in [("stored", zipfile.ZIP_STORED), ("deflated", zipfile.ZIP_DEFLATED)]:
        with zipfile.ZipFile(folder / "3mf" / f"{name}.3mf", "w", method) as package:
            package.writestr("_rels/.rels", relation)
            package.writestr("3D/3dmodel.model", model)


def stored(path, target):
    """A package again without compression, so that changed bytes reach the parser; its sums are then wrong, as are those of most damaged files."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as package:
        for name in source.namelist():
            package.writestr(name, source.read(name))


def main():
    folder, *runs = map(Path, sys.argv[1:])
    for entry in set(FILES) | set(TEXTS) | set(OF_RUN) | {"obj", "stl", "ply", "3mf"}:
        (folder / entry).mkdir(parents=True, exist_ok=True)
    for entry, patterns in FILES.items():
        for path in (path for pattern in patterns for path in ROOT.glob(pattern)):
            if path.stat().st_size <= LARGEST:
                shutil.copy(path, folder / entry / path.name)
    for entry, texts in TEXTS.items():
        for number, text in enumerate(texts):
            (folder / entry / f"made_{number}").write_text(text)
    for number, run in enumerate(runs):
        for entry, name in OF_RUN.items():
            path = run / name
            if path.is_file() and path.stat().st_size <= LARGEST:
                shutil.copy(path, folder / entry / f"run_{number}_{name}")
                if name.endswith(".3mf"):
                    stored(path, folder / entry / f"run_{number}_stored")
    meshes(folder)


main()
