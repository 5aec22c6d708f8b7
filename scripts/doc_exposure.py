#!/usr/bin/env python3
"""docs/images/exposure.png: exposures and keystone, right and wrong.   scripts/doc_exposure.py CAPTURE.png OUT.png

CAPTURE: of simulate-captures. The other exposures are computed from it in linear light (gamma 2.2); the keystone is a
perspective resampling of one-pixel squares. Needs numpy and Pillow.
"""

import sys

import numpy
from PIL import Image, ImageDraw, ImageFont

WIDTH, HEIGHT, GAP, TEXT = 300, 225, 10, 40


def exposed(image, gain):
    linear = gain * (numpy.asarray(image) / 255.0) ** 2.2
    return Image.fromarray(numpy.uint8(numpy.clip(linear, 0, 1) ** (1 / 2.2) * 255))


def main():
    capture, out = sys.argv[1:]
    image = Image.open(capture).convert("L")
    w, h = image.size
    image = image.crop((int(0.2 * w), int(0.25 * h), int(0.8 * w), int(0.7 * h))).resize((WIDTH, HEIGHT), Image.LANCZOS)
    y, x = numpy.mgrid[0:HEIGHT // 3, 0:WIDTH // 3]
    squares = Image.fromarray(numpy.uint8((x + y) % 2 * 255))
    keystone = squares.transform(squares.size, Image.PERSPECTIVE, (1.03, 0.03, -1, 0.004, 1.02, -1, 4e-4, 2e-4), Image.BILINEAR)
    panels = [(exposed(image, 0.015), "too dark: little contrast"), (image, "right: paper below full scale"),
              (exposed(image, 3.5), "overexposed: paper at full scale"),
              (squares.resize((WIDTH, HEIGHT), Image.NEAREST), "keystone off: each pixel as it was sent"),
              (keystone.resize((WIDTH, HEIGHT), Image.NEAREST), "keystone on: pixels are mixed, squares beat")]
    font = ImageFont.truetype("DejaVuSans.ttf", 13)
    picture = Image.new("RGB", (3 * WIDTH + 2 * GAP, 2 * (HEIGHT + TEXT)), (255, 255, 255))
    draw = ImageDraw.Draw(picture)
    for i, (panel, text) in enumerate(panels):
        at = (i % 3 * (WIDTH + GAP), i // 3 * (HEIGHT + TEXT))
        picture.paste(panel, at)
        draw.text((at[0], at[1] + HEIGHT + 5), text, font=font, fill=(40, 40, 40))
    picture.quantize(64).save(out, optimize=True)


main()
