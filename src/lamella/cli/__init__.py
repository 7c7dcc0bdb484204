"""The command ``lamella``: what its subcommands do, and the words they take."""
