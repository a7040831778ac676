"""Files to take away: the same as the commands write, under names of their own."""

from __future__ import annotations

import io
import zipfile

from driving import Running, Tab


def test_the_files_to_make_a_sheet(studio: Running, tab: Tab) -> None:
    tab.order("edit", values={"name": "my sheet/../x"})
    assert "not" in tab.wait("problem")["text"]
    tab.order("edit", values={"name": "my sheet 1"})
    tab.solved()
    tab.order("export", what=["parts"], kerf_mm=0.15, printer="prusa-mk4")
    told = tab.wait("exported", 120)
    assert "places" not in told  # where files lie on this machine is not for the page
    names = [file["name"] for file in told["files"]]
    assert told["zip"] == "my-sheet-1.zip"
    assert {"my-sheet-1.toml", "parts/cut/sheet.dxf", "parts/template-a4.pdf"} <= set(names)
    assert {"parts/assembly.html", "parts/parts/print.3mf"} <= set(names)
    for file in told["files"]:
        status, data, headers = studio.request(f"/out/{tab.name}/{told['name']}/{file['name']}")
        assert (status, len(data)) == (200, file["bytes"])
        assert headers["content-disposition"].startswith("attachment")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.testzip() is None
        assert set(archive.namelist()) == {f"my-sheet-1/{name}" for name in names[:-1]}
    tab.order("export", what=[])
    assert "choose" in tab.wait("problem")["text"]
    tab.order("export", what=["parts"], printer="none-such")
    assert "printer" in tab.wait("problem")["text"]


def test_one_errand_at_a_time_and_it_can_be_stopped(tab: Tab) -> None:
    tab.order("export", what=["run"])
    tab.wait("busy")
    tab.order("shapes")
    assert "wait" in tab.wait("problem")["text"]
    tab.order("stop")
    tab.wait("idle", 60)
    assert not [head for head in tab.seen if head["kind"] == "exported"]
    tab.order("edit", values={"actuation.eps_pre": -0.3})
    assert tab.solved()["numbers"]["status"] == "completed"
