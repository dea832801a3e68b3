"""The interactive view of clouds and maps: one HTML file, drawn by WebGL, without a network.

`scene` says what is shown, `packing` makes text of it that a browser can read, `view_page` wraps one scene
into a page of its own. ``viewer.js`` and ``viewer.css`` draw it, with regl 2.1.1 (``regl-LICENSE.txt``).
"""
