"""Accelerations of bodies that tumble, ours against Pinocchio's and MuJoCo's: `python3 benches/peers/bodies.py [--instructions] [--rounds N]`.

Makes a virtual environment in benches/peers/target; needs gcc, g++, some minutes, and valgrind for --instructions. A free body, a chain of 8 bodies on ball joints, and an arm
of seven axes on a floating body (that of tests/bodies/floating_arm.rs). Peers: Pinocchio's articulated-body algorithm, its templates compiled here; the
same through CasADi's code generation; MuJoCo's `mj_forward` with contacts and constraints off, the library as it is published. What is compiled here is compiled for the
processor at hand, by gcc -O3 -march=native. One program calls all in turn on the same 256 states, each in its own variables (ours in the parameters of attitudes, theirs
in quaternions); the accelerations are compared in those of the place, of the attitude and of the joints.

With --instructions what a call executes is counted by callgrind instead of timed, all compiled for AVX2.
"""

import argparse
import ctypes
import os
import re
import subprocess
from pathlib import Path

from environment import enter

HERE = Path(__file__).resolve().parent
WORK = HERE / "target" / "bodies"
STATES = 256

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--instructions", action="store_true", help="counts instead of times")
parser.add_argument("--rounds", type=int, default=101, help="of which medians are taken (101)")
ASKED = parser.parse_args()

enter("venv-bodies", ["casadi==3.8.2", "pin==4.1.0", "mujoco==4.0.0", "numpy"])

import casadi
import mujoco
import numpy as np
import pinocchio as pin

UP = [0.16, 0.2, 0.2, 0.22, 0.18, 0.22, 0.08, 0.12]
MASS = [4.1, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3]


def arm():
    yield "free", (0, 0, 0), 30.0, (0, 0, 0), (1.2, 1.5, 1.8)
    for i, mass in enumerate(MASS):
        across = mass * (UP[i + 1] ** 2 + 3 * 0.06**2) / 12
        place = (0, 0, UP[i]) if i else (0.1, 0.05, 0.3)
        centre = (0, 0.03 if i % 2 else -0.03, UP[i + 1] / 2)
        yield "y" if i % 2 else "z", place, mass, centre, (across, across, mass * 0.06**2 / 2)


# Joint, place in the body before, mass, mass centre, moments of inertia about it.
SYSTEMS = {
    "body": [("free", (0, 0, 0), 2.0, (0, 0, 0), (1, 2, 2.5))],
    "chain": [("ball", (0, 0, -1 if i else 0), 1.0, (0.01, 0.02, -0.5), (0.1, 0.11, 0.01)) for i in range(8)],
    "arm": list(arm()),
}


def row(values):
    return " ".join(repr(float(x)) for x in values)


def table(bodies):
    return "".join(f"{kind} {row(place)} {mass} {row(centre)} {row(moments)}\n" for kind, place, mass, centre, moments in bodies)


def mjcf(bodies):
    joints = {"free": "<freejoint/>", "ball": '<joint type="ball"/>', "y": '<joint type="hinge" axis="0 1 0"/>', "z": '<joint type="hinge" axis="0 0 1"/>'}
    text = ""
    for kind, place, mass, centre, moments in bodies:
        text += f'<body pos="{row(place)}">{joints[kind]}<inertial pos="{row(centre)}" mass="{mass}" diaginertia="{row(moments)}"/>'
    # Moments of inertia are as they are given, also where a flat body has others.
    head = '<mujoco><compiler balanceinertia="false"/><option gravity="0 0 -9.81"><flag contact="disable" constraint="disable"/></option>'
    return f"{head}<worldbody>{text}{'</body>' * len(bodies)}</worldbody></mujoco>"


def omega(sigma, rate):
    """Angular velocity in the turned axes, of numbers or of complex ones."""
    d = 1 + sigma @ sigma
    return 4 / d**2 * ((2 - d) * rate - 2 * np.cross(sigma, rate) + 2 * (sigma @ rate) * sigma)


