"""``python -m fovolnet`` is the command ``fovolnet``."""

from .programs import command

command()
