"""Blocks of code of pages of the documentation."""

import re


def blocks(page):
    """(language, code) of every block of commands on a page, in order."""
    return re.findall(
        r"^```(bash|python)\n(.*?)^```$", page.read_text(), flags=re.MULTILINE | re.DOTALL
    )


def save_named(page, folder):
    """Save the blocks of a page that begin with the name of a file, ``# boxes.py``; gives names."""
    named = re.findall(
        r"^```\w+\n# (\w+\.\w+)\n(.*?)^```$", page.read_text(), flags=re.MULTILINE | re.DOTALL
    )
    for name, content in named:
        (folder / name).write_text(content)
    return [name for name, _ in named]
