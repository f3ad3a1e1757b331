"""Sphinx configuration of the documentation's site, which scripts/docs_site.sh builds."""

import os
import re
import sys
import types
from pathlib import Path
from xml.etree import ElementTree

from docutils import nodes
from sphinx.errors import ExtensionError
from sphinx.util import logging

# Without the reference of the interfaces, which needs the compiled package and Doxygen's XML.
TEXT_ONLY = "ENGRAM_DOXYGEN_XML" not in os.environ
if not TEXT_ONLY:
    import engram.typing

SITE = Path(__file__).parent

project = "engram"
author = "The engram authors"
version = release = re.search(
    r'^version = "(.+)"$', (SITE / "../../pyproject.toml").read_text(), re.MULTILINE
).group(1)
html_title = f"engram {release}"

extensions = [
    "myst_nb",
    "sphinx_external_toc",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
]
if not TEXT_ONLY:
    extensions.append("breathe")
exclude_patterns = ["site/Doxyfile"]
external_toc_path = "site/toc.yml"

# Pages are Markdown as repositories show it. Headings get the same anchors; dead links to pages and
# anchors are errors.
myst_heading_anchors = 4
smartquotes = False  # readers copy "state" with its quotes
nitpicky = True
# Types of other packages, of C and of C++, which are documented elsewhere, and internal protocols.
nitpick_ignore_regex = [
    (
        "py:.*",
        r"(np|numpy|builtins|gymnasium|collections\.abc|os|pathlib|pufferlib|stable_baselines3)\..*",
    ),
    ("py:class", r"AutoresetMode|.*\.ObsT|engram\.(envs\.sub_env\.Batch|wrappers\.base\.Step)"),
    ("c:identifier", r"u?int\d+_t|size_t|mj(Model|Data)_"),
    ("cpp:identifier", "engram|engram_(env|training)|mj(Model|Data)_"),
]

# Notebooks keep their stored outputs, which python/tests/test_notebooks.py checks.
nb_execution_mode = "off"

# The reference of Python.
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"
autodoc_mock_imports = ["pufferlib", "stable_baselines3"]
# A mocked decorator would hide the class below it.
sys.modules["ray"] = types.SimpleNamespace(remote=lambda one: one)
napoleon_numpy_docstring = False

# The reference of C++ and C, from Doxygen's XML.
breathe_projects = {"engram": os.environ.get("ENGRAM_DOXYGEN_XML", "")}
breathe_default_project = "engram"
NOT_PUBLIC = {"ENGRAM_API", "engram::TrainingEnv::Close", "engram::VectorEnv::Close"}
breathe_default_members = ("members", "undoc-members")
breathe_show_include = False
breathe_domain_by_file_pattern = {"*_c.h": "c", "*/engram_task.h": "c"}

html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["search.js"]
html_copy_source = False
html_use_index = False
html_domain_indices = False
html_show_sphinx = False
html_show_copyright = False

# Pages of the root, which have other names in the site: pages that include them are written here.
ROOT_PAGES = {
    name: f"/site/{name.lower()}" for name in ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")
}
for name in ROOT_PAGES:
    included = f"```{{include}} ../../{name}\n:relative-docs: docs/\n```\n"
    (SITE / name.lower()).write_text(included)


def link_root_pages(text):
    for page, here in ROOT_PAGES.items():
        text = re.sub(rf"\]\((\.\./)*{re.escape(page)}", f"]({here}", text)
    return text


def in_page(app, name, source):
    source[0] = link_root_pages(source[0])
    if TEXT_ONLY and name.startswith("reference/"):
        title = source[0].splitlines()[0]
        source[0] = f"{title}\n{'=' * len(title)}\n\n``scripts/docs_site.sh`` makes this page.\n"


def in_included(app, path, parent, source):
    source[0] = link_root_pages(source[0])


def find_type(app, env, node, text):
    """Resolves types of engram.typing, which annotations name without their module."""
    name = f"engram.typing.{node['reftarget']}"
    if node["refdomain"] != "py" or not hasattr(engram.typing, node["reftarget"]):
        return None
    python = env.get_domain("py")
    return python.resolve_xref(env, node["refdoc"], app.builder, "obj", name, node, text)


def public_names(index):
    """Public names of the headers, by Doxygen's index."""
    for compound in ElementTree.parse(index).getroot():
        name = compound.findtext("name")
        if compound.get("kind") in ("class", "struct"):
            yield name
        elif compound.get("kind") in ("namespace", "file"):
            prefix = f"{name}::" if compound.get("kind") == "namespace" else ""
            for member in compound.iter("member"):
                if member.get("kind") not in ("enumvalue", "variable"):
                    yield prefix + member.findtext("name")


def check_reference(app, env):
    """Warns of public names that the pages of C++ and C leave out."""
    shown = {item[0] for domain in ("c", "cpp") for item in env.get_domain(domain).get_objects()}
    index = Path(breathe_projects["engram"]) / "index.xml"
    for name in sorted(set(public_names(index)) - shown - NOT_PUBLIC):
        logging.getLogger(__name__).warning("docs/reference does not show %s", name)


def moved():
    """Former pages, each with the address that has its text now."""
    return [line.split() for line in (SITE / "moved.txt").read_text().splitlines()]


def add_keywords(app, doctree):
    """Lets the search find a page by the names of former pages whose text it has."""
    page = app.env.docname
    names = [old for old, new in moved() if new.partition(".html")[0] == page]
    if names:
        words = ", ".join(re.findall(r"[a-z]+", " ".join(names).replace("_", " ")))
        doctree.append(nodes.meta(name="keywords", content=words))


def write_moved(app, error):
    """Addresses of former pages lead to the pages that have their text now."""
    for old, new in moved():
        page = Path(app.outdir) / f"{old}.html"
        address = os.path.relpath(new, Path(old).parent)
        if page.exists():
            raise ExtensionError(f"moved.txt: {old} is a page")
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(
            f'<!doctype html><meta charset="utf-8"><title>{old}</title>'
            f'<meta http-equiv="refresh" content="0; url={address}">'
            f'<p>This page has moved: <a href="{address}">{address}</a></p>'
        )


def setup(app):
    app.connect("build-finished", write_moved)
    app.connect("doctree-read", add_keywords)
    if not TEXT_ONLY:
        app.connect("missing-reference", find_type)
        app.connect("env-check-consistency", check_reference)
    app.connect("source-read", in_page)
    app.connect("include-read", in_included)
