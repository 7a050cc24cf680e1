"""Runs deploy/demo.sh and reads its report.json."""
import json
import re

import programs


def run_demo(*arguments):
    folder, path = programs.work_folder()
    result = programs.run("bash", programs.SOURCE / "deploy" / "demo.sh", "--out", path / "out", *arguments, timeout=550)
    print(result.stdout[-4000:], result.stderr[-2000:])
    programs.check(result.returncode == 0, "the demo ends well")
    report = json.loads((path / "out" / "report.json").read_text()) if result.returncode == 0 else None
    if report is None:
        programs.end()
    return folder, path / "out", report


def check_loop(out, report):
    """What holds for every variant."""
    publish = report["publish"]
    programs.check(report["device"]["revision"] == report["adjust"]["revision"], "the device has the station's revision")
    programs.check(report["adjust"]["triangles_added"] > 0, "triangles were added")
    programs.check(report["device"]["rejected"] == 0, "no payload was rejected")
    programs.check(publish["bytes"] <= publish["raw_bytes"] / 10,
                   f"{publish['bytes']} bytes sent for {publish['raw_bytes']}: at most a tenth")
    for r in report["adjust"]["revisions"]:
        # The coder's tables alone take some 200 bytes a node, which shows in a patch of less than 200 triangles.
        allowed = r["raw_bytes"] / 10 + (0 if r["raw_bytes"] > 4_500 else 300)
        programs.check(r["bytes"] <= allowed,
                       f"revision {r['revision']}: {r['bytes']} bytes sent for {r['raw_bytes']}: at most {allowed:.0f}")
    delays = publish["accept_to_drawn_ms_by_revision"]
    middle = sorted(delays.values())[len(delays) // 2] if delays else None
    programs.check(middle is not None and middle < 500, f"half of the revisions are drawn within {middle or 0:.0f} ms: below 500")
    # Nothing can be drawn while the handheld does not know where it is.
    prompt = sorted(ms for revision, ms in delays.items() if int(revision) not in publish["waited_for_pose"])
    # 500 ms, or as long as the device takes for four pictures where that is longer: the machine may be anybody's.
    times = report["times_ms"]
    limit = max(500, 4 * (times["track"] + times["draw"]))
    slow = [ms for ms in prompt if ms >= limit]
    programs.check(len(prompt) > 2 and len(slow) <= len(prompt) / 10,
                   f"accepted to drawn in {[round(ms) for ms in prompt]} ms: nine of ten below {limit:.0f}")
    programs.check(max(delays.values()) < 5000, f"the slowest, lost handheld or not, took {max(delays.values()):.0f} ms")
    for key in ("render", "compare", "snapshot", "encode", "decode", "track", "draw"):
        programs.check(report["times_ms"][key] is not None, f"times_ms.{key} is {report['times_ms'][key]}")
    page = (out / "report.html").read_text()
    programs.check(page.count("data:image/png;base64,") >= 6 and "No picture" not in page, "the page holds its pictures")
    programs.check("src='http" not in page and 'href="http' not in page, "the page needs nothing from elsewhere")


def check_tracking(report):
    track = report["track"]
    programs.check(track["lost_frames"] == 0, "no frame is lost with the adjusted models")
    for adjustment in track["adjustments"]:
        after = adjustment["after"]["mean_error_m"]
        programs.check(after <= 0.01, f"{adjustment['name']}: mean error {after * 1000:.1f} mm after: at most 10")
        # The tracker says lost rather than follow what the model contradicts, so the error of what is left tells little.
        before, after = (adjustment[when]["placed_share"] for when in ("before", "after"))
        # Without a box there is too little to hold on to; one that the model has 2 cm off must do no harm.
        as_expected = before >= 0.98 if adjustment["name"] == "move" else before <= 0.8
        programs.check(as_expected and after >= 0.98,
                       f"{adjustment['name']}: placed within 1 cm: {before:.0%} of the frames before, {after:.0%} after")
    error = track["mean_error_m"]
    programs.check(error["before"] >= 2 * error["after"],
                   f"mean error {error['before'] * 1000:.2f} mm before the loop, {error['after'] * 1000:.2f} after: clearly worse")


def check_misplaced_markers(out):
    """The markers' file is 2 cm off: nothing is committed, and the reason is told."""
    data, scene = out / "data", out / "misplaced.db"
    for x, y, z in ((0.02, 0, 0), (0, 0.02, 0), (0, 0, 0.02)):
        def shift(corner):
            return f"- [{float(corner[1]) + x}, {float(corner[2]) + y}, {float(corner[3]) + z}]"
        markers = out / "misplaced.yaml"
        markers.write_text(re.sub(r"- \[(\S+), (\S+), (\S+)\]", shift, (data / "markers.yaml").read_text()))
        scene.unlink(missing_ok=True)
        programs.run(programs.STATION, "scene", "import", "--scene", scene, data / "model.ply")
        source = ("--scene", scene, "--markers", markers, "--accept", "all", "--json")
        live = programs.run(programs.STATION, "run", *source, "--source", f"recording:{data / 'station'}", "--fast", "--serve", 0,
                            timeout=300)
        events = [json.loads(line) for line in live.stdout.splitlines()]
        reasons = [event["reason"] for event in events if event["event"] == "withheld"]
        revisions = [event["frame"] for event in events if event["event"] == "revision"]
        programs.check(live.returncode == 1 and "no frame could be used" in live.stderr and events[-1]["changes"]["withheld"] == len(reasons)
                       and reasons and not revisions,
                       f"markers off by {x}, {y}, {z} m: {len(reasons)} frames are withheld, revisions from frames {revisions}: {reasons[:1]}")
        batch = programs.run(programs.STATION, "adjust", *source, "--recording", data / "station", "--frames", "2")
        programs.check(batch.returncode == 1 and "no frame could be used" in batch.stderr, f"adjust changes nothing: {batch.stderr}")
        info = json.loads(programs.run(programs.STATION, "scene", "log", "--scene", scene, "--json").stdout)
        programs.check(len(info["revisions"]) == 1, "the scene is as it was imported")
