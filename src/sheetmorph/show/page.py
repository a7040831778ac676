"""Pages of HTML from the templates here; all of them are laid out by `base.html`."""

from __future__ import annotations

from typing import Any

from sheetmorph import __version__


def rendered(template: str, **values: Any) -> str:
    """A page as text; it refers to nothing outside itself.

    Args:
        template: file name, such as "report.html".
        values: what the template fills in. `base.html` wants `title`, `lead`, `references`,
            and, where the template has no summary of its own, `banner` and `facts`; a
            `version` other than that of the program is that of what made the numbers.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("sheetmorph.show"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render({"version": __version__, **values})
