"""The command `studio`."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sheetmorph.core.errors import InputError, OutputError

if TYPE_CHECKING:
    from sheetmorph.studio.server import Settings

PORT = 8777
TRIED = 20
"""Ports that are tried from `PORT` on, where none is given."""
HERE = "127.0.0.1"
MEGABYTE = 2**20


@click.command()
@click.argument("file", type=click.Path(path_type=Path), required=False)
@click.option("--port", type=click.IntRange(0, 65535), metavar="N", help="Port [8777].")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option(
    "--host",
    default=HERE,
    show_default=True,
    metavar="ADDRESS",
    help="Address to bind to. Any other asks for a token, which the printed address has.",
)
@click.option("--token", is_flag=True, help="Ask for a token on this machine too.")
@click.option(
    "--memory",
    type=click.IntRange(256, 1_000_000),
    default=4096,
    show_default=True,
    metavar="MB",
    help="Memory that one computation may have.",
)
@click.option("--workers", type=click.IntRange(1, 64), help="Processes that solve [2].")
def studio(
    file: Path | None,
    port: int | None,
    no_browser: bool,
    host: str,
    token: bool,
    memory: int,
    workers: int | None,
) -> None:
    """Open the studio: a local web page on which a sheet is designed by eye.

    FILE is the design that it begins with and saves to; without it, the bowl. Stop it with
    Ctrl-C.

    \b
    Examples:
      sheetmorph studio
      sheetmorph studio bowl.toml
      sheetmorph studio --host 0.0.0.0 --port 9000 --no-browser
    """
    from sheetmorph.studio.bundle import three_js

    three_js()  # says what to install
    from dataclasses import replace

    from sheetmorph.studio.server import Studio, new_token, serve

    settings = replace(_begun_with(file), memory=memory * MEGABYTE)
    if workers is not None:
        settings = replace(settings, workers=workers)
    if token or host not in (HERE, "localhost", "::1"):
        settings = replace(settings, token=new_token())
    bound = _bound(host, port)
    settings = replace(settings, port=bound.getsockname()[1])
    address = _address(host, settings)

    def ready() -> None:
        click.echo(f"the studio is at {address}  (stop it with Ctrl-C)")
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    serve(Studio(settings), [bound], ready)


def _begun_with(file: Path | None) -> Settings:
    """Settings with the design of a file, or with the bowl."""
    from sheetmorph.design.files import read_design_text
    from sheetmorph.design.presets import preset_text
    from sheetmorph.design.spec import Design
    from sheetmorph.studio.server import Settings

    if file is None:
        return Settings(preset_text("bowl"))
    Design.load(file)  # what is wrong with it is told here, in the terminal
    return Settings(read_design_text(file), file.resolve())


def _bound(host: str, port: int | None) -> socket.socket:
    """A socket at the wanted port; without a wish, at the first free one from `PORT` on."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    for number in [port] if port is not None else range(PORT, PORT + TRIED):
        bound = socket.socket(family, socket.SOCK_STREAM)
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((host, number))
        except socket.gaierror:
            bound.close()
            raise InputError("is no address of this machine", key="--host", value=host) from None
        except OSError as error:
            bound.close()
            if port is not None:
                raise OutputError(
                    f"port {port} of {host} cannot be used ({error.strerror}); choose another "
                    "with --port"
                ) from None
            continue
        return bound
    raise OutputError(f"no port from {PORT} to {PORT + TRIED - 1} is free; choose one with --port")


def _address(host: str, settings: Settings) -> str:
    shown = f"[{host}]" if ":" in host else host
    if host in ("0.0.0.0", "::"):  # noqa: S104  all addresses: one that works is told
        shown = socket.gethostname()
    suffix = "" if settings.token is None else f"?token={settings.token}"
    return f"http://{shown}:{settings.port}/{suffix}"
