"""The command line, for `python -m envlights`."""

from envlights.cli import main

if __name__ == "__main__":
    main(prog_name="python -m envlights")
