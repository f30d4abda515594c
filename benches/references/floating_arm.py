"""Reference digits of an arm of seven axes on a body that floats, for tests/bodies/floating_arm.rs.

    pip install pin mujoco mpmath && python benches/references/floating_arm.py > tests/bodies/floating_arm.json

Three ways, of which nothing is shared but the table of the bodies:

- 40 digits: M = sum m Jv^T Jv + Jw^T I Jw and its right-hand side by the Jacobians and the accelerations at rest of all that is unknown, in the axes of the world;
- Pinocchio's articulated-body algorithm with a free flyer (pinocchio.aba);
- MuJoCo's forward dynamics with a free joint (mj_forward), contacts and constraints off.

The digits are those of the first, and the script fails where one of the others differs from them by more than 1e-12. Quaternions are w, x, y, z; the velocity and the
acceleration of the place are in the axes of the world, those of the attitude in the axes of the body.
"""

import json
import random
import sys

import mpmath as mp
import mujoco
import numpy as np
import pinocchio as pin

mp.mp.dps = 40
N, G = 7, 9.81
UP = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12]
MASS = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3]
BASE, BASE_MOMENTS, MOUNT = 30.0, (1.2, 1.5, 1.8), (0.1, 0.05, 0.3)


def links(number):
    """Place in the parent, axis, mass, mass centre and moments of each link, in numbers of a kind."""
    for i in range(N):
        mass, up = number(str(MASS[i])), number(str(UP[i + 1]))
        across = mass * (up * up + 3 * number("0.06") ** 2) / 12
        place = MOUNT if i == 0 else (0, 0, UP[i])
        centre = (number("0"), number("-0.03" if i % 2 == 0 else "0.03"), up / 2)
        yield [number(str(x)) for x in place], 2 if i % 2 == 0 else 1, mass, centre, (across, across, mass * number("0.06") ** 2 / 2)


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def matrix(q):
    w, x, y, z = q
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return mp.matrix(rows)


def dense(state):
    """Accelerations of the place, of the attitude in the axes of the body, of the joints."""
    number = lambda values: [mp.mpf(x) for x in values]
    q, v, omega, qd, tau = (number(state[name]) for name in ("q", "v", "omega", "qd", "tau"))
    attitude = number(state["attitude"])
    length = mp.sqrt(sum(x * x for x in attitude))
    turned = matrix([x / length for x in attitude])
    zero = lambda: mp.matrix([0, 0, 0])
    size = 6 + N
    # Columns of the velocity of the origin and of the angular velocity; accelerations while those of the unknowns are 0.
    linear = [mp.matrix([k == i for k in range(3)]) if i < 3 else zero() for i in range(size)]
    angular = [turned[:, i - 3] if 3 <= i < 6 else zero() for i in range(size)]
    drift, turning, spin = zero(), zero(), turned * mp.matrix(omega)
    inertia, right = mp.zeros(size, size), mp.zeros(size, 1)
    for i in range(N):
        right[6 + i] = tau[i]

    def add(mass, centre, moments):
        arm = turned * mp.matrix(centre)
        columns = [a + cross(w, arm) for a, w in zip(linear, angular)]
        own = turned * mp.diag(moments) * turned.T
        force = -mass * (drift + cross(turning, arm) + cross(spin, cross(spin, arm)) + mp.matrix([0, 0, mp.mpf(str(G))]))
        moment = -(own * turning + cross(spin, own * spin))
        for a in range(size):
            right[a] += (columns[a].T * force)[0] + (angular[a].T * moment)[0]
            for b in range(size):
                inertia[a, b] += mass * (columns[a].T * columns[b])[0] + (angular[a].T * own * angular[b])[0]

    add(mp.mpf(str(BASE)), [0, 0, 0], number(map(str, BASE_MOMENTS)))
    for i, (place, axis, mass, centre, moments) in enumerate(links(mp.mpf)):
        arm = turned * mp.matrix(place)
        linear = [a + cross(w, arm) for a, w in zip(linear, angular)]
        drift = drift + cross(turning, arm) + cross(spin, cross(spin, arm))
        along = turned[:, axis]
        c, s = mp.cos(q[i]), mp.sin(q[i])
        turned = turned * mp.matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]] if axis == 2 else [[c, 0, s], [0, 1, 0], [-s, 0, c]])
        angular[6 + i] = along
        turning = turning + cross(spin, along * qd[i])
        spin = spin + along * qd[i]
        add(mass, centre, moments)
    return list(mp.lu_solve(inertia, right))


