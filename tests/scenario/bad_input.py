"""Bad input of every kind: one clear sentence, the exit code of the design (1 failed, 2 wrong usage), never a crash."""
import json
import pathlib
import shutil

import programs

STATION, DEVICE = programs.STATION, programs.DEVICE


def refused(what, code, *command, says=None):
    result = programs.run(*command, timeout=200)
    lines = [line for line in result.stderr.splitlines() if line.strip() and "warning:" not in line]
    words = " / ".join(lines)[:300]
    good = result.returncode == code and len(lines) == 1 and "anitizer" not in result.stderr
    if says and says not in result.stderr:
        good = False
    programs.check(good, f"{what}: exit {result.returncode} (want {code}): {words}")


folder, path = programs.work_folder()
made = programs.run(STATION, "simulate", "--out", path / "data", "--noise", 0, "--station-frames", 12, "--device-frames", 2, timeout=400)
programs.check(made.returncode == 0, "simulated data " + made.stderr)
data = path / "data"
model, station = data / "model.ply", data / "station"


def detect(*more, the_model=model, recording=station, frames="0"):
    return (STATION, "detect", "--model", the_model, "--recording", recording, "--frames", frames, "--out", path / "out", *more)


good = programs.run(*detect(), timeout=200)
programs.check(good.returncode == 0, "the same command with good input works: " + good.stderr)


def write(name, content):
    file = path / name
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return file


