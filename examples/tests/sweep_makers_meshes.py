#!/usr/bin/env python3
"""Sweeps a written print of `curved_layers --stage motion` with the maker's meshes of a UR arm: run by hand.

    pip install example-robot-data python-fcl trimesh numpy scipy
    python examples/tests/sweep_makers_meshes.py target/out/curved_layers examples/cells/ur3.json [--part part.stl]

It shares nothing with this project: forward kinematics and meshes are those of the maker's ROS description (by way of
example-robot-data), collisions those of FCL, and of our files it reads `trajectory.csv`, `summary.json` and the workcell. Motions are
sampled: no joint turns by more than `--step` between samples. Every link is looked at against every link that is not its neighbour,
and against stand, solids, plate, nozzle and hot end (on the way while moving; of the arm always). With `--part` the links are looked at
against the finished part as well, which stands as `summary.json` says. Exit status: 0 no contact, 1 contacts.
"""

import argparse, csv, json, sys, xml.etree.ElementTree as xml
from pathlib import Path

import fcl
import numpy as np
import trimesh
from scipy.interpolate import CubicSpline

LINKS = ["base", "shoulder", "upper arm", "forearm", "wrist 1", "wrist 2", "flange"]
URDF = {"UR3": "ur3_robot.urdf", "UR5": "ur5_robot.urdf", "UR10": "ur10_robot.urdf"}


def pose(rotation=np.eye(3), position=(0, 0, 0)):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, position
    return matrix


def about(axis, angle):
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def rpy(angles):
    return about([0, 0, 1], angles[2]) @ about([0, 1, 0], angles[1]) @ about([1, 0, 0], angles[0])


def origin(element):
    if element is None:
        return pose()
    numbers = lambda key: [float(x) for x in element.get(key, "0 0 0").split()]
    return pose(rpy(numbers("rpy")), np.array(numbers("xyz")) * 1000)


class Arm:
    """The arm of a URDF file: six joints in a row, and the collision mesh of each link, in millimetres."""

    def __init__(self, name):
        share = next(p for p in map(Path, sys.path) if (p / "cmeel.prefix/share/example-robot-data").exists())
        share = share / "cmeel.prefix/share"
        root = xml.parse(share / "example-robot-data/robots/ur_description/urdf" / URDF[name]).getroot()
        joints = [joint for joint in root.findall("joint") if joint.get("type") == "revolute"][:6]
        self.joints = [(origin(j.find("origin")), [float(x) for x in j.find("axis").get("xyz").split()]) for j in joints]
        tool = next(j for j in root.findall("joint") if j.find("child").get("link") == "tool0")
        self.tool = origin(tool.find("origin"))
        links = {link.get("name"): link for link in root.findall("link")}
        self.meshes = []
        for name in ["base_link"] + [joint.find("child").get("link") for joint in joints]:
            collision = links[name].find("collision")
            file = collision.find("geometry/mesh").get("filename").replace("package://", "")
            mesh = trimesh.load(share / file, force="mesh")
            mesh.apply_scale(1000)
            mesh.apply_transform(origin(collision.find("origin")))
            self.meshes.append(mesh)

    def frames(self, joints):
        """Frames of the links in the controller's base, which is the description's turned by half a turn, and the tool flange."""
        frames = [pose(about([0, 0, 1], np.pi))]
        for (before, axis), angle in zip(self.joints, joints):
            frames.append(frames[-1] @ before @ pose(about(axis, angle)))
        return frames, frames[-1] @ self.tool


def model(mesh):
    bvh = fcl.BVHModel()
    bvh.beginModel(len(mesh.vertices), len(mesh.faces))
    bvh.addSubModel(mesh.vertices, mesh.faces)
    bvh.endModel()
    return bvh


def cylinder(radius, low, high, top=None):
    ring = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    circle = lambda r, z: np.c_[r * np.cos(ring), r * np.sin(ring), np.full(48, z)]
    return trimesh.convex.convex_hull(np.concatenate([circle(radius, low), circle(radius if top is None else top, high)]))


