"""What `material shrink` and `material cantilever` print."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from sheetmorph.design.shrink_fit import ShrinkFit
    from sheetmorph.measure.cantilever import CantileverResult


def tell_shrink(fit: ShrinkFit, folder: Path) -> None:
    """The fit in a table and a few lines."""
    glass, scatter = fit.data.glass_temperature, fit.scatter
    heads = [*(["T/Tg"] if glass else []), "T [°C]", "rows", "mean", "std", "curve"]
    click.echo("".join(f"{head:>9}" for head in heads))
    together = fit.together
    for index, heat in enumerate(fit.temperatures):
        cells = [*([f"{heat / glass:.3f}"] if glass else []), f"{heat - 273.15:.1f}"]
        cells += [f"{together.counts[index]:.0f}", f"{together.means[index]:.4f}"]
        cells += [f"{together.deviations[index]:.4f}" if together.counts[index] > 1 else "–"]
        click.echo("".join(f"{cell:>9}" for cell in [*cells, f"{fit.fitted[index]:.4f}"]))
    spread = "" if scatter is None else f" ± {scatter[-1]:.2g}"
    end = "" if fit.plateau is None else f", levels off at {_degrees(fit.plateau, glass)}"
    click.echo(
        f"{fit.data.name}: {len(fit.data.temperatures)} rows, L/L0 {fit.trend} from "
        f"{_degrees(fit.onset, glass)} on{end}\n"
        f"  eps_pre    {fit.fitted[-1] - 1.0:+.4f}{spread} at the last temperature\n"
        f"  residual   {fit.residual_rms:.2g} RMS of the rows about the curve\n"
        f"  directions {fit.anisotropy_text}\n"
        f'files in {folder} (in a design beside them: shrink_curve = "curve.csv")'
    )


def tell_cantilever(result: CantileverResult, folder: Path) -> None:
    """Every sample in a table, then the statistics."""
    from sheetmorph.show.material import spread, stiff_unit

    factor, unit = stiff_unit(result.modulus.mean)
    error = result.modulus_uncertainty
    heads = ["sample", f"E [{unit}]", *(["±"] if error is not None else [])]
    click.echo("".join(f"{head:>14}" for head in [*heads, "I [m^4]", "K [N/m]", "defl./length"]))
    for row, sample in enumerate(result.rows.samples[:100]):
        cells = [sample[:12], f"{result.young_modulus[row] / factor:.4g}"]
        cells += [f"{error[row] / factor:.2g}"] if error is not None else []
        cells += [f"{result.rows.second_moment[row]:.3e}", f"{result.stiffness[row]:.4g}"]
        click.echo(
            "".join(f"{c:>14}" for c in [*cells, f"{result.rows.deflection_ratio[row]:.3f}"])
        )
    if len(result.rows.samples) > 100:
        click.echo(f"{'…':>14}  all {len(result.rows.samples)} are in cantilever.csv")
    for warning in result.warnings:
        click.echo(f"warning: {warning}", err=True)
    click.echo(
        f"mean ± standard deviation (n − 1) of {result.modulus.count} samples\n"
        f"  E  {spread(result.modulus, factor)} {unit}"
        f"{' (exact for large deflections)' if result.large_deflection else ''}\n"
        f"  I  {result.second_moment.mean:.3g} ± {result.second_moment.deviation:.2g} m^4\n"
        f"  K  {spread(result.nominal_stiffness, 1.0)} N/m (load over deflection)\n"
        f"files in {folder}"
    )


def _degrees(temperature: float, glass: float | None) -> str:
    share = f"T/Tg = {temperature / glass:.3f}, " if glass else ""
    return f"{share}{temperature - 273.15:.1f} °C"
