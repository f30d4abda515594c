"""Reference digits of the work-precision atlas for motions without a closed form.

    python benches/references/atlas.py examples/work_precision/reference        (needs mpmath; some minutes)

Every motion is computed twice, by methods that have nothing in common:

1. its Taylor series, by recurrences written here by hand, order 44, in 60 digits, steps by the last two coefficients
   (Jorba and Zou, Experimental Mathematics 14, 2005, 99);
2. extrapolation of the modified midpoint rule (Gragg 1965; Bulirsch and Stoer 1966; Hairer, Norsett, Wanner, Solving
   Ordinary Differential Equations I, 1993, II.9), 14 columns, in 50 digits, straight from the equations of motion.

Parameters and initial values are the doubles that they are. What is written has 30 digits; `agreement` is the largest
difference between the two ways, relative to the largest coordinate or velocity at the end.
"""

import json
import sys
from pathlib import Path

from mpmath import cos, mp, mpf, nstr, sin, sqrt

ORDER = 44


def product(a, b, n):
    """Coefficient n of the product of two series."""
    return sum((a[j] * b[n - j] for j in range(n + 1)), mpf(0))


class HenonHeiles:
    """V = (x^2 + y^2)/2 + x^2 y - y^3/3, unit mass. Chaotic and regular motion side by side; energy 0.111."""

    stem = "henon-heiles"
    parameters = {"lambda": 1.0}
    q, qd, end, steps = [0.0, 0.1], [0.45, 0.1], 60.0, 300

    def acceleration(self, p, q, qd, t):
        x, y = q
        return [-x - 2 * p["lambda"] * x * y, -y - p["lambda"] * (x * x - y * y)]

    def recurrence(self, p, t):
        squares = {"xx": [], "yy": [], "xy": []}

        def coefficient(n, q, qd):
            x, y = q
            squares["xx"].append(product(x, x, n))
            squares["yy"].append(product(y, y, n))
            squares["xy"].append(product(x, y, n))
            xx, yy, xy = (squares[name][n] for name in ("xx", "yy", "xy"))
            return [-x[n] - 2 * p["lambda"] * xy, -y[n] - p["lambda"] * (xx - yy)]

        return coefficient


class SpringPendulum:
    """A bob on a stiff spring: k l/(m g) = 10^6, from 1 rad at rest.

    The spring is stretched as far as it takes for it not to vibrate, up to the third power of m g/(k l), so that the fast
    motion is there (period 2 ms) but its amplitude is not.
    """

    stem = "spring-pendulum"
    parameters = {"m": 1.0, "k": 9.81e6, "l": 1.0, "g": 9.81}
    qd, end, steps = [0.0, 0.0], 4.0, 16_000

    def __init__(self):
        # s = r - l on the slow motion, at rest: m/k (g cos - s''), s'' = 3 m/k g^2 sin^2/l.
        c, s, g, inverse = cos(mpf(1)), sin(mpf(1)), mpf(9.81), 1 / mpf(9.81e6)
        r = 1 + inverse * (g * c - 3 * inverse * (g * s) ** 2)
        self.q = [float(r * s), float(-r * c)]

    def acceleration(self, p, q, qd, t):
        x, y = q
        pull = p["k"] / p["m"] * (p["l"] / sqrt(x * x + y * y) - 1)
        return [pull * x, pull * y - p["g"]]

    def recurrence(self, p, t):
        square, inverse = [], []  # r^2 and 1/r = (r^2)^(-1/2)

        def coefficient(n, q, qd):
            x, y = q
            square.append(product(x, x, n) + product(y, y, n))
            if n == 0:
                inverse.append(1 / sqrt(square[0]))
            else:
                # w = u^a: n u0 w_n = sum_j (a j - (n - j)) u_j w_(n-j), j = 1..n
                terms = (mpf(-j - 2 * (n - j)) / 2 * square[j] * inverse[n - j] for j in range(1, n + 1))
                inverse.append(sum(terms, mpf(0)) / (n * square[0]))
            rate = p["k"] / p["m"]
            ax = rate * (p["l"] * product(inverse, x, n) - x[n])
            ay = rate * (p["l"] * product(inverse, y, n) - y[n])
            return [ax, ay - p["g"] if n == 0 else ay]

        return coefficient


