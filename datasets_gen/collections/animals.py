"""The dog and the rodent inside the `dm-control` wheel as collections, posed by the joints of their models.

A skin (MuJoCo's .skn) binds vertices to bodies; the model (MJCF) says how the bodies hang together and how
far each joint turns. MuJoCo itself compiles the model and turns the bodies; the skin follows by linear
blending, as in its viewer. Both meshes are one piece once the seams of their textures are welded.

References
----------
[TDM*20] S. Tunyasuvunakool et al., "dm_control: Software and tasks for continuous control", Software
Impacts 2020.
[MAW*20] J. Merel et al., "Deep neuroethology of a virtual rodent", ICLR 2020.
"""

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from datasets_gen.cache import cache_path, fetch, store
from datasets_gen.collection import Collection
from datasets_gen.collections.animal_poses import PITCH, POSES, JointAngles
from datasets_gen.collections.closing import close, weld
from datasets_gen.collections.file_choice import pose_list
from datasets_gen.collections.skinned import collected, linear_blend_skinning
from datasets_gen.collections.wheel_files import Wheel
from datasets_gen.records import InputError

_log = logging.getLogger(__name__)

Array = NDArray[np.float64]

WHEEL = Wheel(
    package="dm_control",
    distribution="dm-control",
    version="1.0.50",
    licence="Apache-2.0",
    terms=("dm_control-*.dist-info/licenses/*",),
    install=(
        "pip install 'medialbench[animals]', or, for less, pip install mujoco and "
        "pip install --no-deps dm-control==1.0.50"
    ),
    needs=("mujoco",),
)
MODELS = {
    "dog": "locomotion/walkers/assets/dog_v2/dog.xml",
    "rodent": "locomotion/walkers/assets/rodent.xml",
}
TO_Y_UP = [1, 2, 0]
"""Order of coordinates that takes x forward, y left, z up to x left, y up, z forward."""


def load_animal(name: str, *, poses: Sequence[str] | None = None) -> Collection:
    """The dog or the rodent; vertex i is the same place of the skin in every pose.

    Parameters
    ----------
    name
        A key of `MODELS`.
    poses
        Names, default all.

    Raises
    ------
    InputError
        If a package is not installed or is another version, or there is no such pose.
    """
    told = _outlined(name, poses)
    folder = WHEEL.folder()
    path = cache_path(name, {"files": WHEEL.version}, __name__)
    collection = fetch(path)
    if collection is None:
        _log.info("building %r from the files of dm-control %s", name, WHEEL.version)
        collection = _build(name, str(folder / MODELS[name]))
        store(path, collection)
        WHEEL.write_terms()
    return replace(collection, shapes=tuple(collection[pose] for pose in told["poses"]))


def outline_animal(name: str, *, poses: Sequence[str] | None = None) -> dict[str, Any]:
    """Subject, poses and reference that `load_animal` would give.

    Parameters
    ----------
    name, poses
        As for `load_animal`.

    Returns
    -------
    dict
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str).

    Raises
    ------
    InputError
        As `load_animal`.
    """
    WHEEL.folder()
    return _outlined(name, poses)


def _outlined(name: str, poses: Sequence[str] | None) -> dict[str, Any]:
    known = list(POSES[name])
    chosen = known if poses is None else pose_list(poses, known, name)
    return {"subject": name, "poses": chosen, "reference": known[0]}


@threadpool_limits.wrap(limits=1, user_api="blas")  # the last bits of a product depend on the threads
def _build(name: str, path: str) -> Collection:
    """Read a model, close its skin and pose it."""
    import mujoco

    try:
        model = mujoco.MjModel.from_xml_path(path)
    except ValueError as error:
        raise InputError(f"{path!r} cannot be used ({error}); {WHEEL.install}") from error
    bind_bodies(model)
    skin = np.asarray(model.skin_vert, dtype=np.float64)
    welded, faces = weld(skin, model.skin_face)
    kept, faces = close(skin[welded], faces, name)
    ids = welded[kept]
    vertices, weights = skin[ids], skin_weights(model)[ids]
    posed = {}
    for pose, angles in POSES[name].items():
        moved = linear_blend_skinning(vertices, weights, *bone_motions(model, angles))
        pitch = Rotation.from_euler("y", -PITCH[name].get(pose, 0.0), degrees=True)
        posed[pose] = pitch.apply(moved)[:, TO_Y_UP]
    return collected(name, faces, posed)


def skin_weights(model: Any) -> csr_array:
    """Weights of the vertices of a model's skin for its bones, (v, bones), rows summing to 1."""
    bone = np.repeat(np.arange(model.nskinbone), model.skin_bonevertnum)
    entries = (np.asarray(model.skin_bonevertweight, dtype=np.float64), (model.skin_bonevertid, bone))
    weights = csr_array(entries, shape=(model.nskinvert, model.nskinbone))
    return csr_array(weights / np.asarray(weights.sum(axis=1)).reshape(-1, 1))


def bind_bodies(model: Any) -> None:
    """Put the bodies of a model where its skin is bound to them.

    The rodent's skin was made for a skeleton that is a fifth larger than the bodies of its model, with the
    same orientations: as it stands, it would be squeezed at every joint.
    """
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bound = {int(body): k for k, body in enumerate(model.skin_bonebodyid)}
    for body, k in bound.items():
        parent = int(model.body_parentid[body])
        if parent in bound:
            offset = model.skin_bonebindpos[k] - model.skin_bonebindpos[bound[parent]]
            model.body_pos[body] = data.xmat[parent].reshape(3, 3).T @ offset


def bone_motions(model: Any, angles: JointAngles) -> tuple[Array, Array]:
    """Motion of each bone of the skin from where it is bound, x -> turn x + shift.

    Parameters
    ----------
    model
        Compiled by MuJoCo.
    angles
        Degrees by joint; the others are at rest.

    Returns
    -------
    turns (b, 3, 3), shifts (b, 3)

    Raises
    ------
    InputError
        For a joint that is not there, or an angle beyond the range that the model declares for it.
    """
    import mujoco

    data = mujoco.MjData(model)
    for name, degrees in angles.items():
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
        if joint < 0:
            raise InputError(f"the model has no joint {name!r}")
        low, high = np.degrees(model.jnt_range[joint])
        if not low - 1e-6 <= degrees <= high + 1e-6:
            raise InputError(f"joint {name!r} turns from {low:.0f} to {high:.0f} degrees, not by {degrees:g}")
        data.qpos[model.jnt_qposadr[joint]] = np.radians(degrees)
    mujoco.mj_kinematics(model, data)
    bodies = model.skin_bonebodyid
    bind = Rotation.from_quat(np.asarray(model.skin_bonebindquat, dtype=np.float64), scalar_first=True)
    turns = data.xmat[bodies].reshape(-1, 3, 3) @ bind.inv().as_matrix()
    shifts = data.xpos[bodies] - np.einsum("bij,bj->bi", turns, model.skin_bonebindpos)
    return turns, shifts
