"""Runs the commands that the README shows, in a fresh clone, and says where their output differs from what it shows.

    python tools/release/readme.py [--clone DIR] [--only TEXT] [--except TEXT]

Every block of the README that begins with `cargo` is a list of commands; a block right after it is what the last of
them prints. A command that fails fails the run. Output is compared line by line with every number
taken for the same, so that times and the last digits of other processors do not count.
"""

import argparse
import difflib
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def commands(text):
    """Pairs of a command and what it is shown to print, or None."""
    blocks = list(BLOCK.finditer(text))
    for block, following in zip(blocks, [*blocks[1:], None]):
        lines = block[1].splitlines()
        if not lines[0].startswith("cargo "):
            continue
        is_next = following and not text[block.end():following.start()].strip()
        shown = following[1] if is_next and not following[1].startswith("cargo ") else None
        yield from ((line, None) for line in lines[:-1])
        yield lines[-1], shown


def alike(text):
    """Lines without their numbers."""
    return [re.sub(r"\s+", " ", re.sub(r"[-<>]?\s*\d+(\.\d+)?", "#", line)).strip() for line in text.strip().splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clone", type=Path, help="keep the clone here; one that is there is used as it is")
    parser.add_argument("--only", action="append", default=[], help="commands that contain one of these")
    parser.add_argument("--except", action="append", default=[], dest="but", help="no commands that contain one of these")
    args = parser.parse_args()
    clone = args.clone or Path(tempfile.mkdtemp()) / "mlr"
    if not clone.exists():
        subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    failed = 0
    for command, shown in commands((clone / "README.md").read_text()):
        if args.only and not any(text in command for text in args.only) or any(text in command for text in args.but):
            print(f"left out  {command}")
            continue
        began = time.monotonic()
        done = subprocess.run(command, shell=True, cwd=clone, capture_output=True, text=True)
        took = f"{time.monotonic() - began:6.1f} s"
        if done.returncode != 0:
            failed += 1
            print(f"{took}  FAILED {done.returncode}  {command}\n{done.stderr[-2000:]}")
            continue
        different = []
        if shown is not None:
            lines = difflib.unified_diff(alike(shown), alike(done.stdout), "README", "now", lineterm="", n=0)
            different = [line for line in lines if not line.startswith(("---", "+++", "@@"))]
        print(f"{took}  {'other output' if different else 'as shown' if shown is not None else 'done'}  {command}")
        for line in different:
            print(f"          {line}")
        sys.stdout.flush()
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
