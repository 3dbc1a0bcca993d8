"""Reads every .exr file of a directory with the OpenEXR module and compares with the .expected beside it."""

import json
import sys
from pathlib import Path

import numpy as np
import OpenEXR

count = 0
for path in sorted(Path(sys.argv[1]).glob("*.exr")):
    expected = json.loads(path.with_suffix(".expected").read_text())
    width, height, depth = expected["size"]
    channels = expected["channels"]
    values = np.array(expected["values"]).reshape(depth, height, width, channels)
    pixels = values.transpose(1, 0, 2, 3).reshape(height, depth * width, channels)
    with OpenEXR.File(str(path), separate_channels=True) as image:
        names = ["Y"] if channels == 1 else list("RGBA")[:channels]
        assert sorted(image.channels()) == sorted(names), path
        for index, name in enumerate(names):
            found = image.channels()[name].pixels
            assert found.dtype == {"f32": np.float32, "f16": np.float16}[expected["storage"]]
            assert np.array_equal(found, pixels[:, :, index]), (path, name)
        header = image.header()
        for key, value in expected["facts"]:
            assert header[key] == value, (path, key, header[key])
    count += 1
print(f"{count} textures")
