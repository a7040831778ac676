"""Measure what choosing-a-model.md says, print its tables, draw its picture.

    .venv/bin/python benchmarks/models_compared.py [PART …]

Parts: designs, scan, mesh, numbering, fit, picture; all by default. The paper's meshes and the
scan come from the folder that SHEETMORPH_REFERENCE_DATA names.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from time import process_time

import numpy as np

import sheetmorph as sm
from sheetmorph.calibrate.fit import CalibrateOptions, calibrate
from sheetmorph.calibrate.parameter_texts import read_parameters
from sheetmorph.calibrate.targets import MeasuredScan
from sheetmorph.cli.surfaces import read_scan
from sheetmorph.compare.comparison import CompareOptions, Comparison, compare_surfaces
from sheetmorph.compare.surface import Surface
from sheetmorph.design.files import reference_folder
from sheetmorph.design.presets import preset_text
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.study.simulate import simulate

ROOT = Path(__file__).resolve().parents[1]
ACTUATIONS = {"bowl": (-0.2, -0.3, -0.77), "canoe": (-0.08, -0.15, -0.3),
              "petals": (-0.1, -0.3, -0.5)}  # fmt: skip
SIZES = {"bowl": (4.5, 3.2, 2.3, 1.6), "canoe": (5.6, 4.0, 2.8, 2.0),
         "petals": (5.8, 4.1, 2.9, 2.05)}  # fmt: skip
MODELS = ("published", "laminate")
FITS = {
    "published": ("eps_pre=-0.7:-0.3", "coupling=-1:3"),
    "laminate": ("eps_pre=-0.7:-0.3", "actuation.under_pattern=0:0.25"),
    "laminate, gamma": ("eps_pre=-0.7:-0.3", "gamma=0:6"),
    "laminate, moduli": ("eps_pre=-0.7:-0.3", "moduli_ratio=0.5:20"),
}
REPEAT = 3


def design_of(name: str, model: str, eps: float | None = None) -> sm.Design:
    """The published example on the released mesh, in one of the two models."""
    design = sm.Design.load(ROOT / "examples" / "published" / f"{name}.toml")
    values: dict[str, object] = {"perturbation.ramp_down_steps": 1}
    if eps is not None:
        values["actuation.eps_pre"] = eps
    if model == "laminate":
        # The film below pulls the rim down; a push the other way only delays that.
        values |= {"model": "laminate", "published": None, "perturbation.direction": "down"}
    return design.with_values(values)


def made_here(name: str, model: str, size: float) -> sm.Design:
    """The preset on a mesh made here, distances taken to the boundary of the pattern."""
    values = {
        "model": model,
        "mesh.size": f"{size} mm",
        "actuation.distance": "pattern_boundary",
        "perturbation.direction": "down" if model == "laminate" else "up",
    }
    return sm.Design.from_toml(preset_text(name)).with_values(values)


@cache
def solved(name: str, model: str, eps: float) -> sm.Result:
    """The result on the released mesh."""
    return simulate(design_of(name, model, eps))


def surface(result: sm.Result) -> Surface:
    """The last state."""
    return Surface(result.positions[-1], result.mesh.triangles)


def beside(ours: sm.Result, other: sm.Result) -> Comparison:
    """Two shapes of the same size, laid over each other."""
    return compare_surfaces(surface(ours), surface(other), options=CompareOptions(scale=1.0))


def processor_seconds(design: sm.Design) -> float:
    """Median processor time of a run, without pictures and files."""
    times = []
    for _ in range(REPEAT):
        start = process_time()
        simulate(design)
        times.append(process_time() - start)
    return statistics.median(times)


def designs() -> None:
    """The three designs at their three actuations, on the released meshes."""
    print("| design | eps_pre | h/d published | h/d laminate | SSIM | RMS | seconds | factorised |")
    print("|---|---|---|---|---|---|---|---|")
    for name, levels in ACTUATIONS.items():
        for eps in levels:
            results = [solved(name, model, eps) for model in MODELS]
            seconds = [processor_seconds(design_of(name, model, eps)) for model in MODELS]
            found = beside(*results)
            rms = 1e3 * np.mean([found.scan_to_shape.rms, found.shape_to_scan.rms])
            ratios = [r.summary["aspect_ratio"] for r in results]
            counts = [r.summary["factorisations"] for r in results]
            ends = {r.status for r in results}
            print(
                f"| {name} | {eps:.2f} | {ratios[0]:.3f} | {ratios[1]:.3f} "
                f"| {found.similarity.value:.3f} | {rms:.1f} mm "
                f"| {seconds[0]:.2f}, {seconds[1]:.2f} | {counts[0]}, {counts[1]} |"
                + ("" if ends == {"completed"} else f" {ends}"),
                flush=True,
            )


def against_scan(result: sm.Result) -> str:
    """SSIM, RMS both ways and h/d beside the scan of the petals."""
    scan = read_scan(reference_folder(None) / "petals_scan_outer.stl")
    found = compare_surfaces(surface(result), scan)
    there, back = 1e3 * found.scan_to_shape.rms, 1e3 * found.shape_to_scan.rms
    ratio = found.aspect_ratio
    return (
        f"{found.similarity.value:.3f} | {there:.2f}, {back:.2f} mm | {ratio.shape:.3f} "
        f"({ratio.scan:.3f})"
    )


def scan() -> None:
    """The petals at −0.50 beside the scan."""
    print("| model | mesh | nodes | SSIM | RMS scan→shape, back | h/d (scan) |")
    print("|---|---|---|---|---|---|")
    for model in MODELS:
        result = solved("petals", model, -0.5)
        print(f"| {model} | released | {len(result.mesh.nodes)} | {against_scan(result)} |")
        for size in (4.1, 2.9):
            result = simulate(made_here("petals", model, size))
            count = len(result.mesh.nodes)
            print(f"| {model} | {size} mm | {count} | {against_scan(result)} |", flush=True)


def mesh() -> None:
    """Four refinements, each beside the finest."""
    print("| design | model | " + " | ".join(f"mesh {k + 1}" for k in range(4)) + " |")
    print("|---|---|---|---|---|---|")
    for name, sizes in SIZES.items():
        for model in MODELS:
            results = [simulate(made_here(name, model, size)) for size in sizes]
            cells = []
            for result in results:
                same = result is results[-1]
                similar = (
                    "" if same else f", SSIM {beside(results[-1], result).similarity.value:.3f}"
                )
                end = "" if result.status == "completed" else f", {result.status}"
                count = len(result.mesh.nodes)
                cells.append(f"{count} nodes: {result.summary['aspect_ratio']:.3f}{similar}{end}")
            print(f"| {name} | {model} | " + " | ".join(cells) + " |", flush=True)


def numbering() -> None:
    """Edges turned at random: how far the shape moves."""
    print("| design | published, order of the file | published, geometric rule | laminate |")
    print("|---|---|---|---|")
    for name, levels in ACTUATIONS.items():
        moves = []
        for model, values in (
            ("published", {"published.hinge_orientation": "file_order"}),
            ("published", {"published.hinge_orientation": "away_from_pattern"}),
            ("laminate", {}),
        ):
            design = design_of(name, model, levels[-1]).with_values(values)
            plain = design.build_mesh()
            turned = np.random.default_rng(0).random(len(plain.edges)) < 0.5
            edges = np.where(turned[:, None], plain.edges[:, ::-1], plain.edges)
            other = build_mesh(plain.nodes, plain.triangles, edges=edges)
            if values.get("published.hinge_orientation") == "away_from_pattern":
                from sheetmorph.design.meshing import farther_side

                side = farther_side(other, design.pattern_polygon())
                other = other.with_hinges_reversed(side < 0)
            first, second = (simulate(design, mesh=one).positions[-1] for one in (plain, other))
            moves.append(1e3 * float(np.linalg.norm(first - second, axis=1).max()))
        print(f"| {name} | " + " | ".join(f"{move:.2g} mm" for move in moves) + " |", flush=True)


def fit() -> None:
    """Two parameters of each model fitted to the scan."""
    measured = MeasuredScan(read_scan(reference_folder(None) / "petals_scan_outer.stl"))
    options = CalibrateOptions(profile=False, starts=6, descents=2)
    for label, texts in FITS.items():
        model = label.split(",")[0]
        design = (
            design_of("petals", model) if model == "published" else made_here("petals", model, 4.1)
        )
        found = calibrate(design, read_parameters(texts, design), scans=[measured], options=options)
        print(f"{label}: {' '.join(found.summary().split())} ({len(found.evaluations)} designs, "
              f"{found.seconds:.0f} s)")  # fmt: skip
        best = sm.Design.from_toml(found.fitted_toml(), design.folder)
        print(f"  | {label} | {against_scan(simulate(best))} |", flush=True)


def picture() -> None:
    """Both models' shapes of the three designs at full actuation, from one side."""
    sys.path.insert(0, str(ROOT / "docs"))
    from make_pictures import shrink

    from sheetmorph.show import scene, stills, style
    from sheetmorph.show.render import RenderWorker

    size, head = (360, 300), 60
    path = ROOT / "docs" / "pictures" / "models.png"
    with RenderWorker.start() as painter, style.style():
        sheet = style.Sheet(len(ACTUATIONS) * size[0] + 120, head + 2 * (size[1] + 10))
        for column, (name, levels) in enumerate(ACTUATIONS.items()):
            x = 120 + column * size[0]
            sheet.text(x + size[0] / 2, sheet.height - 30, f"{name}, {style.signed(levels[-1])}",
                       fontsize=17, fontweight="bold", ha="center")  # fmt: skip
            still = solved(name, "published", levels[-1]).positions[-1]
            for row, model in enumerate(MODELS):
                result = solved(name, model, levels[-1])
                points = result.positions[-1]
                if row:
                    points = upright(points, still)
                camera = scene.perspective().fitted(points, size, 0.04)
                colours = stills.white(len(points))
                view = scene.View(points, colours, stills.SHAPE_COLOURS, camera, size)
                (image,) = painter.draw(stills.base_job(result, (view,)))
                y = (1 - row) * (size[1] + 10)
                sheet.image(image, x, y)
                if column == 0:
                    sheet.text(14, y + size[1] / 2, model, fontsize=15, ha="left")
        sheet.save(path)
    shrink(path)


def upright(points: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The points turned half about the x axis where the other shape bends the other way."""

    def rise(shape: np.ndarray) -> float:
        rim = np.linalg.norm(shape[:, :2] - shape[:, :2].mean(axis=0), axis=1)
        return float(shape[rim.argmin(), 2] - shape[rim.argmax(), 2])

    return points * [1.0, -1.0, -1.0] if rise(points) * rise(other) < 0 else points


PARTS: dict[str, Callable[[], None]] = {
    "designs": designs,
    "scan": scan,
    "mesh": mesh,
    "numbering": numbering,
    "fit": fit,
    "picture": picture,
}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        print(f"\n## {part}\n", flush=True)
        PARTS[part]()
