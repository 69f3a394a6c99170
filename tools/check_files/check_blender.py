"""Opens what `thallus export` wrote in Blender (the Python package bpy), and looks at what arrives.

    check_blender.py FOLDER        after make.py THALLUS ROCK.obj FOLDER

Blender is z-up and turns what it imports, by the data or by the object.
"""

import json
import os
import sys

import bpy
import numpy as np

from common import FRAMES, Lichen, check_frames, near

IMPORT = {
    "ply": lambda path: bpy.ops.wm.ply_import(filepath=path),
    "obj": lambda path: bpy.ops.wm.obj_import(filepath=path),
    "usda": lambda path: bpy.ops.wm.usd_import(filepath=path),
    "usd": lambda path: bpy.ops.wm.usd_import(filepath=path),
    "glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    "gltf": lambda path: bpy.ops.import_scene.gltf(filepath=path),
}


def load(path):
    """The file alone in the scene; its first object with vertices, points or curves."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert IMPORT[path.rsplit(".", 1)[1]](path) == {"FINISHED"}, path
    kinds = ("POINTCLOUD", "CURVES", "MESH")
    return next(o for o in bpy.context.scene.objects if o.type in kinds)


def attribute(thing, name):
    found = thing.data.attributes.get(name)
    assert found, f"{name} is not among {[a.name for a in thing.data.attributes]}"
    if found.data_type == "QUATERNION":
        wxyz = np.array([tuple(d.value) for d in found.data])
        return wxyz[:, [1, 2, 3, 0]]
    if found.data_type == "FLOAT_VECTOR":
        return np.array([tuple(d.vector) for d in found.data])
    if found.data_type == "FLOAT_COLOR":
        return np.array([tuple(d.color) for d in found.data])
    return np.array([d.value for d in found.data])


def places(thing):
    """Positions in the world."""
    return np.array([tuple(thing.matrix_world @ d.vector) for d in thing.data.attributes["position"].data])


def check_scalars(thing, lichen, name, what):
    near(attribute(thing, name("birth")), lichen.birth, 0, f"{what}: birth")
    near(attribute(thing, name("parent")), lichen.parent, 0, f"{what}: parent")
    near(attribute(thing, name("nage")), lichen.nage, 1e-6, f"{what}: nage")
    near(attribute(thing, name("probability")), lichen.probability, 1e-6, f"{what}: probability")
    for other in ["colony", "density", "rim_distance", "strahler", "depth", "branch_radius", "source_u", "source_v"]:
        assert len(attribute(thing, name(other))) == lichen.count, f"{what}: {other}"


def check_points(stem, lichen):
    for extension in ["ply", "usda", "usd", "glb", "gltf", "obj"]:
        thing = load(f"{stem}_points.{extension}")
        near(places(thing), lichen.placed("z"), 1e-5, extension)
        if extension == "obj":
            assert len(attribute(thing, "Color")) == lichen.count
            continue
        gltf = extension in ("glb", "gltf")
        name = (lambda n: f"_{n.upper()}") if gltf else (lambda n: n)
        check_scalars(thing, lichen, name, extension)
        radius = np.full(lichen.count, lichen.radius)
        near(attribute(thing, name("radius")), radius, 1e-6, f"{extension}: radius")
        if extension in ("usda", "usd"):
            check_frames(attribute(thing, "orient"), attribute(thing, "N"), lichen, "y", extension)
        else:
            q = np.stack([attribute(thing, name(f"orient_{k}")) for k in "xyzw"], 1)
            near(np.linalg.norm(q, axis=1), np.ones(lichen.count), 1e-5, f"{extension}: orient")


def check_instances(stem, lichen):
    # Smooth normals, y-up, which check.py has compared with the other files.
    x, y, z = np.load(f"{stem}_points.npz")["normal"].T
    normals = np.stack([x, -z, y], 1)
    load(f"{stem}_instances.usda")
    graph = bpy.context.evaluated_depsgraph_get()
    found = [placed(i.matrix_world, i.object.data) for i in graph.object_instances if i.is_instance]
    check_lobes(np.array(found), lichen, normals, "usda")
    for extension in ["glb", "gltf"]:
        load(f"{stem}_instances.{extension}")
        lobes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
        found = [placed(o.matrix_world, o.data) for o in lobes]
        check_lobes(np.array(found), lichen, normals, extension)


def placed(matrix, mesh):
    """A lobe's origin and the way to its top, which is the vertex nearest to the origin."""
    top = min((v.co for v in mesh.vertices), key=lambda co: co.length)
    return [tuple(matrix.translation), tuple(matrix @ top - matrix.translation)]


