"""What Taylor series cost a compiler: `python3 benches/peers/build.py [links …]`.

A program with one planar chain of unit links (2, 6, 10 and 20 of them unless told otherwise), compiled with optimisation (`cargo build --release`, dependencies compiled
before) when it asks for the accelerations only, when it integrates by DOP853, and when it integrates by Taylor series. Printed are the shortest of three wall times, and how much longer
series take than accelerations. heyoka's: `compare.py --chain`, the first time (it keeps what it compiled).
"""

import os
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
CRATE = HERE / "target" / "build"
LINKS = [int(word) for word in sys.argv[1:]] or [2, 6, 10, 20]
RUNS = [
    "Ok::<_, ()>(chain.accel(&start.q, &start.qd, start.t))",
    "integrate(&chain, Dop853, PiController::tolerance(1e-12), start).until(1.0).final_state()",
    "integrate(&chain, Taylor::for_tolerance(1e-15), TaylorController::tolerance(1e-15), start).until(1.0).final_state()",
]

MANIFEST = f"""[workspace]
[package]
name = "chain"
version = "0.0.0"
edition = "2024"
[dependencies]
lagrange-runtime = {{ path = "{HERE.parents[1] / 'lagrange-runtime'}" }}
"""

PROGRAM = """#[macro_use]
#[path = "CHAIN"]
mod chain;
use lagrange_runtime::prelude::*;
chain!(Chain, LINKS);
fn main() {
    let (chain, start) = (Chain::default(), State::new(0.0, [0.5; LINKS], [0.0; LINKS]));
    println!("{:?}", RUN);
}
"""


def seconds(program):
    """The shortest of three, without what it depends on."""
    (CRATE / "src" / "main.rs").write_text(program)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(CRATE / "target"), "CARGO_INCREMENTAL": "0"}
    found = []
    for _ in range(4):
        (CRATE / "src" / "main.rs").touch()
        began = time.perf_counter()
        subprocess.run(["cargo", "build", "--release", "-q"], cwd=CRATE, check=True, env=environment)
        found.append(time.perf_counter() - began)
    return min(found[1:])


(CRATE / "src").mkdir(parents=True, exist_ok=True)
(CRATE / "Cargo.toml").write_text(MANIFEST)
print("| links | accelerations, s | DOP853, s | Taylor series, s | more for series, s |")
print("|---|---|---|---|---|")
for links in LINKS:
    program = PROGRAM.replace("CHAIN", str(HERE / "src" / "chain.rs")).replace("LINKS", str(links))
    found = [seconds(program.replace("RUN", run)) for run in RUNS]
    cells = " | ".join(f"{time:.2f}" for time in [*found, found[2] - found[0]])
    print(f"| {links} | {cells} |")