def block(low, high):
    low, high = np.array(low, float), np.array(high, float)
    return trimesh.creation.box(bounds=[low, high])


def frame(given):
    given = given or {}
    return pose(rpy(np.radians(given.get("rpy_deg", [0, 0, 0]))), given.get("position_mm", [0, 0, 0]))


def shape(given):
    (kind, value), = given.items()
    if kind == "block":
        return block(value["min_mm"], value["max_mm"])
    if kind == "cylinder":
        return cylinder(value["radius_mm"], value["min_z_mm"], value["max_z_mm"])
    raise SystemExit(f"shape {kind} is not known here")


def nozzle_frame(nozzle):
    up = -np.array(nozzle["flow"], float) / np.linalg.norm(nozzle["flow"])
    side = np.cross([1, 0, 0] if abs(up[0]) < 0.9 else [0, 1, 0], up)
    side /= np.linalg.norm(side)
    return pose(np.c_[side, np.cross(up, side), up], nozzle["tip_mm"])


def bodies(cell, summary, foot, part_file):
    """Name, mount (`base` or `flange`), pose on it, mesh; and which of them the nozzle is, and where the part is."""
    nozzle, held = cell["nozzle"], cell["held"]
    tool = {"part": "base", "nozzle": "flange"}[held], nozzle_frame(nozzle)
    part = {"part": "flange", "nozzle": "base"}[held], frame(cell.get("part"))
    flat = nozzle["tip_flat_mm"] / 2
    wide = flat + nozzle["cone_height_mm"] * np.tan(np.radians(nozzle["cone_half_angle_deg"]))
    plate = cell["plate"].get("diameter_mm") or summary.get("platform_diameter_mm", 127.5)
    found = [
        ("nozzle", *tool, cylinder(flat, 0, nozzle["cone_height_mm"], wide)),
        ("hot end", *tool, cylinder(nozzle["block_diameter_mm"] / 2, nozzle["cone_height_mm"], nozzle["block_top_mm"])),
        ("plate", *part, cylinder(plate / 2, -cell["plate"]["thickness_mm"], 0)),
    ]
    stand = cell.get("stand") or {}
    if "beam" in stand:
        beam = stand["beam"]
        half, back, (along, across) = beam.get("half_width_mm", foot), -beam["length_mm"], beam["pillar_mm"]
        found.append(("beam", "base", pose(), block([back, -half, -beam["thickness_mm"]], [half, half, -1])))
        found.append(("pillar", "base", pose(), block([back - along, -across / 2, -beam["height_mm"]], [back, across / 2, 0])))
    if "pedestal" in stand:
        found.append(("pedestal", "base", pose(), cylinder(stand["pedestal"].get("radius_mm", foot), -stand["pedestal"]["height_mm"], -1)))
    for solid in cell.get("solids", []):
        mount, on = {"base": ("base", pose()), "flange": ("flange", pose()), "part": part, "nozzle": tool}[solid["mount"]]
        found.append((solid["name"], mount, on @ frame(solid.get("frame")), shape(solid["shape"])))
    if part_file:
        mesh = trimesh.load(part_file, force="mesh")
        low, high = mesh.bounds
        mesh.apply_translation([-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]])
        turn = about([0, 0, 1], np.radians(summary["part_turn_deg"]))
        found.append(("part", part[0], part[1] @ pose(turn), mesh))
    return found


def motions(file):
    """Spline and kind of each motion."""
    rows = {}
    for row in csv.DictReader(line for line in open(file) if not line.startswith("#")):
        rows.setdefault(int(row["motion"]), []).append(row)
    for number, knots in sorted(rows.items()):
        times = np.array([float(k["time_s"]) for k in knots])
        joints = np.array([[float(k[f"q{j}"]) for j in range(1, 7)] for k in knots])
        if len(times) > 1:
            yield number, times, joints, {k["kind"] for k in knots}