class DrivenPendulum:
    """theta'' = -g/l sin theta - c/(m l^2) theta' + a/(m l^2) cos(omega t): the standard driven damped pendulum."""

    stem = "driven-pendulum"
    parameters = {"m": 1.0, "l": 1.0, "g": 1.0, "c": 0.5, "a": 1.07, "omega": 2.0 / 3.0}
    q, qd, end, steps = [0.2], [0.0], 60.0, 300

    def acceleration(self, p, q, qd, t):
        inertia = p["m"] * p["l"] ** 2
        torque = p["a"] * cos(p["omega"] * t) - p["c"] * qd[0]
        return [torque / inertia - p["g"] / p["l"] * sin(q[0])]

    def recurrence(self, p, t):
        sines, cosines = [], []
        drive = [cos(p["omega"] * t), -sin(p["omega"] * t)]

        def coefficient(n, q, qd):
            theta = q[0]
            if n == 0:
                sines.append(sin(theta[0]))
                cosines.append(cos(theta[0]))
            else:
                # (sin u)' = cos u u', (cos u)' = -sin u u'
                sines.append(sum((j * theta[j] * cosines[n - j] for j in range(1, n + 1)), mpf(0)) / n)
                cosines.append(-sum((j * theta[j] * sines[n - j] for j in range(1, n + 1)), mpf(0)) / n)
            # d^n/dt^n cos(omega t) / n! = (omega^n/n!) (cos, -sin, -cos, sin)(omega t)
            sign = 1 if n % 4 < 2 else -1
            driven = sign * drive[n % 2] * p["omega"] ** n / mp.factorial(n)
            inertia = p["m"] * p["l"] ** 2
            return [(p["a"] * driven - p["c"] * qd[0][n]) / inertia - p["g"] / p["l"] * sines[n]]

        return coefficient


def taylor(system, digits):
    """The state at the end, by Taylor series."""
    mp.dps = digits
    p = {name: mpf(value) for name, value in system.parameters.items()}
    q, qd = [mpf(x) for x in system.q], [mpf(x) for x in system.qd]
    t, end, tolerance = mpf(0), mpf(system.end), mpf(10) ** -40
    while t < end:
        series_q, series_qd = [[x] for x in q], [[x] for x in qd]
        coefficient = system.recurrence(p, t)
        for n in range(ORDER):
            acceleration = coefficient(n, series_q, series_qd)
            for a, x, v in zip(acceleration, series_q, series_qd):
                x.append(v[n] / (n + 1))
                v.append(a / (n + 1))
        h = end - t
        for n in (ORDER - 1, ORDER):
            size = max(max(abs(x[n]) for x in series_q), max(abs(v[n]) for v in series_qd))
            h = min(h, (tolerance / size) ** (mpf(1) / n))
        horner = lambda c: mp.polyval(c[::-1], h)
        q, qd, t = [horner(x) for x in series_q], [horner(v) for v in series_qd], t + h
    return q, qd


def extrapolation(system, digits, columns=14):
    """The state at the end, by extrapolation of the modified midpoint rule in equal large steps."""
    mp.dps = digits
    p = {name: mpf(value) for name, value in system.parameters.items()}
    size = len(system.q)
    numbers = [2 * (j + 1) for j in range(columns)]

    def rate(y, t):
        return y[size:] + system.acceleration(p, y[:size], y[size:], t)

    def midpoint(y, t, large, n):
        h = large / n
        before, now = y, [a + h * b for a, b in zip(y, rate(y, t))]
        for i in range(1, n):
            before, now = now, [a + 2 * h * b for a, b in zip(before, rate(now, t + i * h))]
        # Without Gragg's smoothing: with n even the error has an expansion in even powers of h anyway.
        return now

    large = mpf(system.end) / system.steps
    y = [mpf(x) for x in system.q] + [mpf(x) for x in system.qd]
    for step in range(system.steps):
        table = []
        for j, n in enumerate(numbers):
            row = [midpoint(y, step * large, large, n)]
            for k in range(1, j + 1):
                weight = 1 / (mpf(n) ** 2 / numbers[j - k] ** 2 - 1)
                row.append([a + (a - b) * weight for a, b in zip(row[k - 1], table[k - 1])])
            table = row
        y = table[-1]
    return y[:size], y[size:]


def main():
    folder = Path(sys.argv[1])
    names = sys.argv[2:]
    for system in (HenonHeiles(), DrivenPendulum(), SpringPendulum()):
        if names and system.stem not in names:
            continue
        q, qd = taylor(system, 60)
        other_q, other_qd = extrapolation(system, 50)
        mp.dps = 60
        scale = [max(map(abs, end)) for end in (q, qd)]
        agreement = max(
            max(abs(a - b) for a, b in zip(one, other)) / size
            for one, other, size in ((q, other_q, scale[0]), (qd, other_qd, scale[1]))
        )
        digits = lambda end: [nstr(x, 30, strip_zeros=False) for x in end]
        content = {
            "id": system.stem,
            "made_by": "benches/references/atlas.py",
            "params": system.parameters,
            "agreement": nstr(agreement, 3),
            "trajectory": {
                "t0": 0.0,
                "q0": system.q,
                "qd0": system.qd,
                "t_end": system.end,
                "q_end_str": digits(q),
                "qd_end_str": digits(qd),
            },
        }
        (folder / f"{system.stem}.json").write_text(json.dumps(content, indent=1) + "\n")
        print(system.stem, "agreement", nstr(agreement, 3), flush=True)


main()
