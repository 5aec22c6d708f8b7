#!/usr/bin/env python3
"""docs/images/matching.png: the stripe edges round a board's corners.   scripts/doc_matching.py SESSION OUT.png

SESSION: of simulate-captures with Gray code. Needs the Python package and Pillow.
"""

import sys

import numpy
import procam
from PIL import Image, ImageDraw, ImageFont

ZOOM, SIDE = 5, 88  # image pixels a camera pixel; camera pixels of the shown part
EVERY = 4  # one stripe edge of so many is drawn


def main():
    folder, out = sys.argv[1:]
    session = procam.io.load_session(folder)
    size = session.projector_size
    captures = [procam.io.green_channel(procam.io.load_image(file).image)
                for file in procam.io.list_images(f"{folder}/view_00")]
    code = procam.pattern.GrayCode(size)
    decoded = procam.pattern.decode(captures, code)
    edges = procam.pattern.stripe_edges(captures, decoded, code)
    found = procam.detect.detect_board(captures[-2], session.board)
    light = procam.pattern.project_board(found, session.board, procam.detect.board_artwork(session.board), decoded, edges)
    projected = {o.point: o.pixel for o in light.observations}
    middle = numpy.mean([o.pixel for o in found.observations], axis=0)
    corner = min(found.observations, key=lambda o: numpy.linalg.norm(numpy.array(o.pixel) - middle)).pixel
    left, top = (int(c) - SIDE // 2 for c in corner)

    def at(pixel):
        """In the picture: pixel centres are whole numbers."""
        return ((pixel[0] - left + 0.5) * ZOOM, (pixel[1] - top + 0.5) * ZOOM)

    def part(image):
        crop = Image.fromarray(image[top:top + SIDE, left:left + SIDE])
        return crop.resize((SIDE * ZOOM, SIDE * ZOOM), Image.NEAREST).convert("RGB")

    font = ImageFont.truetype("DejaVuSans.ttf", 15)
    stripes, marks = part(captures[16]), part(captures[-2])
    draw = ImageDraw.Draw(marks)
    for edge in edges:
        if round(edge.projector_coordinate + 0.5) % EVERY != 0:
            continue
        x, y = at(edge.camera_pixel)
        if 0 <= x < marks.width and 0 <= y < marks.height:
            is_column = edge.axis == procam.StripeAxis.kColumn
            draw.ellipse([x - 1.7, y - 1.7, x + 1.7, y + 1.7], fill=(236, 112, 20) if is_column else (30, 110, 220))
    for o in found.observations:
        x, y = at(o.pixel)
        if 0 <= x < marks.width and 0 <= y < marks.height and o.point in projected:
            u, v = projected[o.point]
            draw.ellipse([x - 9, y - 9, x + 9, y + 9], outline=(20, 150, 60), width=3)
            text = f"{u:.2f}, {v:.2f}"
            box = draw.textbbox((x + 12, y + 6), text, font=font)
            draw.rectangle([box[0] - 3, box[1] - 2, box[2] + 3, box[3] + 2], fill=(255, 255, 255))
            draw.text((x + 12, y + 6), text, font=font, fill=(10, 100, 40))
    picture = Image.new("RGB", (2 * SIDE * ZOOM + 12, SIDE * ZOOM), (255, 255, 255))
    picture.paste(stripes, (0, 0))
    picture.paste(marks, (SIDE * ZOOM + 12, 0))
    picture.quantize(128).save(out, optimize=True)


main()
