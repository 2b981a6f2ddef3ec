"""Command `snowsim`: every module here is a command, its `command`; it imports what takes time when it runs."""

import importlib
import os
import pkgutil
import sys

import click

from snowsim import __version__


class Commands(click.Group):
    """The modules of this package."""

    def list_commands(self, _):
        """Names of the commands."""
        return sorted(module.name for module in pkgutil.iter_modules(__path__))

    def get_command(self, context, name):
        """A command, or None where there is none."""
        known = name in self.list_commands(context)
        return importlib.import_module(f"{__name__}.{name}").command if known else None


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__)
def commands():
    """Simulate airborne snow radar, and score what tracks its layers; the workflow itself is Snakemake's.

    Errors are one line; exit codes 1 bad data or no room, 2 bad usage, 130 interrupted.
    """


def main(arguments=None):
    """Run a command; where it fails, one line on stderr and its exit code."""
    try:
        commands.main(arguments, prog_name="snowsim", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(2)
    except (click.ClickException, click.Abort, ValueError, OSError, MemoryError) as error:
        from snowsim.io.guard import one_line

        usage, aborted = isinstance(error, click.ClickException), isinstance(error, click.Abort)
        message = error.format_message() if usage else "interrupted" if aborted else error
        click.echo(f"error: {one_line(message)}", err=True)
        try:
            sys.stdout.flush()
        except OSError:  # a full disk: not to be tried again, and complained of, while Python ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(2 if usage else 130 if aborted else 1)
