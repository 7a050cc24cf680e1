#!/usr/bin/env python3
"""Converts the RealSense sequence `mbt-depth/castel` of Debian's package visp-images-data into a recording of ours.

usage: convert_castel.py SEQUENCE OUT

SEQUENCE  the folder mbt-depth/castel (it holds chateau.0.pos, chateau_parts/ and castel/)
OUT       is made: rgb/, depth/, rgb.txt, depth.txt, rig.yaml, model.obj (the CAD model) and
          start_pose.txt (tx,ty,tz,qx,qy,qz,qw of the first picture, camera to world)

Needs Python's standard library only. The depth images are resampled once into an ideal pinhole camera, because the
sensor's lens model (inverse Brown-Conrady) is not the one that rig.yaml describes.
"""

import array
import math
import operator
import re
import struct
import sys
import zlib
from pathlib import Path

FRAMES = 30
RATE_HZ = 30.0
WIDTH, HEIGHT = 640, 480
DEPTH_SCALE = 0.000124986647  # metres per unit
SENSOR_SIGMA_M = 0.002

# The cameras' factory calibration: fx, fy, cx, cy. Colour has no distortion.
COLOR = (615.1674804688, 615.1675415039, 312.1889953613, 243.4373779297)
DEPTH = (476.0536193848, 476.0534973145, 311.4845581055, 246.2832336426)
DEPTH_LENS = (0.165056542, -0.0508309528, 0.00435937941, 0.00541406544, 0.250085592)


def main(arguments):
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    source, out = Path(arguments[0]), Path(arguments[1])
    try:
        convert(source, out)
    except (OSError, ValueError, struct.error) as error:
        print(f"convert_castel.py: {error}", file=sys.stderr)
        return 1
    return 0


def convert(source, out):
    if not (source / "chateau.0.pos").is_file():
        raise ValueError(f"'{source}' is not the castel sequence; install visp-images-data")
    for folder in ("rgb", "depth"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    resample = operator.itemgetter(*ideal_to_sensor(DEPTH, DEPTH_LENS))
    lists = {"rgb": ["# timestamp path"], "depth": ["# timestamp path"]}
    for i in range(FRAMES):
        grey = read_pgm(source / "castel" / f"image_{i:04d}.pgm")
        depth = read_depth(source / "castel" / f"depth_image_{i:04d}.bin")
        depth.append(0)  # what pixels from outside the sensor take
        ideal = array.array("H", resample(depth))
        write_png(out / "rgb" / f"{i:06d}.png", 8, grey)
        write_png(out / "depth" / f"{i:06d}.png", 16, big_endian(ideal))
        for name, lines in lists.items():
            lines.append(f"{i / RATE_HZ!r} {name}/{i:06d}.png")
    for name, lines in lists.items():
        (out / f"{name}.txt").write_text("\n".join(lines) + "\n")
    (out / "rig.yaml").write_text(rig_yaml(read_matrix(source / "depth_M_color.txt")))
    (out / "model.obj").write_text(model_obj(sorted((source / "chateau_parts").glob("*.cao"))))
    (out / "start_pose.txt").write_text(start_pose(source / "chateau.0.pos") + "\n")


# --- images ---------------------------------------------------------------------------------------------------------


def read_pgm(file):
    data = file.read_bytes()
    header = re.match(rb"P5\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)\s+(\d+)\s", data)
    if not header or tuple(map(int, header.groups())) != (WIDTH, HEIGHT, 255):
        raise ValueError(f"'{file}' is not an 8-bit PGM of {WIDTH}x{HEIGHT} pixels")
    pixels = data[header.end() :]
    if len(pixels) != WIDTH * HEIGHT:
        raise ValueError(f"'{file}' is cut off")
    return pixels


def read_depth(file):
    data = file.read_bytes()
    if len(data) != 8 + 2 * WIDTH * HEIGHT or struct.unpack("<II", data[:8]) != (HEIGHT, WIDTH):
        raise ValueError(f"'{file}' is not a depth image of {WIDTH}x{HEIGHT} pixels")
    depth = array.array("H", data[8:])
    if sys.byteorder == "big":
        depth.byteswap()
    return depth


def big_endian(values):
    if sys.byteorder == "little":
        values.byteswap()
    return values.tobytes()


def write_png(file, bits, pixels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    stride = WIDTH * bits // 8
    rows = b"".join(b"\0" + pixels[y * stride : (y + 1) * stride] for y in range(HEIGHT))
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, bits, 0, 0, 0, 0)  # grey
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + body)


# --- lens -----------------------------------------------------------------------------------------------------------


def undistort(x, y, lens):
    """Inverse Brown-Conrady: the ideal normalised point of a distorted one."""
    c0, c1, c2, c3, c4 = lens
    r2 = x * x + y * y
    f = 1 + r2 * (c0 + r2 * (c1 + r2 * c4))
    return x * f + 2 * c2 * x * y + c3 * (r2 + 2 * x * x), y * f + 2 * c3 * x * y + c2 * (r2 + 2 * y * y)


def ideal_to_sensor(camera, lens):
    """For each pixel of the ideal camera the index of the sensor pixel that saw it, or one beyond the last.

    Inverted by fixed-point iteration, which starts at the neighbour's shift and ends below a hundredth of a pixel.
    """
    fx, fy, cx, cy = camera
    outside = WIDTH * HEIGHT
    source = []
    close = 0.01 / fx
    for v in range(HEIGHT):
        y_ideal = (v - cy) / fy
        shift_x = shift_y = 0.0
        for u in range(WIDTH):
            x_ideal = (u - cx) / fx
            for _ in range(50):
                x, y = undistort(x_ideal + shift_x, y_ideal + shift_y, lens)
                shift_x += x_ideal - x
                shift_y += y_ideal - y
                if abs(x_ideal - x) < close and abs(y_ideal - y) < close:
                    break
            column = math.floor((x_ideal + shift_x) * fx + cx + 0.5)
            row = math.floor((y_ideal + shift_y) * fy + cy + 0.5)
            inside = 0 <= column < WIDTH and 0 <= row < HEIGHT
            source.append(row * WIDTH + column if inside else outside)
    return source


