#!/usr/bin/python3
"""Makes the manual pages of lucerna, its commands, lucerna-tradeoff and lucernad from what their --help prints.

    deploy/manual/make.py --version VERSION --out DIRECTORY PROGRAM...

Writes lucerna.1, lucerna-COMMAND.1, lucerna-tradeoff.1 and lucernad.8, each with what its program prints.  Sections
that help does not have, such as exit statuses, come from deploy/manual/NAME.SECTION.  Fails for help that it does not
understand.
"""
import argparse
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
COLUMN = 30  # in CLI11's help, descriptions begin here
TIMEOUT_S = 600  # ends a program that hangs
PURPOSE = {
    "lucerna": "query a lighting server",
    "lucerna-tradeoff": "measure error against time of every sampling method",
    "lucernad": "server for queries about the light in scenes",
}
# CLI11 prints the type of a value before the name of its check.
TYPE = re.compile(r"\b(TEXT|UINT|INT|FLOAT):(?=\S)")


def continues(line):
    """Whether the line has only a description, of the term before it."""
    return len(line) > COLUMN and not line[:COLUMN].strip()


class Help:
    """The parts of a help text."""

    def __init__(self, text):
        lines = text.splitlines()
        usage = next((i for i, line in enumerate(lines) if line.startswith("Usage: ")), None)
        if usage is None:
            raise ValueError("the help has no line that begins with Usage:")
        self.about = " ".join(lines[:usage]).strip()
        self.usage = lines[usage].removeprefix("Usage: ")
        self.groups = {}  # heading: [(term, description)]
        self.footer = []
        heading = None
        for line, next_line in zip(lines[usage + 1:], [*lines[usage + 2:], ""]):
            title = re.match(r"(\w[\w ]*):$", line)
            if title and not self.footer and title[1] in ("Positionals", "Options", "Subcommands"):
                heading = self.groups.setdefault(title[1], [])
            elif heading is not None and not self.footer and line.startswith("  "):
                self.add(heading, line, next_line)
            elif line.strip() or self.footer:
                self.footer.append(line)

    @staticmethod
    def add(heading, line, next_line):
        if continues(line):
            heading[-1] = (heading[-1][0], line.strip())
        # A long term has its description in the next line.
        elif not continues(next_line) and len(line) > COLUMN and line[COLUMN - 1] == " ":
            heading.append((line[:COLUMN].strip(), line[COLUMN:].strip()))
        else:
            heading.append((line.strip(), ""))


def escape(text):
    """Text of roff: no line is a request, and hyphens can be searched and copied."""
    for character, roff in (("\\", "\\e"), ("-", "\\-"), ("~", "\\(ti"), ("^", "\\(ha"), ("`", "\\(ga")):
        text = text.replace(character, roff)
    # Long lists may break after their commas.
    text = re.sub(r"\S{30,}", lambda word: word[0].replace(",", ",\\:"), text)
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.M)


def term_of(term, positional=False):
    """`--seed UINT:NUMBER=0 Needs: --x` as (roff of the option, its default, its notes)."""
    notes = []
    for word, says in (("Excludes", "Excludes"), ("Needs", "Needs")):
        if found := re.search(rf" {word}: ((?:--?[\w-]+ ?)+)", term):
            notes.append(f"{says} {', '.join(found[1].split())}.")
            term = term.replace(found[0], " ")
    if found := re.search(r" \(Env:(\w+)\)", term):
        notes.append(f"The variable {found[1]} sets it too.")
        term = term.replace(found[0], "")
    required = term.endswith("REQUIRED")
    term = term.removesuffix("REQUIRED").strip()
    term = TYPE.sub("", term)
    term = re.sub(r"\{.*?\} :(\w+)$", r"[=\1]", term)  # an option whose value may be left out
    default = None
    if found := re.match(r"(\S+ (?:\{.*?\}|[^\s=]+))=(\S*)(.*)", term):
        term, default = found[1] + found[3], found[2]
    names, _, value = term.partition(" ")
    value = re.sub(r"\{(.*?)\}", lambda m: "|".join(m[1].split(", ")), value)
    # The name of the check after that of the value.
    value = re.sub(r"(?<=[\w.]):(NUMBER|TIME|SHARE|LIMIT|LIGHT)\b", "", value)
    value = re.sub(r"^(UINT|INT|FLOAT)\b", "NUMBER", value)
    if positional and value == "TEXT":
        value = ""
    roff = ", ".join(f"\\fB{escape(name)}\\fR" for name in names.split(","))
    if value:
        roff += f" \\fI{escape(value)}\\fR"
    return roff, default, notes, required


