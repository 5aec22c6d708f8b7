#!/usr/bin/env python3
"""An animated GIF of a part of a Motion JPEG video:   scripts/doc_gif.py VIDEO.avi OUT.gif BEGIN_S END_S EVERY WIDTH

EVERY: one picture of so many is kept; the GIF plays at the video's speed. Needs Pillow.
"""

import io
import struct
import sys

from PIL import Image


def pictures(data):
    """The JPEG of each '00dc' chunk of the 'movi' list (RIFF: a name, a length, content padded to even)."""
    at = data.index(b"movi") + 4
    while at + 8 <= len(data) and data[at:at + 4] == b"00dc":
        size = struct.unpack("<I", data[at + 4:at + 8])[0]
        yield data[at + 8:at + 8 + size]
        at += 8 + size + size % 2


def main():
    video, out, begin, end, every, width = sys.argv[1:]
    data = open(video, "rb").read()
    microseconds = struct.unpack("<I", data[data.index(b"avih") + 8:][:4])[0]
    first, last, every = int(float(begin) * 1e6 / microseconds), int(float(end) * 1e6 / microseconds), int(every)
    frames = [Image.open(io.BytesIO(jpeg)).convert("RGB") for jpeg in list(pictures(data))[first:last:every]]
    height = round(frames[0].height * int(width) / frames[0].width)
    frames = [frame.resize((int(width), height), Image.LANCZOS) for frame in frames]
    # One palette for all: a palette per picture flickers.
    palette = frames[0].quantize(64)
    frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    frames[0].save(out, save_all=True, append_images=frames[1:], duration=microseconds * every // 1000, loop=0, optimize=True)


main()
