#!/usr/bin/python3
"""Runs the commands of a page as printed, in one shell from top to bottom.

    tests/e2e/pages_test.py BUILD_DIR PAGE

PAGE is a Markdown file.  The test runs these fenced blocks:

    ```console        each line that begins with "$ " is a command, the other lines are its output;
                      a line that ends in a backslash continues in the next; each command must succeed
    ```console fails  each command must fail
    ```sh             the whole block is a script, which must succeed

Other blocks are not run.  The shell starts in a folder with the files of a checkout, in which build/release is BUILD_DIR.
Files that the commands write stay in that folder, which is removed.  Prints each command, and the output of a command
that does not behave as the page states.
"""
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIMEOUT_S = 1800  # ends a page that hangs
HOLDS = ("deploy", "docs", "proto", "scenes", "tests/data", "README.md", "LICENSE")


def commands(text):
    """Yields (command, must it succeed, line number) for each command of the page.

    A block of `sh` ends at its first command that fails, and so does the page.
    """
    language, block, begins = None, [], 0
    for number, line in enumerate(text.splitlines(), 1):
        if language is None:
            if opening := re.match(r"```(\S+.*)$", line):
                language, block, begins = opening[1].strip(), [], number + 1
        elif line.startswith("```"):
            if language == "sh":
                yield "set -e\n" + "\n".join(block) + "\nset +e", True, begins
            elif language in ("console", "console fails"):
                yield from prompts(block, language == "console", begins)
            language = None
        else:
            block.append(line)


def prompts(block, succeeds, begins):
    command = None
    for number, line in enumerate(block, begins):
        if command is not None:
            command += "\n" + line.removeprefix("> ")
        elif line.startswith("$ "):
            command, at = line[2:], number
        if command is not None and not command.endswith("\\"):
            yield command, succeeds, at
            command = None


def script(text):
    """One shell script of all commands.  It ends with the first that does not behave as the page states."""
    lines = ["set -o pipefail", "exec 2>&1"]
    for command, succeeds, number in commands(text):
        lines.append(f"printf '%s\\n' {shlex.quote(f'[line {number}] $ {command}')}")
        # Not in a subshell: variables and background processes stay.
        lines.append("{ " + command + "\n}")
        lines.append("status=$?")
        wrong = "-ne 0" if succeeds else "-eq 0"
        says = "must succeed" if succeeds else "must fail"
        lines.append(f"[ $status {wrong} ] && {{ echo \"line {number}: exit status $status, {says}\"; exit 1; }}")
    lines.append("exit 0")
    return "\n".join(lines) + "\n"


def run(page, build):
    text = page.read_text()
    if not list(commands(text)):
        print("no commands")
        return 0
    with tempfile.TemporaryDirectory(prefix="lucerna-page-") as folder:
        folder = pathlib.Path(folder)
        for name in HOLDS:
            # Copies: servers and uploads refuse links that lead out of their root.
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, folder / name)
            else:
                shutil.copy(ROOT / name, folder / name)
        (folder / "build").mkdir()
        (folder / "build/release").symlink_to(build)
        environment = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
        shell = subprocess.Popen(["bash", "-c", script(text)], cwd=folder, env=environment, start_new_session=True,
                                 stdin=subprocess.DEVNULL)
        try:
            return shell.wait(TIMEOUT_S)
        finally:
            # Servers that the page leaves running are in the shell's process group.
            try:
                os.killpg(shell.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass


def check_that_wrong_pages_fail(build):
    """Checks commands that fail where they must succeed, and that succeed where they must fail."""
    for wrong in ("```console\n$ false\n```\n", "```console fails\n$ true\n```\n", "```sh\ntrue\nfalse\n```\n",
                  "```sh\nfalse\ntrue\n```\n"):
        with tempfile.NamedTemporaryFile("w", suffix=".md") as page:
            page.write(wrong)
            page.flush()
            if run(pathlib.Path(page.name), build) == 0:
                sys.exit(f"a wrong page passes:\n{wrong}")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    build, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    if page.name == "README.md" and page.parent == ROOT:
        check_that_wrong_pages_fail(build)
    sys.exit(run(page, build))


main()
