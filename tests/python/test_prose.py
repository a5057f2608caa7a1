"""The documents read easily: sentences are short, and lines fit a screen."""

import ast
import re
import statistics
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "measured").glob("*.md")])
PAGES = sorted((ROOT / "site" / "pages").glob("*.md"))
GALLERY = sorted((ROOT / "site" / "gallery").glob("*.py"))
# Further texts for users: of crates, of the benchmark, of data, of the paper.
READMES = sorted([*ROOT.glob("crates/*/README.md"), *ROOT.glob("benchmark/*.md"), *ROOT.glob("docs/*/README.md"), *ROOT.glob("paper/*.md")])

MEAN_WORDS = 20
NINETIETH_PERCENTILE = 35
WIDEST_LINE = 120

# Words of a sentence, over all documents and pages together.
MEAN_OF_ALL = 15
# Verbs and phrases that are correct, and that no native writer takes: name a remedy, dissipate, carry, separate, resolve, say.
TRANSLATED = re.compile(
    r"\b(lack(s|ed)?|in place of|the way out|(is|are|was) warned of|spen(d|ds|t)|bears?|bore|of before"
    r"|tells?|told|parted|parts them|can(not)? show)\b",
    re.IGNORECASE,
)
TEXTS = sorted((ROOT / "crates" / "meso-py" / "python" / "mesocrete").glob("_*.py*"))
SOURCES = sorted(path for path in (ROOT / "crates").glob("*/src/**/*.rs") if path.name != "tests.rs")
# Help is made from the documents of requests, too.
REQUESTS = [ROOT / "crates" / path for path in ("meso-ask/src/effective/mod.rs", "meso-ask/src/over.rs", "meso-mesh/src/options/table.rs")]
FLAGS = [*[path for path in SOURCES if path.name == "flags.rs"], *REQUESTS]
RECIPES = sorted((ROOT / "crates").glob("*/src/recipes/*.toml"))

DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef)

# A full stop after these ends no sentence.
ABBREVIATION = re.compile(r"\b(Sec|Fig|Eq|eq|No|e\.g|i\.e|vs|Dr)\.$")


def blocks(text: str) -> list[str]:
    """Split a document into paragraphs and list items; code, tables, headings and pictures are left out."""
    found, block, fenced = [], [], False
    for line in [*text.splitlines(), ""]:
        fenced ^= line.lstrip().startswith("```")
        item = re.match(r"\s*([-*]|\d+\.)\s+", line)
        code = line.startswith("    ") and not block
        outside = fenced or code or not line.strip() or re.match(r"\s*(```|\||#|!\[)", line)
        if outside or item:
            found.append(" ".join(block))
            block = []
        if not outside:
            block.append(line[item.end() :] if item else line.strip())
    return [block for block in found if block]


def sentences(block: str) -> list[str]:
    """Split a paragraph at the marks that end a sentence; what is quoted as code counts as one word."""
    plain = re.sub(r"`[^`]*`", "code", block)
    plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", plain)
    found = [""]
    for part in re.split(r"(?<=[.!?])[*)\"]*\s+", plain):
        found[-1] = f"{found[-1]} {part}".strip()
        if not ABBREVIATION.search(part):
            found.append("")
    return [sentence for sentence in found if sentence]


def words(sentence: str) -> int:
    """Count the words: whatever holds a letter or a digit."""
    return sum(any(letter.isalnum() for letter in word) for word in sentence.split())


def lengths(text: str) -> list[int]:
    """Count the words of every sentence of a document."""
    return [words(sentence) for block in blocks(text) for sentence in sentences(block)]


def test_the_counter_sees_sentences_and_skips_what_is_none():
    text = "# A heading\n\nOne two three. Four `five six` (Sec. 2.1)\nseven!\n\n- An item\n  of four.\n\n| a | table |\n\n    code\n"
    assert lengths(text) == [3, 5, 4]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_sentences_are_short(document):
    counts = sorted(lengths(document.read_text(encoding="utf-8")))
    longest = counts[int(0.9 * (len(counts) - 1))]
    assert statistics.mean(counts) <= MEAN_WORDS
    assert longest <= NINETIETH_PERCENTILE


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_lines_fit_a_screen(document):
    text = document.read_text(encoding="utf-8").splitlines()
    # A row of a table cannot be broken.
    wide = [number for number, line in enumerate(text, 1) if len(line) > WIDEST_LINE and not line.startswith("|")]
    assert not wide, f"lines wider than {WIDEST_LINE}: {wide}"


@pytest.mark.parametrize(("name", "most"), [("docs/meshing.md", 150), ("docs/decks.md", 150), ("CHANGELOG.md", 130)])
def test_manuals_and_the_changelog_stay_short(name, most):
    assert len((ROOT / name).read_text(encoding="utf-8").splitlines()) <= most


def test_the_mean_sentence_of_all_documents_and_pages_is_short():
    counts = [count for path in [*DOCUMENTS, *PAGES, *READMES] for count in lengths(path.read_text(encoding="utf-8"))]
    assert len(counts) > 1000 and statistics.mean(counts) <= MEAN_OF_ALL


def test_the_mean_sentence_of_help_hover_texts_and_messages_is_short():
    """A message is a string of six words or more; what it puts in counts as a word."""
    hovers = [ast.get_docstring(node) or "" for path in [*TEXTS, *GALLERY] for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, DOCUMENTED)]
    said = [re.sub(r"\{[^}]*\}", "value", text) for path in SOURCES for text in strings(path)]
    texts = {
        "help": [count for path in FLAGS for count in lengths(helps(path))],
        "hover texts": [count for text in hovers for count in lengths(text)],
        "messages": [words(sentence) for text in said for sentence in sentences(text) if words(text) >= 6],
    }
    means = {kind: statistics.mean(counts) for kind, counts in texts.items()}
    assert min(map(len, texts.values())) > 100 and max(means.values()) <= MEAN_OF_ALL, means


def strings(path: Path) -> list[str]:
    """What a Rust source says outside its tests: strings with a space, without the tags of pages."""
    code = re.split(r"#\[cfg\(test\)\]", path.read_text(encoding="utf-8"))[0]
    code = "\n".join(line for line in code.splitlines() if not line.lstrip().startswith("//"))
    code = re.sub(r"b?'(\\.|[^'\\])'", "", code)
    said = re.findall(r'"((?:[^"\\]|\\.)*)"', code, re.DOTALL)
    return [re.sub(r"<[^>]*>|\\\s+", " ", text) for text in said if " " in text.strip()]


def helps(path: Path) -> str:
    """The help of a command's flags: paragraphs of documentation comments."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return "\n".join(line.strip().removeprefix("///").strip() if line.strip().startswith("///") else "" for line in lines)


def read_by_users(path: Path) -> str:
    """The text of a document, the strings of a Python file, or what a command says: its strings and its help."""
    if path.suffix == ".rs":
        return "\n".join([*strings(path), helps(path) if path.name == "flags.rs" else ""])
    text = path.read_text(encoding="utf-8")
    if path.suffix in (".py", ".pyi"):
        return "\n".join(node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    return text


@pytest.mark.parametrize("path", [*DOCUMENTS, *PAGES, *READMES, *RECIPES, *TEXTS, *GALLERY], ids=lambda path: path.name)
def test_documents_and_hover_texts_use_the_verbs_of_the_field(path):
    assert TRANSLATED.findall(read_by_users(path)) == []


def test_messages_use_the_verbs_of_the_field():
    found = {str(path.relative_to(ROOT)): match[0] for path in SOURCES for match in TRANSLATED.finditer(read_by_users(path))}
    assert len(SOURCES) > 200 and found == {}
