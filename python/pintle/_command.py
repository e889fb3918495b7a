"""The command `pintle` of the wheel."""

import os
import shlex
import signal
import sys

from ._pintle import command_line

# What a shell starts as Python, and as this command.
PYTHON = shlex.quote(sys.executable or "python3")
COMMAND = f"{PYTHON} -c 'import pintle._command as it; it.main()'"


def main() -> int:
    """Runs the command line with the words of this process, and gives its exit code."""
    # Ctrl-C ends the command, as it ends the program.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # `--python` asks the Python of this environment, activated or not.
    os.environ["PATH"] = os.pathsep.join((os.path.dirname(sys.executable), os.environ.get("PATH", os.defpath)))
    # `--library` starts this command again, which is Python.
    os.environ["PINTLE_COMMAND"] = COMMAND
    return command_line(["pintle", *sys.argv[1:]])
