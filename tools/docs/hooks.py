"""What mkdocs does otherwise than forges, put right: called by mkdocs while it builds the site, see mkdocs.yml."""

import re


def on_page_markdown(markdown, **_):
    """Forges begin a table right behind a comment; mkdocs takes both for one piece of HTML. Comments go."""
    return re.sub(r"^<!--.*?-->[ \t]*$", "", markdown, flags=re.M | re.S)
