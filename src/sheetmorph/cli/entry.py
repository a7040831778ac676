"""The program `sheetmorph`: its commands, and what becomes of their errors."""

from __future__ import annotations

import errno
import sys
from contextlib import suppress

import click

from sheetmorph import __version__
from sheetmorph.cli.branches import branches
from sheetmorph.cli.calibrate import calibrate
from sheetmorph.cli.check import check
from sheetmorph.cli.compare import compare
from sheetmorph.cli.design import design
from sheetmorph.cli.fabricate import fabricate
from sheetmorph.cli.history import history
from sheetmorph.cli.material import material
from sheetmorph.cli.new import new
from sheetmorph.cli.paper import paper
from sheetmorph.cli.plot import plot
from sheetmorph.cli.run import run
from sheetmorph.cli.studio import studio
from sheetmorph.cli.sweep import sweep
from sheetmorph.cli.verify import verify
from sheetmorph.core.errors import SheetmorphError

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS}
"""What the system says where a disk has no room, or takes nothing."""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, "-V", "--version", prog_name="sheetmorph")
def cli() -> None:
    """Predict the 3D shape into which a flat, patterned, layered sheet morphs.

    \b
    Start here:
      sheetmorph new bowl --preset bowl     write bowl.toml, a commented design
      sheetmorph check bowl.toml            see what would be computed
      sheetmorph run bowl.toml -o bowl      compute it, with pictures and a report
      sheetmorph fabricate bowl.toml        write the files to print, cut and glue it
      sheetmorph compare bowl scan.stl      measure it against a scan of the real thing
      sheetmorph studio                     design by eye, in the browser
    """


for _command in (
    *(new, check, run, compare, history, calibrate, fabricate, material, paper, verify),
    *(branches, sweep, plot, design, studio),
):
    cli.add_command(_command)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: as typed after `sheetmorph`; those of the process by default.

    Returns:
        The exit code: 0, 1 for a computation that failed, 2 for bad input, 130 when
        interrupted.
    """
    try:
        code = cli.main(arguments, prog_name="sheetmorph", standalone_mode=False)
    except SheetmorphError as error:
        return _fail(str(error), error.exit_code)
    except click.exceptions.Abort as error:
        return _fail(str(error) or "interrupted", 130)
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        help_of = context.command_path if context is not None else "sheetmorph"
        return _fail(f"{error.format_message()} (see {help_of} --help)", 2)
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except MemoryError:
        return _fail("out of memory; use a larger mesh.size", 1)
    except BrokenPipeError:
        # The reader of our output has gone (as in `| head`); nothing is left to tell.
        sys.stderr.close()
        return 1
    except OSError as error:
        if error.errno not in _FULL:
            raise
        with suppress(OSError):  # what it still holds would be written once more at the end
            sys.stdout.close()
        where = error.filename or "the output"
        return _fail(f"{where}: cannot be written ({error.strerror}); free some space", 2)
    return code if isinstance(code, int) else 0


def script() -> None:
    """Entry point of the `sheetmorph` program."""
    sys.exit(main())


def _fail(message: str, code: int) -> int:
    with suppress(OSError):  # where even errors cannot be told, the code tells
        click.echo(f"sheetmorph: {' '.join(message.split())}", err=True)
    return code
