"""Reference accelerations of chains and trees of 32 links.

    python benches/references/chains.py tests/chains        (needs mpmath; a minute)

Random states within ±π and ±2, random masses and lengths within 0.5 … 1.5 (all of them the doubles that are written beside),
g = 9.81 as a double; the dense equations in the angles with the vertical, written here by hand, solved by LU with 50 digits.
"""

import json
import math
import random
import sys
from pathlib import Path

from mpmath import cos, lu_solve, matrix, mp, mpf, nstr, sin

mp.dps = 50
N = 32
STATES = 3
G = mpf(9.81)


def accelerations(kind, m, l, q, qd):
    """Of link i hanging on link i − 1, or (i − 1)/2 of a tree; on a cart of mass 1 its position comes first."""
    cart = 1 if kind == "cart" else 0
    angles, rates = [mpf(x) for x in q[cart:]], [mpf(x) for x in qd[cart:]]
    if kind == "relative":
        angles = [sum(angles[: i + 1]) for i in range(N)]
        rates = [sum(rates[: i + 1]) for i in range(N)]
    parent = (lambda i: (i - 1) // 2) if kind == "tree" else (lambda i: i - 1)
    above = []
    for i in range(N):
        above.append({i} | (above[parent(i)] if i > 0 else set()))
    m, l = [mpf(x) for x in m], [mpf(x) for x in l]
    # Mass of the bobs that hang below both links.
    mu = lambda j, k: sum((m[i] for i in range(N) if j in above[i] and k in above[i]), mpf(0))
    size = N + cart
    inertia, force = matrix(size, size), matrix(size, 1)
    for j in range(N):
        force[cart + j] -= G * mu(j, j) * l[j] * sin(angles[j])
        for k in range(N):
            shared = mu(j, k) * l[j] * l[k]
            inertia[cart + j, cart + k] = shared * cos(angles[j] - angles[k])
            force[cart + j] -= shared * sin(angles[j] - angles[k]) * rates[k] ** 2
        if cart:
            inertia[0, 1 + j] = inertia[1 + j, 0] = mu(j, j) * l[j] * cos(angles[j])
            force[0] += mu(j, j) * l[j] * sin(angles[j]) * rates[j] ** 2
    if cart:
        inertia[0, 0] = 1 + sum(m)
    solution = list(lu_solve(inertia, force))
    if kind == "relative":
        solution = [a - b for a, b in zip(solution, [mpf(0), *solution])]
    return [nstr(a, 25) for a in solution]


def main():
    draw = random.Random(6)
    cases = []
    for kind in ["absolute", "relative", "cart", "tree"]:
        for unit in [True, False]:
            m = [1.0 if unit else draw.uniform(0.5, 1.5) for _ in range(N)]
            l = [1.0 if unit else draw.uniform(0.5, 1.5) for _ in range(N)]
            for _ in range(STATES):
                size = N + (kind == "cart")
                q = [draw.uniform(-math.pi, math.pi) for _ in range(size)]
                qd = [draw.uniform(-2, 2) for _ in range(size)]
                accel = accelerations(kind, m, l, q, qd)
                cases.append({"kind": kind, "unit": unit, "m": m, "l": l, "q": q, "qd": qd, "accel": accel})
    lines = ",\n".join(json.dumps(case) for case in cases)
    Path(sys.argv[1], "accelerations.json").write_text(f"[\n{lines}\n]\n")


main()
