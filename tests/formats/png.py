"""Reads every .png file of a directory and compares with the .expected beside it: modes, sizes and text by Pillow, which cuts
16 bits of colour to 8, and all samples by OpenImageIO."""

import json
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from PIL import Image

MODES = {("unorm16", 1): "I;16", ("unorm8", 1): "L", ("unorm8", 4): "RGBA", ("unorm16", 4): "RGBA"}

count = 0
for path in sorted(Path(sys.argv[1]).glob("*.png")):
    expected = json.loads(path.with_suffix(".expected").read_text())
    width, height, depth = expected["size"]
    channels, storage = expected["channels"], expected["storage"]
    steps = {"unorm16": 65535, "unorm8": 255}[storage]

    values = np.array(expected["values"]).reshape(depth, height, width, channels)
    if channels == 2:
        values = np.concatenate([values, np.zeros((depth, height, width, 1))], axis=3)
    # slices side by side
    pixels = np.rint(values * steps).transpose(1, 0, 2, 3).reshape(height, depth * width, -1)

    with Image.open(path) as image:
        assert image.size == (width * depth, height), path
        assert image.mode == MODES.get((storage, channels), "RGB"), (path, image.mode)
        assert image.info["gamma"] == 1.0 and "srgb" not in image.info
        for key, value in expected["facts"]:
            assert image.text["whitefurnace." + key] == value, (path, key)
        if storage == "unorm8" or channels == 1:
            found = np.asarray(image).reshape(height, depth * width, -1)
            assert np.array_equal(found, pixels), path

    # associated alpha would multiply the colours
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    image = oiio.ImageInput.open(str(path), config)
    kind = oiio.UINT16 if storage == "unorm16" else oiio.UINT8
    spec = image.spec()
    assert str(spec.format) == str(oiio.TypeDesc(kind)), (path, spec.format)
    found = image.read_image(0, 0, 0, spec.nchannels, kind)
    assert np.array_equal(found, pixels), path
    count += 1
print(f"{count} textures")
