#!/usr/bin/env python3
"""Builds static pages of README, docs/, results/ and, where it has been run, the report of first light. Nothing is fetched.

    docs/site/build.py [OUT]        into out/site; needs Debian's python3-markdown

The pages lie as the sources do, so that links between them hold: README.md becomes index.html, X.md becomes X.html, and every file
that a page shows or names is copied beside it.
"""
import html
import os
import re
import shutil
import sys
import urllib.parse

try:
    import markdown
except ImportError:
    print("build.py: needs the Python package markdown (Debian: python3-markdown)", file=sys.stderr)
    sys.exit(77)

top = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
out = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.path.join(top, "out/site"))
report = os.path.join(top, "out/first-light/report.html")

pages = ["README.md", "results/README.md"] + sorted(f"docs/{name}" for name in os.listdir(f"{top}/docs") if name.endswith(".md"))
menu = [("index.html", "etendue"), ("docs/quick-start.html", "Quick start"), ("docs/tutorial.html", "Tutorial"),
        ("docs/gallery.html", "Gallery"), ("docs/results.html", "Results"), ("docs/methods.html", "Methods"),
        ("docs/using.html", "Using")]
if os.path.exists(report):
    menu.insert(3, ("first-light.html", "First light"))


def page_of(path):
    """Where the page of a source lies."""
    folder, name = os.path.split(path)
    return os.path.join(folder, "index.html" if name == "README.md" else name[:-3] + ".html")


def write(path, text):
    path = os.path.join(out, path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(text)


def frame(path, title, body):
    up = "../" * path.count("/")
    links = " ".join(f'<a href="{up}{target}"{" class=here" if target == path else ""}>{name}</a>' for target, name in menu)
    with open(f"{top}/docs/site/page.html") as template:
        return template.read().replace("TITLE", html.escape(title)).replace("MENU", links).replace("BODY", body)


def html_of(text):
    body = markdown.markdown(text, extensions=["tables", "fenced_code", "toc"])
    return body.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")


def copy(path):
    """Copies a file; of a folder, makes a page of its tables. Returns whether there is one."""
    source, target = os.path.join(top, path), os.path.join(out, path)
    if os.path.isdir(source):
        tables = sorted(name for name in os.listdir(source) if name.endswith(".md"))
        texts = [open(os.path.join(source, name)).read() for name in tables]
        there = os.path.join(path, "index.html")
        write(there, frame(there, path, html_of("\n\n".join(texts))))
        return True
    if not os.path.isfile(source):
        return False
    os.makedirs(os.path.dirname(target), exist_ok=True)
    shutil.copyfile(source, target)
    return True


def build(path):
    with open(os.path.join(top, path)) as source:
        text = re.sub(r"<!--.*?-->", "", source.read(), flags=re.S)  # markers of figures
    title = text.split("\n", 1)[0].lstrip("# ")

    def link(match):
        attribute, target = match.groups()
        address, mark, anchor = target.partition("#")
        if not address or "//" in address:
            return match.group(0)
        there = os.path.normpath(os.path.join(os.path.dirname(path), urllib.parse.unquote(address)))
        if there in pages:
            address = os.path.relpath(page_of(there), os.path.dirname(path) or ".")
        elif not copy(there):
            sys.exit(f"build.py: {path}: {target} is not there")
        elif os.path.isdir(os.path.join(top, there)):
            address = os.path.join(address, "index.html")
        return f'{attribute}="{address}{mark}{anchor}"'

    write(page_of(path), frame(page_of(path), title, re.sub(r'\b(href|src)="([^"]*)"', link, html_of(text))))


shutil.rmtree(out, ignore_errors=True)
for page in pages:
    build(page)
if os.path.exists(report):
    shutil.copyfile(report, os.path.join(out, "first-light.html"))
print(os.path.join(out, "index.html"))
