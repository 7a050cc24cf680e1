"""Running the programs from a test."""
import os
import pathlib
import subprocess
import sys
import tempfile

BIN = pathlib.Path(os.environ["MESHLOOP_BIN"])
SOURCE = pathlib.Path(os.environ["MESHLOOP_SOURCE"])
STATION = BIN / "meshloop-station"
DEVICE = BIN / "meshloop-device"
SKIPPED = 77

failures = []


def run(*command, timeout=120):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=timeout)


def check(good, what):
    print(("ok    " if good else "WRONG ") + what, flush=True)
    if not good:
        failures.append(what)


def end():
    if failures:
        print(f"{len(failures)} wrong")
    sys.exit(1 if failures else 0)


def skip(why):
    print("skipped:", why)
    sys.exit(SKIPPED)


def work_folder():
    folder = tempfile.TemporaryDirectory(prefix="meshloop-")
    return folder, pathlib.Path(folder.name)
