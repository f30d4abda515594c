"""Virtual environments of the scripts beside it, each made when its script runs first."""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent


def enter(name, packages):
    """Goes on as the script was called, with these packages, in the environment `target/name`."""
    environment = HERE / "target" / name
    if Path(sys.prefix) == environment:
        return
    python = environment / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", environment], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *packages], check=True)
    os.execv(python, [python, *sys.argv])
