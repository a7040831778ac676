"""The command `run`."""

from __future__ import annotations

import json
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from sheetmorph.cli.shared import (
    ProgressBar,
    design_file,
    load_design,
    naming,
    output_folder,
    set_values,
)
from sheetmorph.core.errors import SheetmorphError

STARTED = perf_counter()


@click.command()
@design_file
@output_folder("Folder for the results. Default: results/NAME.", "results/bowl")
@set_values
@click.option("--resume", is_flag=True, help="Go on with a run that was cut off in this folder.")
@click.option("--force", is_flag=True, help="Replace the results that are in the folder.")
@click.option(
    "--modes",
    type=click.IntRange(0, 50),
    default=0,
    metavar="N",
    help="Compute the N softest modes of every state, and the first bifurcation: modes.h5.",
)
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, nothing else.")
def run(
    file: Path,
    output: Path | None,
    overrides: tuple[str, ...],
    resume: bool,
    force: bool,
    modes: int,
    quiet: bool,
    as_json: bool,
) -> None:
    """Compute the shape of the design FILE and write a folder of results.

    The folder receives result.h5 (every state), summary.json, shape.stl, a series for
    ParaView, pictures, an animation and report.html. With solver.kind = "dynamic" the sheet
    moves in time, and motion.csv has its energies.

    \b
    Examples:
      sheetmorph run bowl.toml -o results/bowl
      sheetmorph run bowl.toml --set actuation.eps_pre=-0.3 --set mesh.size="2 mm"
      sheetmorph run bowl.toml -o results/bowl --resume
    """
    design = load_design(file, overrides)
    folder = output or Path("results") / file.stem
    silent = quiet or as_json
    with ProgressBar(silent) as listener, naming(file):
        from sheetmorph.show.outputs import run_design

        try:
            result, notes = run_design(
                design,
                folder,
                resume=resume,
                force=force,
                modes=modes,
                on_event=listener,
                started=STARTED,
            )
        except KeyboardInterrupt:
            raise click.exceptions.Abort("interrupted; add --resume to go on") from None
    if as_json:
        click.echo(json.dumps(result.summary, indent=2, ensure_ascii=False))
    elif not quiet:
        _tell(result.summary, folder, [*design.notes, *notes])
    if result.status == "interrupted":
        raise click.exceptions.Abort(
            f"interrupted after {len(result.positions) - 1} states; add --resume to go on"
        )
    if result.status != "completed":
        raise SheetmorphError(
            f"{file}: the run ended as {result.status} ({result.summary['detail']}): "
            f"{result.summary['remedy']}"
        )


def _tell(summary: dict[str, Any], folder: Path, notes: list[str]) -> None:
    """The result in a few lines."""
    for note in notes:
        click.echo(f"note: {note}", err=True)
    if summary["status"] == "interrupted":
        return
    width, depth, height = (1e3 * value for value in summary["bbox_m"])
    stable = "stable" if summary["stable"] else f"{summary['negative_pivots']} negative pivots"
    if not summary.get("motion", {}).get("at_rest", True):
        stable = "in motion"
    seconds = summary["seconds"]
    click.echo(
        f"{summary['name']}: {summary['status']} at {100 * summary['actuation_reached']:.0f} % of "
        f"eps_pre {summary['eps_pre']:g}, {stable}\n"
        f"  size       {width:.1f} × {depth:.1f} × {height:.1f} mm, "
        f"h/d {summary['aspect_ratio']:.3f}\n"
        f"  mesh       {summary['nodes']} nodes, {summary['triangles']} triangles\n"
        f"  solve      {seconds['total']:.2f} s, {summary['factorisations']} factorisations by "
        f"{summary['solver']}, {summary['states']} states\n"
        f"{_motion(summary)}"
        f"{_stability(summary)}"
        f"{_surroundings(summary)}"
        f"  everything {seconds['wall']:.1f} s\n"
        f"results in {folder}{'/' if not str(folder).endswith('/') else ''}"
        f"{' (open report.html)' if (folder / 'report.html').is_file() else ''}"
    )


def _motion(summary: dict[str, Any]) -> str:
    """What moved, and where its energy went; nothing for equilibria."""
    if "motion" not in summary:
        return ""
    told = summary["motion"]
    rest = "at rest after" if told["at_rest"] else "in motion after"
    return (
        f"  motion     {rest} {told['time_s']:.4g} s, {told['steps']} steps "
        f"({told['integrator'].replace('_', ' ')}), fastest {told['fastest_m_per_s']:.3g} m/s\n"
        f"  energy     {1e3 * told['actuation_work_J']:.3g} mJ by the actuation, "
        f"{1e3 * told['load_work_J']:.3g} mJ by loads; {1e3 * told['damped_J']:.3g} mJ damped, "
        f"{1e3 * told['numerical_J']:.3g} mJ lost to the steps\n"
    )


def _stability(summary: dict[str, Any]) -> str:
    """The softest modes and the first bifurcation, where they were asked for."""
    if "stability" not in summary:
        return ""
    told = summary["stability"]
    values = ", ".join(f"{value:.3g}" for value in told["eigenvalues_N_per_m3"])
    first = told["first_bifurcation"]
    place = f"at eps_pre {first['eps_pre']:.4g}" if first else "none found"
    return f"  modes      {values} N/m³; first bifurcation without load: {place}\n"


def _surroundings(summary: dict[str, Any]) -> str:
    """What bears the sheet, and whether it passes through itself."""
    lines = ""
    if table := summary.get("table"):
        touching, weight = table["nodes_in_contact"], summary.get("weight_N", 0.0)
        lines += (
            f"  table      bears {table['reaction_N']:.4g} N of {weight:.4g} N "
            f"on {touching} {'node' if touching == 1 else 'nodes'}\n"
        )
    elif "weight_N" in summary:
        lines += f"  weight     {summary['weight_N']:.4g} N\n"
    if any(one["touches"] for one in summary.get("self_contact", [])):
        lines += "  contact    the sheet touches itself\n"
    if crossing := summary["crossing_pairs"]:
        pairs = "a pair" if crossing == 1 else f"{crossing} pairs"
        lines += (
            f"  warning    the sheet passes through itself in {pairs} of triangles; "
            "contact.self_contact = true keeps its parts apart\n"
        )
    return lines
