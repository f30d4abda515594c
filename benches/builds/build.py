"""Cost of a system in its user's build: `python3 benches/builds/build.py [--runtime FOLDER] [--systems a,b] [--runs 'a;b'] [--rounds N]`.

Each program has one system of `systems.rs` and one way to use it. Printed is the processor time of `cargo build --release` in seconds (dependencies
compiled before; of all cores together, so that it says the same on a busy machine), the least of the rounds. `--runtime` is the folder of another
`lagrange-runtime`, to compare with. `--limit` gives up after so many seconds on the clock. `--check` measures `cargo check` after a change of the file instead,
and `--clean` a release build with its dependencies.
"""

import argparse
import os
import resource
import shutil
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent
SYSTEMS = ["pendulum_by_hand", "pendulum", "double_pendulum_by_hand", "double_pendulum", "arm_by_hand", "arm", "floating_arm", "ball_chain", "bicycle_by_hand", "bicycle", "truss"]


def run(method, controller, number=""):
    return f'println!("{{:?}}", integrate(&system, {method}, {controller}, start{number}).until(end).final_state());'


def chosen(aim):
    return f'println!("{{:?}}", method_for(&system, {aim}).integrate(start).until(end).final_state());'


DOP853 = run("Dop853", "PiController::tolerance(1e-9)")
RUNS = {
    "accelerations": 'println!("{:?}", system.accel(&start.q, &start.qd, end));',
    "RK4": run("Rk4", "FixedStep::new(1e-3)"),
    "Dop853": DOP853,
    "Dop853, Radau5, Taylor": DOP853
    + run("Radau5::default()", "PiController::tolerance(1e-9)")
    + run("Taylor", "TaylorController::tolerance(1e-12)"),
    "method_for Accuracy": chosen("goal::Accuracy(1e-9)"),
    "method_for LongTime": chosen("goal::LongTime(1e-3)"),
    "method_for Stiff": chosen("goal::Stiff(1e-9)"),
}

MANIFEST = """[workspace]
[package]
name = "built"
version = "0.0.0"
edition = "2024"
[dependencies]
lagrange-runtime = { path = "RUNTIME" }
"""

PROGRAM = """#[macro_use]
#[path = "SYSTEMS"]
#[allow(unused_macros)]
mod systems;
#[allow(unused_imports)]
use lagrange_runtime::prelude::*;
SYSTEM!();
fn main() {
    let end: f64 = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(1e-3);
    let (system, start) = (Built::default(), State::new(0.0, START.0, START.1));
    RUN
}
"""


def seconds(folder, program, limit, check=False, clean=False):
    """Processor time of one build, with its dependencies if it is a clean one."""
    (folder / "src" / "main.rs").write_text(program)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(folder / "target"), "CARGO_INCREMENTAL": "1" if check else "0"}
    if clean:
        shutil.rmtree(folder / "target", ignore_errors=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = ["cargo", "check", "-q"] if check else ["cargo", "build", "--release", "-q"]
    try:
        subprocess.run(command, cwd=folder, check=True, env=environment, timeout=limit)
    except subprocess.TimeoutExpired:
        return float("inf")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runtime", type=Path, default=HERE.parents[1] / "lagrange-runtime")
    parser.add_argument("--folder", type=Path, default=HERE / "target")
    parser.add_argument("--systems", default=",".join(SYSTEMS))
    parser.add_argument("--runs", default=";".join(RUNS), help="names of the columns, divided by semicolons")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=600)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--clean", action="store_true")
    options = parser.parse_args()
    folder = options.folder
    (folder / "src").mkdir(parents=True, exist_ok=True)
    (folder / "Cargo.toml").write_text(MANIFEST.replace("RUNTIME", str(options.runtime.resolve())))
    seconds(folder, "fn main() {}", None, options.check)
    runs = options.runs.split(";")
    print("| system | " + " | ".join(runs) + " |\n|---|" + "---|" * len(runs))
    for system in options.systems.split(","):
        print(f"| {system}", end="", flush=True)
        for run in runs:
            program = PROGRAM.replace("SYSTEMS", str(HERE / "systems.rs")).replace("SYSTEM", system)
            found = []
            for round in range(options.rounds):
                text = program.replace("RUN", RUNS[run]) + f"// {round}\n"
                found.append(seconds(folder, text, options.limit, options.check, options.clean))
            print(f" | {min(found):.2f}" if min(found) < float("inf") else f" | > {options.limit:.0f}", end="", flush=True)
        print(" |", flush=True)


if __name__ == "__main__":
    main()
