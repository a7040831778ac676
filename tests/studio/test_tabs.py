"""A tab: what it asks for is computed, what is stale is not, what is wrong is said."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import pytest
from driving import Running, Tab, open_tab, start_studio, stop_studio
from small import SMALL

import sheetmorph as sm
from sheetmorph.design.presets import preset_text


def test_a_tab_shows_the_design_of_the_file(studio: Running) -> None:
    tab = open_tab(studio)
    hello = tab.wait("hello")
    assert (hello["file"], hello["presets"][0]) == ("small.toml", "bowl")
    design = tab.wait("design")
    assert design["text"] == SMALL
    scene = tab.solved()
    result = sm.simulate(sm.Design.from_toml(SMALL))
    assert scene["numbers"]["aspect_ratio"] == pytest.approx(result.summary["aspect_ratio"])
    np.testing.assert_allclose(tab.shape, 1e3 * result.positions[-1], atol=1e-4)
    tab.socket.close()


def test_a_change_makes_another_shape_and_is_undone(tab: Tab) -> None:
    tab.order("edit", values={"pattern.0.half_width": "4 mm"})
    design = tab.wait("design")
    assert 'half_width = "4 mm"' in design["text"]
    assert tab.wait("history")["undo"] is True
    wide = tab.solved()["numbers"]["aspect_ratio"]
    tab.order("undo")
    assert 'half_width = "3 mm"' in tab.wait("design")["text"]
    narrow = tab.solved()["numbers"]["aspect_ratio"]
    assert abs(wide - narrow) > 0.01
    tab.order("redo")
    assert tab.solved()["numbers"]["aspect_ratio"] == pytest.approx(wide)
    again = sm.simulate(sm.Design.from_toml(design["text"])).summary["aspect_ratio"]
    assert again == pytest.approx(wide)


def test_dragging_gives_previews_and_leaves_no_trace_until_it_ends(tab: Tab) -> None:
    for width in (3.2, 3.4, 3.6):
        tab.order("edit", values={"pattern.0.half_width": f"{width} mm"}, drag=True)
    while tab.wait("settled")["drag"] is not True:
        pass
    assert all(head["preview"] for head in tab.seen if head["kind"] == "scene")
    assert not any(head.get("undo") for head in tab.seen if head["kind"] == "history")
    tab.order("edit", values={"pattern.0.half_width": "3.6 mm"})
    assert tab.solved()["preview"] is False
    assert tab.seen[-1]["kind"] == "settled"


def test_edits_that_come_at_once_are_all_made(tab: Tab) -> None:
    for key, value in (("half_width", "3.3 mm"), ("arm_length", "15 mm"), ("arms", 4)):
        tab.order("edit", values={f"pattern.0.{key}": value})
    tab.solved()
    (star,) = sm.Design.from_toml(last_text(tab)).pattern
    assert (star.half_width, star.arm_length, star.arms) == (3.3e-3, 15e-3, 4)


def last_text(tab: Tab) -> str:
    return str([head for head in tab.seen if head["kind"] == "design"][-1]["text"])


def test_stale_solves_are_cancelled(tab: Tab) -> None:
    tab.order("edit", values={"mesh.size": "0.5 mm"})  # about 6000 nodes: many seconds
    tab.wait("progress")
    began = time.monotonic()
    tab.order("undo")
    scene = tab.solved()
    assert scene["numbers"]["nodes"] < 1000
    assert time.monotonic() - began < 8.0


WRONG = (
    ("pattern.0.half_width", "-1 mm", "out of range"),
    ("pattern.0.half_width", "3 potatoes", "potatoes"),
    ("pattern.0.widht", "3 mm", "did you mean half_width"),
    ("no.such.key", 1, "no"),
    ("mesh.size", "50 mm", "too coarse"),
    ("__proto__", 1, "key"),
)


def test_what_is_wrong_is_said_in_words(tab: Tab) -> None:
    for key, value, said in WRONG:
        tab.order("edit", values={key: value})
        problem = tab.wait("problem")
        assert said in problem["text"]
        assert "Traceback" not in problem["text"]
    tab.order("edit", values={"actuation.eps_pre": -0.35})
    assert tab.solved()["numbers"]["status"] == "completed"


NO_ORDERS = (
    *("", "{", "[]", "1", '{"do": "exec"}', '{"do": "edit"}', '{"do": "edit", "values": []}'),
    *('{"do": "open", "text": 7}', '{"do": "preset", "name": "../../etc"}', "[" * 5000),
    *('{"do": "export", "what": "run"}', '{"do": "use", "roles": 3}', '{"do": ["edit"]}'),
    *('{"do": "add", "shape": []}', '{"do": "compare"}', '{"do": "look", "unit": 7}'),
)


def test_orders_that_are_none_are_refused_and_do_no_harm(tab: Tab) -> None:
    for message in NO_ORDERS:
        tab.socket.send(message)
        assert tab.wait("problem")["text"], message
    tab.order("undo")
    assert tab.solved()["numbers"]["status"] == "completed"


def test_a_text_that_is_no_design_is_refused_with_its_line(tab: Tab) -> None:
    tab.order("open", text="name = 'x'\nthis is no toml")
    assert "line 2" in tab.wait("problem")["text"]
    tab.order("open", text=SMALL.replace("arms = 3", "arms = 5"))
    assert "arms = 5" in tab.wait("design")["text"]
    assert tab.wait("history")["undo"] is True


def test_presets_open_and_shapes_are_added(tab: Tab) -> None:
    tab.order("preset", name="blank")
    assert tab.wait("design")["text"] == preset_text("blank")
    shape = {"kind": "disc", "radius": "12 mm", "clip": True}
    tab.order("add", shape=shape)
    design = sm.Design.from_toml(tab.wait("design")["text"])
    assert [piece.kind for piece in design.pattern] == ["star", "disc"]
    tab.order("edit", values={"pattern.0": None})
    design = sm.Design.from_toml(tab.wait("design")["text"])
    assert [piece.kind for piece in design.pattern] == ["disc"]


def test_two_tabs_do_not_mix(studio: Running, tab: Tab) -> None:
    other = open_tab(studio)
    other.wait("hello")
    other.solved()
    tab.order("edit", values={"actuation.eps_pre": -0.3})
    other.order("edit", values={"actuation.eps_pre": -0.2})
    assert "eps_pre = -0.3" in tab.wait("design")["text"]
    assert "eps_pre = -0.2" in other.wait("design")["text"]
    shapes = [one.solved()["numbers"]["aspect_ratio"] for one in (tab, other)]
    assert abs(shapes[0] - shapes[1]) > 0.01
    other.socket.close()


def test_a_lost_connection_is_taken_up_again(studio: Running, tab: Tab) -> None:
    tab.order("edit", values={"actuation.eps_pre": -0.3})
    ratio = tab.solved()["numbers"]["aspect_ratio"]
    tab.socket.close()
    again = open_tab(studio, tab.name)
    assert again.wait("hello")["fresh"] is False
    assert "eps_pre = -0.3" in again.wait("design")["text"]
    assert again.wait("scene")["numbers"]["aspect_ratio"] == pytest.approx(ratio)
    assert again.wait("history")["undo"] is True
    again.socket.close()


def test_a_copied_tab_takes_the_name(studio: Running, tab: Tab) -> None:
    copy = open_tab(studio, tab.name)
    copy.wait("hello")
    with pytest.raises(Exception, match="4001"):
        while True:
            tab.socket.recv(5)
    copy.order("edit", values={"actuation.eps_pre": -0.3})
    assert copy.solved()["numbers"]["status"] == "completed"
    copy.socket.close()


def test_leaving_in_the_middle_of_a_solve_frees_the_worker(studio: Running, tab: Tab) -> None:
    tab.order("edit", values={"mesh.size": "0.5 mm"})
    tab.wait("progress")
    tab.socket.socket.close()  # no farewell: as when the cable is pulled
    began = time.monotonic()
    other = open_tab(studio)
    other.wait("hello")
    assert other.solved()["numbers"]["status"] == "completed"
    assert time.monotonic() - began < 10.0
    other.socket.close()


@pytest.mark.skipif(os.name != "posix", reason="ends a process by its number")
def test_a_worker_that_dies_is_replaced(studio: Running, tab: Tab) -> None:
    tab.order("edit", values={"mesh.size": "0.5 mm"})
    tab.wait("progress")
    (worker,) = studio.children("--warm")
    os.kill(worker, signal.SIGKILL)
    assert "before its time" in tab.wait("problem")["text"]
    tab.order("undo")
    assert tab.solved()["numbers"]["status"] == "completed"
    assert studio.children("--warm") != [worker]


@pytest.mark.skipif(os.name != "posix", reason="ends processes by their group")
def test_a_browser_that_is_killed_while_it_solves_leaves_the_studio_healthy(
    tmp_path: Path, chromium_command: list[str]
) -> None:
    studio = start_studio(tmp_path, text=SMALL.replace('size = "3 mm"', 'size = "0.5 mm"'))
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    browser = subprocess.Popen([*chromium_command, studio.address], start_new_session=True, **quiet)
    try:
        server = psutil.Process(studio.process.pid)
        eventually(lambda: any(one.status == "ESTABLISHED" for one in server.net_connections()))
        eventually(lambda: studio.children("--warm"))
        (worker,) = studio.children("--warm")
        used = psutil.Process(worker).cpu_times().user
        eventually(lambda: psutil.Process(worker).cpu_times().user > used + 1.0)  # it solves
    finally:
        os.killpg(browser.pid, signal.SIGKILL)
        browser.wait()
    other = open_tab(studio)
    other.wait("hello")
    other.order("edit", values={"mesh.size": "3 mm"})
    while other.solved()["numbers"]["nodes"] > 1000:
        pass
    other.socket.close()
    assert stop_studio(studio)[0] in (0, 130)


def eventually(holds: Callable[[], object], seconds: float = 60.0) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_the_file_is_saved_and_changes_by_others_are_seen(studio: Running, tab: Tab) -> None:
    before = studio.file.read_text("utf-8")
    tab.order("edit", values={"actuation.eps_pre": -0.31})
    tab.solved()
    tab.order("save")
    assert tab.wait("saved")["file"] == "small.toml"
    assert studio.file.read_text("utf-8") == last_text(tab)
    studio.file.write_text(SMALL + "# mine\n", encoding="utf-8")
    tab.order("edit", values={"actuation.eps_pre": -0.32})
    tab.solved()
    tab.order("save")
    assert tab.wait("conflict")["file"] == "small.toml"
    assert studio.file.read_text("utf-8").endswith("# mine\n")
    tab.order("save", force=True)
    tab.wait("saved")
    assert studio.file.read_text("utf-8") == last_text(tab)
    studio.file.write_text(before, encoding="utf-8")


def test_other_shapes_of_the_sheet_are_found(tab: Tab) -> None:
    tab.order("preset", name="petals")
    tab.wait("design")
    nodes = tab.solved()["numbers"]["nodes"]
    tab.order("shapes")
    shapes = tab.wait("shapes", 90)["shapes"]
    assert [shape["stable"] for shape in shapes] == [True, True]
    heights = tab.arrays["shapes"][:, :, 2]
    assert heights.shape == (2, nodes)
    assert heights[0].max() > 40.0 > -40.0 > heights[1].min()  # one up, one down
    assert shapes[0]["energy_mJ"] < shapes[1]["energy_mJ"]
