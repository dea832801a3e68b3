"""Links that the pages and docstrings imply: names in code, pages by path, files of the repository."""

import re
from typing import Any

from docutils import nodes
from reference_pages import FACE, PACKAGES, public_names, source_files
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

AT_ROOT = {"README.md": "index.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
"""Files of the repository's root that are pages here."""
DOTTED = re.compile(r"((?:[a-z]\w*\.)+\w+)(?:\(.*\))?")
PAGE = re.compile(r"docs/(\w[\w-]*)\.md")


def root_links(app: Sphinx, path: Any, docname: str, content: list[str]) -> None:
    """Make links of a file in the repository's root right for the page that includes it."""
    text = content[0].replace("](docs/", "](")
    for name in ("CITATION.cff", "LICENSE"):
        text = text.replace(f"]({name})", f"](../{name})")
    content[0] = _pages_for_files(text, "")


def page_links(app: Sphinx, docname: str, content: list[str]) -> None:
    """Let links to a file in the repository's root go to the page that includes it."""
    content[0] = _pages_for_files(content[0], "../")


def _pages_for_files(text: str, prefix: str) -> str:
    for name, page in AT_ROOT.items():
        text = text.replace(f"]({prefix}{name}", f"]({page}")
    return text


def known_names(app: Sphinx) -> None:
    """Remember by which name each exported object is documented."""
    public = public_names(source_files())
    short = {name.rpartition(".")[2]: name for name in public.values()}
    classes = {word: name for word, name in short.items() if word[0].isupper()}
    app.config.exported_names = classes | public


def _documented(env: BuildEnvironment, target: str) -> tuple[str, str] | None:
    """Page and anchor of a name, as it is or as its package exports it."""
    parts = re.sub(r"^mb\.", "medialbench.", target).split(".")
    public = env.config.exported_names
    for count in range(len(parts), 0, -1):
        start = ".".join(parts[:count])
        name = ".".join([public.get(start, start), *parts[count:]])
        found = env.domains.python_domain.objects.get(name)
        if found:
            return found.docname, found.node_id
    return None


def _page(env: BuildEnvironment, target: str) -> tuple[str, str] | None:
    found = PAGE.fullmatch(target)
    return (found[1], "") if found and found[1] in env.found_docs else None


def types_of_others(app: Sphinx, document: nodes.document) -> None:
    """Leave types of other projects as text: Sphinx would look for any name here that ends like theirs."""
    exported = app.config.exported_names
    for node in list(document.findall(pending_xref)):
        if node.get("refdomain") != "py" or "refspecific" not in node:
            continue
        target = node["reftarget"]
        node["reftarget"] = exported.get(target, target)
        if node["reftarget"].partition(".")[0] not in (FACE, *PACKAGES):
            node.replace_self(node.children)


def missing_reference(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.Node | None:
    """Resolve exported names, written without their package or with their module, and pages."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"]
    found = _page(env, target) or _documented(env, target)
    return _reference(app, node["refdoc"], found, content) if found else None


def _reference(app: Sphinx, here: str, found: tuple[str, str], content: nodes.Node) -> nodes.reference:
    docname, anchor = found
    uri = app.builder.get_relative_uri(here, docname) + (f"#{anchor}" if anchor else "")
    return nodes.reference("", "", content, internal=True, refuri=uri)


class CodeLinks(SphinxPostTransform):
    """Names of documented objects and paths of pages become links wherever text shows them as code."""

    default_priority = 900

    def run(self, **kwargs: Any) -> None:
        """Wrap each literal that names something."""
        for literal in list(self.document.findall(nodes.literal)):
            text = literal.astext()
            inside = literal.parent
            while inside is not None and not isinstance(inside, nodes.reference | nodes.title | pending_xref):
                inside = inside.parent
            if inside is not None:
                continue
            found = _page(self.env, text)
            if not found and (name := DOTTED.fullmatch(text)):
                found = _documented(self.env, name[1])
            if found:
                link = _reference(self.app, self.env.docname, found, literal.deepcopy())
                literal.replace_self(link)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the handlers."""
    app.add_config_value("exported_names", {}, "env")
    app.connect("builder-inited", known_names)
    app.connect("include-read", root_links)
    app.connect("source-read", page_links)
    app.connect("doctree-read", types_of_others)
    app.connect("missing-reference", missing_reference)
    app.add_post_transform(CodeLinks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
