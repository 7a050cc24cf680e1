#!/usr/bin/env python3
"""Makes report.json and report.html (self-contained) from what deploy/demo.sh left in a folder."""
import json
import pathlib
import statistics
import sys

import report_html

CHANGES = ("closer", "farther", "unmodelled")


def read_json(path):
    return json.loads(path.read_text()) if path.exists() else None


def read_events(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def median(values):
    values = [v for v in values if v is not None]
    return round(statistics.median(values), 3) if values else None


def ratio(part, whole):
    return part / whole if whole else None


def detection(out):
    """Scores of both detect runs, added up pixel by pixel; None where there is no truth."""
    runs = [r for r in (read_json(out / f"detect_{name}.json") for name in ("first", "moved")) if r]
    scores = [r["truth"]["pixels"] for r in runs if "truth" in r]

    def total(group, key):
        return sum(s[group][key] for s in scores)

    if not scores:
        return {"iou": dict.fromkeys(CHANGES), "recall": None, "false_change": None, "undecided": None}, runs
    return {
        "iou": {c: ratio(total(c, "both"), total(c, "either")) for c in CHANGES},
        "recall": ratio(total("change", "found"), total("change", "above_threshold")),
        "false_change": ratio(total("change", "falsely_changed"), total("change", "unchanged")),
        "undecided": ratio(total("change", "undecided"), total("change", "changed")),
    }, runs


def accept_to_drawn(revisions, device):
    """Milliseconds for each revision that was accepted while the device was drawing already."""
    drawn = {r["revision"]: r for r in device["revisions"]}
    first_drawn = min((r["drawn_ns"] for r in drawn.values()), default=0)
    return {
        r["revision"]: (drawn[r["revision"]]["drawn_ns"] - r["accepted_ns"]) / 1e6
        for r in revisions
        if r["revision"] in drawn and r["accepted_ns"] > first_drawn
    }


def tracking(out):
    adjustments = []
    for name, what in (("insertion", "what was missing is inserted"), ("move", "the box moved by 2 cm is corrected")):
        before, after = (read_json(out / "views" / f"{name}_{when}.json") for when in ("before", "after"))
        if not before:
            continue
        entry = {"name": name, "what": what}
        for when, result in (("before", before), ("after", after)):
            truth = result["truth"] or {}
            entry[when] = {"mean_error_m": truth.get("mean_error_m"), "max_error_m": truth.get("max_error_m"),
                           "lost": result["lost"], "frames": len(result["frames"]),
                           # A frame that is lost is not placed.
                           "placed_share": ratio(truth.get("within_1cm", 0), len(result["frames"])) if truth else None}
        adjustments.append(entry)
    return adjustments


def collect(out):
    events = read_events(out / "station.jsonl")
    device = read_json(out / "device.json")
    revisions = [e for e in events if e["event"] == "revision"]
    frames = [e for e in events if e["event"] == "frame" and "time_ms" in e]
    detect, runs = detection(out)
    delays = accept_to_drawn(revisions, device)
    adjustments = tracking(out)
    report = {
        "detect": detect,
        "adjust": {
            "revision": revisions[-1]["revision"],
            "triangles_added": sum(r["triangles_added"] for r in revisions),
            "triangles_removed": sum(r["triangles_removed"] for r in revisions),
            "revisions": revisions,
        },
        "publish": {
            "bytes": sum(r["bytes"] for r in revisions),
            "raw_bytes": sum(r["raw_bytes"] for r in revisions),
            "accept_to_drawn_ms": max(delays.values(), default=None),
            "accept_to_drawn_ms_by_revision": delays,
            # Nothing is drawn before the handheld knows where it is.
            "waited_for_pose": [r["revision"] for r in device["revisions"] if r["revision"] in delays and r["waited_for_pose"]],
        },
        "device": {"revision": device["revision"], "rejected": device["rejected"], "lost": device["lost"],
                   "frames": len(device["frames"])},
        "track": {
            # The model that the loop began with on the first circle, the model that it ended with on the last.
            "mean_error_m": {"before": adjustments[0]["before"]["mean_error_m"],
                             "after": adjustments[-1]["after"]["mean_error_m"]},
            "placed_share": {"before": adjustments[0]["before"]["placed_share"],
                             "after": adjustments[-1]["after"]["placed_share"]},
            "lost_frames": sum(a["after"]["lost"] for a in adjustments),
            "adjustments": adjustments,
            "station_lost_frames": sum(1 for e in events if e["event"] == "frame" and e["state"] == "lost"),
        },
        "times_ms": {
            "render": median([f["time_ms"]["render"] for f in frames]),
            "compare": median([f["time_ms"]["compare"] for f in frames]),
            "snapshot": median([r["time_ms"]["snapshot"] for r in revisions]),
            "encode": median([r["time_ms"]["encode"] for r in revisions]),
            "decode": median([r["decode_ms"] for r in device["revisions"] if r["revision"] in delays]),
            "track": device["time_ms"]["track"]["median"],
            "draw": device["time_ms"]["draw"]["median"],
            "station_track": median([f["track_ms"] for f in frames]),
            "station_frame": median([f["track_ms"] + f["time_ms"]["total"] for f in frames]),
        },
    }
    return report, runs


def main():
    out = pathlib.Path(sys.argv[1])
    report, runs = collect(out)
    (out / "report.json").write_text(json.dumps(report, indent=2) + "\n")
    (out / "report.html").write_text(report_html.render(out, report, runs))
    print(report_html.summary(report))


if __name__ == "__main__":
    main()
