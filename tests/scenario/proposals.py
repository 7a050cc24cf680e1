"""Proposals as an operator meets them: ids that last, decisions that are remembered, pictures, and commands while it runs."""
import json
import os
import re
import signal
import subprocess
import time

import images
import programs

STATION = programs.STATION
folder, path = programs.work_folder()
made = programs.run(STATION, "simulate", "--out", path / "data", "--noise", 0, "--station-frames", 120, "--device-frames", 2, timeout=400)
programs.check(made.returncode == 0, "simulated data " + made.stderr)
data = path / "data"
FIRST, LATER, MOVED = 22, 37, 60  # frames: two before the box is moved by 2 cm, and one after
HIDDEN = 72  # bricks stand before the box that has moved: it is no move then


def new_scene(name):
    scene = path / name
    programs.run(STATION, "scene", "import", "--scene", scene, data / "model.ply")
    return scene


def adjust(scene, frame, *more):
    result = programs.run(STATION, "adjust", "--scene", scene, "--recording", data / "station", "--frames", frame, "--json", *more,
                          timeout=200)
    told = json.loads(result.stdout) if result.stdout else {}
    return result, (told.get("frames") or [{}])[-1]


def ids_of(frame):
    return {p["id"]: (p["kind"], p["state"]) for p in frame.get("proposals", [])}


def listed(scene, *more):
    result = programs.run(STATION, "scene", "proposals", "--scene", scene, "--json", *more)
    return {p["id"]: p for p in json.loads(result.stdout)["proposals"]}


def says(result, *words):
    return result.returncode == 1 and all(word in result.stderr for word in words) and len(result.stderr.splitlines()) == 1


def show(result):
    return f"exit {result.returncode}: {result.stderr.strip()}"


print("-- ids")
scene = new_scene("scene.db")
_, first = adjust(scene, FIRST, "--out", path / "pictures")
seen = ids_of(first)
programs.check(len(seen) >= 2 and sorted(seen) == list(range(1, len(seen) + 1)), f"ids begin with 1: {seen}")
boxes = {p["id"]: p["box_m"] for p in first["proposals"]}
for attempt in range(2):
    _, again = adjust(scene, FIRST)
    programs.check({p["id"]: p["box_m"] for p in again["proposals"]} == boxes, "the same command has the same ids")
_, elsewhere = adjust(scene, LATER)
programs.check(set(ids_of(elsewhere)) & set(seen) == set(ids_of(elsewhere)), f"from another place too: {ids_of(elsewhere)}")
for proposal in first["proposals"]:
    keys = {"id", "kind", "state", "accepted", "centre_m", "box_m", "effect", "confidence", "closes", "see_through", "pictures",
            "triangles_added", "triangles_removed", "largest_change_m", "first_seen_ns", "last_seen_ns"}
    programs.check(keys <= set(proposal), f"proposal {proposal['id']} says all: {sorted(keys - set(proposal))}")
    inside = all(low <= c <= high for low, c, high in zip(proposal["box_m"]["min"], proposal["centre_m"], proposal["box_m"]["max"]))
    programs.check(inside and "closes region" in proposal["effect"], f"... where, and what: {proposal['effect']}")
    width, height = images.png(path / "pictures" / proposal["pictures"]["proposal"])[:2]
    programs.check(proposal["pictures"]["proposal"] == f"proposal_{proposal['id']:04}.png" and width >= 640 and height >= 480,
                   f"... with a picture of {width} x {height}")

print("-- decisions")
keep, leave = 1, 2
result, frame = adjust(scene, FIRST, "--reject", leave, "--reason", "a toy; not öurs", "--operator", "Jörg")
programs.check(ids_of(frame)[leave][1] == "rejected" and frame["revision"] is None, f"rejected: {ids_of(frame)}")
record = listed(scene)[leave]
programs.check(record["reason"] == "a toy; not öurs" and record["author"] == "Jörg" and not record["accepted"],
               "who and why is remembered")
result, frame = adjust(scene, FIRST, "--accept", "all", "--operator", "anna", "--out", path / "pictures")
states = {id: state for id, (_, state) in ids_of(frame).items()}
programs.check(states.pop(leave) == "rejected" and set(states.values()) == {"accepted"}, f"accept all leaves it out: {ids_of(frame)}")
accepting = frame["revision"]
pictures = {p["id"]: p["pictures"] for p in frame["proposals"]}
programs.check(pictures[leave]["after"] is None and (path / "pictures" / pictures[keep]["after"]).exists()
               and (path / "pictures" / pictures[keep]["before"]).exists(), f"pictures before and after: {pictures[keep]}")
