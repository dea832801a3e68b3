"""Small glTF files, written by hand: arrays one after the other in a buffer, and the JSON that names them."""

import json
import struct

import numpy as np

TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}


class Writer:
    """Collects arrays; `content` is the JSON, to be filled in."""

    def __init__(self):
        self.data = bytearray()
        self.content = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "nodes": []}

    def view(self, data, **more):
        """Number of a buffer view of some bytes."""
        self.data += bytes(-len(self.data) % 4)
        where = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more}
        self.data += data
        self.content["bufferViews"].append(where)
        return len(self.content["bufferViews"]) - 1

    def add(self, array, kind="float32", **more):
        """Number of an accessor of an array (n,) or (n, width)."""
        values = np.asarray(array, dtype=np.dtype(kind).newbyteorder("<"))
        width = 1 if values.ndim == 1 else values.shape[1]
        view = self.view(values.tobytes())
        return self.accessor(view, COMPONENTS[kind], len(values), TYPES[width], **more)

    def accessor(self, view, component, count, kind, **more):
        entry = {"componentType": component, "count": count, "type": kind, **more}
        if view is not None:
            entry["bufferView"] = view
        self.content["accessors"].append(entry)
        return len(self.content["accessors"]) - 1

    def write_glb(self, path):
        self.content["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.content).encode()
        text += b" " * (-len(text) % 4)
        blob = bytes(self.data) + bytes(-len(self.data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        return path

    def write_gltf(self, path, uri):
        """The JSON alone; with a name as `uri` the data go beside it."""
        self.content["buffers"] = [{"byteLength": len(self.data), "uri": uri}]
        path.write_text(json.dumps(self.content))
        if not uri.startswith("data:"):
            (path.parent / uri).write_bytes(self.data)
        return path


def tube(sides=8, rings=9, length=2.0, radius=0.2):
    """Vertices and faces of a closed tube along y from 0 to its length, the ends closed by a vertex each."""
    angle = 2 * np.pi * np.arange(sides) / sides
    circle = radius * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    heights = np.linspace(0, length, rings)
    vertices = [circle + np.array([0, y, 0]) for y in heights] + [[[0, 0, 0], [0, length, 0]]]
    faces = []
    for k in range(sides):
        after = (k + 1) % sides
        for ring in range(rings - 1):
            a, b, c, d = (
                ring * sides + k,
                ring * sides + after,
                (ring + 1) * sides + k,
                (ring + 1) * sides + after,
            )
            faces += [[a, c, b], [b, c, d]]
        faces.append([rings * sides, k, after])
        faces.append([rings * sides + 1, (rings - 1) * sides + after, (rings - 1) * sides + k])
    return np.concatenate(vertices), np.array(faces)


def turn(axis, degrees):
    """Quaternion (x, y, z, w) about an axis."""
    half = np.radians(degrees) / 2
    return [*(np.sin(half) * np.eye(3)[axis]), np.cos(half)]


def two_bones(*, split=False, upper=1.0):
    """A tube whose half above y = 1 follows a bone that hangs there, ready for animations.

    Nodes: 0 the mesh, 1 the lower bone at the origin, 2 the upper bone. With `split` every face has vertices
    of its own, as behind seams everywhere.
    """
    vertices, faces = tube()
    if split:
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    writer = Writer()
    share = np.where(vertices[:, 1] > upper + 1e-6, 1.0, 0.0)
    weights = np.column_stack([1 - share, share, 0 * share, 0 * share])
    binds = np.stack([np.eye(4), np.eye(4)])
    binds[1, 1, 3] = -1.0
    attributes = {
        "POSITION": writer.add(vertices),
        "JOINTS_0": writer.add(np.tile([0, 1, 0, 0], (len(vertices), 1)), "uint8"),
        "WEIGHTS_0": writer.add(weights),
    }
    primitive = {"attributes": attributes, "indices": writer.add(faces.ravel(), "uint16")}
    matrices = writer.add(binds.transpose(0, 2, 1).reshape(2, 16))
    writer.content |= {
        "nodes": [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 1, 0]}],
        "scenes": [{"nodes": [0, 1]}],
        "meshes": [{"name": "tube", "primitives": [primitive]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": matrices}],
        "animations": [],
    }
    return writer, vertices, faces


def animate(writer, name, *, node=2, path="rotation", times, values, kind=None, interpolation="LINEAR"):
    """Add an animation of one property."""
    entry = {
        "name": name,
        "samplers": [
            {
                "input": writer.add(times),
                "output": writer.add(values, *kind or ("float32",), **({"normalized": True} if kind else {})),
                "interpolation": interpolation,
            }
        ],
        "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
    }
    writer.content["animations"].append(entry)