def check_lobes(found, lichen, normals, what):
    """As many, in the same places, as high, and upright on the surface; in any order."""
    assert len(found) == lichen.count, f"{what}: {len(found)} instances"
    order = lambda points: np.lexsort(np.round(points, 4).T)
    found, places = found[order(found[:, 0])], lichen.placed("z")
    near(found[:, 0], places[order(places)], 1e-5, f"{what}: places of instances")
    tops = 0.38 * lichen.radius * normals[order(places)]
    near(found[:, 1], tops, 5e-3 * lichen.radius, f"{what}: tops of instances")


def check_curves(stem, lichen):
    thing = load(f"{stem}_curves.usda")
    birth = attribute(thing, "birth")
    near(places(thing), lichen.placed("z")[birth], 1e-5, "curves: places")
    radii = attribute(thing, "radius")
    near(radii, attribute(thing, "branch_radius"), 1e-6, "curves: radius")
    for extension in ["ply", "obj", "glb", "gltf"]:
        if not os.path.exists(f"{stem}_curves.{extension}"):
            continue
        thing = load(f"{stem}_curves.{extension}")
        near(places(thing), lichen.placed("z"), 1e-5, f"curves: {extension}")
        edges = {tuple(sorted(e.vertices)) for e in thing.data.edges}
        assert edges == lichen.links, f"curves: edges of {extension}"


def check_skins(stem, lichen):
    """In every format the skin lies on the elements, coloured, with its attributes."""
    low, high = lichen.placed("z").min(0), lichen.placed("z").max(0)
    for extension in ["glb", "usda", "usd", "ply", "obj"]:
        thing = load(f"{stem}_skin.{extension}")
        found = places(thing)
        margin = 3 * lichen.radius
        assert (found.min(0) > low - margin).all() and (found.max(0) < high + margin).all(), extension
        if lichen.count > 1:
            assert (found.min(0) < low).all() and (found.max(0) > high).all(), extension
        assert len(thing.data.color_attributes) == 1, f"skin: {extension}"
        if extension in ("usda", "usd"):
            nodes = thing.data.materials[0].node_tree.nodes
            assert [n.attribute_name for n in nodes if n.type == "ATTRIBUTE"] == ["displayColor"], extension
        if extension == "obj":
            continue
        name = (lambda n: f"_{n.upper()}") if extension == "glb" else (lambda n: n)
        birth = attribute(thing, name("birth"))
        assert 0 <= birth.min() and birth.max() < lichen.count, f"skin: {extension}"
        for other in ["density", "rim_distance", "colony"]:
            assert len(attribute(thing, name(other))) == len(birth), f"skin: {extension}: {other}"


