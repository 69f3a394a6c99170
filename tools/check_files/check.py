"""Opens what `thallus export` wrote in the libraries that others read it with.

    check.py FOLDER        after make.py THALLUS FOLDER

Needs numpy, plyfile, pyarrow, trimesh and usd-core, and, by NODE_PATH, the npm package
gltf-validator.
"""


import os
import subprocess
import sys

import numpy as np
import plyfile
import pyarrow.parquet
import trimesh
from pxr import Usd, UsdGeom, UsdValidation

from common import FRAMES, SKINS, SLOW, Lichen, check_frames, near

HERE = os.path.dirname(os.path.abspath(__file__))


def check_columns(get, lichen, up, what):
    """A table by a function from name to column."""
    near(np.stack([get(k) for k in "xyz"], 1), lichen.placed(up), 1e-6, f"{what}: position")
    near(get("birth"), lichen.birth, 0, f"{what}: birth")
    near(get("parent"), lichen.parent, 0, f"{what}: parent")
    near(get("radius"), np.full(lichen.count, lichen.radius), 1e-9, f"{what}: radius")
    near(get("probability"), lichen.probability, 1e-7, f"{what}: probability")
    near(get("nage"), lichen.nage, 1e-6, f"{what}: nage")
    orient = np.stack([get(f"orient_{k}") for k in "xyzw"], 1)
    normals = np.stack([get(f"n{k}") for k in "xyz"], 1)
    check_frames(orient, normals, lichen, up, f"{what}: orient")
    for name in ["density", "rim_distance", "strahler", "depth", "branch_radius", "colony", "source_u", "source_v"]:
        assert len(get(name)) == lichen.count, f"{what}: {name}"
    parent = lichen.parent
    depth = np.asarray(get("depth"))
    near(depth[parent >= 0] - depth[parent[parent >= 0]], np.ones((parent >= 0).sum()), 0, what)


def check_tables(stem, lichen):
    def csv():
        with open(f"{stem}.csv") as file:
            names = file.readline().strip().split(",")
            table = np.loadtxt(file, delimiter=",", ndmin=2)
        return lambda name: table[:, names.index(name)]

    check_columns(csv(), lichen, "y", "csv")
    npy = np.load(f"{stem}.npy")
    check_columns(lambda name: npy[name], lichen, "y", "npy")
    parquet = pyarrow.parquet.read_table(f"{stem}.parquet")
    assert parquet.column_names == list(npy.dtype.names)
    for name in npy.dtype.names:
        column = parquet.column(name).to_numpy()
        assert column.dtype == npy[name].dtype and (column == npy[name]).all(), f"parquet: {name}"
    vertices = plyfile.PlyData.read(f"{stem}.ply")["vertex"]
    check_columns(lambda name: vertices[name], lichen, "z", "ply")
    with np.load(f"{stem}.npz") as npz:
        near(npz["position"], lichen.points, 1e-6, "npz: position")
        near(npz["parent"], lichen.parent, 0, "npz: parent")
        check_frames(npz["orient"], npz["normal"], lichen, "y", "npz: orient")
        assert (npz["density"] == npy["density"]).all()


def open_stage(path):
    stage = Usd.Stage.Open(path)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    problems = [e.GetMessage() for e in UsdValidation.ValidationContext(validators).Validate(stage)]
    assert not problems, f"{path}: {problems}"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetPath() == "/lichen"
    return stage


def check_usd(stem, lichen):
    for extension in ["usda", "usd"]:
        stage = open_stage(f"{stem}_points.{extension}")
        points = UsdGeom.Points(stage.GetPrimAtPath("/lichen/elements"))
        near(points.GetPointsAttr().Get(), lichen.points, 1e-6, "usd: points")
        near(points.GetIdsAttr().Get(), lichen.birth, 0, "usd: ids")
        widths = np.full(lichen.count, 2 * lichen.radius)
        near(points.GetWidthsAttr().Get(), widths, 1e-6, "usd: widths")
        primvars = UsdGeom.PrimvarsAPI(points)
        get = lambda name: primvars.GetPrimvar(name).Get()
        assert len(get("displayColor")) == lichen.count
        near(get("birth"), lichen.birth, 0, "usd: birth")
        near(get("parent"), lichen.parent, 0, "usd: parent")
        near(get("nage"), lichen.nage, 1e-6, "usd: nage")
        orient = np.array([[*q.imaginary, q.real] for q in get("orient")])
        check_frames(orient, points.GetNormalsAttr().Get(), lichen, "y", "usd: orient")
        extent = np.array(points.GetExtentAttr().Get())
        near(extent, UsdGeom.Points.ComputeExtent(points.GetPointsAttr().Get(),
                                                  points.GetWidthsAttr().Get()), 1e-6, "usd: extent")
    check_usd_instances(stem, lichen)


