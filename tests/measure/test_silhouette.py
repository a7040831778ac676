"""The mask: drawn shapes of known size on backgrounds that are not even."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.measure.side_view import extents
from sheetmorph.measure.silhouette import MaskOptions, find_silhouette, find_threshold


def picture(
    sheet=(200, 190, 180), back=60.0, slope=30.0, noise=8.0, blur=2.0, box=(80, 90, 280, 170)
):
    rng = np.random.default_rng(2)
    x, y = np.meshgrid(np.linspace(-1, 1, 360), np.linspace(-1, 1, 260))
    image = np.repeat((back + slope * (x - 0.6 * y**2))[..., None], 3, axis=2)
    if sheet is not None:
        image[box[1] : box[3], box[0] : box[2]] = sheet
    image = cv2.GaussianBlur(image, (0, 0), blur)
    return np.clip(image + noise * rng.standard_normal(image.shape), 0, 255).astype(np.uint8)


def found(image, **options):
    mask = MaskOptions(**options)
    return find_silhouette(image, find_threshold([image], mask), mask)


@pytest.mark.parametrize("blur", [0.5, 2.0, 3.0])
@pytest.mark.parametrize(
    ("sheet", "back", "background"),
    [
        *(((200, 190, 180), 60, "auto"), ((200, 190, 180), 60, "dark")),
        *(((40, 60, 90), 190, "auto"), ((40, 60, 90), 190, "light")),
        ((150, 100, 40), 100, "auto"),  # as bright as the background, of another colour
    ],
)
def test_the_size_does_not_depend_on_blur_and_light(sheet, back, background, blur):
    silhouette = found(picture(sheet, back, blur=blur), background=background)
    assert silhouette.flags == ()
    width, height = extents(silhouette.outline, 0.0)
    near = 2.5 if back != 100 else 4.0  # a contrast of 45 grey levels
    assert (width, height) == (pytest.approx(200, abs=near), pytest.approx(80, abs=near))
    assert silhouette.area == pytest.approx(200 * 80, rel=0.03)


def test_nothing_is_found_where_nothing_is():
    silhouette = found(picture(None))
    assert silhouette.flags == ("nothing found",)
    assert not silhouette.found


def test_the_wrong_background_finds_nothing():
    assert not found(picture(), background="light").found


def test_what_fills_the_region_is_flagged():
    full = find_silhouette(
        picture(), 1e-3, MaskOptions(region=(100, 100, 260, 160), threshold=1e-3)
    )
    assert full.flags == ("the sheet fills the region",)
    cut = found(picture(box=(200, 90, 360, 170)))
    assert cut.flags == ("touches the edge of the region",)


def test_the_region_leaves_out_the_rest():
    image = picture()
    image[180:250, 20:340] = 255  # a tray
    silhouette = found(image, region=(20, 40, 340, 178))
    assert silhouette.outline.min(axis=0) == pytest.approx([80, 90], abs=2)
    assert extents(silhouette.outline, 0.0)[1] == pytest.approx(80, abs=2.5)
    for region in ((0, 0, 361, 100), (50, 50, 52, 90), (-1, 0, 100, 100)):
        with pytest.raises(InputError, match="--region"):
            found(image, region=region)


def test_hairs_and_specks_are_left_out():
    image = picture(noise=0.0, blur=0.5)
    image[60:90, 180] = 255  # a thread that hangs from above
    image[20:30, 20:30] = 255
    silhouette = found(image)
    assert extents(silhouette.outline, 0.0) == pytest.approx((200, 80), abs=3)


def test_a_sheet_seen_from_its_edge():
    silhouette = found(picture(box=(80, 120, 280, 123), noise=4.0, blur=1.0))
    width, height = extents(silhouette.outline, 0.0)
    assert width == pytest.approx(200, abs=4) and height < 7


def test_a_given_threshold_is_used_as_it_is():
    low = found(picture(), threshold=20.0)
    high = found(picture(), threshold=110.0)
    assert low.area > high.area > 0
