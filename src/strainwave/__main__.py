"""`python -m strainwave` is the command `strainwave`."""

from .app.commands.cli import main

if __name__ == "__main__":
    main()
