"""``python -m lamella`` is the command ``lamella``."""

from lamella.cli.main import run

if __name__ == "__main__":
    run()