result, _ = adjust(scene, FIRST, "--accept", keep)
programs.check(says(result, f"proposal {keep} was accepted by revision {accepting}", "anna"), "accepting it again: " + show(result))
result, _ = adjust(scene, FIRST, "--reject", keep)
programs.check(says(result, f"accepted by revision {accepting}", "undo"), "rejecting it now: " + show(result))
result, _ = adjust(scene, FIRST, "--accept", 99)
programs.check(says(result, "there is no proposal 99"), "an id that is none: " + show(result))
result, _ = adjust(scene, FIRST, "--reject", 99)
programs.check(says(result, "there is no proposal 99"), "rejecting one that is none: " + show(result))
programs.check({id for id, p in listed(scene, "--state", "rejected").items()} == {leave}, "the list can be told by state")
_, frame = adjust(scene, LATER, "--accept", "all")
programs.check(all(state != "accepted" or id not in seen for id, (_, state) in ids_of(frame).items())
               and ids_of(frame).get(leave, ("", "rejected"))[1] == "rejected", f"from elsewhere it stays left out: {ids_of(frame)}")
last = json.loads(programs.run(STATION, "scene", "info", "--scene", scene, "--json").stdout)["revision"]

print("-- undo, redo, journal")
for _ in range(last - accepting + 1):
    programs.run(STATION, "scene", "undo", "--scene", scene, "--operator", "bert")
records = listed(scene)
programs.check(records[keep]["state"] == "open" and records[keep]["undone_revision"] == accepting and records[keep]["author"] == "bert",
               f"undo opens it again: {records[keep]['state']}")
_, frame = adjust(scene, FIRST)
programs.check(ids_of(frame) == {**seen, leave: (seen[leave][0], "rejected")}, f"under the same ids: {ids_of(frame)}")
programs.run(STATION, "scene", "redo", "--scene", scene)
programs.check(listed(scene)[keep]["state"] == "accepted", "redo closes it again")
programs.run(STATION, "scene", "undo", "--scene", scene)
_, frame = adjust(scene, FIRST, "--accept", f"{keep},{leave}", "--operator", "carl")
programs.check(frame["revision"] > accepting and {s for _, s in ids_of(frame).values()} >= {"accepted"}
               and listed(scene)[leave]["state"] == "accepted", "what was undone or rejected can be accepted by its id")
log = programs.run(STATION, "scene", "log", "--scene", scene, "--json", "--pictures", path / "journal")
revisions = {r["revision"]: r for r in json.loads(log.stdout)["revisions"]}
programs.check([p["id"] for p in revisions[accepting]["proposals"]] == [id for id in sorted(seen) if id != leave]
               and revisions[accepting]["author"] == "anna", "the journal has what each revision accepted")
entry = revisions[frame["revision"]]
programs.check([p["id"] for p in entry["proposals"]] == [keep, leave] and entry["snapshot"]["calibration"] and entry["author"] == "carl",
               "... and with what it was measured")
files = [file for r in revisions.values() for file in r["picture_files"]]
programs.check(len(files) >= 2 and all(images.png(path / "journal" / file)[0] >= 640 for file in files), f"its pictures: {files}")

print("-- what moved, and what is gone")
moved = path / "moved.db"
programs.run(STATION, "scene", "import", "--scene", moved, data / "model_before_move.ply")
_, frame = adjust(moved, MOVED)
there = {p["kind"]: p for p in frame["proposals"]}
programs.check(list(there) == ["move"], f"a move, and nothing else: {ids_of(frame)}")
_, frame = adjust(moved, HIDDEN)
there |= {p["kind"]: p for p in frame["proposals"] if p["kind"] == "removal"}
programs.check("removal" in there, f"what is seen through goes: {ids_of(frame)}")
evidence = there["removal"]["see_through"]
programs.check(0 < evidence["seen_through_px"] <= evidence["measured_px"] <= evidence["visible_px"]
               and abs(evidence["share"] - evidence["seen_through_px"] / evidence["visible_px"]) < 1e-9
               and there["removal"]["confidence"] == evidence["share"] and 0.01 < evidence["behind_m"] < 0.5
               and evidence["behind_sigmas"] > 3, f"the removal says what speaks for it: {evidence}")
_, frame = adjust(moved, MOVED, "--accept", there["move"]["id"], "--operator", "anna")
log = programs.run(STATION, "scene", "log", "--scene", moved, "--json")
entry = json.loads(log.stdout)["revisions"][-1]
way = sum(x * x for x in entry["proposals"][0]["T_world_new_old"]["translation"]) ** 0.5
programs.check(entry["revision"] == frame["revision"] and entry["proposals"][0]["kind"] == "move" and 0.018 < way < 0.022
               and entry["proposals"][0]["confidence"] == there["move"]["confidence"] > 0.9 and entry["author"] == "anna"
               and entry["snapshot"]["T_world_depth"] and entry["proposals"][0]["nodes"] == there["move"]["nodes"],
               f"the journal has the move, by {1000 * way:.1f} mm")
