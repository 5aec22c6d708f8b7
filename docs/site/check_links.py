#!/usr/bin/env python3
"""Follows every link and image of a built site that leads into it: the file and the anchor must exist.

    check_links.py HTML
"""
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """The links of a page, and the anchors that others can link."""

    def __init__(self, text):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name in ("id", "name") and value:
                self.anchors.add(value)


def problems(root):
    """(number of links followed, number of links out of the site, what is wrong)"""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in root.rglob("*.html")}
    followed, outside, wrong = 0, 0, []
    for path, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                outside += 1
                continue
            followed += 1
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            anchor = urllib.parse.unquote(parts.fragment)
            if not target.exists():
                wrong.append(f"{path.relative_to(root.resolve())}: no file {link}")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                wrong.append(f"{path.relative_to(root.resolve())}: no anchor {link}")
    return followed, outside, wrong


if __name__ == "__main__":
    followed, outside, wrong = problems(pathlib.Path(sys.argv[1]))
    for line in sorted(set(wrong)):
        print(line)
    print(f"{followed} links inside the site, {outside} to other sites (not followed), {len(set(wrong))} lead nowhere")
    sys.exit(1 if wrong or followed == 0 else 0)
