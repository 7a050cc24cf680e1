"""kill -9 in the middle of accepting: every revision that was reported is there, and the device catches up."""
import json
import os
import random
import signal
import subprocess
import time

import programs

ROUNDS = 6


def start_station(path, domain):
    log = open(path / "station.jsonl", "w+")
    process = subprocess.Popen(
        [programs.STATION, "run", "--scene", path / "scene.db", "--name", "killed", "--domain", str(domain), "--source",
         f"recording:{path / 'data' / 'station'}", "--markers", path / "data" / "markers.yaml", "--accept", "all",
         "--serve", "-1", "--fast", "--json"], stdout=log, stderr=subprocess.DEVNULL)
    return process, log


def events(path):
    lines = (path / "station.jsonl").read_text().splitlines()
    complete = []
    for line in lines:
        try:
            complete.append(json.loads(line))
        except json.JSONDecodeError:
            pass  # the line that the kill cut off
    return complete


def wait_until(condition, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def reported(path):
    return [e["revision"] for e in events(path) if e["event"] == "revision"]


folder, path = programs.work_folder()
domain = 1 + os.getpid() % 200
made = programs.run(programs.STATION, "simulate", "--out", path / "data", "--device-frames", 40, timeout=200)
programs.check(made.returncode == 0, "simulated data " + made.stderr)
device = subprocess.Popen(
    [programs.DEVICE, "run", "--scene", "killed", "--domain", str(domain), "--camera",
     f"recording:{path / 'data' / 'device_after_move'}", "--loop", "--init", f"markers:{path / 'data' / 'markers.yaml'}",
     "--display", f"offscreen:{path / 'views'}", "--every", "1000", "--json"],
    stdout=open(path / "device.jsonl", "w"), stderr=subprocess.DEVNULL)
source = random.Random(1)
most = 0
for round_ in range(ROUNDS):
    for name in ("scene.db", "scene.db-wal", "scene.db-shm"):
        if round_ == 0:
            (path / name).unlink(missing_ok=True)
    if round_ == 0:
        programs.run(programs.STATION, "scene", "import", "--scene", path / "scene.db", path / "data" / "model.ply")
    station, log = start_station(path, domain)
    if round_ == 0:
        wait_until(lambda: len(reported(path)) >= 1, 60)
    else:
        wait_until(lambda: len(events(path)) >= 2, 60)
    time.sleep(source.uniform(0, 0.6))
    station.send_signal(signal.SIGKILL)
    station.wait()
    last = max(reported(path), default=0)
    most = max(most, last)
    info = programs.run(programs.STATION, "scene", "info", "--scene", path / "scene.db", "--json")
    present = json.loads(info.stdout)["revision"] if info.returncode == 0 else -1
    programs.check(present >= max(last, 1), f"round {round_}: revision {last} was reported, {present} is in the store")
programs.check(most > 1, f"revisions were reported, up to {most}")

station, log = start_station(path, domain)
programs.check(wait_until(lambda: any(e["event"] == "end" for e in events(path)), 120), "the restarted station goes on to the end")
final = [e["revision"] for e in events(path) if e["event"] == "end"]
drawn = f'"revision":{final[0]}}}' if final else "none"
programs.check(wait_until(lambda: drawn in (path / "device.jsonl").read_text(), 60),
               f"the device, which was never restarted, draws revision {final}")
station.terminate()
device.terminate()
programs.check(station.wait() == 0 and device.wait() == 0, "both end well when they are told to")
programs.end()
