"""What a program prints with --help, as Markdown: tables of its options, paragraphs, and its examples as they are."""

import re

HEADER = re.compile(r"[A-Z][^:]{0,60}:$")
ALONE = re.compile(r"Exit(?: code| status)?: |PADR_JOBS=|usage:", re.I)  # a line that begins a paragraph of its own
COMMANDS = ("padr-", "tools/", "tcpdump ")  # what an example begins with
NAMES_AT = 30  # the column at which the programs' descriptions of options begin
WIDE = re.compile(r" {2,}")


def markdown(text, level, known):
    """The help text below headings of a level. `known`: groups of options by their rows, and the heading that has each; a group
    that is there already is only named, and others are added."""
    out, lines = [], text.rstrip().split("\n")
    at = 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
        elif lines[at].lower().startswith("usage:"):
            at = usage(lines, at, out)
        elif lines[at].startswith("  "):
            end = block_end(lines, at)
            out += listed(lines[at:end], ["what", "meaning"])
            at = end
        elif HEADER.match(lines[at]) and at + 1 < len(lines) and lines[at + 1].startswith("  "):
            end = block_end(lines, at + 1)
            out += section(lines[at][:-1], lines[at + 1 : end], level, known)
            at = end
        else:
            end = paragraph_end(lines, at)
            out += [prose(" ".join(lines[at:end])), ""]
            at = end
    return "\n".join(out).strip() + "\n"


def block_end(lines, at):
    while at < len(lines) and lines[at].startswith("  "):
        at += 1
    return at


def paragraph_end(lines, at):
    """A paragraph ends before a blank line, an indented one, a headline, and a sentence that stands alone."""
    at += 1
    while at < len(lines) and lines[at].strip() and not lines[at].startswith("  "):
        if HEADER.match(lines[at]) or ALONE.match(lines[at]):
            break
        at += 1
    return at


def usage(lines, at, out):
    """The line of usage, which may go on in lines that are indented, as a block."""
    end = at + 1
    while end < len(lines) and lines[end].startswith("   "):
        end += 1
    shown = [re.sub(r"^usage:\s*(?:\S*/(?=padr-))?", "", line, flags=re.I).strip() for line in lines[at:end]]
    out += code(shown)
    return end


def section(title, block, level, known):
    table = rows(block)
    if table is None or not (block[0].startswith("  -") or title in ("Positionals", "Subcommands")):
        return [prose(title + ":"), "", *listed(block, ["what", "meaning"])]
    kept = str(table)
    if kept in known and len(table) > 3:
        shown, anchor = known[kept]
        return [f"**{title}**: as under [{shown}](#{anchor}).", ""]
    out = [f"{'#' * level} {title}", ""]
    if all(names.startswith("-") for names, _ in table):
        return out + option_table(table)
    return out + plain_table(table, ["name", "meaning"])


def listed(block, head):
    table = rows(block)
    if table is None:
        return code(block)
    if all(names.startswith("-") for names, _ in table):
        return option_table(table)
    return plain_table(table, head)


def code(lines):
    return ["```text", *[line[2:] if line.startswith("  ") else line for line in lines], "```", ""]


def rows(block):
    """[names, meaning] of a block in two columns; None for any other."""
    found = []
    for line in block:
        base = re.match(r" {2}\S", line) is not None
        if not base and found:
            rest = line.strip()
            # A list in a meaning stays one.
            found[-1][1] += ("\n" if re.match(r"[a-z-]+: ", rest) else " " if found[-1][1] else "") + rest
            continue
        if not base or line.strip().startswith(COMMANDS):
            return None
        names, meaning = columns(line)
        if meaning is not None and WIDE.search(meaning.split("(default")[0].rstrip()):
            return None
        found.append([names, meaning or ""])
    return found if all(meaning for _, meaning in found) else None


def columns(line):
    text = line[2:]
    names = line[2:NAMES_AT].rstrip()
    # A range such as [1 - 600], or what follows "Needs:", may happen to have a space there.
    goes_on = re.search(r" (?:Needs|Excludes):", names) and line[NAMES_AT:].startswith("--")
    whole = names.count("[") == names.count("]") and not names.endswith(":") and not goes_on
    if text.startswith("-") and whole and line[NAMES_AT - 1 : NAMES_AT] == " " and not WIDE.search(names):
        return names, line[NAMES_AT:]
    parts = WIDE.split(text, maxsplit=1)
    return (parts[0], parts[1]) if len(parts) == 2 else (parts[0], None)