def damaged_recording(name, file, content):
    copy = path / name
    shutil.copytree(station, copy)
    (copy / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    return copy


print("-- output that cannot be written")
full = programs.run("sh", "-c", 'exec "$0" "$@" >/dev/full', *detect("--json"))
programs.check(full.returncode == 1 and "cannot be written" in full.stderr, "a full disk behind the output: " + full.stderr)
programs.check(programs.run(STATION, "scene", "import", "--scene", path / "small.db", model).returncode == 0, "a scene is made")
small = programs.run("sh", "-c", 'ulimit -f 200; exec "$0" "$@"', STATION, "scene", "export", "--scene", path / "small.db", path / "small.ply")
programs.check(small.returncode == 1 and len(small.stderr.splitlines()) == 1 and "small.ply" in small.stderr,
               f"a file that may not grow: exit {small.returncode}: {small.stderr}")
print("-- usage")
refused("no subcommand", 2, STATION)
refused("an unknown subcommand", 2, STATION, "detekt", "--model", model, says="'detekt' is no subcommand")
refused("an unknown option before the subcommand", 2, STATION, "--went", says="no option '--went'")
there = sorted((path / "out").iterdir())
refused("a frame after the last", 2, *detect(frames="10-13"), says="frame 12 is not in the recording, which has frames 0 to 11")
programs.check(sorted((path / "out").iterdir()) == there, "that was said before anything was done")
refused("an unknown subcommand of scene", 2, STATION, "scene", "look", "--scene", path / "x.db", says="'look' is no subcommand of scene")
refused("unknown option", 2, STATION, "detect", "--nonsense")
for option in ("--markers", "--poses", "--rig", "--sensor", "--init", "--truth"):
    refused(f"an empty {option}", 2, *detect(option, ""), says=option + " ")
refused("an empty --frames", 2, *detect(frames=""), says="--frames ")
refused("an empty --accept", 2, STATION, "adjust", "--scene", path / "x.db", "--recording", station, "--frames", "0", "--accept", "",
        says="--accept ")
refused("a comma too many in --accept", 2, STATION, "adjust", "--scene", path / "x.db", "--recording", station, "--frames", "0",
        "--accept", "1,", says="not '1,'")
refused("a comma too many in --frames", 2, *detect(frames="0,"), says="'0,'")
refused("an operator without a name", 2, STATION, "adjust", "--scene", path / "x.db", "--recording", station, "--frames", "0",
        "--operator", "", says="--operator ")
refused("an operator with two lines", 2, STATION, "scene", "undo", "--scene", path / "x.db", "--operator", "a\nb", says="control")
refused("an empty folder for pictures", 2, DEVICE, "track", "--model", model, "--recording", data / "device_after_move",
        "--init", "pose:0,0,0,0,0,0,1", "--out", path / "p.txt", "--draw=", says="--draw ")
refused("unknown threshold", 2, *detect("--threshold", "2 apples"))
refused("negative threshold", 2, *detect("--threshold=-0.1"))
refused("a threshold of three metres", 2, *detect("--threshold", "3"), says="3sigma")
refused("poses given and to be found", 2, *detect("--poses", station / "groundtruth.txt", "--markers", data / "markers.yaml"))
refused("frames that are no list", 2, *detect(frames="a-b"))
refused("a frame past the end", 2, *detect(frames="5000"), says="5000")
refused("a pose that is not a number", 2, *detect("--init", "pose:nan,0,0,0,0,0,1"))
refused("a pose with six numbers", 2, *detect("--init", "pose:0,0,0,0,0,1"))
refused("an unknown source", 2, STATION, "run", "--scene", path / "x.db", "--source", "webcam:0")
refused("an unknown display", 2, DEVICE, "run", "--scene", "s", "--camera", f"recording:{data / 'device_after_move'}",
        "--display", "hologram", "--init", "pose:0,0,0,0,0,0,1")
refused("an unknown camera", 2, DEVICE, "run", "--scene", "s", "--camera", "pinhole", "--display", f"offscreen:{path / 'v'}",
        "--init", "pose:0,0,0,0,0,0,1")
for what, *option in (("a place that is not a number", "--object-at", "nan,0,0"), ("a direction of no length", "--object-up", "0,0,0"),
                      ("a height of NaN", "--object-height", "nan"), ("a negative time", "--seconds=-5")):
    refused(what, 2, DEVICE, "run", "--scene", "s", "--camera", f"recording:{data / 'device_after_move'}", "--display",
            f"offscreen:{path / 'v'}", "--init", "pose:0,0,0,0,0,0,1", *option)
refused("a scene that nobody serves", 1, DEVICE, "run", "--scene", "nobody", "--domain", 219, "--camera",
        f"recording:{data / 'device_after_move'}", "--display", f"offscreen:{path / 'v'}", "--init", "pose:0,0,0,0,0,0,1",
        "--seconds", 1, says="nobody")
refused("a start pose from which nothing is seen", 1, DEVICE, "track", "--model", model, "--recording", data / "device_after_move",
        "--init", "pose:0,0,9,0,0,0,1", "--out", path / "p.txt", says="every frame is lost")

refused("an unknown sensor", 2, *detect("--sensor", "kinect9"), says="constant:METRES")
refused("a sensor without noise", 2, *detect("--sensor", "constant:0"), says="above 0")
refused("a tolerance beside a fixed threshold", 2, *detect("--threshold", "0.02", "--model-sigma", "0.01"), says="sigmas")
refused("an average of a moving camera", 1, *detect("--average", "2", frames="0-3"), says="moved")
refused("a calibration of nothing", 2, STATION, "calibrate", "--recording", station, "--out", path / "rig.yaml")
refused("noise of too few frames", 1, STATION, "calibrate", "--noise", "--recording", station, "--out", path / "rig.yaml",
        says="at least 20")
refused("a size that is none", 2, STATION, "simulate", "--out", path / "s", "--color-size", "640")
refused("pictures of four pixels", 2, STATION, "simulate", "--out", path / "s", "--depth-size", "4x4", says="4x4")
refused("an unknown palette", 2, *detect("--palette", "rainbow"))
refused("an opacity below nothing", 2, *detect("--opacity=-1"))
blind = programs.run(*detect("--threshold", "100sigma", "--model-sigma", "0.1"))
programs.check(blind.returncode == 0 and "nothing can be told at this threshold" in blind.stdout and "0.25 m" in blind.stdout,
               f"a threshold above all that can be told: exit {blind.returncode}: {blind.stdout}")

print("-- models")
refused("no such model", 1, *detect(the_model=path / "none.ply"), says="none.ply")
refused("a model with no triangles", 1, *detect(the_model=write("points.obj", "v 0 0 0\nv 1 0 0\n")))
refused("indices out of range", 1, *detect(the_model=write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")))
refused("an empty model file", 1, *detect(the_model=write("empty.ply", b"")))
refused("half a model file", 1, *detect(the_model=write("half.ply", model.read_bytes()[: model.stat().st_size // 2])))
refused("a model of no known kind", 1, *detect(the_model=write("model.xyz", "1 2 3")))
refused("a folder as model", 1, *detect(the_model=data))
refused("the device's model", 1, DEVICE, "track", "--model", path / "none.ply", "--recording", data / "device_after_move",
        "--init", "pose:0,0,0,0,0,0,1", "--out", path / "p.txt")

print("-- recordings")
refused("no such recording", 1, *detect(recording=path / "none"), says="none")
rig = (station / "rig.yaml").read_text()
refused("a rig with a NaN", 1, *detect(recording=damaged_recording("nan", "rig.yaml", rig.replace("fx: 525", "fx: .nan"))), says="rig.yaml")
refused("a rig without depth", 1, *detect(recording=damaged_recording("nodepth", "rig.yaml", rig.split("depth:")[0])), says="rig.yaml")
refused("depth of another resolution", 1,
        *detect(recording=damaged_recording("size", "rig.yaml", rig.replace("depth: {width: 640, height: 480", "depth: {width: 320, height: 240"))),
        says="640x480")
def with_rig(name, before, after):
    return damaged_recording(name, "rig.yaml", rig.replace(before, after, 1))


refused("a unit of depth of five kilometres", 1,
        *detect(recording=with_rig("unit", "depth_scale: 0.00025", "depth_scale: 5000")), says="0.0002")
refused("a lens with six coefficients", 1, *detect(recording=with_rig("six", "[0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 0]")), says="5 or 8")
refused("a lens that folds the picture over", 1,
        *detect(recording=with_rig("fold", "[0, 0, 0, 0, 0]", "[-3, 0, 0, 0, 0]")), says="folds")
refused("registered depth with a camera of its own", 1,
        *detect(recording=with_rig("registered", "depth_registered: false", "depth_registered: true")), says="must repeat")
refused("poses that are not numbers", 1, *detect("--poses", write("nan.txt", "1.0 nan 0 0 0 0 0 1\n")), says="nan.txt")
refused("no such poses", 1, *detect("--poses", path / "none.txt"), says="none.txt")
refused("markers that are none", 1, *detect("--markers", write("markers.yaml", "dictionary: NO\nmarkers: 7\n")), says="markers.yaml")
first = "000001.png"
cut = damaged_recording("cut", f"depth/{first}", (station / "depth" / first).read_bytes()[:2000])
refused("a truncated PNG", 1, *detect(frames="0-2", recording=cut), says=first)

print("-- what was done before an error")


def reported(name, *command):
    """The JSON of a command that fails at frame 3."""
    result = programs.run(*command, "--json", timeout=200)
    told = json.loads(result.stdout) if result.stdout else {}
    programs.check(result.returncode == 1 and "000003.png" in told.get("error", ""), f"{name} ends with the error: {result.stderr}")
    programs.check([frame["index"] for frame in told.get("frames", [])] == [0, 1, 2], f"{name} reports the frames before it")
    return told


damaged = damaged_recording("damaged", "depth/000003.png", b"no picture")
stale = ("labels_000077.png", "overlay_depth_000077.png", "region_0077.png")
kept = ("labels_77.png", "labels_000077.png.txt", "difference_mine.tiff", "notes.txt")
for name in stale + kept:
    write(f"out/{name}", "x")
(path / "out" / "overlay_000078.png").mkdir()
told = reported("detect", *detect(recording=damaged, frames="0-5"))
left = {file.name for file in (path / "out").iterdir()}
programs.check(not left & set(stale) and set(kept) < left and "overlay_000078.png" in left and told.get("removed_files", 0) >= 3,
               f"detect removes its own files of an earlier run, and nothing else: {sorted(left)}")
(path / "out" / "overlay_000078.png").rmdir()
poses = path / "damaged.txt"
reported("track", STATION, "track", "--recording", damaged, "--markers", data / "markers.yaml", "--out", poses)
programs.check(poses.exists() and len([line for line in poses.read_text().splitlines() if line[0] != "#"]) == 3,
               "track writes the poses before it")
told = reported("adjust", STATION, "adjust", "--scene", path / "small.db", "--recording", damaged, "--frames", "0-5", "--accept", "all")
programs.check(told.get("revision", 0) > 1, "adjust tells the revision that it made before it")

print("-- every frame lost")
other = write("other.yaml", (data / "markers.yaml").read_text().replace("DICT_4X4", "DICT_5X5"))
refused("track without a marker that is known", 1, STATION, "track", "--recording", station, "--markers", other, "--out", path / "p.txt",
        says="every frame is lost")
refused("detect without a marker that is known", 1, *detect("--markers", other), says="every frame is lost")
refused("adjust without a marker that is known", 1, STATION, "adjust", "--scene", path / "small.db", "--recording", station,
        "--frames", "0", "--markers", other, says="every frame is lost")

print("-- poses that are not where they say")
poses = [line.split() for line in (station / "groundtruth.txt").read_text().splitlines() if line[0] != "#"]
shifted = write("shifted.txt", "".join(" ".join([time, str(float(x) + 0.02), *more]) + "\n" for time, x, *more in poses))
programs.run(STATION, "scene", "import", "--scene", path / "shifted.db", model, timeout=200)
adjust = (STATION, "adjust", "--scene", path / "shifted.db", "--recording", station, "--frames", "0")
for what, accept in (("all", ("--accept", "all")), ("an id", ("--accept", "1")), ("nothing", ())):
    refused(f"adjust with {what} accepted", 1, *adjust, "--poses", shifted, *accept, says="check the given pose or trajectory")
log = programs.run(STATION, "scene", "log", "--scene", path / "shifted.db", "--json")
programs.check(len(json.loads(log.stdout)["revisions"]) == 1, "nothing was committed: " + log.stdout[:200])
right = programs.run(*adjust, "--accept", "all", timeout=200)
programs.check("revision 2" in right.stdout, f"with the right poses it is: {right.stdout}{right.stderr}")

print("-- scene files")
scene = path / "scene.db"
imported = programs.run(STATION, "scene", "import", "--scene", scene, model, timeout=200)
programs.check(imported.returncode == 0, "a scene is made: " + imported.stderr)
content = bytearray(scene.read_bytes())
refused("no such scene", 1, STATION, "scene", "info", "--scene", path / "none.db", says="none.db")
refused("not a scene", 1, STATION, "scene", "info", "--scene", write("text.db", "hello " * 1000))
refused("half a scene", 1, STATION, "scene", "info", "--scene", write("half.db", bytes(content[: len(content) // 2])))
for offset in range(100, len(content), max(1, len(content) // 40)):
    content[offset] ^= 0x5A
refused("a scene with flipped bytes", 1, STATION, "scene", "info", "--scene", write("flipped.db", bytes(content)))
twice = programs.run(STATION, "adjust", "--scene", scene, "--recording", station, "--frames", "0", "--accept", "1,1", timeout=200)
programs.check(twice.returncode == 0 and "revision 2" in twice.stdout, f"an id that is given twice counts once: {twice.stdout}{twice.stderr}")
undone = programs.run(STATION, "scene", "undo", "--scene", scene, "--operator", "anna")
log = programs.run(STATION, "scene", "log", "--scene", scene).stdout
programs.check("anna: undo of revision 2" in log, "an undo has an author: " + log)
programs.run(STATION, "scene", "redo", "--scene", scene)
refused("nothing to undo to", 1, STATION, "scene", "redo", "--scene", scene)
refused("no such revision to restore", 1, STATION, "scene", "restore", "--scene", scene, 99, says="has no revision 99")
refused("a revision that is no number", 2, STATION, "scene", "restore", "--scene", scene, "last", says="last is not")
refused("no revision to restore", 2, STATION, "scene", "restore", "--scene", scene, says="revision")
refused("a revision that is there", 1, STATION, "scene", "restore", "--scene", scene, 2, says="as it was at revision 2 already")
restored = programs.run(STATION, "scene", "restore", "--scene", scene, 1)
for name, revision in (("then", 1), ("now", 5)):
    programs.run(STATION, "scene", "export", "--scene", scene, path / f"{name}.ply", "--revision", revision)
programs.check("revision 5" in restored.stdout and (path / "then.ply").read_bytes() == (path / "now.ply").read_bytes(),
               f"what is restored is what was there: {restored.stdout}{restored.stderr}")
programs.run(STATION, "scene", "undo", "--scene", scene)
refused("a proposal that is not there", 1, STATION, "adjust", "--scene", scene, "--recording", station, "--frames", "0", "--accept", "977",
        says="no proposal 977")
refused("an export of no known kind", 1, STATION, "scene", "export", "--scene", scene, path / "out.xyz")
refused("an export into nowhere", 1, STATION, "scene", "export", "--scene", scene, path / "no" / "such" / "folder.glb")
refused("an export of no such revision", 1, STATION, "scene", "export", "--revision", 99, "--scene", scene, path / "o.glb")
refused("an export of a negative revision", 2, STATION, "scene", "export", "--revision=-1", "--scene", scene, path / "o.glb", says="-1 is")

print("-- folders")
blocked = write("blocked", "a file")
refused("an output folder that is a file", 1, STATION, "detect", "--model", model, "--recording", station, "--frames", "0",
        "--out", blocked)
refused("a file where views should go", 1, DEVICE, "run", "--scene", "s", "--camera",
        f"recording:{data / 'device_after_move'}", "--display", f"offscreen:{blocked}", "--init", "pose:0,0,0,0,0,0,1")
programs.end()
