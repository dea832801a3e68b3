"""Small meshes, and files of them in the formats of data sets of the field."""

import numpy as np
import trimesh
from scipy.io import savemat


def egg(bend=0.0):
    """Vertices and faces of a closed mesh without symmetry, bent or not."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    x, y, z = (mesh.vertices * [1.0, 1.4, 2.0]).T
    x = x + 0.2 * y * z
    return np.column_stack([x + bend * z**2, y, z]), np.array(mesh.faces)


def write_off(path, vertices, faces, *, newline="\n"):
    """An OFF file; faces may have four corners."""
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(f"{x:.9g}" for x in vertex) for vertex in vertices]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes((newline.join(lines) + newline).encode())


def write_table(path, rows, *, newline="\n"):
    """Numbers separated by blanks."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = newline.join(" ".join(f"{x:.9g}" for x in np.atleast_1d(row)) for row in rows) + newline
    path.write_bytes(text.encode())


def write_matlab(path, vertices, faces):
    """A file as TOSCA has them: ``surface`` with X, Y, Z and TRIV from 1."""
    columns = {name: vertices[:, [k]] for k, name in enumerate("XYZ")}
    savemat(path, {"surface": {**columns, "TRIV": faces + 1.0}})