class Variables:
    """Coordinates and velocities of a state for each tool, and the accelerations that are compared."""

    def __init__(self, bodies):
        rng = np.random.default_rng(30)
        self.kinds = [kind for kind, *_ in bodies]
        self.states = [[self.draw(rng, kind) for kind in self.kinds] for _ in range(STATES)]

    @staticmethod
    def draw(rng, kind):
        """Place and velocity in space, quaternion w, x, y, z, and angular velocity in the turned axes; or an angle and its rate."""
        if kind in "yz":
            return rng.uniform(-3, 3), rng.uniform(-2, 2)
        q = rng.normal(size=4)
        q /= np.linalg.norm(q) * np.sign(q[0])
        return rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3), q, rng.uniform(-2, 2, 3)

    def written(self, tool, state):
        q, w = [], []
        for kind, joint in zip(self.kinds, state):
            if kind in "yz":
                q.append([joint[0]])
                w.append([joint[1]])
                continue
            place, velocity, attitude, spin = joint
            if kind == "free":
                q.append(place)
                own = matrix(attitude).T @ velocity
                w.append(own if tool == "Pinocchio" else velocity)
            if tool == "ours":
                sigma = attitude[1:] / (1 + attitude[0])
                q.append(sigma)
                w.append(((1 - sigma @ sigma) * spin + 2 * np.cross(sigma, spin) + 2 * (sigma @ spin) * sigma) / 4)
            else:
                q.append(attitude if tool == "MuJoCo" else [*attitude[1:], attitude[0]])
                w.append(spin)
        return np.concatenate(q), np.concatenate(w)

    def compared(self, tool, state, a):
        """Accelerations of places in space, of attitudes in the turned axes, of angles."""
        q, w = self.written(tool, state)
        out, at = np.array(a), 0
        for kind, joint in zip(self.kinds, state):
            if kind == "free":
                if tool == "Pinocchio":
                    turned = matrix(joint[2])
                    out[at : at + 3] = turned @ (a[at : at + 3] + np.cross(joint[3], turned.T @ joint[1]))
                at += 3
            if kind in ("free", "ball"):
                own = slice(at, at + 3)
                if tool == "ours":
                    step = 1e-30j
                    out[own] = (omega(q[own] + step * w[own], w[own] + step * a[own])).imag / 1e-30
                at += 3
            else:
                at += 1
        return out


def matrix(q):
    w, x, y, z = q
    return pin.Quaternion(w, x, y, z).toRotationMatrix()


def generated(name):
    """CasADi's C with our signature, and its operations."""
    run = subprocess.run(["./generated", f"{name}.txt", f"{name}_casadi.c"], check=True, capture_output=True, text=True)
    with open(f"{name}_casadi.c", "a") as file:
        call = "const double *in[2] = {q, w}; double *out[1] = {a}; casadi_f0(in, out, 0, 0, 0);"
        file.write(f"\nvoid accel(const double *q, const double *w, double *a) {{ {call} }}\n")
    return f"{name}_casadi.c", int(run.stdout)


def made(out, source, *command):
    """Compiles a file unless that has been done."""
    if not Path(out).exists() or Path(out).stat().st_mtime < Path(source).stat().st_mtime:
        subprocess.run([*command[:1], "-w", *command[1:], "-o", out], check=True)


