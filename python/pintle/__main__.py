"""python -m pintle: the command."""

from . import main

main()