def pinocchio():
    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -G])
    parent = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    model.appendBodyToJoint(parent, pin.Inertia(BASE, np.zeros(3), np.diag(BASE_MOMENTS)), pin.SE3.Identity())
    for i, (place, axis, mass, centre, moments) in enumerate(links(float)):
        joint = pin.JointModelRZ() if axis == 2 else pin.JointModelRY()
        parent = model.addJoint(parent, joint, pin.SE3(np.eye(3), np.array(place)), f"joint{i}")
        model.appendBodyToJoint(parent, pin.Inertia(mass, np.array(centre), np.diag(moments)), pin.SE3.Identity())
    data = model.createData()

    def accelerations(state):
        w, x, y, z = np.array(state["attitude"]) / np.linalg.norm(state["attitude"])
        turned = pin.Quaternion(w, x, y, z).toRotationMatrix()
        omega = np.array(state["omega"])
        own = turned.T @ np.array(state["v"])
        place = np.concatenate([state["x"], [x, y, z, w], state["q"]])
        rates = np.concatenate([own, omega, state["qd"]])
        found = pin.aba(model, data, place, rates, np.concatenate([np.zeros(6), state["tau"]])).copy()
        # The velocity is in the axes of the body: a = R (v' + omega x v).
        found[:3] = turned @ (found[:3] + np.cross(omega, own))
        return found

    return accelerations


def mjcf():
    """The arm in MuJoCo's language; benches/peers/bodies.py times it."""
    row = lambda values: " ".join(repr(float(x)) for x in values)
    text, close = "", ""
    for place, axis, mass, centre, moments in links(float):
        text += f'<body pos="{row(place)}"><joint type="hinge" axis="{"0 0 1" if axis == 2 else "0 1 0"}"/>'
        text += f'<inertial pos="{row(centre)}" mass="{mass}" diaginertia="{row(moments)}"/>'
        close += "</body>"
    base = f'<freejoint/><inertial pos="0 0 0" mass="{BASE}" diaginertia="{row(BASE_MOMENTS)}"/>'
    option = f'<option gravity="0 0 {-G}"><flag contact="disable" constraint="disable"/></option>'
    return f"<mujoco>{option}<worldbody><body>{base}{text}{close}</body></worldbody></mujoco>"


def in_mujoco():
    model = mujoco.MjModel.from_xml_string(mjcf())
    data = mujoco.MjData(model)

    def accelerations(state):
        data.qpos[:] = np.concatenate([state["x"], np.array(state["attitude"]) / np.linalg.norm(state["attitude"]), state["q"]])
        data.qvel[:] = np.concatenate([state["v"], state["omega"], state["qd"]])
        data.qfrc_applied[6:] = state["tau"]
        mujoco.mj_forward(model, data)
        return data.qacc.copy()

    return accelerations


def main():
    rng, states, peers = random.Random(30), [], {"Pinocchio": pinocchio(), "MuJoCo": in_mujoco()}
    for _ in range(4):
        draw = lambda count, size: [round(rng.uniform(-size, size), 6) for _ in range(count)]
        state = {"x": draw(3, 2), "attitude": draw(4, 1), "q": draw(N, 3), "v": draw(3, 2), "omega": draw(3, 2), "qd": draw(N, 2), "tau": draw(N, 20)}
        exact = dense(state)
        for name, accelerations in peers.items():
            difference = max(abs(mp.mpf(float(p)) - x) for p, x in zip(accelerations(state), exact)) / max(map(abs, exact))
            print(f"{name} differs by {mp.nstr(difference, 2)}", file=sys.stderr)
            assert difference < 1e-12
        states.append(state | {"accelerations": [float(mp.nstr(x, 20)) for x in exact]})
    json.dump({"pinocchio": pin.__version__, "mujoco": mujoco.__version__, "states": states}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