def check_usd_instances(stem, lichen):
    stage = open_stage(f"{stem}_instances.usda")
    lobes = UsdGeom.PointInstancer(stage.GetPrimAtPath("/lichen/lobes"))
    time = Usd.TimeCode.Default()
    transforms = lobes.ComputeInstanceTransformsAtTime(time, time)
    assert len(transforms) == lichen.count
    near([t.ExtractTranslation() for t in transforms], lichen.points, 1e-6, "instances: place")
    as_points = open_stage(f"{stem}_points.usda")
    points = UsdGeom.Points(as_points.GetPrimAtPath("/lichen/elements"))
    tops = np.array([t.TransformDir((0, 0, 1)) for t in transforms])
    normals = np.array(points.GetNormalsAttr().Get())
    near(tops, normals * lichen.radius, 2e-3 * lichen.radius, "instances: normal")
    assert stage.GetPrimAtPath(lobes.GetPrototypesRel().GetTargets()[0]).IsA(UsdGeom.Mesh)


def check_usd_curves(stem, lichen):
    stage = open_stage(f"{stem}_curves.usda")
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/lichen/branches"))
    counts = curves.GetCurveVertexCountsAttr().Get()
    birth = UsdGeom.PrimvarsAPI(curves).GetPrimvar("birth").Get()
    near(curves.GetPointsAttr().Get(), lichen.points[birth], 1e-6, "curves: points")
    widths = np.array(curves.GetWidthsAttr().Get())
    assert sum(counts) == len(birth) == len(widths)
    near(UsdGeom.PrimvarsAPI(curves).GetPrimvar("pscale").Get(), widths / 2, 1e-9, "curves: pscale")
    links, start = [], 0
    for count in counts:
        one = slice(start, start + count)
        links += zip(birth[one][:-1], birth[one][1:])
        assert (np.diff(widths[one]) < 0).all(), "branches taper"
        start += count
    assert len(links) == len(set(links)) and set(links) == lichen.links


def check_gltf(stem, lichen):
    files = [f"{stem}_{what}.{e}" for what in ["points", "instances", "curves", "skin", "skin_film", "points_film", "curves_film"]
             for e in ["glb", "gltf"] if os.path.exists(f"{stem}_{what}.{e}")]
    files += [f"{os.path.dirname(stem)}/maps_{kind}/lichened.glb" for kind in ["png", "exr", "unwrapped"]]
    done = subprocess.run(["node", f"{HERE}/validate_gltf.js", *files], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    for extension in ["glb", "gltf"]:
        cloud = trimesh.load(f"{stem}_points.{extension}", process=False)
        near(list(cloud.geometry.values())[0].vertices, lichen.points, 1e-6, "trimesh: points")


def check_trimesh(stem, lichen):
    cloud = trimesh.load(f"{stem}_points.ply", process=False)
    near(cloud.vertices, lichen.placed("z"), 1e-6, "trimesh: ply")
    assert len(cloud.colors) == lichen.count


def check_skins(stem, lichen):
    """The mesh of every format is closed, and the same but for its axes."""
    stage = open_stage(f"{stem}_skin.usda")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/lichen/skin"))
    points = np.array(mesh.GetPointsAttr().Get(), float)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    valid, why = UsdGeom.Mesh.ValidateTopology(
        mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), len(points))
    assert valid, why
    near(mesh.GetExtentAttr().Get(), [points.min(0), points.max(0)], 1e-6, "skin: extent")
    primvars = UsdGeom.PrimvarsAPI(mesh)
    birth = np.array(primvars.GetPrimvar("birth").Get())
    assert birth.shape == (len(points),) and 0 <= birth.min() and birth.max() < lichen.count
    for name in ["displayColor", "density", "rim_distance", "colony"]:
        assert len(primvars.GetPrimvar(name).Get()) == len(points), f"skin: {name}"
    for extension in SKINS:
        if extension in ("usd", "usda"):
            continue
        read = trimesh.load(f"{stem}_skin.{extension}", process=False, force="mesh")
        assert read.is_watertight and read.is_winding_consistent and read.volume > 0, extension
        x, y, z = points.T
        expected = np.stack([x, -z, y] if extension == "ply" else [x, y, z], 1)
        near(read.bounds, [expected.min(0), expected.max(0)], 1e-5, f"skin: {extension}")
        assert len(read.faces) == len(corners), extension


