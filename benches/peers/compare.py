"""Our integrators against Python's, at equal achieved error: `python3 benches/peers/compare.py [rounds]`.

Makes a virtual environment in benches/peers/target, with heyoka, scipy and sympy, and builds the benchmark beside this
file. Contestants: heyoka's Taylor integrator, compiled from the equations that its own `lagrangian` derives; scipy's
DOP853 with the function that sympy derives by Lagrange's method and lambdifies. Ours are the points of the benchmark,
measured anew in every round. Printed are the medians over the rounds of (its time / the time of DOP853)
and the same for Verner9.

With `--series` instead: our Taylor method against heyoka's, the ratio of times to the error that heyoka reaches at a
tolerance; with and without its `fast_math`. The free body is Euler's equations with a quaternion for heyoka.
`--only SYSTEM` measures one. heyoka compiles for the processor it runs on; to let rustc do so too, set
RUSTFLAGS="-C target-cpu=native".

With `--chain`: a step of n unit links at 1e-15, the ratio of times to heyoka's, by its two ways to compile; ours are longer
(the numbers of both are printed by `series -- chain` and here). Of four links and more its way with all orders written out takes from seconds to hours to compile: the lengths to be tried so are
named after `--chain`, as in `compare.py --chain 2 4`, and all others are compiled its compact way alone.

With `--lanes`: 10,000 double pendulums on one thread, ours in lanes against heyoka's batches of 8 by the same tolerance.
"""

import argparse
import math
import statistics
import subprocess
import time
from pathlib import Path

from environment import enter

