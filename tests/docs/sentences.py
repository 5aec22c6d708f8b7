"""Length of the sentences in the documents: at most 18 words in the mean, none above 40.

    sentences.py SOURCE [--list]

Code, tables, headings and lists of links are not sentences. The changelog is not measured.
"""

import pathlib
import re
import sys

MEAN, LONGEST = 18, 40


def sentences(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    paragraphs = []
    for block in re.split(r"\n\s*\n", text):
        lines = [line for line in block.split("\n") if not re.match(r"\s*(\||#|!\[|<|    )", line)]
        # Each item of a list is a paragraph of its own.
        for part in re.split(r"\n(?=\s*(?:[-*]|\d+\.) )", "\n".join(lines)):
            paragraphs.append(re.sub(r"^\s*(?:[-*]|\d+\.) ", "", part))
    for paragraph in paragraphs:
        plain = re.sub(r"`[^`]*`", "CODE", paragraph)
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", plain)
        plain = re.sub(r"(\d)\.(\d)", r"\1_\2", plain)
        plain = re.sub(r"\b(e\.g|i\.e|al|vs|cf|pp|p|Fig|Sec|No|Proc|ed)\.", r"\1", plain)
        for sentence in re.split(r"(?<=[.!?])[)\"*_]*\s+|:\s*\n|;\s*\n(?=[a-z])", plain.replace("\n", " ").strip()):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if len(words) > 2:
                yield len(words), " ".join(words)


def main():
    source = pathlib.Path(sys.argv[1])
    lengths, long = [], []
    for path in [source / "README.md", source / "CONTRIBUTING.md", *sorted(source.glob("docs/*.md")),
                 *sorted(source.glob("examples/*/README.md"))]:
        own = list(sentences(path.read_text()))
        lengths += [length for length, _ in own]
        long += [f"{path.relative_to(source)}: {length} words: {text}" for length, text in own if length > LONGEST]
        if "--list" in sys.argv and own:
            print(f"{sum(length for length, _ in own) / len(own):5.1f} {path.relative_to(source)}")
    mean = sum(lengths) / len(lengths)
    print(f"{len(lengths)} sentences, {mean:.1f} words in the mean, {len(long)} above {LONGEST}")
    print("\n".join(long))
    sys.exit(0 if mean <= MEAN and not long else 1)


main()
