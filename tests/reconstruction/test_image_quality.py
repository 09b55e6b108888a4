"""PSNR and SSIM by hand, and the SSIM that training uses."""

import numpy as np
import pytest

from remosplat_drake.reconstruction.report.image_quality import (
    psnr,
    structural_similarity,
)


@pytest.fixture
def images():
    rng = np.random.default_rng(0)
    target = rng.uniform(0, 1, (30, 40, 3))
    return np.clip(target + rng.normal(0, 0.1, target.shape), 0, 1), target


def test_psnr_by_hand():
    """An error of 0.1 everywhere is 20 dB."""
    black = np.zeros((4, 5, 3))
    assert psnr(black + 0.1, black) == pytest.approx(20)
    assert psnr(black, black) == np.inf


def test_ssim_equals_the_one_of_training(images):
    torch = pytest.importorskip("torch")
    from pytorch_msssim import ssim

    batches = (torch.tensor(x).permute(2, 0, 1)[None] for x in images)
    expected = ssim(*batches, data_range=1.0)
    assert structural_similarity(*images) == pytest.approx(
        expected.item(), abs=1e-6
    )


def test_ssim_of_even_images_by_hand():
    """Without texture, only the luminance's factor is left."""
    dark, light = np.full((11, 12, 3), 0.2), np.full((11, 12, 3), 0.6)
    expected = (2 * 0.2 * 0.6 + 1e-4) / (0.2**2 + 0.6**2 + 1e-4)
    assert structural_similarity(dark, light) == pytest.approx(expected)
    assert np.isnan(structural_similarity(dark[1:], light[1:]))


def test_equal_images_have_ssim_one(images):
    assert structural_similarity(images[1], images[1]) == pytest.approx(1)


def test_hidden_pixels_change_nothing(images):
    image, target = images
    hidden = np.zeros(image.shape[:2], bool)
    hidden[10:14, 20:25] = True
    other = np.where(hidden[..., None], 1.0, image)
    for measure in (psnr, structural_similarity):
        value = measure(other, target, hidden)
        assert value == measure(image, target, hidden)
        assert value != measure(other, target)
        assert value == pytest.approx(measure(image, target), rel=0.05)
        assert np.isnan(measure(image, target, np.ones_like(hidden)))
