"""Reads every .dds file of a directory by the layout that Microsoft documents (DDS_HEADER, DDS_HEADER_DXT10) and compares with the
.expected beside it. Libraries at hand, Pillow and OpenImageIO, know next to none of these numbers of DXGI formats."""

import json
import struct
import sys
from pathlib import Path

import numpy as np

# numbers of dxgiformat.h
FORMATS = {
    "f32": [41, 16, 2, 2],
    "f16": [54, 34, 10, 10],
    "unorm16": [56, 35, 11, 11],
    "unorm8": [61, 49, 28, 28],
}
TYPES = {"f32": "<f4", "f16": "<f2", "unorm16": "<u2", "unorm8": "u1"}
STEPS = {"f32": 1, "f16": 1, "unorm16": 65535, "unorm8": 255}
CAPS, HEIGHT, WIDTH, PITCH, PIXELFORMAT, DEPTH = 0x1, 0x2, 0x4, 0x8, 0x1000, 0x800000
COMPLEX, TEXTURE, VOLUME = 0x8, 0x1000, 0x200000

count = 0
for path in sorted(Path(sys.argv[1]).glob("*.dds")):
    expected = json.loads(path.with_suffix(".expected").read_text())
    width, height, depth = expected["size"]
    channels, storage, is_volume = expected["channels"], expected["storage"], expected["axes"] == 3
    bytes_ = path.read_bytes()
    magic, size, flags, h, w, pitch, d, mips = struct.unpack_from("<4s7I", bytes_, 0)
    assert (magic, size, h, w) == (b"DDS ", 124, height, width), path
    assert d == (depth if is_volume else 0) and mips in (0, 1), (path, d, mips)
    needed = CAPS | HEIGHT | WIDTH | PIXELFORMAT | (DEPTH if is_volume else 0)
    assert flags & needed == needed and (is_volume or not flags & DEPTH), (path, hex(flags))
    pixel_size, pixel_flags, code = struct.unpack_from("<2I4s", bytes_, 76)
    assert (pixel_size, pixel_flags, code) == (32, 4, b"DX10"), path
    caps, caps2 = struct.unpack_from("<2I", bytes_, 108)
    assert caps & TEXTURE and bool(caps & COMPLEX) == is_volume, (path, hex(caps))
    assert caps2 == (VOLUME if is_volume else 0), (path, hex(caps2))
    dxgi, dimension, misc, array, misc2 = struct.unpack_from("<5I", bytes_, 128)
    assert dxgi == FORMATS[storage][channels - 1], (path, dxgi)
    assert (dimension, misc, array) == (4 if is_volume else 3, 0, 1), path
    assert misc2 == {3: 3, 4: 4}.get(channels, 0), (path, misc2)

    stored = 4 if channels == 3 else channels
    assert flags & PITCH and pitch == width * stored * np.dtype(TYPES[storage]).itemsize, path
    found = np.frombuffer(bytes_, TYPES[storage], offset=148).astype(float) / STEPS[storage]
    values = np.array(expected["values"]).reshape(-1, channels)
    if stored > channels:
        values = np.concatenate([values, np.ones((len(values), 1))], axis=1)
    assert np.array_equal(found.reshape(-1, stored), values), path
    count += 1
print(f"{count} textures")
