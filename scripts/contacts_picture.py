#!/usr/bin/env python3
"""Draws docs/pictures/contacts.svg: what a contact region and a penetration depth are, from what proxima says.

    scripts/contacts_picture.py build/dev/apps/cli/proxima docs/pictures/contacts.svg

Both halves are sections at y = 0 of solids made of boxes. Every number and position is the program's own.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SCALE = 150  # pixels of a unit
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def boxes_file(folder, name, boxes):
    """An OFF file of boxes ((x0, x1), (y0, y1), (z0, z1))."""
    points = [(x, y, z) for box in boxes for x in box[0] for y in box[1] for z in box[2]]
    faces = [tuple(8 * i + corner for corner in face) for i in range(len(boxes)) for face in FACES]
    lines = ["OFF", f"{len(points)} {len(faces)} 0"] + ["%r %r %r" % p for p in points] + ["3 %d %d %d" % f for f in faces]
    path = folder / name
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def ask(program, *arguments):
    return json.loads(subprocess.run([program, *arguments, "--quiet", "--json", "-"], check=True, stdout=subprocess.PIPE).stdout)


class Drawing:
    """A section: x to the right, z up, the origin at a pixel."""

    def __init__(self, x, y):
        self.x, self.y, self.parts = x, y, []

    def at(self, point):
        return self.x + SCALE * point[0], self.y - SCALE * point[-1]

    def polygon(self, corners, style):
        path = " ".join("%.2f,%.2f" % self.at(corner) for corner in corners)
        self.parts.append(f'<polygon points="{path}" style="{style}"/>')

    def box(self, box, style, pose=lambda p: p):
        self.polygon([pose((x, z)) for x, z in ((box[0][0], box[2][0]), (box[0][1], box[2][0]), (box[0][1], box[2][1]), (box[0][0], box[2][1]))],
                     style)

    def line(self, start, end, color, width=2, arrow=False, dashed=False):
        (x0, y0), (x1, y1) = self.at(start), self.at(end)
        marks = (' marker-end="url(#tip)"' if arrow else "") + (' stroke-dasharray="6 4"' if dashed else "")
        self.parts.append(f'<line x1="{x0:.2f}" y1="{y0:.2f}" x2="{x1:.2f}" y2="{y1:.2f}" stroke="{color}" stroke-width="{width}"{marks}/>')

    def circle(self, center, radius, style):
        x, y = self.at(center)
        self.parts.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:.2f}" style="{style}"/>')

    def text(self, point, words, aside=(0, 0), anchor="start", color="#222"):
        x, y = self.at(point)
        self.parts.append(f'<text x="{x + aside[0]:.2f}" y="{y + aside[1]:.2f}" text-anchor="{anchor}" fill="{color}">{words}</text>')


A_STYLE = "fill:#c9d6e8;stroke:#33507a;stroke-width:1.5"
B_STYLE = "fill:#f2c894;fill-opacity:0.65;stroke:#9a5b12;stroke-width:1.5"
GHOST = "fill:none;stroke:#9a5b12;stroke-width:1.2;stroke-dasharray:5 4"


def draw_region(program, folder, drawing):
    floor = ((-1.3, 1.3), (-1.5, 1.5), (-0.9, 0.0))
    box = ((-0.8, 0.8), (-0.6, 0.6), (-0.4, 0.4))
    degrees = 12
    shift = (0.05, 0.0, 0.42)
    pose = ",".join(map(str, shift)) + f"@0,1,0,{degrees}"
    answer = ask(program, "contacts", boxes_file(folder, "a.off", [floor]), boxes_file(folder, "b.off", [box]), "--pose", pose)
    region, = answer["poses"][0]["regions"]
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    turned = lambda p: (cosine * p[0] + sine * p[1] + shift[0], -sine * p[0] + cosine * p[1] + shift[2])
    drawing.box(floor, A_STYLE)
    drawing.box(box, B_STYLE, turned)
    drawing.text((-1.2, -0.75), "A")
    drawing.text(turned((-0.65, 0.2)), "B")
    # The contour in the section: where B's outline crosses the floor.
    corners = [turned(c) for c in ((-0.8, -0.4), (0.8, -0.4), (0.8, 0.4), (-0.8, 0.4))]
    for (x0, z0), (x1, z1) in zip(corners, corners[1:] + corners[:1]):
        if (z0 < 0) != (z1 < 0):
            drawing.circle((x0 + (x1 - x0) * z0 / (z0 - z1), 0), 4, "fill:#b3261e")
    position, normal = region["position"], region["normal"]
    tip = [p + 0.45 * n for p, n in zip(position, normal)]
    drawing.line(position, tip, "#b3261e", 2.5, arrow=True)
    drawing.circle(position, 3, "fill:#b3261e")
    drawing.text(tip, "normal, from A to B", (10, 0), color="#b3261e")
    drawing.text(position, "position", (-8, -8), "end", "#b3261e")
    deepest = region["points"][0]
    drawing.line(deepest["on_a"], deepest["on_b"], "#1b5e20", 3)
    drawing.text(deepest["on_b"], f"depth {region['depth']:.3f}", (0, 20), "middle", "#1b5e20")
    drawing.text((0, -1.25), "Contact region: a connected part of the contour (red points)", anchor="middle")


def draw_depth(program, folder, drawing):
    ell = [((-1.1, 0.9), (-1.0, 1.0), (-0.9, -0.3)), ((-1.1, -0.5), (-1.0, 1.0), (-0.9, 0.9))]
    box = ((-0.45, 0.45), (-0.4, 0.4), (-0.3, 0.3))
    shift = (-0.25, 0.0, -0.16)
    a, b = boxes_file(folder, "ell.off", ell), boxes_file(folder, "box.off", [box])
    pose, = ask(program, "contacts", a, b, "--pose", ",".join(map(str, shift)))["poses"]
    for part in ell:
        drawing.box(part, "fill:#c9d6e8;stroke:none")
    outline = [(-1.1, -0.9), (0.9, -0.9), (0.9, -0.3), (-0.5, -0.3), (-0.5, 0.9), (-1.1, 0.9)]
    drawing.polygon(outline, "fill:none;stroke:#33507a;stroke-width:1.5")
    placed = lambda p: (p[0] + shift[0], p[1] + shift[2])
    drawing.box(box, B_STYLE, placed)
    move = pose["translation"]
    drawing.box(box, GHOST, lambda p: (p[0] + shift[0] + move[0], p[1] + shift[2] + move[2]))
    center = (shift[0], shift[1], shift[2])
    drawing.line(center, [c + m for c, m in zip(center, move)], "#b3261e", 2.5, arrow=True)
    drawing.text((-0.42, 0.6), f"translation of length {math.hypot(*move):.3f}: upper bound", color="#b3261e")
    deepest = pose["deepest"]
    depths = []
    for model, point in ((a, deepest), (b, [d - s for d, s in zip(deepest, shift)])):
        points, rows = folder / "points.csv", folder / "rows.csv"
        points.write_text(",".join(map(repr, point)) + "\n")
        subprocess.run([program, "closest", model, "--points", str(points), "--signed", "--out", str(rows), "--quiet"], check=True)
        names, values = (line.split(",") for line in rows.read_text().split())
        depths.append(-float(values[names.index("signed_distance")]))
    for depth, color in zip(depths, ("#33507a", "#9a5b12")):
        drawing.circle(deepest, SCALE * depth, f"fill:none;stroke:{color};stroke-width:1.5")
    drawing.circle(deepest, 3, "fill:#1b5e20")
    drawing.text((0.85, -0.8), f"radii {depths[0]:.3f} + {depths[1]:.3f}: lower bound", anchor="end", color="#1b5e20")
    drawing.text((-1.02, 0.7), "A")
    drawing.text(placed((0.25, 0.1)), "B")
    drawing.text((-0.1, -1.25), "Penetration depth: bounds of the least translation that parts them", anchor="middle")


def main():
    program, out = sys.argv[1:]
    left, right = Drawing(230, 190), Drawing(730, 190)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        draw_region(program, folder, left)
        draw_depth(program, folder, right)
    head = ('<svg xmlns="http://www.w3.org/2000/svg" width="960" height="410" viewBox="0 0 960 410" font-family="sans-serif" font-size="14">\n'
            '<defs><marker id="tip" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="6" markerHeight="6" orient="auto">'
            '<path d="M0,0 L10,5 L0,10 z" fill="#b3261e"/></marker></defs>\n<rect width="960" height="410" fill="white"/>\n')
    pathlib.Path(out).write_text(head + "\n".join(left.parts + right.parts) + "\n</svg>\n")


if __name__ == "__main__":
    main()
