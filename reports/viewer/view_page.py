"""One scene as a page of its own: a file that opens from disk, without a network."""

import html
from importlib.resources import files
from pathlib import Path

from datasets_gen.records import atomic_path
from reports.viewer.packing import packed
from reports.viewer.scene import Scene

REGL = "regl-2.1.1.min.js"

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>
body {{ margin: 0; padding: 14px; background: Canvas; color: CanvasText;
  font: 15px/1.5 system-ui, sans-serif; }}
h1 {{ font-size: 18px; margin: 0 0 10px; }}
{style}
</style>
</head>
<body>
<h1>{title}</h1>
<div id="view">Reading the clouds ...</div>
<script id="scene" type="application/octet-stream">{scene}</script>
<script>{regl}</script>
<script>{script}</script>
<script>
const element = document.getElementById("view");
MedialView.decode(document.getElementById("scene").textContent).then(
  (scene) => {{ window.view = MedialView.mount(element, scene); }},
  (error) => {{ element.textContent = "This browser cannot read the clouds: " + error; }});
</script>
</body>
</html>
"""


def view_page(scene: Scene) -> str:
    """The HTML of a scene."""
    return PAGE.format(
        title=html.escape(scene.title),
        style=resource("viewer.css"),
        scene=packed(scene),
        regl=resource(REGL),
        script=resource("viewer.js"),
    )


def write_view(scene: Scene, path: Path) -> None:
    """Write the page of a scene, atomically."""
    with atomic_path(path) as temporary:
        temporary.write_text(view_page(scene), encoding="utf-8")


def resource(name: str) -> str:
    """Text of a file of this folder."""
    return files("reports.viewer").joinpath(name).read_text(encoding="utf-8")
