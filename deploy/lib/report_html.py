"""How the demo's report looks: text for the terminal and one HTML file with all pictures inside."""
import base64
import html
import json
import math

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 1100px; padding: 0 1rem; color: #222; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 1rem 0; } th, td { padding: .3rem .8rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; } .good { color: #006b3c; } .bad { color: #b00020; font-weight: bold; }
figure { display: inline-block; margin: .5rem; vertical-align: top; width: 31rem; max-width: 100%; }
figure img { width: 100%; border: 1px solid #ccc; } figcaption { font-size: .9rem; color: #555; }
.note { color: #555; } svg { background: #fafafa; border: 1px solid #ccc; }
"""


def number(value, unit="", digits=1, scale=1):
    return "not known" if value is None else f"{value * scale:.{digits}f}{unit}"


def millimetres(value):
    return number(value, " mm", 1, 1000)


def percent(value, digits=2):
    return number(value, " %", digits, 100)


def table(head, rows):
    def line(cells, tag):
        return "<tr>" + "".join(f"<{tag}>{c}</{tag}>" for c in cells) + "</tr>"
    return "<table>" + line(head, "th") + "".join(line(r, "td") for r in rows) + "</table>"


def picture(path, caption):
    if path is None or not path.exists():
        return f"<p class='note'>No picture: {html.escape(caption)}</p>"
    data = base64.b64encode(path.read_bytes()).decode()
    return (f"<figure><img src='data:image/png;base64,{data}' alt='{html.escape(caption)}'>"
            f"<figcaption>{html.escape(caption)}</figcaption></figure>")


def summary_rows(report):
    detect, publish, track = report["detect"], report["publish"], report["track"]
    size = publish["bytes"] / publish["raw_bytes"] if publish["raw_bytes"] else None
    return [
        ("labels that are right (IoU): closer / farther / unmodelled",
         " / ".join(number(detect["iou"][c], "", 3) for c in ("closer", "farther", "unmodelled"))),
        ("changed pixels above the threshold that were found", percent(detect["recall"])),
        ("unchanged pixels inside a confirmed region", percent(detect["false_change"], 3)),
        ("model revision on the station / on the device",
         f"{report['adjust']['revision']} / {report['device']['revision']}"),
        ("triangles added / removed", f"{report['adjust']['triangles_added']} / {report['adjust']['triangles_removed']}"),
        ("bytes published (Draco) / uncompressed",
         f"{publish['bytes']} / {publish['raw_bytes']} ({percent(size, 1)})"),
        ("from acceptance to drawn on the device, slowest revision", number(publish["accept_to_drawn_ms"], " ms", 0)),
        ("mean tracking error where not lost, first / adjusted model",
         f"{millimetres(track['mean_error_m']['before'])} / {millimetres(track['mean_error_m']['after'])}"),
        ("frames placed within 1 cm with the first / the adjusted model",
         f"{percent(track['placed_share']['before'], 0)} / {percent(track['placed_share']['after'], 0)}"),
        ("lost frames while tracking the adjusted models", str(track["lost_frames"])),
    ]


def summary(report):
    return "\n".join(f"  {what:<62} {value}" for what, value in summary_rows(report))


def revision_rows(report):
    delays = report["publish"]["accept_to_drawn_ms_by_revision"]
    return [(r["revision"], r["frame"], r["triangles_added"], r["triangles_removed"], r["bytes"], r["raw_bytes"],
             percent(r["bytes"] / r["raw_bytes"] if r["raw_bytes"] else None, 1),
             number(delays.get(r["revision"]), " ms", 0) if r["revision"] in delays else "before the device joined, or overtaken")
            for r in report["adjust"]["revisions"]]


def adjustment_rows(report):
    rows = []
    for a in report["track"]["adjustments"]:
        for when in ("before", "after"):
            e = a[when]
            rows.append((f"{html.escape(a['what'])}: {when}", millimetres(e["mean_error_m"]), millimetres(e["max_error_m"]),
                         f"{e['lost']} of {e['frames']}", percent(e["placed_share"], 0)))
    return rows


def positions(path):
    if not path.exists():
        return []
    lines = [line.split() for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return [(float(p[0]), float(p[1]), float(p[2])) for p in lines]


def stretches(curve):
    """The curve (time, x, y) cut where frames are missing, because they were lost: no line is drawn across."""
    steps = sorted(b[0] - a[0] for a, b in zip(curve, curve[1:]))
    longest = 1.5 * steps[len(steps) // 10] if steps else 0
    parts = []
    for point in curve:
        if not parts or point[0] - parts[-1][-1][0] > longest:
            parts.append([])
        parts[-1].append(point)
    return parts


def camera_paths(curves):
    """Curves (name, colour, points of time, x and y) seen from above, with a scale of 0.5 m (or less for small scenes)."""
    points = [p[1:] for _, _, curve in curves for p in curve]
    if not points:
        return "<p class='note'>No camera path.</p>"
    low = [min(p[i] for p in points) for i in (0, 1)]
    high = [max(p[i] for p in points) for i in (0, 1)]
    extent = max(high[0] - low[0], high[1] - low[1], 1e-3)
    size, margin = 420, 40
    scale = (size - 2 * margin) / extent

    def xy(p):
        return f"{margin + (p[1] - low[0]) * scale:.1f},{size - margin - (p[2] - low[1]) * scale:.1f}"

    lines, legend = [], []
    for i, (name, color, curve) in enumerate(curves):
        for part in stretches(curve):
            lines.append(f"<polyline points='{' '.join(map(xy, part))}' fill='none' stroke='{color}' stroke-width='1.5' "
                         "stroke-linecap='round'/>")
        legend.append(f"<text x='{size + 10}' y='{30 + 22 * i}' fill='{color}'>{html.escape(name)}</text>")
    bar = 10 ** math.floor(math.log10(extent)) / 2
    lines.append(f"<path d='M{margin},{size - 12} h{bar * scale:.1f}' stroke='#222' stroke-width='2'/>"
                 f"<text x='{margin}' y='{size - 18}' font-size='12'>{bar:g} m</text>")
    return f"<svg width='{size + 320}' height='{size}' font-size='14'>{''.join(lines)}{''.join(legend)}</svg>"


def first_and_last(folder, pattern):
    files = sorted(folder.glob(pattern))
    return (files[0], files[-1]) if files else (None, None)


# Where along the device's path the box stands between its camera and the lighthouse: behind its middle, behind its edge.
VIEW_AT = {"insertion": 15 / 24, "move": 14 / 24}


def sample_views(out, name):
    """The augmented view of one frame, before and after, in which one sees what the adjustment changed: the nearest to
    VIEW_AT in which the handheld believed to know its place before."""
    tracked = {f["index"] for f in json.loads((out / "views" / f"{name}_before.json").read_text())["frames"]
               if f["state"] != "lost"}
    folders = [out / "views" / f"{name}_{when}" for when in ("before", "after")]
    drawn = sorted(int(file.stem) for file in folders[0].glob("*.png"))
    usable = [frame for frame in drawn if frame in tracked] or drawn
    if not usable:
        return None, None
    wanted = drawn[int(len(drawn) * VIEW_AT[name])]
    frame = min(usable, key=lambda f: abs(f - wanted))
    return tuple(folder / f"{frame:06}.png" for folder in folders)


def overlays(out, report):
    """The largest additions, and the largest removal: what was moved."""
    revisions = report["adjust"]["revisions"]
    shown = []
    for r in revisions:
        before = out / "station" / f"revision_{r['revision']:04}_before.png"
        # Of two revisions from one frame the later one has the picture of the next frame.
        last = max(other["revision"] for other in revisions if other["frame"] == r["frame"])
        after = out / "station" / f"revision_{last:04}_after.png"
        if before.exists() and after.exists():
            shown.append((r, before, after))
    chosen = sorted(shown, key=lambda s: -s[0]["triangles_added"])[:2]
    for s in sorted(shown, key=lambda s: -s[0]["triangles_removed"]):
        if s not in chosen and len(chosen) < 3:
            chosen.append(s)
    return "".join(picture(before, f"revision {r['revision']}: difference before it was accepted") +
                   picture(after, f"revision {r['revision']}: the next frame, compared with the adjusted model")
                   for r, before, after in sorted(chosen, key=lambda s: s[0]["revision"]))


def views(out, report):
    text = []
    for a in report["track"]["adjustments"]:
        for when, view in zip(("before", "after"), sample_views(out, a["name"])):
            text.append(picture(view, f"{a['what']}: {when}"))
    return "".join(text)


def render(out, report, runs):
    curves = []
    truths = sorted((out / "data").glob("device_*/groundtruth.txt"))
    if truths:
        curves.append(("true path", "#888", positions(truths[-1])))
    first = report["track"]["adjustments"][0]["name"]
    curves.append(("tracked, model before the adjustment", "#d55e00", positions(out / "views" / f"{first}_before.txt")))
    curves.append(("tracked, model after the adjustment", "#0072b2", positions(out / "views" / f"{first}_after.txt")))
    detected = [p for name in ("first", "moved") for p in first_and_last(out / f"detect_{name}", "overlay_[0-9]*.png")[:1]]
    depth_view = first_and_last(out / "detect_first", "overlay_depth_*.png")[0]
    detection_part = "" if not runs else (
        "<h2>Differences, against the exact truth</h2>" +
        "".join(picture(p, f"over the colour image: {p.parent.name}, {p.name}") for p in detected if p) +
        picture(depth_view, "over the depth image"))
    times = sorted(report["times_ms"].items())
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>meshloop: the loop closes</title>
<style>{STYLE}</style><h1>The loop closes</h1>
<p class="note">A capture station compared what it saw with the shared model, adapted the model and published each change; a
handheld device, another process, received it, tracked its camera against it and drew with it.</p>
{table(("", ""), summary_rows(report))}
<h2>The model is adapted</h2>{overlays(out, report)}
{table(("revision", "frame", "triangles +", "triangles -", "bytes", "uncompressed", "share", "accepted to drawn"), revision_rows(report))}
<h2>What the handheld sees</h2>{views(out, report)}
<h2>How well the handheld knows where it is</h2>
{table(("model", "mean error", "largest", "lost frames", "placed within 1 cm"), adjustment_rows(report))}
<p class="note">Distance between tracked and true camera position, over the frames that were not lost. A box that the model has
2 cm off contradicts what the camera sees, and has no say in its place: adjusting it mends what is drawn, not where the handheld
is.</p>
{camera_paths(curves)}
{detection_part}
<h2>Time</h2>{table(("stage", "median ms"), [(k, number(v, "", 2)) for k, v in times])}
</html>
"""
