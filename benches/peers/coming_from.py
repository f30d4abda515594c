"""The Python programs of docs/guide/src/coming-from.md, as the page shows them:
`python3 benches/peers/coming_from.py`.

Makes a virtual environment in benches/peers/target. The page shows the numbers that its Lagrange listing prints; the
tests of the guide check these. Fails if a program prints others.
"""

import re
import subprocess
import sys
from pathlib import Path

from environment import HERE, enter

PAGE = HERE.parent.parent / "docs/guide/src/coming-from.md"
WORK = HERE / "target" / "coming_from"

enter(
    "venv-coming-from",
    "sympy==1.14.0 scipy==1.17.1 heyoka==7.13.2 mujoco==4.0.0 drake==1.51.1 diffrax==0.7.2 jax==0.10.2".split(),
)


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


expected = blocks("text")[0]
WORK.mkdir(parents=True, exist_ok=True)
(WORK / "cart_pole.xml").write_text(blocks("xml")[0])
failed = []
for program in blocks("python"):
    tool = re.search(r"^(?:import|from) (sympy|heyoka|mujoco|pydrake|diffrax)", program, re.MULTILINE)[1]
    run = subprocess.run([sys.executable, "-c", program], cwd=WORK, stdout=subprocess.PIPE, text=True, check=True)
    print(f"{tool:8} {run.stdout.strip()}")
    if run.stdout != expected:
        failed.append(tool)
if failed:
    sys.exit(f"{', '.join(failed)}: not {expected.strip()}")
