"""Links of a built site: what they lead to must be there, places within pages too. Other sites are not asked."""

import html.parser
import pathlib
import re
import urllib.parse


class Page(html.parser.HTMLParser):
    """The places and links of one page."""

    def __init__(self, text):
        super().__init__()
        self.places, self.links, self.fetched = {"", "top"}, [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.places.update(named[key] for key in ("id", "name") if named.get(key))
        self.links += [named[key] for key in ("href", "src") if named.get(key)]
        if tag != "a":
            self.fetched += [named[key] for key in ("href", "src") if named.get(key)]


def of_style(path):
    """What a style sheet fetches."""
    return [link.strip("\"' ") for link in re.findall(r"url\(([^)]*)\)", path.read_text(encoding="utf-8")) if "data:" not in link]


def broken(folder):
    """"page: link" for every link to a file or a place that is not there, and for everything that would be fetched from elsewhere."""
    folder = pathlib.Path(folder).resolve()
    # A page of `balance report` holds its own test, and megabytes of samples.
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in folder.rglob("*.html") if path.parent.name != "pages"}
    found = []
    for path, page in pages.items():
        found += [f"{path.relative_to(folder)}: {link} is fetched from elsewhere" for link in page.fetched
                  if urllib.parse.urlsplit(link).netloc]
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            there = target.is_file() and target.is_relative_to(folder)
            place = urllib.parse.unquote(parts.fragment)
            if not there or (target in pages and place not in pages[target].places):
                found.append(f"{path.relative_to(folder)}: {link}")
    for path in folder.rglob("*.css"):
        found += [f"{path.relative_to(folder)}: {link}" for link in of_style(path) if not (path.parent / link).is_file()]
    return found