def texels(path):
    """The first channel of an image, as its file has it."""
    image = bpy.data.images.load(os.path.abspath(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    return np.array(image.pixels[:], float).reshape(height, width, -1)[..., 0]


def check_maps(folder):
    """The baked cube wears its maps, and EXR and PNG say the same."""
    thing = load(f"{folder}/maps_png/lichened.glb")
    assert thing.data.uv_layers and len(thing.data.polygons) == 12, "the baked mesh"
    nodes = thing.data.materials[0].node_tree.nodes
    shader = next(n for n in nodes if n.type == "BSDF_PRINCIPLED")
    for socket in ["Base Color", "Roughness", "Metallic", "Normal"]:
        assert shader.inputs[socket].is_linked, f"the baked material: {socket}"
    images = [n.image for n in nodes if n.type == "TEX_IMAGE"]
    assert images and all(tuple(image.size) == (512, 512) for image in images), "the baked images"
    with open(f"{folder}/maps_png/maps.json") as file:
        highest = json.load(file)["highest_meters"]
    for name, factor in [("mask", 1), ("height", highest), ("birth", 1), ("normal", 1)]:
        png, exr = (texels(f"{folder}/maps_{kind}/{name}.{kind}") for kind in ["png", "exr"])
        assert png.max() > 0.5, name
        near(exr, png * factor, factor * (0.003 if name == "mask" else 0.001), f"{name}.exr")


def check_unwrapped(folder):
    """The rock has charts of its own, that fill half of the image and lie in it."""
    thing = load(f"{folder}/maps_unwrapped/lichened.glb")
    uvs = np.empty(2 * len(thing.data.loops))
    thing.data.uv_layers[0].uv.foreach_get("vector", uvs)
    assert 0 <= uvs.min() and uvs.max() <= 1, "the charts"
    a, b, c = np.moveaxis(uvs.reshape(-1, 3, 2), 1, 0)
    areas = 0.5 * np.cross(b - a, c - a)
    assert (areas > 0).all() and 0.5 < areas.sum() < 1, f"the charts: {areas.min()}, {areas.sum()}"


def check_films(stem, lichen):
    """Played frame by frame, USD shows the meshes of the numbered files, and glTF one at a time."""
    counts = []
    for frame in range(1, FRAMES + 1):
        counts.append(len(load(f"{stem}_frames/frame_{frame:04}.ply").data.polygons))
    thing = load(f"{stem}_skin_film.usda")
    scene = bpy.context.scene
    assert scene.render.fps == 24 and (scene.frame_start, scene.frame_end) == (1, FRAMES)
    near([faces(thing, frame) for frame in range(1, FRAMES + 1)], counts, 0, "skin film: faces")
    thing = load(f"{stem}_points_film.usda")
    for frame in range(1, FRAMES + 1):
        points = evaluated(thing, frame).data.points
        assert len(points) == lichen.count * frame // FRAMES, f"points film: {len(points)}"
        near([p.radius for p in points], np.full(len(points), lichen.radius), 1e-6, "points film")
    load(f"{stem}_skin_film.glb")
    scene = bpy.context.scene
    assert scene.render.fps == 24
    meshes = [o for o in scene.objects if o.type == "MESH"]
    assert len(meshes) == FRAMES
    for frame in range(FRAMES):
        scene.frame_set(frame)
        shown = [len(o.data.polygons) for o in meshes if o.matrix_world.determinant() > 0.5]
        assert shown == [counts[frame]], f"skin film, glb: {shown} at frame {frame}"


def evaluated(thing, frame):
    bpy.context.scene.frame_set(frame)
    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get())


def faces(thing, frame):
    return len(evaluated(thing, frame).data.polygons)


def main(folder):
    for name in ["cube", "rock"]:
        lichen = Lichen(f"{folder}/{name}")
        check_points(f"{folder}/{name}", lichen)
        check_instances(f"{folder}/{name}", lichen)
        check_skins(f"{folder}/{name}", lichen)
    check_curves(f"{folder}/rock", lichen)
    check_maps(folder)
    check_unwrapped(folder)
    check_films(f"{folder}/rock", lichen)
    print("check_blender.py: Blender", bpy.app.version_string, "finds what the elements are")


# Blender may hang when it is left.
code = 1
try:
    main(sys.argv[1])
    code = 0
except BaseException:
    import traceback

    traceback.print_exc()
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
