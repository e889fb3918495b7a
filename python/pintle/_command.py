"""The command `pintle` of the wheel."""

import os
import shlex
import signal
import sys

from ._pintle import command_line


def main() -> int:
    """Runs the command line with the words of this process, and gives its exit code."""
    # Ctrl-C ends the command, as it ends the program.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # `--python` asks the Python of this environment, activated or not.
    os.environ["PATH"] = os.pathsep.join((os.path.dirname(sys.executable), os.environ.get("PATH", os.defpath)))
    # `--library` starts this command again, which is Python.
    os.environ["PINTLE_COMMAND"] = f"{shlex.quote(sys.executable)} -c 'import pintle._command as it; it.main()'"
    return command_line(["pintle", *sys.argv[1:]])
