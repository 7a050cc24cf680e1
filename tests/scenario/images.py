"""Reads the image files that the programs write; only what they write (Python's standard library has no reader)."""
import struct
import zlib


def png(file):
    """Width, height, channels and the bytes of an 8-bit PNG."""
    data = file.read_bytes()
    width, height, _, kind = struct.unpack(">IIBB", data[16:26])
    channels = {0: 1, 2: 3}[kind]
    packed, at = b"", 8
    while at < len(data):
        size, name = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + size] if name == b"IDAT" else b""
        at += 12 + size
    raw, row = zlib.decompress(packed), width * channels
    pixels = bytearray()
    for y in range(height):
        line = bytearray(raw[y * (row + 1) + 1:(y + 1) * (row + 1)])
        kind = raw[y * (row + 1)]
        if kind not in (0, 1):
            raise ValueError(f"filter {kind} is not among those that are written")
        if kind == 1:
            for x in range(channels, row):
                line[x] = (line[x] + line[x - channels]) & 255
        pixels += line
    return width, height, channels, bytes(pixels)


def float_tiff(file):
    """Width, height and the floats of a TIFF with one channel of 32-bit float, deflated in strips."""
    data = file.read_bytes()
    if data[:4] != b"II*\0":
        raise ValueError("not a little-endian TIFF")
    start, = struct.unpack("<I", data[4:8])
    count, = struct.unpack("<H", data[start:start + 2])
    tags = {}
    for i in range(count):
        tag, kind, number, value = struct.unpack("<HHI4s", data[start + 2 + 12 * i:start + 14 + 12 * i])
        size, letter = {3: (2, "H"), 4: (4, "I"), 16: (8, "Q")}.get(kind, (1, "B"))
        at = value if size * number <= 4 else data[struct.unpack("<I", value)[0]:]
        tags[tag] = struct.unpack(f"<{number}{letter}", at[:size * number])
    if tags[258] != (32,) or tags[339] != (3,) or tags[259] != (8,):
        raise ValueError("not 32-bit float, deflated")
    raw = b"".join(zlib.decompress(data[at:at + size]) for at, size in zip(tags[273], tags[279]))
    return tags[256][0], tags[257][0], struct.unpack(f"<{len(raw) // 4}f", raw)