programs.run(STATION, "scene", "undo", "--scene", moved)
_, frame = adjust(moved, MOVED)
programs.check(there["move"]["id"] in ids_of(frame), "undone it is proposed under its id again")

print("-- usage")
for what, *more in (("an id of zero", "--reject", "0"), ("ids that are none", "--reject", "one"), ("a reason for nothing", "--reason", "x"),
                    ("both at once", "--accept", "2", "--reject", "2"), ("a name of blanks", "--operator", "  "),
                    ("a name of 101 letters", "--operator", "a" * 101), ("a name that turns", "--operator", "a\u202eb"),
                    ("a reason of two lines", "--reject", "2", "--reason", "a\nb")):
    result, _ = adjust(scene, FIRST, *more)
    programs.check(result.returncode == 2 and len(result.stderr.splitlines()) == 1, f"{what}: {show(result)}")
result = programs.run(STATION, "run", "--scene", scene, "--source", f"recording:{data / 'station'}", "--markers", data / "markers.yaml",
                      "--sure-change", "0.1")
programs.check(result.returncode == 2 and "--accept sure" in result.stderr, "limits without a rule: " + show(result))

print("-- a scene that may not be written")
locked = new_scene("locked.db")
adjust(locked, FIRST)
command = [STATION, "run", "--scene", locked, "--source", f"recording:{data / 'station'}", "--markers", data / "markers.yaml",
           "--fast", "--json", "--domain", str(1 + os.getpid() % 200)]


