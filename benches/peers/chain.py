"""Accelerations of the chain of n links, ours against what other tools generate: `python3 benches/peers/chain.py [n …]`.

Makes a virtual environment in benches/peers/target; needs gcc, g++ and an hour at most. Planar chain of unit masses and
lengths, angles with the vertical (Pinocchio's with the link before). Peers: CasADi (M and f by automatic differentiation, and
its sparse LDL^T), wrenfold (the same two), SymPy (Kane's method, common subexpressions), Pinocchio's articulated-body algorithm
through CasADi's code generation. Everything is compiled for the processor at hand, gcc -O3 -march=native, loaded into one program
that times all in turn on the same states, and checked against ours. M q" = f of the first ways is solved by an LDL^T in loops of
constant length.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Annotated

from environment import enter

HERE = Path(__file__).resolve().parent
WORK = HERE / "target" / "chain"
SIZES = [int(word) for word in sys.argv[1:]] or [2, 3, 4, 6, 8, 12, 16, 24, 32]
ROUNDS = 31
SYMPY_UNTIL = 16  # Its derivation takes minutes beyond.

enter("venv-chain", ["casadi==3.8.2", "wrenfold==0.5.3", "sympy==1.14.0", "pin==4.1.0"])

import casadi
import sympy
from sympy.physics import mechanics
from wrenfold import code_generation, sym, type_annotations

SOLVE = """
static inline void solve(double *M, double *f, double *a) {
  for (int j = 0; j < N; j++) {
    double d = 1 / M[j * N + j];
    for (int i = j + 1; i < N; i++) { double u = M[i * N + j] * d; for (int k = j + 1; k <= i; k++) M[i * N + k] -= u * M[k * N + j]; }
    for (int i = j + 1; i < N; i++) M[i * N + j] *= d;
    for (int i = j + 1; i < N; i++) f[i] -= M[i * N + j] * f[j];
    M[j * N + j] = d;
  }
  for (int i = 0; i < N; i++) f[i] *= M[i * N + i];
  for (int i = N - 1; i >= 0; i--) for (int k = 0; k < i; k++) f[k] -= M[i * N + k] * f[i];
  for (int i = 0; i < N; i++) a[i] = f[i];
}
"""


def by_casadi(n, solved):
    q, w = casadi.SX.sym("q", n), casadi.SX.sym("w", n)
    rate = lambda e: casadi.jtimes(e, q, w)
    x = y = lagrangian = 0
    for i in range(n):
        x, y = x + casadi.sin(q[i]), y - casadi.cos(q[i])
        lagrangian += 0.5 * (rate(x) ** 2 + rate(y) ** 2) - 9.81 * y
    p = casadi.gradient(lagrangian, w)
    inertia, force = casadi.jacobian(p, w), casadi.gradient(lagrangian, q) - rate(p)
    results = [casadi.densify(inertia), force]
    if solved:
        results = [casadi.ldl_solve(force, *casadi.ldl(inertia))]
    name = f"casadi_{solved:d}_{n}"
    casadi.Function("f", [q, w], results, {"cse": True}).generate(f"{name}.c", {"with_header": False})
    return c_of_casadi(name, n, solved)


def c_of_casadi(name, n, solved):
    """CasADi's C with our signature."""
    text = Path(f"{name}.c").read_text() + f"\n#define N {n}\n" + SOLVE
    signature = "void accel(const double *q, const double *w, double *a) { const double *in[2] = {q, w};"
    if solved:
        text += signature + " double *out[1] = {a}; casadi_f0(in, out, 0, 0, 0); }\n"
    else:
        text += signature + " double M[N * N], f[N], *out[2] = {M, f}; casadi_f0(in, out, 0, 0, 0); solve(M, f, a); }\n"
    Path(f"{name}.c").write_text(text)
    return f"{name}.c"


