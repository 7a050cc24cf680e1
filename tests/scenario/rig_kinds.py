"""One recording for each kind of rig: sizes, lenses, formats of depth. The labels must be right against the truth."""
import json
import math
import os
import pathlib

import images
import programs

STATION = programs.STATION
REWRITE = pathlib.Path(os.environ["MESHLOOP_REWRITE"])
# Of the labels closer and unmodelled, without noise: outlines are what is left.
LEAST_IOU = 0.99
# A Kinect's threshold reaches two pixels to the side: where a measurement lies there between two surfaces it is undecided,
# which is one pixel in a hundred of what changes in so small a picture.
LEAST_IOU_SMALL = 0.985
# A bent image takes the nearest measurement twice, which moves outlines by up to a pixel.
LEAST_IOU_BENT = 0.98
# With a Kinect's noise of 0.8 px to the side, outlines weigh the more the fewer pixels there are.
LEAST_RECALL = {(176, 144): 0.88, (320, 240): 0.93, (640, 480): 0.96, (1280, 720): 0.97}
MOST_FALSE = 0.003
# Of a region, against the one at 640x480.
LARGEST_AREA_RATIO = 1.25

# Of the tracked colour camera, by markers alone, while the hand moves fast.
LARGEST_ERROR_M = {(176, 144): 0.03, (320, 240): 0.005, (640, 480): 0.002, (1280, 720): 0.002}

folder, path = programs.work_folder()
areas = {}


def simulate(name, noise, *more):
    made = programs.run(STATION, "simulate", "--out", path / name, "--noise", noise, "--station-frames", 12, "--device-frames", 2,
                        *more, timeout=300)
    programs.check(made.returncode == 0, f"{name}: simulated {made.stderr}")
    return path / name


def detect(name, data, *more, recording=None, frames="0-3"):
    result = programs.run(STATION, "detect", "--model", data / "model.ply", "--recording", recording or data / "station", "--truth",
                          data / "station_truth", "--frames", frames, "--out", path / f"{name}_out", "--json", *more, timeout=300)
    programs.check(result.returncode == 0, f"{name}: detect {result.stderr}")
    return json.loads(result.stdout) if result.returncode == 0 else None


def scores(truth):
    return truth["iou"]["closer"], truth["iou"]["unmodelled"], truth["false_change"]


def check_exact(name, result, least_iou=LEAST_IOU):
    closer, unmodelled, false = scores(result["truth"])
    programs.check(min(closer, unmodelled) >= least_iou and false <= MOST_FALSE,
                   f"{name}: IoU {closer:.4f} closer, {unmodelled:.4f} unmodelled (at least {least_iou}), false {false:.5f}")


def positions(file):
    lines = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    return {round(float(words[0]), 5): tuple(map(float, words[1:4])) for words in lines}


