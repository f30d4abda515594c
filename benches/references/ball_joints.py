"""Reference numbers of a chain of bodies on ball joints, for tests/bodies.rs.

    python benches/references/ball_joints.py 8                           (needs numpy; some seconds)

Newton's and Euler's laws of each body apart, with the forces in the joints as unknowns: absolute quaternions and angular velocities, 6 n linear equations for the
angular accelerations and the forces, Gragg's midpoint rule extrapolated to the order 16 in double precision, with two step sizes; `agreement` is the difference.
"""

import sys

import numpy as np

MASS, MOMENTS, CENTRE, END, GRAVITY = 1.0, np.diag([0.1, 0.11, 0.01]), np.array([0.01, 0.02, -0.5]), np.array([0, 0, -1.0]), 9.81


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def matrix(q):
    w, v = q[0], q[1:]
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * skew(v)


def rate(y, n):
    q, omega = y[: 4 * n].reshape(n, 4), y[4 * n :].reshape(n, 3)
    a, right = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
    # The acceleration of the joint: linear in the angular accelerations, and a rest.
    joint, rest = np.zeros((3, 6 * n)), np.zeros(3)
    for i in range(n):
        turned, w, own = matrix(q[i]), omega[i], slice(3 * i, 3 * i + 3)
        at = lambda place: (-turned @ skew(place), turned @ np.cross(w, np.cross(w, place)))
        force, following = slice(3 * (n + i), 3 * (n + i) + 3), slice(3 * (n + i) + 3, 3 * (n + i) + 6)
        centre, drift = at(CENTRE)
        rows = slice(3 * (n + i), 3 * (n + i) + 3)
        a[rows] = MASS * joint
        a[rows, own] += MASS * centre
        a[rows, force] -= np.eye(3)
        right[rows] = -MASS * (rest + drift) - np.array([0, 0, MASS * GRAVITY])
        a[own, own] = MOMENTS
        a[own, force] = skew(CENTRE) @ turned.T
        right[own] = -np.cross(w, MOMENTS @ w)
        if i + 1 < n:
            a[rows, following] += np.eye(3)
            a[own, following] = skew(END - CENTRE) @ turned.T
        end, drift = at(END)
        joint[:, own] += end
        rest = rest + drift
    turning = np.linalg.solve(a, right)[: 3 * n]
    spin = [np.concatenate([[-q[i, 1:] @ omega[i]], q[i, 0] * omega[i] + np.cross(q[i, 1:], omega[i])]) / 2 for i in range(n)]
    return np.concatenate([*spin, turning])


def extrapolated(y, n, end, count):
    whole = end / count
    for _ in range(count):
        row = []
        for i in range(1, 9):
            h = whole / (2 * i)
            before, now = y, y + h * rate(y, n)
            for _ in range(2 * i - 1):
                before, now = now, before + 2 * h * rate(now, n)
            following = [(before + now + h * rate(now, n)) / 2]
            for k, above in enumerate(row, start=1):
                ratio = (i / (i - k)) ** 2
                following.append(following[-1] + (following[-1] - above) / (ratio - 1))
            row = following
        y = row[-1]
    return y


if __name__ == "__main__":
    n = int(sys.argv[1])
    # Body i is turned by 0.3 + 0.2 i about x, and turns at (0.5, -0.25 i, 1).
    q = [[np.cos(0.15 + 0.1 * i), np.sin(0.15 + 0.1 * i), 0, 0] for i in range(n)]
    start = np.concatenate([np.array(q).ravel(), np.array([[0.5, -0.25 * i, 1.0] for i in range(n)]).ravel()])
    a, b = extrapolated(start, n, 0.5, 20), extrapolated(start, n, 0.5, 30)
    print("agreement", abs(a - b).max())
    for i in (0, n - 1):
        print("body", i, "q", b[4 * i : 4 * i + 4].tolist(), "omega", b[4 * n + 3 * i : 4 * n + 3 * i + 3].tolist())