# --- poses ----------------------------------------------------------------------------------------------------------


def read_numbers(file, count):
    numbers = [float(word) for word in file.read_text().split()]
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ValueError(f"'{file}' must hold {count} numbers")
    return numbers


def read_matrix(file):
    numbers = read_numbers(file, 16)
    return [numbers[4 * row : 4 * row + 4] for row in range(3)]


def quaternion_of(matrix):
    """x, y, z, w of a rotation by less than 180 degrees."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = matrix
    w = math.sqrt(max(0.0, 1 + a + e + i)) / 2
    if w < 1e-3:
        raise ValueError("depth_M_color.txt turns by half a circle")
    quaternion = [(h - f) / (4 * w), (c - g) / (4 * w), (d - b) / (4 * w), w]
    length = math.hypot(*quaternion)
    return [q / length for q in quaternion]


def rotate(quaternion, p):
    """p turned by the quaternion (x, y, z, w)."""
    *axis, w = quaternion
    t = [2 * value for value in cross(axis, p)]
    return [p[i] + w * t[i] + cross(axis, t)[i] for i in range(3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def start_pose(file):
    """The file holds T_color_world as translation and rotation vector; its inverse is the camera's pose."""
    numbers = read_numbers(file, 6)
    translation, vector = numbers[:3], numbers[3:]
    angle = math.hypot(*vector)
    scale = math.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    inverse = [-scale * v for v in vector] + [math.cos(angle / 2)]
    position = [-value for value in rotate(inverse, translation)]
    return ",".join(repr(value) for value in position + inverse)


def rig_yaml(depth_from_color):
    def camera(name, numbers):
        fx, fy, cx, cy = numbers
        size = f"width: {WIDTH}, height: {HEIGHT}"
        return f"{name}: {{{size}, fx: {fx}, fy: {fy}, cx: {cx}, cy: {cy}, distortion: [0, 0, 0, 0, 0]}}\n"

    translation = [row[3] for row in depth_from_color]
    return (
        camera("color", COLOR)
        + camera("depth", DEPTH)
        + f"depth_scale: {DEPTH_SCALE}\n"
        + f"T_depth_color: {{translation: {translation}, rotation_xyzw: {quaternion_of(depth_from_color)}}}\n"
        + f"sensor: {{constant: {SENSOR_SIGMA_M}}}\n"
        + "depth_registered: false\n"
    )


# --- model ----------------------------------------------------------------------------------------------------------


def model_obj(parts):
    if not parts:
        raise ValueError("the folder chateau_parts holds no .cao file")
    lines = ["# metres"]
    first = 1
    for part in parts:
        points, faces = read_cao(part)
        lines.append(f"o {part.stem}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points]
        for face in faces:
            lines += ["f " + " ".join(str(first + i) for i in triangle) for triangle in triangulate(points, face)]
        first += len(points)
    return "\n".join(lines) + "\n"


def read_cao(file):
    """Points and face polygons of a CAO file, version V1, that has no other kind of face."""
    lines = [line.split("#")[0].strip() for line in file.read_text().splitlines()]
    lines = iter([line for line in lines if line])
    try:
        if next(lines) != "V1":
            raise ValueError(f"'{file}' is not a CAO file of version V1")
        points = [tuple(map(float, next(lines).split()[:3])) for _ in range(int(next(lines)))]
        if int(next(lines)) or int(next(lines)):
            raise ValueError(f"'{file}' has faces made of segments, which this converter does not read")
        faces = []
        for _ in range(int(next(lines))):
            count, *words = next(lines).split()
            faces.append([int(word) for word in words[: int(count)]])
    except StopIteration:
        raise ValueError(f"'{file}' is cut off") from None
    if any(not 0 <= i < len(points) for face in faces for i in face) or any(len(face) < 3 for face in faces):
        raise ValueError(f"'{file}' has a face with missing points")
    return points, faces


def triangulate(points, face):
    """Ear clipping in the polygon's own plane; keeps the direction in which the polygon runs."""
    normal = newell_normal([points[i] for i in face])

    def area(a, b, c):
        p, q, r = points[a], points[b], points[c]
        sides = cross([q[k] - p[k] for k in range(3)], [r[k] - p[k] for k in range(3)])
        return sum(sides[k] * normal[k] for k in range(3))

    def is_ear(rest, k):
        a, b, c = rest[k - 1], rest[k], rest[(k + 1) % len(rest)]
        if area(a, b, c) <= 0:
            return False
        others = [i for i in rest if i not in (a, b, c)]
        return not any(area(a, b, i) >= 0 and area(b, c, i) >= 0 and area(c, a, i) >= 0 for i in others)

    rest, triangles = list(face), []
    while len(rest) > 3:
        ear = next((k for k in range(len(rest)) if is_ear(rest, k)), None)
        if ear is None:
            raise ValueError("a face of the model crosses itself")
        triangles.append((rest[ear - 1], rest[ear], rest[(ear + 1) % len(rest)]))
        del rest[ear]
    return triangles + [tuple(rest)]


def newell_normal(polygon):
    normal = [0.0, 0.0, 0.0]
    for p, q in zip(polygon, polygon[1:] + polygon[:1]):
        for k in range(3):
            normal[k] += (p[k - 2] - q[k - 2]) * (p[k - 1] + q[k - 1])
    return normal


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