def tracking_error_m(name, data, recording, *more):
    """Median over the frames; the half that is worse is the hand's fastest motion."""
    poses = path / f"{name}_poses.txt"
    result = programs.run(STATION, "track", "--recording", recording, "--markers", data / "markers.yaml", "--out", poses, *more)
    if result.returncode != 0:
        return math.inf
    truth = positions(data / "station" / "groundtruth.txt")
    errors = sorted(math.dist(p, truth[t]) for t, p in positions(poses).items())
    return errors[len(errors) // 2] if len(errors) >= 10 else math.inf


def check_tracking(name, size, data, recording):
    error = tracking_error_m(name, data, recording)
    programs.check(error <= LARGEST_ERROR_M[size], f"{name}: tracked to {1000 * error:.2f} mm")


def region_areas(result):
    return sorted(region["area_m2"] for region in result["frames"][-1]["regions"])


def check_difference(name, depth_size):
    """float32 in the depth image's size, NaN where nothing can be subtracted, a number where a label needs one."""
    width, height, difference = images.float_tiff(path / f"{name}_out" / "difference_000003.tiff")
    label_width, label_height, _, labels = images.png(path / f"{name}_out" / "labels_000003.png")
    wrong = sum(math.isnan(d) != (label in (0, 1)) for d, label in zip(difference, labels) if label != 5)
    programs.check((width, height) == (label_width, label_height) == depth_size and len(difference) == width * height and wrong == 0,
                   f"{name}: differences {width}x{height}, {wrong} of the wrong kind")


def check_views(name, color_size, depth_size):
    for view, size in (("overlay", color_size), ("overlay_depth", depth_size)):
        width, height, _, _ = images.png(path / f"{name}_out" / f"{view}_000003.png")
        factor = -(-640 // size[0])
        programs.check(width == size[0] * factor and height > size[1] * factor + 60, f"{name}: {view} is {width}x{height}, with legend")


print("-- sizes, exact and with a Kinect's noise")
for size in ((640, 480), (176, 144), (320, 240), (1280, 720)):
    text = f"{size[0]}x{size[1]}"
    for noise in (0, 1):
        name = f"{text}_noise{noise}"
        result = detect(name, simulate(name, noise, "--color-size", text, "--depth-size", text))
        if noise == 0:
            check_exact(name, result, LEAST_IOU_SMALL if size[0] < 200 else LEAST_IOU)
            areas[size] = region_areas(result)
            ratios = [a / b for a, b in zip(areas[size], areas[(640, 480)])]
            same = len(areas[size]) == len(areas[(640, 480)])
            programs.check(same and all(1 / LARGEST_AREA_RATIO < r < LARGEST_AREA_RATIO for r in ratios),
                           f"{name}: the regions of 640x480, their areas {[round(r, 3) for r in ratios]} of those")
        else:
            recall, false = result["truth"]["recall"], result["truth"]["false_change"]
            programs.check(recall >= LEAST_RECALL[size] and false <= MOST_FALSE, f"{name}: recall {recall:.4f}, false {false:.5f}")
    check_tracking(text, size, path / f"{text}_noise1", path / f"{text}_noise1" / "station")
    check_difference(f"{text}_noise0", size)
    check_views(f"{text}_noise0", size, size)

print("-- depth and colour that differ")
for name, color, depth in (("coarse_depth", (1280, 720), (176, 144)), ("coarse_color", (320, 240), (640, 480)),
                           ("odd_sizes", (641, 359), (333, 251))):
    data = simulate(name, 0, "--color-size", f"{color[0]}x{color[1]}", "--depth-size", f"{depth[0]}x{depth[1]}")
    check_exact(name, detect(name, data), LEAST_IOU_SMALL if depth[0] < 200 else LEAST_IOU)
    check_difference(name, depth)
    check_views(name, color, depth)
data = simulate("registered", 0, "--registered", "--color-size", "640x360")
check_exact("registered", detect("registered", data))
check_views("registered", (640, 360), (640, 360))

print("-- formats of depth")
exact = path / "640x480_noise0"
data = simulate("float", 0, "--float-depth", "--depth-size", "320x240", "--color-size", "320x240")
check_exact("float", detect("float", data))
programs.check((data / "station" / "depth" / "000000.tiff").exists(), "float depth is kept as TIFF")
for kind, least in (("tum", LEAST_IOU), ("brown", LEAST_IOU_BENT), ("rational", LEAST_IOU_BENT)):
    if kind == "brown":
        print("-- lenses")
    written = programs.run(REWRITE, exact / "station", path / kind, kind)
    programs.check(written.returncode == 0, f"{kind}: rewritten {written.stderr}")
    check_exact(kind, detect(kind, exact, recording=path / kind), least)
    check_tracking(kind, (640, 480), exact, path / kind)
    if kind != "tum":
        error = tracking_error_m(f"{kind}_unaware", exact, path / kind, "--rig", exact / "station" / "rig.yaml")
        programs.check(error > 0.01, f"{kind}: seen as a perfect lens tracking is {1000 * error:.1f} mm off")
        unaware = detect(f"{kind}_unaware", exact, "--rig", exact / "station" / "rig.yaml", recording=path / kind)
        programs.check(scores(unaware["truth"])[0] < least - 0.05, f"{kind}: seen as a perfect lens the labels are wrong")

print("-- how the views look")
small = path / "176x144_noise0"
PAPER_RED, SAFE_RED = bytes((230, 20, 20)), bytes((213, 94, 0))


def colors(name, *more):
    detect(name, small, *more, frames="3")
    width, height, _, pixels = images.png(path / f"{name}_out" / "overlay_000003.png")
    picture = pixels[:3 * width * 144 * 4]
    return [sum(picture[i:i + 3] == color for i in range(0, len(picture), 3)) for color in (PAPER_RED, SAFE_RED)]


paper, safe, faint = colors("paper"), colors("safe", "--palette", "safe"), colors("faint", "--opacity", "0.5")
programs.check(paper[0] > 10_000 and paper[1] == 0, f"the paper's colours: {paper}")
programs.check(safe == [paper[1], paper[0]], f"the safe palette colours the same pixels: {safe}")
programs.check(faint[0] == 0, f"at an opacity of 0.5 nothing below two metres is solid: {faint}")
detect("without", small, "--views", "none", frames="3")
detect("depth_only", small, "--views", "depth", frames="3")
names = {name: sorted(p.name for p in (path / f"{name}_out").glob("overlay*")) for name in ("without", "depth_only")}
programs.check(names == {"without": [], "depth_only": ["overlay_depth_000003.png"]}, f"only the views that were asked for: {names}")
programs.end()