def option_table(table):
    lines, any_beside = [], False
    for names, meaning in table:
        shown, notes = split_option(names)
        meaning, default = split_default(meaning)
        beside = "; ".join(filter(None, [default, *notes]))
        any_beside = any_beside or beside != ""
        lines.append((f"| {cell_code(shown)} | {prose(meaning)} |", f" {beside} |"))
    if any_beside:
        return ["| option | meaning | default; allowed |", "|---|---|---|", *[a + b for a, b in lines], ""]
    return ["| option | meaning |", "|---|---|", *[a for a, _ in lines], ""]


def plain_table(table, head):
    out = [f"| {head[0]} | {head[1]} |", "|---|---|"]
    out += [f"| {cell_code(split_option(names)[0])} | {prose(meaning)} |" for names, meaning in table]
    return out + [""]


def split_option(names):
    """An option as one types it, and what is said beside: default, range, whether it is needed."""
    notes = []
    found = re.search(r"(?<=[A-Z\]})-])=(.+?)(?= (?:Needs|Excludes|REQUIRED|\(Env|\.\.\.)|$)", names)
    if found and not re.fullmatch(r"[A-Z,.]+", found[1]):  # else it is a part of how the option is written
        notes.append(f"`{found[1]}`")
        names = names[: found.start()] + names[found.end() :]
    for pattern, shown in ((r":in \[(\S+) - (\S+)\]", r"\1 to \2"), (r":\{([^}]*)\}", r"\1")):
        found = re.search(pattern, names)
        if found:
            notes.append(found.expand(shown).replace(",", ", "))
            names = names[: found.start()] + names[found.end() :]
    found = re.search(r" \(Env:(\w+)\)", names)
    if found:
        notes.append(f"environment: `{found[1]}`")
        names = names.replace(found[0], "")
    for word, shown in (("Needs", "only with"), ("Excludes", "not with")):
        found = re.search(rf" {word}:((?: --[\w-]+)+)", names)
        if found:
            notes.append(f"{shown} " + ", ".join(f"`{name}`" for name in found[1].split()))
            names = names.replace(found[0], "")
    if " REQUIRED" in names:
        notes.append("required")
        names = names.replace(" REQUIRED", "")
    names = re.sub(r"\bU?INT\b", "N", re.sub(r"\bFLOAT\b", "X", names))
    return re.sub(r"^(-\w),(--)", r"\1, \2", names.strip()), notes


def split_default(meaning):
    """What ends in '[value]' or '(default value)' has a default."""
    found = re.search(r"\s*(?:\[([^\][]+)\]|\(default:? ([^()]+)\))$", meaning)
    if not found:
        return meaning, ""
    value = (found[1] or found[2]).strip()
    return meaning[: found.start()], prose(value) if re.search(r"[a-z,] ", value) and value[0] != '"' else cell_code(value)


def cell_code(text):
    return f"`{text}`".replace("|", "\\|")


# Options, addresses, file names and the like.
CODE = re.compile(r"(?<!\S)['\"(\[]*((?:--?[a-zA-Z][\w-]*|\S*[*<>\[\]_#$]\S*?|[\w./-]+\.(?:md|sh|py|cpp|csv|json|trace|yml)))"
                  r"(?=[.,;:)'\"]*(?:\s|$))")  # fmt: skip


def prose(text):
    """Words as they are; options, file names and the like as code, so that no sign in them means anything."""
    if "\n" in text:
        return "<br>".join(prose(line) for line in text.split("\n"))
    out = ""
    for i, part in enumerate(text.split("`")):
        if i % 2 == 1:
            out += cell_code(part)
            continue
        at = 0
        for found in CODE.finditer(part):
            page = re.fullmatch(r"docs/([\w-]+\.md)", found[1])
            out += plain(part[at : found.start(1)]) + (f"[{found[1]}]({page[1]})" if page else cell_code(found[1]))
            at = found.end(1)
        out += plain(part[at:])
    return out


def plain(text):
    return re.sub(r"([\\*_\[\]<>|])", r"\\\1", text)