def samples(times, joints, step):
    """Postures along a motion with no joint more than a step from the sample before; no more of them than that needs."""
    spline, last = CubicSpline(times, joints, bc_type="clamped"), None
    for a, b in zip(times[:-1], times[1:]):
        turn = np.abs(spline(np.linspace(a, b, 5), 1)).max() * (b - a)
        for t in np.linspace(a, b, max(1, int(np.ceil(2 * turn / step))), endpoint=False):
            q = spline(t)
            if last is None or np.abs(q - last).max() >= step / 2:
                last = q
                yield t, q
    yield times[-1], joints[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("workcell", type=Path)
    parser.add_argument("--part", type=Path)
    parser.add_argument("--step", type=float, default=0.01, help="radians between samples")
    args = parser.parse_args()
    cell, summary = json.loads(args.workcell.read_text()), json.loads((args.folder / "summary.json").read_text())
    arm = Arm(cell["arm"]["geometry"]["named"])
    foot = min(np.abs(arm.meshes[0].vertices[:, :2]).max(axis=0))
    others = bodies(cell, summary, foot, args.part)
    links = [fcl.CollisionObject(model(mesh)) for mesh in arm.meshes]
    things = [(name, mount, on, fcl.CollisionObject(model(mesh))) for name, mount, on, mesh in others]
    pairs = [(a, b) for a in range(7) for b in range(a + 2, 7)]
    # The base and what carries it are one; the flange carries its tool.
    against = [(k, n) for n, (_, mount, *_) in enumerate(things) for k in range(7) if not (k == 0 and mount == "base" or k == 6 and mount == "flange")]
    flange_things = [n for n, (_, mount, *_) in enumerate(things) if mount == "flange"]
    base_things = [n for n, (_, mount, *_) in enumerate(things) if mount == "base"]
    printing_pair = {"nozzle", "hot end", "plate", "part"}
    request, least = fcl.CollisionRequest(), {}
    count = touching = looked = 0
    contacts = {}
    for number, times, joints, kinds in motions(args.folder / "trajectory.csv"):
        count, touches = count + 1, False
        for index, (t, q) in enumerate(samples(times, joints, args.step)):
            looked += 1
            frames, flange = arm.frames(q)
            for link, at in zip(links, frames):
                link.setTransform(fcl.Transform(at[:3, :3], at[:3, 3]))
            for _, mount, on, thing in things:
                at = flange @ on if mount == "flange" else on
                thing.setTransform(fcl.Transform(at[:3, :3], at[:3, 3]))
            asked = [((LINKS[a], LINKS[b]), links[a], links[b]) for a, b in pairs]
            asked += [((LINKS[k], things[n][0]), links[k], things[n][3]) for k, n in against]
            for a in flange_things:
                for b in base_things:
                    names = (things[a][0], things[b][0])
                    # What prints touches what is printed on; while it moves, sampled knots say nothing of which cells are there.
                    if not set(names) <= printing_pair:
                        asked.append((names, things[a][3], things[b][3]))
            for names, a, b in asked:
                if fcl.collide(a, b, request, fcl.CollisionResult()):
                    contacts.setdefault(names, set()).add(number)
                    touches = True
                elif index % 25 == 0 and names[1] not in ("floor",):
                    gap = fcl.distance(a, b, fcl.DistanceRequest(), fcl.DistanceResult())
                    least[names] = min(gap, least.get(names, np.inf))
        touching += touches
    print(f"{touching} of {count} motions touch; {looked} samples")
    for names, where in sorted(contacts.items()):
        print(f"  {names[0]} and {names[1]}: {len(where)} motions, first {min(where)}")
    for names, gap in sorted(least.items(), key=lambda item: item[1])[:6]:
        print(f"  least distance of {names[0]} and {names[1]}: {gap:.1f} mm")
    return 1 if touching else 0


if __name__ == "__main__":
    sys.exit(main())
