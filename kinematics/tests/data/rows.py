"""Makes rows.csv: joints and flange poses of the published arms, computed with 50 digits (mpmath).

Nothing here is shared with the crate: the lengths are those of the makers' documents, UR arms are multiplied out as
Denavit-Hartenberg tables, ABB arms as turns about their axes where these are in the zero posture.
Run from this folder: python3 rows.py > rows.csv
"""

import random
from mpmath import mp, mpf, matrix, cos, sin, pi, eye, findroot, asin, atan2, radians

mp.dps = 50
# Metres: d1..d6, upper arm, forearm.
UR = {
    "UR3": (["0.1519", 0, 0, "0.11235", "0.08535", "0.0819"], "-0.24365", "-0.21325"),
    "UR3e": (["0.15185", 0, 0, "0.13105", "0.08535", "0.0921"], "-0.24355", "-0.2132"),
    "UR5": (["0.089159", 0, 0, "0.10915", "0.09465", "0.0823"], "-0.425", "-0.39225"),
    "UR5e": (["0.1625", 0, 0, "0.1333", "0.0997", "0.0996"], "-0.425", "-0.3922"),
}
# Metres: height of axis 2, upper arm, forearm, how far axis 4 is above axis 3, flange; stops in degrees.
ABB = {
    "IRB120-3_0.6": (["0.290", "0.270", "0.302", "0.070", "0.072"],
                     [(-165, 165), (-110, 110), (-110, 70), (-160, 160), (-120, 120), (-400, 400)]),
    "IRB1200-7_0.7": (["0.3991", "0.350", "0.351", "0.042", "0.082"],
                      [(-170, 170), (-100, 135), (-200, 70), (-270, 270), (-130, 130), (-360, 360)]),
}


def pose(rotation, shift):
    m = eye(4)
    for i in range(3):
        for k in range(3):
            m[i, k] = rotation[i][k]
        m[i, 3] = shift[i]
    return m


def turn(axis, q):
    c, s = cos(q), sin(q)
    return {"x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]


ONE = turn("z", mpf(0))


def ur(name, q):
    d, a2, a3 = UR[name]
    m = eye(4)
    for qk, dk, ak, alpha in zip(q, d, [0, a2, a3, 0, 0, 0], [pi / 2, 0, 0, pi / 2, -pi / 2, 0]):
        m = m * pose(turn("z", qk), [0, 0, mpf(dk)]) * pose(turn("x", mpf(alpha)), [mpf(ak), 0, 0])
    return m


def about(axis, point, q):
    return pose(ONE, point) * pose(turn(axis, q), [0, 0, 0]) * pose(ONE, [-x for x in point])


def abb_points(name):
    low, upper, fore, above, flange = map(mpf, ABB[name][0])
    shoulder, elbow = [0, 0, low], [0, 0, low + upper]
    wrist = [fore, 0, low + upper + above]
    return shoulder, elbow, wrist, [fore + flange, 0, low + upper + above]


def abb(name, q):
    shoulder, elbow, wrist, flange = abb_points(name)
    m = about("z", [0, 0, 0], q[0]) * about("y", shoulder, q[1]) * about("y", elbow, q[2])
    m = m * about("x", wrist, q[3]) * about("y", wrist, q[4]) * about("x", wrist, q[5])
    return m * pose(turn("y", pi / 2), flange)


def abb_plane(name, q2, q3):
    """Elbow and wrist centre in the plane of the arm: forward of axis 1, above axis 2."""
    low, upper, fore, above, _ = map(mpf, ABB[name][0])
    elbow = (upper * sin(q2), upper * cos(q2))
    s, c = sin(q2 + q3), cos(q2 + q3)
    return elbow, (elbow[0] + fore * c + above * s, elbow[1] - fore * s + above * c)


def cfx(name, q):
    elbow, wrist = abb_plane(name, q[1], q[2])
    behind = wrist[0] < 0
    below = elbow[1] * wrist[0] - elbow[0] * wrist[1] < 0
    return 4 * behind + 2 * below + (sin(q[4]) < 0)


def singular(name, eps):
    """One posture for each singularity, `eps` off it."""
    q = [mpf(x) for x in ["0.4", "-0.9", "1.1", "0.5", "0.8", "-0.6"]]
    wrist, elbow, shoulder = q[:], q[:], q[:]
    wrist[4] = eps
    if name in UR:
        d, a2, a3 = UR[name]
        elbow[2] = eps
        shoulder[1], shoulder[2] = mpf("-1.5"), mpf("0.05")
        along = mpf(a2) * cos(shoulder[1]) + mpf(a3) * cos(shoulder[1] + shoulder[2])
        shoulder[3] = asin(-along / mpf(d[4])) - shoulder[1] - shoulder[2] + eps
    else:
        _, _, fore, above, _ = map(mpf, ABB[name][0])
        elbow[2] = -atan2(fore, above) + eps
        over = findroot(lambda q2: abb_plane(name, q2, shoulder[2])[1][0], mpf("-0.6"))
        shoulder[1] = over + eps
    return [("wrist", wrist), ("elbow", elbow), ("shoulder", shoulder)]


def postures(name, rng):
    stops = ABB[name][1] if name in ABB else [(-180, 180)] * 6
    drawn = lambda: [mpf(rng.uniform(float(radians(a)), float(radians(b)))) for a, b in stops]
    for _ in range(6):
        yield "random", "", drawn()
    if name in UR:
        yield "wrap", "", [mpf(rng.uniform(-6.28, 6.28)) for _ in range(6)]
    else:
        edge = drawn()
        edge[3] = mpf(float(radians(stops[3][1])))
        yield "edge", "", edge
    for eps in ["0", "1e-9", "1e-4"]:
        for kind, q in singular(name, mpf(eps)):
            yield kind, eps, q


def main():
    rng = random.Random(32)
    names = ["robot", "id", "class", "eps"] + [f"q{k}" for k in range(1, 7)]
    names += [f"r{i}{k}" for i in "123" for k in "123"] + ["px", "py", "pz", "cfx"]
    print(",".join(names))
    for name in list(UR) + list(ABB):
        for number, (kind, eps, q) in enumerate(postures(name, rng)):
            # The pose is that of the joints as they are written.
            q = [mpf(float(x)) for x in q]
            m = ur(name, q) if name in UR else abb(name, q)
            numbers = q + [m[i, k] for i in range(3) for k in range(3)] + [m[i, 3] for i in range(3)]
            last = str(cfx(name, q)) if name in ABB else ""
            print(",".join([name, str(number), kind, eps] + [repr(float(x)) for x in numbers] + [last]))


main()
