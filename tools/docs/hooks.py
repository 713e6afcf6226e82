"""What mkdocs does otherwise than forges, put right: called by mkdocs while it builds the site, see mkdocs.yml."""

import re


def on_page_markdown(markdown, **_):
    # Forges begin a table right behind a comment; mkdocs takes both for one piece of HTML.
    markdown = re.sub(r"^<!--.*?-->[ \t]*$", "", markdown, flags=re.M | re.S)
    # In a table, forges need '\|' for a bar inside of code; mkdocs would show the backslash.
    return re.sub(r"^\|.*$", lambda row: re.sub(r"`[^`]*`", lambda code: code[0].replace("\\|", "|"), row[0]), markdown, flags=re.M)
