"""A view that a notebook shows and that saves itself as a page."""

import html
import os
from dataclasses import dataclass
from pathlib import Path

from reports.viewer.scene import Scene
from reports.viewer.view_page import view_page, write_view


@dataclass(frozen=True)
class InteractiveView:
    """A scene that can be turned: shown by a notebook, or saved as a page that needs no network.

    Attributes
    ----------
    scene : Scene
    height : int
        Pixels in a notebook.
    """

    scene: Scene
    height: int = 640

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page, atomically.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        write_view(self.scene, Path(path))

    def _repr_html_(self) -> str:
        """The page in a frame of its own, as notebooks ask for it."""
        page = html.escape(view_page(self.scene))
        return (
            f'<iframe srcdoc="{page}" title="{html.escape(self.scene.title)}" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )
