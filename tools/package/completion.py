#!/usr/bin/env python3
"""Writes bash completions, made from what the programs say with --help: every option, the values that an option allows, and
file names where a file is wanted.

usage: completion.py FOLDER PROGRAM...

Writes FOLDER/NAME for every PROGRAM, NAME being its file name. bash-completion reads the file of that name when the program is
first typed; without bash-completion, `source` it.
"""

import os
import sys

import help_text

SCRIPT = """# {name}: completion for bash. Made from its --help; do not edit.
{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command='' values='' word
  # Bash makes three words of --name=value.
  if [[ $current == = ]]; then
    current=''
  elif [[ $before == = ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  word=${{COMP_WORDS[1]}}
  if ((COMP_CWORD > 1)); then
    case $word in
      {commands}) command=$word ;;
    esac
  fi
  COMPREPLY=()
  case $command:$before in
{values}
  esac
  case $values in
    file) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -f -- "$current"); return ;;
    folder) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -d -- "$current"); return ;;
    anything) return ;;
    *file) compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -W "${{values%file}}" -- "$current"; compgen -f -- "$current"); return ;;
    ?*) mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current"); return ;;
  esac
  if [[ $current != -* ]]; then
    case $command in
{words}
    esac
    return
  fi
  case $command in
{options}
  esac
  mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current")
}}
complete -F {function} {name}
"""


def values_word(option):
    """What the script puts into its variable `values` behind an option that takes a value."""
    if option.values and option.kind == "file":
        return " ".join(option.values) + " file"
    return " ".join(option.values) or option.kind or "anything"


def script(name, commands):
    values, words, options = [], [], []
    for command, text in commands.items():
        for option in text.options:
            if option.takes:
                values.append(f"    {command}:{option.name}) values='{values_word(option)}' ;;")
        if text.commands:
            words.append(f"      '{command}') mapfile -t COMPREPLY < <(compgen -W '{' '.join(text.commands)}' -- \"$current\") ;;")
        elif text.files:
            words.append(f"      '{command}') compopt -o filenames 2>/dev/null; mapfile -t COMPREPLY < <(compgen -f -- \"$current\") ;;")
        options.append(f"    '{command}') values='{' '.join(option.name for option in text.options)}' ;;")
    return SCRIPT.format(
        name=name, function="_" + name.replace("-", "_"), commands=" | ".join(c for c in commands if c) or "''",
        values="\n".join(values), words="\n".join(words) or "      *) ;;", options="\n".join(options))  # fmt: skip


def with_scenarios(programs):
    """An option that is called alike in several places takes the same names, also where --help does not list them again."""
    listed = {}
    for commands in programs.values():
        for text in commands.values():
            for option in text.options:
                if len(option.values) > len(listed.get(option.name, [])) and option.takes.startswith("NAME"):
                    listed[option.name] = option.values
    for commands in programs.values():
        for text in commands.values():
            for option in text.options:
                if option.takes.startswith("NAME"):
                    option.values = listed.get(option.name, [])
    return programs


def main(folder, *paths):
    os.makedirs(folder, exist_ok=True)
    programs = with_scenarios({os.path.basename(path): help_text.commands_of(path) for path in paths})
    for name, commands in programs.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(script(name, commands))


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__.strip() if sys.argv[1:] in (["--help"], ["-h"]) else "completion.py: give a folder and programs (see --help)")
    main(*sys.argv[1:])
