"""Pages of the site that are made when it is built: those from code, and the files that pages name.

The README is the first page. A link to a file beyond `docs` leads to a page that shows it, so that the site is whole.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mkdocs.structure.files import File

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT: Final = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from docs.site import reference  # noqa: E402

_LINK: Final = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
_LANGUAGES: Final = {".py": "python", ".yaml": "yaml", ".sh": "bash", ".csv": "text"}
_LONGEST: Final = 400


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made from code, the README, and the files that pages name."""
    made = reference.pages()
    made["index.md"] = _from_root((ROOT / "README.md").read_text(encoding="utf-8"))
    texts = {file.src_uri: file.content_string for file in files.documentation_pages()} | made
    for uri, text in texts.items():
        for path in _outside(uri, text):
            made.setdefault(_page_of(path), _shown(path))
    for uri, text in made.items():
        files.append(File.generated(config, uri, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001
    """Lead links to files beyond `docs` to the pages that show them."""
    uri = page.file.src_uri

    def lead(match: re.Match[str]) -> str:
        path = _beyond(uri, match[2])
        if path is None:
            return match[0]
        return f"{match[1]}{os.path.relpath(_page_of(path), Path(uri).parent)}{match[4]}"

    return _LINK.sub(lead, markdown)


def _from_root(text: str) -> str:
    """Return a text that stands beside `docs` with its links as seen from there."""

    def lead(match: re.Match[str]) -> str:
        link = match[2]
        if ":" in link:
            return match[0]
        link = link.removeprefix("docs/") if link.startswith("docs/") else f"../{link}"
        return f"{match[1]}{link}{match[3] or ''}{match[4]}"

    return _LINK.sub(lead, text)


def _beyond(uri: str, link: str) -> Path | None:
    """Return the file or folder beyond `docs` to which a link of a page leads; None if it leads elsewhere."""
    if ":" in link or link.startswith("/"):
        return None
    path = Path(os.path.normpath(ROOT / "docs" / Path(uri).parent / link))
    own = path.is_relative_to(ROOT / "docs") and not path.is_relative_to(ROOT / "docs" / "site")
    if own or not path.is_relative_to(ROOT) or not path.exists():
        return None
    return path.relative_to(ROOT)


def _outside(uri: str, text: str) -> list[Path]:
    return [path for match in _LINK.finditer(text) if (path := _beyond(uri, match[2])) is not None]


def _page_of(path: Path) -> str:
    return f"files/{path.as_posix() or 'root'}.md"


def _shown(path: Path) -> str:
    """Return a page that shows a file, or names what is in a folder."""
    real = ROOT / path
    if real.is_dir():
        names = sorted(one.name + "/" * one.is_dir() for one in real.iterdir() if one.name != "__pycache__")
        return f"# {path}\n\n" + "\n".join(f"- `{name}`" for name in names)
    if path.suffix == ".md":
        return _LINK.sub("](#)", real.read_text(encoding="utf-8"))  # its links lead from where it stands
    lines = real.read_text(encoding="utf-8").splitlines()
    rest = f"\n\n... {len(lines) - _LONGEST} more lines" if len(lines) > _LONGEST else ""
    body = "\n".join(lines[:_LONGEST])
    return f"# {path}\n\n````{_LANGUAGES.get(path.suffix, 'text')}\n{body}\n````{rest}\n"
