"""Links: those of the repository lead somewhere there; on the site they lead to its pages; none is dead."""

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parent.parent

# A link or an image of Markdown: mark, text, target, anchor.
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)")
# Where a page has the picture of a gallery's page, which exists once that page ran.
PICTURE = re.compile(r"<!-- picture (\w+): (.*?) -->")


def repository_links(pages: Path, sources: dict[str, Path], repository: str | None) -> None:
    """Point links between files of the repository at the site's pages, at the repository, or else at plain names."""
    places = {path.resolve(): page for page, path in sources.items()}
    for path in sorted(pages.rglob("*.md")):
        page = path.relative_to(pages).as_posix()
        up = "../" * page.count("/")
        # Written pages have the site's own links.
        home = (sources[page] if page in sources and sources[page].suffix == ".md" else path).parent

        def moved(found: re.Match[str], home: Path = home, path: Path = path, up: str = up) -> str:
            image, text, target, anchor = found[1], found[2], found[3], found[4] or ""
            file = (home / target).resolve()
            if ":" in target or not file.exists() or home == path.parent:
                return found[0]
            if file in places:
                return f"{image}[{text}]({up}{places[file]}{anchor})"
            name = file.relative_to(ROOT).as_posix()
            return f"[{text}]({repository}/blob/main/{name}{anchor})" if repository else f"{text} (`{name}`)"

        text = path.read_text(encoding="utf-8")
        linked = PICTURE.sub(rf"![\2]({up}gallery/\1/picture.png)", LINK.sub(moved, text))
        if linked != text:
            path.write_text(linked, encoding="utf-8")


class Targets(HTMLParser):
    """The addresses that a page of HTML names, raw ones too."""

    def __init__(self) -> None:
        """Begin with none."""
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep the addresses of a tag."""
        self.found += [value for name, value in attrs if name in ("href", "src") and value]


def dead(site: Path) -> list[str]:
    """List the relative links of a built site that lead nowhere, each with its page."""
    return [f"{page.relative_to(site)}: {link}" for page in sorted(site.rglob("*.html")) for link in broken(page)]


def broken(page: Path) -> Iterator[str]:
    """Yield the dead links of one page; the page of a wrong address has links from the site's root."""
    targets = Targets()
    targets.feed(page.read_text(encoding="utf-8"))
    for link in targets.found:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc or not parts.path or parts.path.startswith("/"):
            continue
        if not (page.parent / unquote(parts.path)).exists():
            yield link


def dead_in_repository(page: Path) -> list[str]:
    """List the relative links of a Markdown file of the repository that lead nowhere there."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = [found[3] for found in LINK.finditer(text)]
    # A picture within a link is matched from its own bracket on; the link itself ends behind it.
    targets += re.findall(r"\)\]\(([^)\s#]+)", text)
    return [target for target in targets if ":" not in target and not (page.parent / target).exists()]
