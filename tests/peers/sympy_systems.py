"""Random systems: our accelerations against those of SymPy's LagrangesMethod, in 40 digits.

    python3 tests/peers/sympy_systems.py [systems] [first seed]

has the macro crate write random systems with their accelerations, derives the equations of each by SymPy, solves them with
mpmath, and compares to within what rounding is measured to be worth (see lagrange-macros/src/differential.rs). A derivation
that takes longer than twenty seconds is left out and counted. Needs sympy.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import mpmath
from sympy import Float, Function, Matrix, Rational, Symbol, diff
from sympy import acos, acosh, asin, asinh, atan, atan2, atanh, cos, cosh, exp, log, pi, sin, sinh, sqrt, tan, tanh
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 20
mpmath.mp.dps = 40


def written(count, first):
    """The systems, by the test of the macro crate."""
    given = os.environ.get("LAGRANGE_FILE")
    if given and Path(given).exists():
        return json.loads(Path(given).read_text())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "systems.json"
        environment = dict(os.environ, LAGRANGE_FILE=str(file), LAGRANGE_SYSTEMS=str(count), LAGRANGE_SEED=str(first))
        command = "cargo test --release -q -p lagrange-macros --lib -- --ignored written_for_sympy".split()
        subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)
        return json.loads(file.read_text())


def accelerations(system):
    """q̈ of a system at its state."""
    t = dynamicsymbols._t
    n = system["coordinates"]
    q = [Function(f"q{i}", real=True)(t) for i in range(n)]
    p = [Symbol(f"p{i}", positive=True) for i in range(len(system["p"]))]
    scope = dict(
        t=t, p=p, x=list(q), u=[], diff=diff, sin=sin, cos=cos, tan=tan, exp=exp, ln=log, sqrt=sqrt, tanh=tanh, atan=atan,
        asinh=asinh, asin=asin, acos=acos, sinh=sinh, cosh=cosh, acosh=acosh, atanh=atanh, atan2=atan2, Rational=Rational,
        exp_m1=lambda x: exp(x) - 1, exp2=lambda x: 2**x, ln_1p=lambda x: log(1 + x), log2=lambda x: log(x) / log(2),
        log10=lambda x: log(x) / log(10), powf=lambda x, y: x**y, recip=lambda x: 1 / x, hypot=lambda x, y: sqrt(x * x + y * y),
        # Real, on both sides of 0.
        cbrt=lambda x: x * (x * x) ** Rational(-1, 3),
        to_radians=lambda x: pi * x / 180, to_degrees=lambda x: 180 * x / pi,
    )  # fmt: skip

    def of(text):
        return eval(text, scope)  # noqa: S307 (our own test wrote it)

    scope["x"] += [of(text) for text in system["prescribed"]]
    for text in system["bindings"]:
        scope["u"].append(of(text))
    rates = [diff(x, t) for x in q]
    holonomic, velocities = [], []
    for text, on_velocities in system["constraints"]:
        (velocities if on_velocities else holonomic).append(of(text))
    method = LagrangesMethod(
        of(system["T"]) - of(system["V"]), q, hol_coneqs=holonomic or None, nonhol_coneqs=velocities or None
    )
    method.form_lagranges_equations()
    # What is left of M q̈ = f + Aᵀ λ when friction and forces are added: each Q by its virtual work.
    dissipation = of(system["D"])
    forces = [-diff(dissipation, rate) for rate in rates]
    for i, text in system["applied"]:
        forces[i] += of(text)
    for force, place in system["forces"]:
        force, place = of(force), of(place)
        forces = [total + force * diff(place, x) for total, x in zip(forces, q)]

    full, forcing = method.mass_matrix_full, method.forcing_full
    if holonomic or velocities:
        # Rows: q̇, M q̈, A q̈; the multipliers come last.
        full, forcing = full[n:, n:], forcing[n:, :]
    else:
        full, forcing = method.mass_matrix, method.forcing
    forcing = Matrix(forcing)
    for i in range(n):
        forcing[i] += forces[i]

    numbers = {t: Float(system["t"], 40)}
    numbers.update({a: Float(b, 40) for a, b in zip(p, system["p"])})
    state = [(rate, Float(v, 40)) for rate, v in zip(rates, system["qd"])]
    state += [(x, Float(v, 40)) for x, v in zip(q, system["q"])]

    def number(e):
        # Derivatives first, then what they are derivatives of, then time and parameters.
        return mpmath.mpf(e.subs(state[:n]).subs(state[n:]).subs(numbers).evalf(40))

    matrix = mpmath.matrix(full.rows, full.cols)
    right = mpmath.matrix(forcing.rows, 1)
    for i in range(full.rows):
        right[i] = number(forcing[i])
        for j in range(full.cols):
            matrix[i, j] = number(full[i, j])
    return mpmath.lu_solve(matrix, right)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    compared, values, late, wrong, worst = 0, 0, 0, 0, (0, None)

    def too_late(*_):
        raise TimeoutError

    signal.signal(signal.SIGALRM, too_late)
    for system in written(count, first):
        signal.alarm(SECONDS)
        try:
            expected = accelerations(system)
        except TimeoutError:
            late += 1
            continue
        finally:
            signal.alarm(0)
        compared += 1
        if compared % 20 == 0:
            print(f"… {compared} compared, {late} left out", file=sys.stderr)
        for name, found, granted in system["values"]:
            i = int(name[6:-1])
            error = abs(found - expected[i])
            values += 1
            roundings = float(error / granted)
            worst = max(worst, (roundings, f"{name} of system {system['seed']}"))
            if error > granted:
                wrong += 1
                print(f"system {system['seed']}: {name} is {found}, by SymPy {mpmath.nstr(expected[i], 17)}; granted {granted}")
    print(f"{compared} systems, {values} accelerations, {wrong} wrong, {late} took SymPy longer than {SECONDS} s")
    print(f"worst: {worst[0]:.2g} of what is granted, {worst[1]}")
    sys.exit(wrong > 0 or compared == 0)


if __name__ == "__main__":
    main()
