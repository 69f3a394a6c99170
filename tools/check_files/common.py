"""What the lichens must be, told from elements.ply and nothing else, and how they are exported."""

import os
import subprocess

import numpy as np

# One element at a corner of a cube of one metre, which is y-up: at (1, 1, 1), z-up at (1, -1, 1).
CUBE = """v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1
f 8 7 5 6\nf 4 2 1 3\nf 8 6 2 4\nf 7 3 1 5\nf 8 4 3 7\nf 6 5 1 2\n"""

# The same with UVs: each face a chart of its own, in a row.
UV_CUBE = CUBE.split("f")[0] + "".join(
    f"vt {k / 6 + x} {y}\n" for k in range(6) for x, y in [(.01, .4), (.15, .4), (.15, .54), (.01, .54)]
) + "".join(
    "f " + " ".join(f"{v}/{4 * k + i + 1}" for i, v in enumerate(face)) + "\n"
    for k, face in enumerate([[8, 7, 5, 6], [4, 2, 1, 3], [8, 6, 2, 4], [7, 3, 1, 5], [8, 4, 3, 7], [6, 5, 1, 2]])
)

WHAT = {
    "points": ["ply", "glb", "gltf", "usda", "usd", "obj", "inc", "csv", "npy", "npz", "parquet"],
    "instances": ["glb", "gltf", "usda", "inc"],
    "curves": ["ply", "glb", "gltf", "usda", "obj", "inc"],
}

SKINS = ["glb", "usda", "usd", "ply", "obj"]

# Films of six frames at 24 a second, in which elements are there or not.
FRAMES = 6
SLOW = 240
FILMS = {"skin": ["usda", "glb"], "points": ["usda", "glb"], "curves": ["usda", "glb"]}

PLY_TYPES = {"float": "<f4", "double": "<f8", "int": "<i4", "uchar": "u1"}


def read_ply(path):
    """The vertices of a binary PLY, by its header."""
    with open(path, "rb") as file:
        dtype, count = [], 0
        while (line := file.readline().split()) != [b"end_header"]:
            words = [word.decode() for word in line]
            if words[:2] == ["element", "vertex"]:
                count = int(words[2])
            elif words[0] == "element":
                break
            elif words[0] == "property":
                dtype.append((words[2], PLY_TYPES[words[1]]))
        else:
            return np.frombuffer(file.read(), dtype=dtype, count=count)
    raise AssertionError(f"{path}: more than vertices")


def thallus(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, f"thallus {' '.join(map(str, words))}: {done.stderr}"
    return done.stderr


def make(program, rock, folder):
    """Grows a lichen on the cube and one on the rock, and exports both in every way."""
    cube = os.path.join(folder, "cube.obj")
    with open(cube, "w") as file:
        file.write(CUBE)
    thallus(program, "grow", cube, "-o", f"{folder}/cube", "--elements", 1, "--radius", 0.05,
            "--at", "1,1,1", "--preview", 16)
    thallus(program, "grow", rock, "-o", f"{folder}/rock", "--elements", 600, "--preview", 16)
    for lichen in ["cube", "rock"]:
        for what, extensions in WHAT.items():
            if (lichen, what) == ("cube", "curves"):
                continue  # one element has no branches
            for extension in extensions:
                out = f"{folder}/{lichen}_{what}.{extension}"
                said = thallus(program, "export", f"{folder}/{lichen}", "--what", what, "-o", out)
                assert "warning" not in said, said
        for extension in SKINS:
            out = f"{folder}/{lichen}_skin.{extension}"
            said = thallus(program, "skin", f"{folder}/{lichen}", "-o", out, "--quiet")
            assert said == "", said
    for what, extensions in FILMS.items():
        for extension in extensions:
            out = f"{folder}/rock_{what}_film.{extension}"
            thallus(program, "animate", f"{folder}/rock", "--what", what, "--frames", FRAMES,
                    "--window", 0, "-o", out, "--quiet")
    thallus(program, "animate", f"{folder}/rock", "--frames", FRAMES, "--window", 0,
            "-o", f"{folder}/rock_frames", "--quiet")
    thallus(program, "animate", f"{folder}/rock", "--frames", FRAMES, "--what", "points", "--format", "usda",
            "-o", f"{folder}/rock_fading", "--quiet")
    thallus(program, "animate", f"{folder}/rock", "--frames", SLOW, "-o", f"{folder}/rock_slow.usda", "--quiet")
    make_maps(program, folder)


def make_maps(program, folder):
    """Bakes a lichen on the cube as PNG and as EXR, and one on the rock, which has no UVs."""
    cube = os.path.join(folder, "uv_cube.obj")
    with open(cube, "w") as file:
        file.write(UV_CUBE)
    thallus(program, "grow", cube, "-o", f"{folder}/uv_cube", "--elements", 300, "--radius", 0.02,
            "--preview", 16)
    for kind in ["png", "exr"]:
        said = thallus(program, "bake", f"{folder}/uv_cube", "-o", f"{folder}/maps_{kind}", "--format",
                       kind, "--size", 512, "--quiet")
        assert said == "", said
    thallus(program, "bake", f"{folder}/rock", "-o", f"{folder}/maps_unwrapped", "--unwrap", "--size", 512)


class Lichen:
    """The elements of a run, y-up as its mesh."""

    def __init__(self, folder):
        table = read_ply(f"{folder}/elements.ply")
        self.points = np.stack([table[k] for k in "xyz"], 1).astype(float)
        self.radius = float(table["radius"][0])
        self.birth, self.parent = table["birth"], table["parent"]
        self.probability = table["probability"]
        self.links = {(p, b) for p, b in zip(self.parent.tolist(), self.birth.tolist()) if p >= 0}
        self.nage = 1 - self.birth / max(len(table) - 1, 1)
        self.count = len(table)

    def placed(self, up):
        """Positions with this axis up."""
        x, y, z = self.points.T
        return np.stack([x, -z, y] if up == "z" else [x, y, z], 1)


def near(found, expected, tolerance, what):
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    assert found.shape == expected.shape, f"{what}: {found.shape} where {expected.shape} is expected"
    worst = np.abs(found - expected).max(initial=0)
    assert worst <= tolerance, f"{what}: off by {worst}"


def rotate(q, v):
    """The vector turned by quaternions x, y, z, w."""
    q = np.asarray(q, float)
    axis, w = q[:, :3], q[:, 3:]
    t = 2 * np.cross(axis, v)
    return v + w * t + np.cross(axis, t)


def check_frames(orient, normals, lichen, up, what, tolerance=1e-5):
    """The third axis is the normal, and growth has no part along the first and goes up the second."""
    near(np.linalg.norm(orient, axis=1), np.ones(lichen.count), tolerance, f"{what}: length")
    near(rotate(orient, [0, 0, 1]), normals, tolerance, f"{what}: normal")
    points = lichen.placed(up)
    child = lichen.parent >= 0
    way = points[child] - points[lichen.parent[child]]
    x, y = (np.sum(rotate(orient, axis)[child] * way, 1) for axis in ([1, 0, 0], [0, 1, 0]))
    assert (y > 0).all() and (np.abs(x) <= 10 * tolerance * np.linalg.norm(way, axis=1)).all(), what
