#!/usr/bin/env python3
"""What other programs read in the files that Meniscus writes.

    python3 -m venv venv && venv/bin/pip install trimesh lxml networkx pillow pygltflib pymeshlab bpy lib3mf
    venv/bin/python benches/compare/formats.py target/release/meniscus

Writes the samples `egg` (textured) and `ring` (colours of vertices) with filled holes in every format and prints
a table: a row for each file and reader with vertices, faces, and what it found of colours, texture coordinates
and images. Readers that are not installed are left out. Ends with exit code 1 if one reads other faces than
were written.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

FORMATS = ["obj", "ply", "stl", "off", "glb", "gltf", "3mf"]
SAMPLES = ["egg", "ring"]


def of_trimesh(path):
    import trimesh

    scene = trimesh.load_scene(str(path), process=False)
    meshes = list(scene.geometry.values())
    found = set()
    for mesh in meshes:
        visual = mesh.visual
        if getattr(visual, "uv", None) is not None:
            found.add("coordinates")
            material = visual.material
            image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
            if image is not None:
                found.add(f"image {image.size[0]}x{image.size[1]}")
        elif visual.kind in ("vertex", "face"):
            found.add(f"colours of {visual.kind}")
    return sum(len(m.vertices) for m in meshes), sum(len(m.faces) for m in meshes), found


def of_pygltflib(path):
    import pygltflib

    if path.suffix not in (".glb", ".gltf"):
        return None
    file = pygltflib.GLTF2().load(str(path))
    primitives = [p for mesh in file.meshes for p in mesh.primitives]
    vertices = sum(file.accessors[p.attributes.POSITION].count for p in primitives)
    faces = sum(file.accessors[p.indices].count // 3 for p in primitives)
    found = {f"{len(file.images)} images"} if file.images else set()
    if any(p.attributes.COLOR_0 is not None for p in primitives):
        found.add("colours of vertex")
    if any(p.attributes.TEXCOORD_0 is not None for p in primitives):
        found.add("coordinates")
    return vertices, faces, found


def of_pymeshlab(path):
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(path))
    vertices = faces = 0
    found = set()
    for mesh in meshes:
        vertices += mesh.vertex_number()
        faces += mesh.face_number()
        if mesh.has_vertex_color():
            found.add("colours of vertex")
        if mesh.has_face_color():
            found.add("colours of face")
        if mesh.has_wedge_tex_coord() or mesh.has_vertex_tex_coord():
            found.add("coordinates")
        for image in mesh.textures().values():
            found.add(f"image {image.width()}x{image.height()}")
    return vertices, faces, found


def of_blender(path):
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    name = str(path)
    if path.suffix == ".obj":
        bpy.ops.wm.obj_import(filepath=name)
    elif path.suffix == ".ply":
        bpy.ops.wm.ply_import(filepath=name)
    elif path.suffix == ".stl":
        bpy.ops.wm.stl_import(filepath=name)
    elif path.suffix in (".glb", ".gltf"):
        bpy.ops.import_scene.gltf(filepath=name)
    else:
        return None
    vertices = faces = 0
    found = set()
    for mesh in (thing.data for thing in bpy.data.objects if thing.type == "MESH"):
        vertices += len(mesh.vertices)
        faces += sum(len(polygon.vertices) - 2 for polygon in mesh.polygons)
        if mesh.color_attributes:
            found.add("colours of vertex")
        if mesh.uv_layers:
            found.add("coordinates")
    for image in bpy.data.images:
        if image.size[0] > 0:
            found.add(f"image {image.size[0]}x{image.size[1]}")
    return vertices, faces, found


def of_lib3mf(path):
    import lib3mf

    if path.suffix != ".3mf":
        return None
    model = lib3mf.Wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    vertices = faces = 0
    meshes = model.GetMeshObjects()
    while meshes.MoveNext():
        mesh = meshes.GetCurrentMeshObject()
        vertices += mesh.GetVertexCount()
        faces += mesh.GetTriangleCount()
    counts = {
        "images": model.GetTexture2Ds().Count(),
        "groups of coordinates": model.GetTexture2DGroups().Count(),
        "groups of colours": model.GetColorGroups().Count(),
        "groups of materials": model.GetBaseMaterialGroups().Count(),
        "warnings": reader.GetWarningCount(),
    }
    return vertices, faces, {f"{count} {name}" for name, count in counts.items() if count}


READERS = {
    "trimesh": of_trimesh,
    "pygltflib": of_pygltflib,
    "MeshLab": of_pymeshlab,
    "Blender": of_blender,
    "lib3mf": of_lib3mf,
}


RESULT = "result: "


def read(name, path):
    """Prints what a reader finds in a file: null if it is not installed or does not know the format."""
    try:
        result = READERS[name](pathlib.Path(path))
    except ImportError:
        result = None
    if result is not None:
        vertices, faces, found = result
        result = [vertices, faces, sorted(found)]
    print(RESULT + json.dumps(result))


def main():
    if sys.argv[1] == "--read":
        return read(*sys.argv[2:])
    program = sys.argv[1]
    failed = False
    print("| file | reader | vertices | faces | found |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for sample in SAMPLES:
            given = pathlib.Path(folder, f"{sample}.obj")
            subprocess.run([program, "sample", sample, "-o", given], check=True)
            for extension in FORMATS:
                path = pathlib.Path(folder, f"{sample}-filled.{extension}")
                subprocess.run([program, "fill", given, "-o", path, "--quiet"], check=True)
                known = None
                for name in READERS:
                    # each in a process of its own, because their libraries do not agree
                    words = [sys.executable, __file__, "--read", name, path]
                    run = subprocess.run(words, capture_output=True, text=True)
                    lines = [line for line in run.stdout.splitlines() if line.startswith(RESULT)]
                    if run.returncode != 0 or not lines:
                        error = (run.stderr.strip().splitlines() or ["no result"])[-1]
                        print(f"| {path.name} | {name} | | | {error} |")
                        failed = True
                        continue
                    result = json.loads(lines[-1].removeprefix(RESULT))
                    if result is None:
                        continue
                    vertices, faces, found = result
                    print(f"| {path.name} | {name} | {vertices} | {faces} | {', '.join(found)} |")
                    failed |= known is not None and known != faces
                    known = faces
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