def build():
    """What all systems share; the functions of each system by tools, and the operations of those that are known."""
    level = "x86-64-v3" if ASKED.instructions else "native"
    cargo = ["cargo", "build", "-q", "--release", "--example", "bodies", "--manifest-path", str(HERE / "Cargo.toml")]
    subprocess.run(cargo, check=True, env=os.environ | {"RUSTFLAGS": f"-C target-cpu={level}"})
    ours = Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target")) / "release" / "examples" / "libbodies.so"
    library = ctypes.CDLL(str(ours))
    for name, bodies in SYSTEMS.items():
        Path(f"{name}.txt").write_text(table(bodies))
        Path(f"{name}.xml").write_text(mjcf(bodies))
    sources = HERE / "bodies"
    made("time", sources / "time.c", "gcc", "-O2", sources / "time.c", "-ldl")
    packages, folder = Path(casadi.__file__).parent, Path(mujoco.__file__).parent
    prefix = packages.parent / "cmeel.prefix"
    include = [prefix / "include", packages / "include", packages / "include" / "eigen3"]
    limits = ["NDEBUG", "BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    limits += ["BOOST_MPL_LIMIT_VECTOR_SIZE=30", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]
    flags = ["-std=c++17", *(f"-D{limit}" for limit in limits), *(word for path in include for word in ("-isystem", str(path)))]
    pinocchio = [f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]
    casadis = [f"-L{packages}", "-lcasadi", f"-Wl,-rpath,{packages}"]
    source = sources / "generated.cpp"
    made("generated", source, "g++", "-O0", *flags, source, *casadis, *pinocchio)
    fast, where = ["-O3", f"-march={level}", "-shared", "-fPIC"], f'-DFOLDER="{WORK}"'
    source, native = sources / "pinocchio.cpp", f"./pinocchio_{level}.so"
    made(native, source, "g++", *fast, *flags, where, source, *pinocchio)
    found = {}
    for name in SYSTEMS:
        source, count = generated(name)
        made(f"{name}_casadi_{level}.so", source, "gcc", *fast, source, "-lm")
        words = [f'-DMODEL="{WORK / name}.xml"', f"-I{folder / 'include'}", sources / "mujoco.c", next(folder.glob("libmujoco.so*"))]
        made(f"{name}_mujoco_{level}.so", sources / "mujoco.c", "gcc", *fast, *words, f"-Wl,-rpath,{folder}")
        found[name] = {
            "ours": ("ours", f"{ours}:accel_{name}", getattr(library, f"operations_{name}")()),
            "Pinocchio": ("Pinocchio", f"{native}:accel_{name}", "–"),
            "Pinocchio, generated": ("Pinocchio", f"./{name}_casadi_{level}.so:accel", count),
            "MuJoCo": ("MuJoCo", f"./{name}_mujoco_{level}.so:accel", "–"),
        }
    return found


def counted(words):
    """Instructions of a call, by two runs of which one calls more often."""
    def run(rounds):
        tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "./time", str(rounds), "1", words]
        told = subprocess.run(tool, check=True, capture_output=True, text=True).stderr
        return int(re.search(r"Collected : (\d+)", told).group(1))

    return (run(5) - run(1)) / 4 / STATES


def main():
    WORK.mkdir(parents=True, exist_ok=True)
    os.chdir(WORK)
    functions = build()
    print(f"Pinocchio {pin.__version__}, MuJoCo {mujoco.__version__}\n")
    unit = "instructions" if ASKED.instructions else "ns"
    print(f"| system | tool | operations | {unit} | ours / tool | quartiles | difference |\n|---|---|---|---|---|---|---|")
    for name, bodies in SYSTEMS.items():
        tools = functions[name]
        variables, words = Variables(bodies), []
        for tool, (form, function, _) in tools.items():
            written = [variables.written(form, state) for state in variables.states]
            file = f"{name}_{tool.replace(', ', '_')}.states"
            np.array([np.concatenate(both) for both in written]).tofile(file)
            words.append(f"{function}:{file}:{len(written[0][0])}:{len(written[0][1])}")
        if ASKED.instructions:
            found = [counted(word) for word in words]
            lines = [[n, found[0] / n, found[0] / n, found[0] / n] for n in found]
        else:
            run = subprocess.run(["./time", str(ASKED.rounds), "8", *words], check=True, capture_output=True, text=True)
            lines = [list(map(float, line.split())) for line in run.stdout.splitlines()]
        known = None
        for (tool, (form, _, count)), word, (spent, low, middle, high) in zip(tools.items(), words, lines):
            all = np.fromfile(f"{word.split(':')[2]}.out").reshape(STATES, -1)
            all = np.array([variables.compared(form, state, a) for state, a in zip(variables.states, all)])
            known = all if known is None else known
            difference = (abs(all - known).max(axis=1) / abs(known).max(axis=1)).max()
            print(f"| {name} | {tool} | {count} | {spent:.0f} | {middle:.3f} | {low:.3f} – {high:.3f} | {difference:.1e} |", flush=True)


main()