def check_films(stem, lichen):
    """Time samples are those of frames by themselves, and as many elements as the frame has."""
    stage = open_stage(f"{stem}_skin_film.usda")
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1, FRAMES)
    assert stage.GetTimeCodesPerSecond() == 24
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/lichen/skin"))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    triangles = []
    for frame in range(1, FRAMES + 1):
        points = np.array(mesh.GetPointsAttr().Get(frame), float)
        corners, counts = (a.Get(frame) for a in (mesh.GetFaceVertexIndicesAttr(), mesh.GetFaceVertexCountsAttr()))
        valid, why = UsdGeom.Mesh.ValidateTopology(corners, counts, len(points))
        assert valid, why
        alone = trimesh.load(f"{stem}_frames/frame_{frame:04}.ply", process=False)
        assert alone.is_watertight and alone.volume > 0
        near(points, np.stack([alone.vertices.T[0], alone.vertices.T[2], -alone.vertices.T[1]], 1), 1e-6,
             f"skin film: frame {frame}")
        near(np.array(corners).reshape(-1, 3), alone.faces, 0, "skin film: corners")
        near(mesh.GetExtentAttr().Get(frame), [points.min(0), points.max(0)], 1e-6, "skin film: extent")
        for name in ["displayColor", "birth", "density", "colony"]:
            assert len(primvars.GetPrimvar(name).Get(frame)) == len(points), f"skin film: {name}"
        triangles.append(len(alone.faces))
    assert (np.diff(triangles) > 0).all()
    stage = open_stage(f"{stem}_points_film.usda")
    points = UsdGeom.Points(stage.GetPrimAtPath("/lichen/elements"))
    for frame in range(1, FRAMES + 1):
        count = lichen.count * frame // FRAMES
        near(points.GetIdsAttr().Get(frame), lichen.birth[:count], 0, "points film: ids")
        near(points.GetPointsAttr().Get(frame), lichen.points[:count], 1e-6, "points film")
        near(points.GetWidthsAttr().Get(frame), np.full(count, 2 * lichen.radius), 1e-6, "points film: widths")
    stage = open_stage(f"{stem}_curves_film.usda")
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/lichen/branches"))
    for frame in range(1, FRAMES + 1):
        birth = np.array(UsdGeom.PrimvarsAPI(curves).GetPrimvar("birth").Get(frame))
        assert birth.max() == lichen.count * frame // FRAMES - 1
        assert sum(curves.GetCurveVertexCountsAttr().Get(frame)) == len(birth)
        near(curves.GetPointsAttr().Get(frame), lichen.points[birth], 1e-6, "curves film")


def check_fading(stem, lichen):
    """Elements that come are small in numbered frames too, for programs that read widths and for Houdini."""
    for frame in range(1, FRAMES + 1):
        stage = open_stage(f"{stem}_fading/frame_{frame:04}.usda")
        points = UsdGeom.Points(stage.GetPrimAtPath("/lichen/elements"))
        get = lambda name: np.array(UsdGeom.PrimvarsAPI(points).GetPrimvar(name).Get())
        influence = get("influence")
        assert frame == FRAMES or (influence < 1).any(), f"fading: frame {frame}"
        near(points.GetWidthsAttr().Get(), 2 * lichen.radius * influence, 1e-6, "fading: widths")
        near(get("pscale"), lichen.radius * influence, 1e-6, "fading: pscale")


def check_slow_film(stem):
    """Skins are held between frames, as many vertices as the next may have."""
    stage = open_stage(f"{stem}_slow.usda")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/lichen/skin"))
    corners = [np.array(mesh.GetFaceVertexIndicesAttr().Get(frame)) for frame in range(1, SLOW + 1)]
    doubled = 0
    for frame, (now, later) in enumerate(zip(corners, corners[1:]), 1):
        points = np.array(mesh.GetPointsAttr().Get(frame))
        doubled += len(now) > 0 and now.max() + 1 < len(points)
        if not np.array_equal(now, later):
            near(np.array(mesh.GetPointsAttr().Get(frame + 0.5)), points, 0, f"slow film: frame {frame}")
    assert doubled > 0, "slow film: no two frames have as many vertices"


def check_obj(stem, lichen, curves):
    vertices, links = [], []
    with open(stem) as file:
        for line in file:
            match line.split():
                case ["v", *numbers]:
                    vertices.append([float(n) for n in numbers[:3]])
                case ["l", *numbers]:
                    start, end = [int(n) - 1 for n in numbers]
                    links.append((start, end))
    near(vertices, lichen.points, 1e-6, "obj")
    assert set(links) == (lichen.links if curves else set())


def main(folder):
    for name in ["cube", "rock"]:
        lichen, stem = Lichen(f"{folder}/{name}"), f"{folder}/{name}"
        check_tables(f"{stem}_points", lichen)
        check_usd(stem, lichen)
        check_gltf(stem, lichen)
        check_trimesh(stem, lichen)
        check_skins(stem, lichen)
        check_obj(f"{stem}_points.obj", lichen, False)
    near(Lichen(f"{folder}/cube").points, [[1, 1, 1]], 1e-7, "the corner of the cube")
    check_usd_curves(f"{folder}/rock", lichen)
    check_films(f"{folder}/rock", lichen)
    check_fading(f"{folder}/rock", lichen)
    check_slow_film(f"{folder}/rock")
    check_obj(f"{folder}/rock_curves.obj", lichen, True)
    edges = plyfile.PlyData.read(f"{folder}/rock_curves.ply")["edge"].data
    assert {tuple(edge) for edge in edges.tolist()} == lichen.links
    print("check.py: all files say what the elements are")


main(sys.argv[1])