HERE = Path(__file__).resolve().parent
ERRORS = [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
OURS = ["DOP853", "Verner9"]
CHAIN_END = 10.0

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("rounds", nargs="?", type=int, default=5, help="of which medians are taken (5)")
what = parser.add_mutually_exclusive_group()
what.add_argument("--series", action="store_true", help="our Taylor method against heyoka's")
parser.add_argument("--only", help="of --series one system, such as 'Free body'")
what.add_argument("--chain", nargs="*", type=int, metavar="LINKS", help="steps of chains")
what.add_argument("--lanes", action="store_true", help="lanes against batches")
ASKED = parser.parse_args()
ROUNDS = ASKED.rounds

enter("venv", ["heyoka", "numpy", "scipy", "sympy"])

import heyoka
import numpy
import scipy
import sympy
import sympy.physics.mechanics
from scipy.integrate import solve_ivp


def energies(name, q, qd, sin, cos):
    """T and V, in the symbols of either library."""
    if name == "Pendulum":
        m, l, g = 1.3, 0.85, 9.81
        return 0.5 * m * (l * qd[0]) ** 2, -m * g * l * cos(q[0])
    if name == "Kepler":
        return 0.5 * (qd[0] ** 2 + (q[0] * qd[1]) ** 2), -1.0 / q[0]
    if name == "Top":
        a, c, mgl = 1.0, 0.7, 1.3
        spin = qd[2] + qd[1] * cos(q[0])
        return 0.5 * a * (qd[0] ** 2 + (qd[1] * sin(q[0])) ** 2) + 0.5 * c * spin**2, mgl * cos(q[0])
    m1, m2, l1, l2, g = 0.7, 0.4, 0.8, 0.6, 9.81
    (a, b), (ad, bd) = q, qd
    coupling = l1 * l2 * ad * bd * (cos(a) * cos(b) + sin(a) * sin(b))
    first, second = (l1 * ad) ** 2, (l1 * ad) ** 2 + (l2 * bd) ** 2 + 2.0 * coupling
    return 0.5 * m1 * first + 0.5 * m2 * second, -(m1 + m2) * g * l1 * cos(a) - m2 * g * l2 * cos(b)


def with_quaternion(start):
    """Euler's equations with a quaternion, started at the attitude 1, and the numbers that are compared: matrix and angular velocity."""
    a, b, c = 1.0, 2.0, 3.0
    names = ["w", "x", "y", "z", "o0", "o1", "o2"]
    w, x, y, z, o0, o1, o2 = variables = heyoka.make_vars(*names)
    rates = [
        -0.5 * (x * o0 + y * o1 + z * o2),
        0.5 * (w * o0 + y * o2 - z * o1),
        0.5 * (w * o1 + z * o0 - x * o2),
        0.5 * (w * o2 + x * o1 - y * o0),
        (b - c) / a * o1 * o2,
        (c - a) / b * o2 * o0,
        (a - b) / c * o0 * o1,
    ]

    def compared(state):
        w, x, y, z = state[:4]
        rows = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
        rows += [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
        rows += [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
        return numpy.array([*rows, *state[4:]])

    return list(zip(variables, rates)), [1.0, 0.0, 0.0, 0.0, *start[9:]], compared


def with_heyoka(name, start, fast_math=False):
    """A function of end and tolerance that gives the state at the end and the seconds."""
    compared = numpy.copy
    if name == "Free body":
        equations, start, compared = with_quaternion(start)
    else:
        n = len(start) // 2
        q, qd = heyoka.make_vars(*[f"q{i}" for i in range(n)]), heyoka.make_vars(*[f"v{i}" for i in range(n)])
        q, qd = (q, qd) if n > 1 else ([q], [qd])
        T, V = energies(name, q, qd, heyoka.sin, heyoka.cos)
        equations = heyoka.lagrangian(T - V, q, qd)
    integrators = {}

    def run(end, tolerance):
        if tolerance not in integrators:
            integrators[tolerance] = heyoka.taylor_adaptive(
                equations, list(start), tol=tolerance, fast_math=fast_math
            )
        integrator = integrators[tolerance]
        integrator.time = 0.0
        integrator.state[:] = start
        began = time.perf_counter()
        integrator.propagate_until(end)
        seconds = time.perf_counter() - began
        return compared(integrator.state), seconds

    return run, [10 ** (-0.5 * k) for k in range(4, 32)]


def with_scipy(name, start):
    n = len(start) // 2
    t = sympy.Symbol("t")
    q = [sympy.Function(f"q{i}")(t) for i in range(n)]
    qd = [x.diff(t) for x in q]
    T, V = energies(name, q, qd, sympy.sin, sympy.cos)
    method = sympy.physics.mechanics.LagrangesMethod(T - V, q)
    method.form_lagranges_equations()
    names = sympy.symbols(f"x0:{2 * n}")
    right = method.rhs().subs(dict(zip(qd, names[n:]))).subs(dict(zip(q, names[:n])))
    compiled = sympy.lambdify(names, list(right), "math", cse=True)

    def run(end, tolerance):
        began = time.perf_counter()
        solution = solve_ivp(
            lambda _, y: compiled(*y), (0.0, end), start, "DOP853", t_eval=[end], rtol=tolerance, atol=tolerance
        )
        return solution.y[:, -1], time.perf_counter() - began

    return run, [10.0**-k for k in range(3, 14)]


def at(curve, error):
    """The time where the error falls below `error` for good; as in curve.rs."""
    for (e0, t0), (e1, t1) in reversed(list(zip(curve, curve[1:]))):
        if e0 >= error > e1:
            share = math.log(error / e0) / math.log(e1 / e0)
            return t0 * (t1 / t0) ** share
    return math.nan


def benchmark(*arguments):
    """States of the benchmark, and its points as lists of fields, by system."""
    command = ["cargo", "run", "-q", "--release", "--manifest-path", HERE / "Cargo.toml", *arguments]
    states, points = {}, {}
    for line in subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines():
        system, kind, *fields = line.split("\t")
        if kind == "state":
            states.setdefault(system, []).append([float(x) for x in fields])
        else:
            points.setdefault(system, []).append(fields)
    return states, points


def ours():
    """States and curves of the benchmark, by system."""
    states, points = benchmark("--", "--points")
    curves = {}
    for system, rows in points.items():
        for name, _, error, _, seconds in rows:
            if name in OURS:
                curves.setdefault(system, {}).setdefault(name, []).append((float(error), float(seconds)))
    return states, curves


def largest_error(run, exact, tolerance):
    errors = [numpy.abs(run(t, tolerance)[0] - y).max() for t, *y in exact]
    # Not a number: lost.
    return max(errors) if all(e == e for e in errors) else math.inf


def to_reach(points, error):
    """The shortest time with which the error is reached, between neighbouring points by interpolation."""
    points = [(float(e), float(t)) for _, e, t, *_ in points]
    reached = [t for e, t in points if e <= error]
    return min([at(points, error)] + reached) if reached and at(points, error) > 0 else min(reached, default=math.nan)


def series():
    peers, ratios = {}, {}
    for round in range(ROUNDS):
        states, points = benchmark("--bin", "series", *(["--", ASKED.only] if ASKED.only else []))
        for system, (start, *exact) in states.items():
            for fast_math in (False, True):
                if (system, fast_math) not in peers:
                    run, _ = with_heyoka(system, start[1:], fast_math)
                    errors = {tol: largest_error(run, exact, tol) for tol in (1e-9, 1e-12, 1e-15)}
                    peers[system, fast_math] = run, errors
                run, errors = peers[system, fast_math]
                for tolerance, error in errors.items():
                    time = min(run(exact[-1][0], tolerance)[1] for _ in range(100))
                    ratio = to_reach(points[system], error) / time
                    ratios.setdefault((system, tolerance), {}).setdefault(fast_math, []).append((ratio, error, time))
    print(f"heyoka {heyoka.__version__}\n")
    print("| system | its tolerance | its error | its µs | our time / its | the same with fast_math |")
    print("|---|---|---|---|---|---|")
    for (system, tolerance), by_mode in ratios.items():
        plain, fast = ([statistics.median(x) for x in zip(*by_mode[mode])] for mode in (False, True))
        cells = f"{plain[1]:.0e} | {plain[2] * 1e6:.1f} | {plain[0]:.2f} | {fast[0]:.2f}"
        print(f"| {system} | {tolerance:.0e} | {cells} |")


def batches(tolerance, fast_math):
    """A function that runs all samples in heyoka's batches of 8, for its seconds."""
    count, width = 10_000, 8
    q, qd = heyoka.make_vars("q0", "q1"), heyoka.make_vars("v0", "v1")
    T, V = energies("Double pendulum", q, qd, heyoka.sin, heyoka.cos)
    equations = heyoka.lagrangian(T - V, q, qd)
    i = numpy.arange(count)
    shares = [3.0 * numpy.modf(x * i)[0] - 1.5 for x in (0.6180339887498949, 0.41421356237309503)]
    starts = numpy.array([*shares, 0.0 * i, 0.0 * i]).reshape(4, -1, width)
    integrator = heyoka.taylor_adaptive_batch(
        equations, numpy.ascontiguousarray(starts[:, 0]), tol=tolerance, fast_math=fast_math
    )

    def run():
        began = time.perf_counter()
        for batch in range(count // width):
            integrator.set_time(0.0)
            integrator.state[:] = starts[:, batch]
            integrator.propagate_until(10.0)
        return time.perf_counter() - began

    return run


def lanes():
    peers, ratios = {}, {}
    for round in range(ROUNDS):
        _, points = benchmark("--bin", "series", "--", "lanes")
        for tolerance, beside, alone in sorted(points["lanes"]):
            found = [float(alone) / float(beside)]
            for mode in (False, True):
                if (tolerance, mode) not in peers:
                    peers[tolerance, mode] = batches(float(tolerance), mode)
                found.append(min(peers[tolerance, mode]() for _ in range(3)) / float(beside))
            ratios.setdefault(tolerance, []).append(found)
    print("| tolerance | heyoka's time / ours in lanes | the same with fast_math | ours one by one / in lanes |")
    print("|---|---|---|---|")
    for tolerance, found in ratios.items():
        alone, plain, fast = ([f(column) for f in (min, statistics.median, max)] for column in zip(*found))
        cells = [f"{middle:.2f} ({least:.2f} – {most:.2f})" for least, middle, most in (plain, fast, alone)]
        print(f"| {tolerance} | {' | '.join(cells)} |")


def chain(n, compact):
    """A function that gives the seconds of a step of heyoka's, and the number of steps; and the seconds to make it."""
    began = time.perf_counter()
    q, qd = (list(heyoka.make_vars(*[f"{name}{i}" for i in range(n)])) for name in "qv")
    # Of the ways to write T (squares of sums, cosines of differences, products of cosines and sines) the one with the quickest steps.
    T = sum(((n - i) * 0.5 * v**2 for i, v in enumerate(qd)), heyoka.expression(0.0))
    for i in range(n):
        T += sum(((n - i) * qd[i] * qd[j] * heyoka.cos(q[i] - q[j]) for j in range(i)), heyoka.expression(0.0))
    V = -9.81 * sum(((n - i) * heyoka.cos(a) for i, a in enumerate(q)), heyoka.expression(0.0))
    start = [0.5 + 0.1 * i for i in range(n)] + [0.0] * n
    integrator = heyoka.taylor_adaptive(heyoka.lagrangian(T - V, q, qd), start, tol=1e-15, compact_mode=compact)
    made = time.perf_counter() - began

    def run():
        integrator.time = 0.0
        integrator.state[:] = start
        began = time.perf_counter()
        steps = integrator.propagate_until(CHAIN_END)[3]
        return (time.perf_counter() - began) / steps, steps

    return run, made


def chains():
    peers, ratios, told = {}, {}, {}
    for round in range(ROUNDS):
        _, points = benchmark("--bin", "series", "--", "chain")
        for links, _, step, *_ in points["chain"]:
            for compact in (False, True):
                if not compact and int(links) not in ASKED.chain:
                    continue
                key = int(links), compact
                if key not in peers:
                    peers[key] = chain(int(links), compact)
                run, made = peers[key]
                seconds, steps = min(run() for _ in range(15))
                ratios.setdefault(key, []).append(float(step) / seconds)
                told[key] = made, seconds, steps
    print("| links | compact | seconds to make it | its step, µs | steps | our step / its |")
    print("|---|---|---|---|---|---|")
    for (n, compact), found in sorted(ratios.items()):
        made, seconds, steps = told[n, compact]
        print(f"| {n} | {compact} | {made:.1f} | {seconds * 1e6:.2f} | {steps} | {statistics.median(found):.4f} |")


def main():
    states, curves = ours()
    peers = {}
    for system, (start, *exact) in states.items():
        for peer, make in {"heyoka": with_heyoka, "scipy DOP853": with_scipy}.items():
            run, tolerances = make(system, start[1:])
            points = []
            for tolerance in tolerances:
                points.append((tolerance, largest_error(run, exact, tolerance)))
            peers[system, peer] = run, exact[-1][0], [p for p in points if 0.0 < p[1] < math.inf]
    ratios = {}
    for round in range(ROUNDS):
        if round > 0:
            _, curves = ours()
        for (system, peer), (run, end, points) in peers.items():
            repeat = 20 if peer == "heyoka" else 1
            curve = [(e, statistics.median(run(end, tol)[1] for _ in range(repeat))) for tol, e in points]
            for error in ERRORS:
                for method in OURS:
                    ratio = at(curve, error) / at(curves[system][method], error)
                    ratios.setdefault((system, error, peer), {}).setdefault(method, []).append(ratio)
    print(f"heyoka {heyoka.__version__}, scipy {scipy.__version__}, sympy {sympy.__version__}\n")
    print("| system | error | peer |" + "".join(f" its time / {method} |" for method in OURS))
    print("|---|---|---|" + "---|" * len(OURS))
    for (system, error, peer), by_method in ratios.items():
        cells = "".join(f" {statistics.median(by_method[method]):.3g} |" for method in OURS)
        print(f"| {system} | {error:.0e} | {peer} |{cells}")


if ASKED.series:
    series()
elif ASKED.chain is not None:
    chains()
elif ASKED.lanes:
    lanes()
else:
    main()
