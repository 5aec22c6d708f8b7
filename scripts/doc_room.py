#!/usr/bin/env python3
"""Draws docs/images/undistorted.png: an image on a slanted wall, shown as it is and as procam shows it, in a simulated room.

    PYTHONPATH=BUILD/src/python/package scripts/doc_room.py OUTPUT.png

Needs procam's Python package and PIL.
"""
import sys

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import procam
from procam import simulate

WALL_TURN = np.radians(38)  # about the vertical


def rotation(axis, angle):
    axis = np.asarray(axis, float)
    return np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))


def rectangle(name, pose, low, high, paint):
    return simulate.Body(name, simulate.Rectangle(np.array(low), np.array(high)), pose, paint)


def person(x, z, height):
    """A figure for scale: its feet on the floor, which is at y = 1.3."""
    floor, radius = 1.3, 0.17
    # A cylinder stands on its frame's z axis, which points up here.
    upright = procam.Pose()
    upright.rotation = rotation([1, 0, 0], np.pi / 2)
    upright.translation = np.array([x, floor, z])
    head = procam.Pose()
    head.translation = np.array([x, floor - height + 0.12, z])
    return [simulate.Body("body", simulate.Cylinder(radius, 0, height - 0.3), upright, 0.12),
            simulate.Body("head", simulate.Sphere(0.12), head, 0.2)]


def room():
    wall = procam.Pose()
    wall.rotation = rotation([0, 1, 0], WALL_TURN)
    wall.translation = np.array([0.15, -0.05, 2.6])
    floor = procam.Pose()
    floor.rotation = rotation([1, 0, 0], np.pi / 2)
    floor.translation = np.array([0, 1.3, 2])
    back = procam.Pose()
    back.translation = np.array([0, 0, 4.6])
    made = simulate.Room()
    made.ambient = 0.22
    made.bodies = [rectangle("wall", wall, [-1.75, -1.15], [1.75, 1.35], 0.8), rectangle("floor", floor, [-6, -6], [6, 6], 0.35),
                   rectangle("back", back, [-6, -4], [6, 1.3], 0.5), *person(-1.45, 3.35, 1.7)]
    return made, wall


def main():
    output = sys.argv[1]
    card = procam.io.load_image("examples/data/test_card.png").image
    size = procam.ImageSize(1024, 640)
    projector = procam.Projector(procam.Camera(size, procam.Intrinsics(1150, 1150, 511.5, 319.5, 0), procam.NoDistortion()))
    made, wall_pose = room()

    # As it is: the image in the middle of the projector's frame.
    plain = np.zeros((640, 1024, 3), np.uint8)
    shown = np.asarray(Image.fromarray(np.asarray(card)).convert("RGB").resize((640, 426), Image.LANCZOS))
    plain[107:533, 192:832] = shown

    # As procam draws it: a surface of the same height on the wall.
    surface = procam.Surface()
    surface.name = "wall"
    planar = procam.PlanarSurface()
    planar.frame = "rig"
    planar.frame_from_surface = wall_pose
    planar.content = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    planar.points = np.array([[-1.1, -0.55], [0.55, -0.55], [0.55, 0.55], [-1.1, 0.55]], float)
    surface.geometry = planar
    surfaces = procam.SurfaceSet()
    surfaces.surfaces = [surface]
    rig_projector = procam.RigProjector("projector", projector, procam.Pose())
    solved = procam.surface.solve_surfaces(surfaces, rig_projector)
    scene = procam.Scene([procam.SceneItem(solved.surfaces[0].placement, np.asarray(Image.fromarray(np.asarray(card)).convert("RGB")))])
    frame = procam.render.render(scene, projector)

    # The eye stands before the wall, where a visitor would.
    eye = procam.Camera(procam.ImageSize(640, 480), procam.Intrinsics(370, 370, 319.5, 209.5, 0), procam.NoDistortion())
    eye_pose = procam.Pose()
    eye_pose.rotation = rotation([0, 1, 0], WALL_TURN - np.radians(4))
    normal = np.array([-np.sin(WALL_TURN), 0, -np.cos(WALL_TURN)])
    eye_pose.translation = np.array([0.30, 0.12, 2.6]) + 2.75 * normal
    seen = []
    for picture in (plain, frame):
        light = simulate.RoomLight()
        light.projector = projector
        light.room_from_projector = procam.Pose()
        light.frames = [picture]
        # Brighter than light alone: rooms with a projector are dark.
        lit = np.asarray(simulate.preview(made, [light], eye, eye_pose)) / 255.0
        seen.append((255 * lit ** 0.65).astype(np.uint8))

    panels = [("shown as it is: distorted on the slanted wall", seen[0]), ("the frame that procam draws", frame),
              ("the same wall, undistorted", seen[1])]
    height, gap, caption = 330, 12, 30
    font = ImageFont.truetype("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", 16)
    pictures = [Image.fromarray(np.asarray(p)).convert("RGB") for _, p in panels]
    pictures = [p.resize((round(p.width * height / p.height), height), Image.LANCZOS) for p in pictures]
    sheet = Image.new("RGB", (sum(p.width for p in pictures) + 2 * gap, height + caption), "white")
    draw = ImageDraw.Draw(sheet)
    x = 0
    for (words, _), picture in zip(panels, pictures):
        sheet.paste(picture, (x, 0))
        draw.text((x + 2, height + 7), words, fill=(34, 34, 34), font=font)
        x += picture.width + gap
    sheet.save(output)


if __name__ == "__main__":
    main()