def options(entries, positional=False):
    for term, text in entries:
        roff, default, notes, required = term_of(term, positional)
        text = text.rstrip(".") + "." if text else ""
        if default and "default" not in text:
            text += f" Default: {default}."
        if positional and not required:
            text += " Optional."
        yield ".TP\n" + roff + "\n" + escape(" ".join([text, *notes]).strip())


def footer(lines):
    """Examples as literal text, other lines as paragraphs."""
    examples, text, inside = [], [], False
    for line in lines:
        if re.match(r"Examples?:$", line):
            inside = True
        elif inside and line.startswith("  "):
            examples.append(line[2:])
        else:
            inside = False
            # Rows of a list are paragraphs.
            text += ["", line.strip(), ""] if line.startswith("  ") else [line]
    return examples, "\n".join(text).strip()


def page(name, section, version, about, help_text, see, commands=()):
    manual = "System Administration" if section == 8 else "User Commands"
    out = [f'.TH {name.upper()} {section} "" "Lucerna {version}" "{manual}"', ".SH NAME",
           f"{escape(name)} \\- {escape(about)}", ".SH SYNOPSIS"]
    words = help_text.usage.split()
    program = len(words) if "[OPTIONS]" not in words else words.index("[OPTIONS]")
    called = "lucernad" if name == "lucernad" else " ".join(words[:program])
    out.append(f"\\fB{escape(called)}\\fR " + escape(" ".join(words[program:])))
    examples, more = footer(help_text.footer)
    extra = HERE / f"{name}.{section}"
    paragraphs = [help_text.about.rstrip(".") + "."] + [" ".join(p.split()) for p in more.split("\n\n")
                                                       if p and not p.startswith("Exit status")]
    out += [".SH DESCRIPTION", "\n.PP\n".join(escape(p) for p in paragraphs)]
    if "Positionals" in help_text.groups:
        out += [".SH ARGUMENTS", *options(help_text.groups["Positionals"], positional=True)]
    if commands:
        out.append(".SH COMMANDS")
        for command, text in commands:
            name_of_page = escape(f"lucerna-{command}")
            out.append(f".TP\n\\fB{escape(command)}\\fR\n{escape(text.rstrip('.'))}.  See\n.BR {name_of_page} (1).")
    if "Options" in help_text.groups:
        out += [".SH OPTIONS", *options(help_text.groups["Options"])]
    if section == 1 and name not in ("lucerna", "lucerna-tradeoff"):
        out.append(".PP\nThe options of\n.BR lucerna (1)\nmay come before or after the command.")
    if examples:
        out += [".SH EXAMPLES", ".nf", *(escape(line) for line in examples), ".fi"]
    if extra.exists():
        out.append(extra.read_text().rstrip())
    out += [".SH SEE ALSO", ",\n".join(f".BR {escape(n)} ({s})" for n, s in see).replace("),\n", "),\n")]
    return "\n".join(out) + "\n"


def help_of(*command):
    ran = subprocess.run([*command, "--help"], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    if ran.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} --help: exit status {ran.returncode}\n{ran.stderr}")
    return Help(ran.stdout)


def pages_of(program, version):
    """Yields (file name, text) for each page of the program."""
    name = pathlib.Path(program).name
    help_text = help_of(program)
    see = [("lucerna", 1), ("lucerna-tradeoff", 1), ("lucernad", 8)]
    commands = help_text.groups.get("Subcommands", [])
    section = 8 if name == "lucernad" else 1
    yield f"{name}.{section}", page(name, section, version, PURPOSE[name], help_text,
                                    [entry for entry in see if entry[0] != name], commands)
    for command, text in commands:
        full = f"lucerna-{command}"
        if full in PURPOSE:
            continue  # a program of its own
        about = text[0].lower() + text[1:].split(";")[0].rstrip(".")
        yield f"{full}.1", page(full, 1, version, about, help_of(program, command), [("lucerna", 1), ("lucernad", 8)])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--version", required=True)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for program in arguments.programs:
        for name, text in pages_of(program, arguments.version):
            (arguments.out / name).write_text(text)


if __name__ == "__main__":
    main()