def by_wrenfold(n, solved):
    vector = Annotated[sym.MatrixExpr, type_annotations.Shape(rows=n, cols=1)]

    def accelerations(q: vector, w: vector):
        q, w = [q[i, 0] for i in range(n)], [w[i, 0] for i in range(n)]
        rate = lambda e: sum((e.diff(q[i]) * w[i] for i in range(n)), sym.zero)
        x = y = lagrangian = sym.zero
        for i in range(n):
            x, y = x + sym.sin(q[i]), y - sym.cos(q[i])
            lagrangian = lagrangian + (rate(x) ** 2 + rate(y) ** 2) / 2 - sym.rational(981, 100) * y
        p = [lagrangian.diff(v) for v in w]
        lower = [[p[i].diff(w[j]) for j in range(i + 1)] for i in range(n)]
        full = [[lower[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
        f = [lagrangian.diff(q[i]) - rate(p[i]) for i in range(n)]
        if not solved:
            return [code_generation.OutputArg(sym.matrix(full), "m"), code_generation.OutputArg(sym.vector(*f), "f")]
        diagonal, factor = [None] * n, [[None] * n for _ in range(n)]
        for j in range(n):
            diagonal[j] = full[j][j]
            for i in range(j + 1, n):
                factor[i][j] = full[i][j] / diagonal[j]
                for k in range(j + 1, i + 1):
                    full[i][k] = full[i][k] - factor[i][j] * full[k][j]
                f[i] = f[i] - factor[i][j] * f[j]
        f = [f[i] / diagonal[i] for i in range(n)]
        for i in reversed(range(n)):
            for k in range(i):
                f[k] = f[k] - factor[i][k] * f[i]
        return [code_generation.OutputArg(sym.vector(*f), "a")]

    text = code_generation.generate_function(accelerations, code_generation.CppGenerator(), name="f")
    # What the generated code expects of views of its arguments.
    spans = """#include <cmath>
#include <utility>
namespace wf {
template <int R, int C, class T> struct View { T *p; inline T &operator()(int i, int j) const { return p[i * C + j]; } };
template <int R, int C, class T> inline View<R, C, const double> make_input_span(const T &x) { return {x}; }
template <int R, int C, class T> inline View<R, C, double> make_output_span(T &&x) { return {x}; }
}
"""
    signature = 'extern "C" void accel(const double *q, const double *w, double *a) '
    call = "{ f<double>(q, w, a); }" if solved else "{ double m[N * N], r[N]; f<double>(q, w, m, r); solve(m, r, a); }"
    name = f"wrenfold_{solved:d}_{n}.cpp"
    Path(name).write_text(f"#define N {n}\n{spans}{text}\n{SOLVE}\n{signature}{call}\n")
    return name


def by_sympy(n):
    q, w = mechanics.dynamicsymbols(f"q:{n}"), mechanics.dynamicsymbols(f"w:{n}")
    frame, point = mechanics.ReferenceFrame("A"), mechanics.Point("O")
    point.set_vel(frame, 0)
    bodies, forces = [], []
    for i in range(n):
        s, c = sympy.sin(q[i]), sympy.cos(q[i])
        velocity = point.vel(frame) + w[i] * (c * frame.x + s * frame.y)
        point = point.locatenew(f"P{i}", s * frame.x - c * frame.y)
        point.set_vel(frame, velocity)
        bodies.append(mechanics.Particle(f"B{i}", point, 1))
        forces.append((point, -sympy.Float(9.81) * frame.y))
    kane = mechanics.KanesMethod(frame, q, w, [v - x.diff() for v, x in zip(w, q)])
    kane.kanes_equations(bodies, forces)
    symbols = {x: sympy.Symbol(f"q[{i}]") for i, x in enumerate(q)} | {v: sympy.Symbol(f"w[{i}]") for i, v in enumerate(w)}
    inertia, force = kane.mass_matrix.xreplace(symbols), kane.forcing.xreplace(symbols)
    lets, (inertia, force) = sympy.cse([inertia, force])
    lines = [f"double {x} = {sympy.ccode(e)};" for x, e in lets]
    lines += [f"M[{i}] = {sympy.ccode(e)};" for i, e in enumerate(inertia)]
    lines += [f"f[{i}] = {sympy.ccode(e)};" for i, e in enumerate(force)]
    body = "\n".join(lines)
    name = f"sympy_{n}.c"
    signature = "void accel(const double *q, const double *w, double *a) { double M[N * N], f[N];"
    Path(name).write_text(f"#include <math.h>\n#define N {n}\n{SOLVE}\n{signature}\n{body}\nsolve(M, f, a); }}\n")
    return name


def by_pinocchio(n):
    # CasADi writes where it stands.
    subprocess.run(["./aba", str(n), f"pinocchio_{n}.c"], check=True)
    return c_of_casadi(f"pinocchio_{n}", n, True)


def seconds(work, *arguments):
    start = time.process_time()
    children = os.times()
    result = work(*arguments)
    spent = os.times()
    return result, time.process_time() - start + spent.children_user - children.children_user


def compiled(source):
    compiler = ["g++", "-std=c++17"] if source.endswith(".cpp") else ["gcc"]
    library = f"{Path(source).stem}.so"
    subprocess.run([*compiler, "-O3", "-march=native", "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
    return library


def main():
    WORK.mkdir(parents=True, exist_ok=True)
    os.chdir(WORK)
    environment = os.environ | {"RUSTFLAGS": "-C target-cpu=native"}
    build = ["cargo", "build", "--release", "--example", "chain", "--manifest-path", str(HERE / "Cargo.toml")]
    subprocess.run(build, check=True, env=environment)
    target = Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target"))
    ours = target / "release" / "examples" / "libchain.so"
    subprocess.run(["gcc", "-O2", str(HERE / "chain" / "time.c"), "-o", "time", "-ldl", "-lm"], check=True)
    if not Path("aba").exists():
        packages = Path(casadi.__file__).parent
        pinocchio = packages.parent / "cmeel.prefix" / "include"
        include = [pinocchio, packages / "include", packages / "include" / "eigen3"]
        # As many kinds of joints as Pinocchio has.
        limits = ["NDEBUG", "BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
        limits += ["BOOST_MPL_LIMIT_VECTOR_SIZE=30", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]
        flags = [f"-D{limit}" for limit in limits] + [word for path in include for word in ("-isystem", str(path))]
        link = [f"-L{packages}", "-lcasadi", f"-Wl,-rpath,{packages}"]
        source = str(HERE / "chain" / "aba.cpp")
        subprocess.run(["g++", "-std=c++17", "-O0", *flags, source, "-o", "aba", *link], check=True)
    tools = {
        "CasADi": (lambda n: by_casadi(n, False), False),
        "CasADi, LDL^T": (lambda n: by_casadi(n, True), False),
        "wrenfold": (lambda n: by_wrenfold(n, False), False),
        "wrenfold, LDL^T": (lambda n: by_wrenfold(n, True), False),
        "SymPy": (by_sympy, False),
        "Pinocchio": (by_pinocchio, True),
    }
    print("| n | tool | ns | ours / tool | difference | s to derive | s to compile |\n|---|---|---|---|---|---|---|")
    for n in SIZES:
        words, rows = [f"{ours}:accel_{n}:0"], [("ours", 0.0, 0.0)]
        for name, (generate, relative) in tools.items():
            if name == "SymPy" and n > SYMPY_UNTIL:
                print(f"| {n} | {name} | not derived beyond {SYMPY_UNTIL} links | | | | |", flush=True)
                continue
            source, derive = seconds(generate, n)
            library, build = seconds(compiled, source)
            words.append(f"./{library}:accel:{relative:d}")
            rows.append((name, derive, build))
        timed = subprocess.run(["./time", str(n), str(ROUNDS), *words], check=True, capture_output=True, text=True)
        for (name, derive, build), line in zip(rows, timed.stdout.splitlines()):
            ns, ratio, difference = line.split()
            print(f"| {n} | {name} | {ns} | {float(ratio):.2f} | {difference} | {derive:.2f} | {build:.2f} |", flush=True)


main()