def start(*more, scene=locked):
    command[3] = scene
    return subprocess.Popen([str(c) for c in command + list(more)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL, text=True)


class Running:
    """A station with commands; reads events as they come."""

    def __init__(self, *more, scene):
        self.process = start(*more, "--commands", "--serve", "60", scene=scene)
        self.events = []

    def until(self, wanted):
        for line in self.process.stdout:
            self.events.append(json.loads(line))
            if wanted(self.events[-1]):
                return self.events[-1]
        return {}

    def do(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.until(lambda e: e["event"] == "command" and e["command"] == line)

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=30)


station = Running("--accept", "none", scene=locked)
station.until(lambda e: e["event"] == "end")
result, frame = adjust(locked, FIRST)
programs.check(result.returncode == 0 and set(ids_of(frame)) <= {*seen, None} and "warning" in result.stderr,
               f"beside a running station proposals are only looked at: {ids_of(frame)}")
result, _ = adjust(locked, FIRST, "--accept", "all")
programs.check(result.returncode == 1, "and not accepted: " + show(result))

print("-- commands while it runs")
shown = [e for e in station.events if e["event"] == "proposals"]
programs.check(bool(shown) and all(p["left_out"] for e in shown for p in e["proposals"]), f"{len(shown)} times something is proposed")
offered = [p["id"] for p in shown[-1]["proposals"]]
programs.check(len(offered) >= 1, f"the last frame proposes {offered}")
for wrong in ("accept", "accept 9999", "acept 1", "reject 9999", "redo", "x" * 5000):
    station.process.stdin.write(wrong + "\n")
    station.process.stdin.flush()
    answer = station.until(lambda e: e["event"] == "command")
    programs.check(answer.get("refused"), f"'{wrong[:20]}': {answer.get('refused')}")
answer = station.do("undo")
programs.check("scene undo" in (answer.get("refused") or "") and answer["revision"] == 1, f"the import stays: {answer.get('refused')}")
one = offered[0]
answer = station.do(f"accept {one}")
revision = next((e for e in station.events if e["event"] == "revision"), {})
programs.check(answer.get("refused") is None and revision.get("proposals") == [one], f"accept {one}: {revision.get('summary')}")
answer = station.do(f"accept {one}")
programs.check("accepted by revision" in (answer.get("refused") or ""), f"again: {answer.get('refused')}")
answer = station.do("undo")
again = [e for e in station.events if e["event"] == "proposals"][-1]
programs.check(answer.get("refused") is None and one in [p["id"] for p in again["proposals"]], "undo offers it again")
answer = station.do(f"reject {one} not today")
programs.check(answer.get("refused") is None, f"reject {one}")
answer = station.do("accept all")
station.do("list")
station.process.stdin.close()
programs.check(station.until(lambda e: e["event"] == "commands_ended") != {} and station.process.poll() is None,
               "the end of the commands is not the end of the station")
programs.check(station.end() == 0, "it ends well")
records = listed(locked)
programs.check(records[one]["state"] == "rejected" and records[one]["reason"] == "not today", "what was rejected is remembered")

print("-- without asking")
told, _ = start("--accept", "all").communicate(timeout=200)
events = [json.loads(line) for line in told.splitlines()]
accepted = {id for e in events if e["event"] == "revision" for id in e["proposals"]}
programs.check(one not in accepted and listed(locked)[one]["state"] == "rejected", f"accept all leaves {one} out: {sorted(accepted)}")
reasons = [p["left_out"] for e in events if e["event"] == "proposals" for p in e["proposals"] if p["id"] == one]
programs.check(bool(reasons) and all("not today" in r for r in reasons), f"and says why: {set(reasons)}")
sure = new_scene("sure.db")
told, _ = start("--accept", "sure", "--sure-confidence", "0.5", "--sure-change", "0.001", scene=sure).communicate(timeout=200)
events = [json.loads(line) for line in told.splitlines()]
programs.check(not [e for e in events if e["event"] == "revision"]
               and any("more than 1" in p["left_out"] for e in events if e["event"] == "proposals" for p in e["proposals"]),
               "nothing is sure to change by less than a millimetre")
told, _ = start("--accept", "sure", "--sure-confidence", "0", "--sure-change", "100", scene=sure).communicate(timeout=200)
programs.check('"event":"revision"' in told, "everything that the model can be compared with is sure within 100 m")

print("-- markers that are 2 cm off")
misplaced = path / "misplaced.yaml"
misplaced.write_text(re.sub(r"- \[(\S+), (\S+), (\S+)\]", lambda c: f"- [{c[1]}, {c[2]}, {float(c[3]) + 0.02}]",
                            (data / "markers.yaml").read_text()))


def run_misplaced(*more):
    """Its end, how many frames were withheld, and the event at its end."""
    result = programs.run(*command[:2], "--scene", new_scene(f"misplaced{more[1]}.db"), *command[4:6], "--markers", misplaced, *command[8:],
                          *more, timeout=200)
    told = [json.loads(line) for line in result.stdout.splitlines()]
    return result, [e for e in told if e["event"] == "withheld"], told[-1]


result, withheld, end = run_misplaced("--accept", "all")
programs.check(says(result, "no frame could be used", "check the given pose or trajectory", "markers' file"), show(result))
programs.check(end["event"] == "end" and end["changes"]["withheld"] == end["changes"]["looked_at"] == len(withheld) > 10
               and "markers' file" in end["changes"]["reason"], f"the end says it too: {end}")

result, withheld, end = run_misplaced("--accept", "none")
programs.check(says(result, "no frame could be used", "markers' file") and 1 <= len(withheld) <= 13 and end["revision"] <= 1,
               f"without a rule it is looked at once a second: {len(withheld)} of {end['changes']['confirmed']} frames; {show(result)}")
unknown = new_scene("unknown.db")
told, _ = start("--accept", "none", scene=unknown).communicate(timeout=200)
end = json.loads(told.splitlines()[-1])
programs.check(end["changes"]["looked_at"] > 0 == end["changes"]["withheld"] and not listed(unknown), f"... and nothing is proposed: {end}")

print("-- what the rule leaves out beside what it accepts")
partly = new_scene("partly.db")
adjust(partly, FIRST, "--reject", leave, "--reason", "not this one")
station = Running("--accept", "all", scene=partly)
station.until(lambda e: e["event"] == "end")
revisions = [i for i, e in enumerate(station.events) if e["event"] == "revision"]
lists = [i for i, e in enumerate(station.events) if e["event"] == "proposals" and e["proposals"]]
beside = [(i, k) for i in revisions for k in lists if station.events[i]["frame"] == station.events[k]["frame"]]
programs.check(bool(beside) and all(i < k for i, k in beside),
               f"{len(revisions)} revisions; of {len(beside)} the rest of the frame is told afterwards")
programs.check(all(not set(station.events[i]["proposals"]) & {p["id"] for p in station.events[k]["proposals"]} for i, k in beside),
               "... and only the rest")
rest = [p["id"] for p in station.events[lists[-1]]["proposals"] if p["left_out"]] if lists else []
programs.check(leave in rest, f"what was told last, {rest}, has what was rejected")
answer = station.do(f"accept {leave}")
programs.check(answer.get("refused") is None and listed(partly)[leave]["state"] == "accepted",
               f"what was told can be accepted: {answer.get('refused')}")
programs.check(station.end() == 0, "it ends well")

print("-- what moved, in a room that is one mesh")
room = path / "room.db"
programs.run(STATION, "scene", "import", "--scene", room, data / "model_before_move.ply")
for frame in (84, 91, 98, 110):  # the box has come nearer, and hides where it was; in the last one it went aside
    _, seen = adjust(room, frame)
    moves = [p["effect"] for p in seen["proposals"] if "moves" in p["effect"]]
    programs.check(len(moves) == 1 and len(seen["proposals"]) == 1 and "by 20 mm and 0 degrees" in moves[0],
                   f"frame {frame}: {[p['effect'] for p in seen['proposals']]}")
programs.end()
