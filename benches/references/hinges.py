"""Reference digits of a chain of six hinges in space, for tests/frames.rs.

    pip install pin mpmath && python benches/references/hinges.py > tests/frames/hinges.json

Each link turns about y or x in the one before, at (0.3, 0.2, -1) of it. Its body has a mass, a mass centre off the axis and
three moments of inertia. Twice independent:

- by Pinocchio's articulated-body algorithm (pinocchio.aba), in double precision;
- by 50 digits: each body is six particles with the same mass, mass centre and inertia, so that there is nothing but
  positions p(q), and M = sum m J^T J, M q'' = sum m J^T (g - J' q'), with central differences of 90 digits for J and J'.

The digits are those of the second, and the script fails where the first differs from them by more than 1e-12.
"""
import json
import random
import sys

import mpmath as mp
import numpy as np
import pinocchio as pin

mp.mp.dps = 90
N, OFFSET, G = 6, (0.3, 0.2, -1.0), 9.81
BODIES = [  # mass, mass centre, moments of inertia about it, in the axes of the link
    (1.0 + 0.25 * i, (0.1 + 0.05 * i, -0.2 + 0.03 * i, -0.5 + 0.02 * i), (0.3 + 0.1 * i, 0.4, 0.35 + 0.04 * i))
    for i in range(N)
]


def particles(mass, centre, moments):
    """Six particles at +-a, +-b, +-c of the axes: Ixx = m/3 (b^2 + c^2), and so on."""
    total = sum(map(mp.mpf, moments)) / 2
    reach = [mp.sqrt(3 * (total - mp.mpf(moment)) / mp.mpf(mass)) for moment in moments]
    for axis in range(3):
        for sign in (1, -1):
            yield mp.mpf(mass) / 6, [mp.mpf(c) + (sign * reach[axis] if k == axis else 0) for k, c in enumerate(centre)]


def positions(q):
    rotation, origin, out = mp.eye(3), mp.matrix([0, 0, 0]), []
    for i in range(N):
        c, s = mp.cos(q[i]), mp.sin(q[i])
        turn = [[c, 0, s], [0, 1, 0], [-s, 0, c]] if i % 2 == 0 else [[1, 0, 0], [0, c, -s], [0, s, c]]
        rotation = rotation * mp.matrix(turn)
        out += [origin + rotation * mp.matrix(at) for _, at in particles(*BODIES[i])]
        origin = origin + rotation * mp.matrix(list(map(mp.mpf, OFFSET)))
    return out


def dense(q, qd):
    q, qd = [mp.mpf(x) for x in q], [mp.mpf(x) for x in qd]
    h = mp.mpf(10) ** -20
    masses = [m for body in BODIES for m, _ in particles(*body)]
    columns = []
    for j in range(N):
        def moved(k):
            return positions([x + (k * h if i == j else 0) for i, x in enumerate(q)])
        # Richardson: the error is of order h^6.
        a, b, c, d = moved(2), moved(1), moved(-1), moved(-2)
        columns.append([(8 * (b[k] - c[k]) - (a[k] - d[k])) / (12 * h) for k in range(len(masses))])
    along = [positions([x + k * h * v for x, v in zip(q, qd)]) for k in (-2, -1, 0, 1, 2)]
    drift = [(-along[0][k] + 16 * along[1][k] - 30 * along[2][k] + 16 * along[3][k] - along[4][k]) / (12 * h * h)
             for k in range(len(masses))]
    inertia, right = mp.zeros(N, N), mp.zeros(N, 1)
    weight = mp.matrix([0, 0, -mp.mpf(G)])
    for k, m in enumerate(masses):
        for i in range(N):
            right[i] += m * (columns[i][k].T * (weight - drift[k]))[0]
            for j in range(N):
                inertia[i, j] += m * (columns[i][k].T * columns[j][k])[0]
    return list(mp.lu_solve(inertia, right))


def model():
    chain = pin.Model()
    chain.gravity.linear = np.array([0, 0, -G])
    parent = 0
    for i, (mass, centre, moments) in enumerate(BODIES):
        joint = pin.JointModelRY() if i % 2 == 0 else pin.JointModelRX()
        at = pin.SE3(np.eye(3), np.array(OFFSET if i else (0.0, 0.0, 0.0)))
        parent = chain.addJoint(parent, joint, at, f"hinge{i}")
        chain.appendBodyToJoint(parent, pin.Inertia(mass, np.array(centre), np.diag(moments)), pin.SE3.Identity())
    return chain


def main():
    chain = model()
    data, rng, states = chain.createData(), random.Random(6), []
    for _ in range(5):
        q = [round(rng.uniform(-3, 3), 6) for _ in range(N)]
        qd = [round(rng.uniform(-2, 2), 6) for _ in range(N)]
        exact = dense(q, qd)
        peer = pin.aba(chain, data, np.array(q), np.array(qd), np.zeros(N))
        largest = max(abs(x) for x in exact)
        difference = max(abs(mp.mpf(float(p)) - x) for p, x in zip(peer, exact)) / largest
        print(f"Pinocchio differs by {mp.nstr(difference, 2)}", file=sys.stderr)
        assert difference < 1e-12
        states.append({"q": q, "qd": qd, "qdd": [float(mp.nstr(x, 20)) for x in exact],
                       "pinocchio": [float(x) for x in peer]})
    json.dump({"pinocchio": pin.__version__, "states": states}, sys.stdout, indent=1)
    print()


main()
