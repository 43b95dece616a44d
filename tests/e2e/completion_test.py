#!/usr/bin/python3
"""Completes command lines in bash, zsh and fish, as a person does with the tab key.

    tests/e2e/completion_test.py BUILD_DIR bash|zsh|fish

The shells take the scripts of client/terminal from folders such as those of an installation.  Exit status 77: the shell, or
bash-completion for bash, is not installed.
"""
import os
import pathlib
import pty
import select
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_process import ServerProcess  # noqa: E402

SHELL = pathlib.Path(__file__).resolve().parents[2] / "client/terminal"
REFERENCE = SHELL.parents[1] / "tests/data/reference"
TIMEOUT_S = 600  # ends a test that hangs
BASH_COMPLETION = pathlib.Path("/usr/share/bash-completion/bash_completion")


def expect(condition, message):
    if not condition:
        sys.exit(message)


def run(command, folder, environment):
    ran = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=TIMEOUT_S,
                         check=False)
    expect(ran.returncode == 0, f"{command}: {ran.stdout}{ran.stderr}")
    return ran.stdout


def ask_bash(line, _there, folder, environment):
    """Calls the function that bash calls for the tab key, with the variables that bash sets."""
    script = f"""
        source {BASH_COMPLETION}
        source {SHELL}/$1.bash
        COMP_LINE=$2 COMP_POINT=${{#2}} COMP_TYPE=9 COMP_KEY=9
        # Readline divides the line at these characters too.
        mapfile -t COMP_WORDS < <(grep -oE '[^ =:]+|[=:]+' <<<"$2")
        [[ $2 != *' ' ]] || COMP_WORDS+=('')
        COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
        compopt() {{ :; }}
        spec=$(complete -p "${{COMP_WORDS[0]}}")
        [[ $spec =~ -F\\ ([^ ]+) ]]
        "${{BASH_REMATCH[1]}}" "${{COMP_WORDS[0]}}" "${{COMP_WORDS[COMP_CWORD]}}" "${{COMP_WORDS[COMP_CWORD - 1]}}"
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    name = "lucernad" if line.startswith("lucernad ") else "lucerna"
    return run(["bash", "--norc", "-c", script, "bash", name, line], folder, environment).split("\n")


def ask_fish(line, _there, folder, environment):
    out = run(["fish", "--no-config", "-c", f"set -p fish_complete_path {SHELL}; complete -C $argv[1]", line], folder,
              environment)
    return [entry.split("\t")[0] for entry in out.splitlines()]


def words_of(text):
    """The words that the terminal shows below the first line."""
    return " ".join(line for line in text.split("\n")[1:] if not line.startswith("READY> ")).split()


def ask_zsh(line, there, folder, environment):
    """Types the line and a tab into a zsh of its own terminal, and reads the list that appears.  Waits until `there` is in it."""
    setup = folder / ".zshrc"
    setup.write_text(f"fpath=({SHELL} $fpath)\nautoload -U compinit\ncompinit -u -D\nPROMPT='READY> '\n"
                     "zstyle ':completion:*' list-prompt ''\nLISTMAX=10000\nsetopt no_beep no_list_beep\n"
                     "bindkey '^I' list-choices\nunset zle_bracketed_paste\n")
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(folder)
        os.execvpe("zsh", ["zsh", "-d", "-i"], environment | {"ZDOTDIR": str(folder), "TERM": "dumb", "COLUMNS": "300",
                                                             "LINES": "200"})
    try:
        read_until(terminal, lambda text: "READY> " in text)
        os.write(terminal, line.encode() + b"\t")
        # The shell draws the list, and then the line again.  It may also draw the line before the list.
        text = read_until(terminal, lambda text: there in words_of(text) and text.endswith("READY> " + line))
    finally:
        os.kill(pid, 9)
        os.waitpid(pid, 0)
        os.close(terminal)
    return words_of(text)


def read_until(terminal, done):
    text, ends = "", time.monotonic() + TIMEOUT_S
    while not done(text):
        left = ends - time.monotonic()
        expect(left > 0 and select.select([terminal], [], [], left)[0], f"the shell is silent after {text!r}")
        text += os.read(terminal, 65536).decode(errors="replace")
    return text


def main():
    build, shell = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    if shutil.which(shell) is None or (shell == "bash" and not BASH_COMPLETION.exists()):
        print(f"skipped: {shell} is not installed")
        sys.exit(77)
    ask = {"bash": ask_bash, "zsh": ask_zsh, "fish": ask_fish}[shell]
    with tempfile.TemporaryDirectory() as folder, ServerProcess(build, REFERENCE) as server:
        folder = pathlib.Path(folder)
        (folder / "points.csv").write_text("0,0,0\n")
        (folder / "results").mkdir()
        environment = {"PATH": f"{build}/bin:{os.environ['PATH']}", "HOME": str(folder), "LC_ALL": "C.UTF-8",
                       "LUCERNA_SERVER": server.target, "TERM": "dumb"}

        def check(line, there, absent):
            found = ask(line, there, folder, environment)
            expect(there in found, f"{line!r} in {shell}: no {there} in {found}")
            expect(absent not in found, f"{line!r} in {shell}: {absent} in {found}")

        check("lucerna p", "power", "render")
        check("lucerna power --me", "--method", "--seed")
        check("lucerna --timeout 3 power --method s", "sampled", "exact")
        # Bash replaces only the part after "=".
        check("lucerna power --method=s", "sampled" if shell == "bash" else "--method=sampled", "exact")
        check("lucerna irradiance --points poi", "points.csv", "results")
        check("lucerna power many", "many_points.pbrt", "point.pbrt")
        check("lucerna tradeoff --query i", "irradiance", "render")
        check("lucerna-tradeoff --out res", "results" if shell == "bash" else "results/", "points.csv")
        check("lucernad --scene-r", "--scene-root", "--load")


main()
