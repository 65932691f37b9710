"""Measure pictures with other people's implementations, and write what they say to ledger.txt.

    pip install flip-evaluator scikit-image
    python tests/metrics/check.py target/release/fragloom

The suite does not run this: tests read the ledger (tests/metrics.rs, src/image/ledger.rs).
Run it again after a change of the cases below, and of nothing else. It fails if fragloom does not agree.
"""

import csv
import importlib.metadata
import pathlib
import subprocess
import sys
import tempfile

import flip_evaluator
import numpy
import skimage
from skimage import io, metrics

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# A reference and a picture: arguments of `fragloom render`, or `pattern` with width, height and seed.
CASES = [
    ("k-3", "scenes/glass.toml --size 240x150 -m exact", "scenes/glass.toml --size 240x150 -k 3"),
    ("k-8", "scenes/glass.toml --size 240x150 -m exact", "scenes/glass.toml --size 240x150 -k 8"),
    (
        "race",
        "scenes/glass.toml --size 240x150 -m exact",
        "scenes/glass.toml --size 240x150 -m kb --exec sim --seed 1",
    ),
    ("opacity", "cubes --size 101x67 -m exact --alpha 0.2", "cubes --size 101x67 -m exact --alpha 0.9"),
    ("equal", "stack --size 64x200 -m exact", "stack --size 64x200 -k 64"),
    ("shading", "greenhouse --size 64x200 -m exact --shading flat", "greenhouse --size 64x200 -m exact"),
    ("subtle", "cubes --size 96x96 -m exact --alpha 0.50", "cubes --size 96x96 -m exact --alpha 0.51"),
    ("other", "cubes --size 96x96 -m exact", "greenhouse --size 96x96 -m exact"),
    ("small", "cubes --size 11x12 -m exact", "cubes --size 11x12 -k 1"),
    ("patterns", "pattern 97 83 1", "pattern 97 83 2"),
    ("patterns-wide", "pattern 211 17 3", "pattern 211 17 5"),
]

# How far fragloom may be from the others. flip-evaluator computes in single precision, the others in double.
BOUNDS = {"psnr": 1e-9, "psnr_linear": 1e-9, "ssim": 1e-9, "flip": 2e-6}


def pattern(width, height, seed):
    """A made-up picture: a slope, blocks, and something like noise."""
    y, x = numpy.mgrid[0:height, 0:width]
    red = 5 * x + 40 * seed
    green = (x // (3 + seed) + y // 4) % 2 * (170 + seed)
    blue = x * x + 3 * y * y + 7 * seed * x
    return numpy.stack([red, green, blue], axis=-1).astype(numpy.uint64).astype(numpy.uint8)


def draw(fragloom, arguments, path):
    words = arguments.split()
    if words[0] == "pattern":
        io.imsave(path, pattern(*map(int, words[1:])), check_contrast=False)
    else:
        # Exit code 1 is a fault that the method has, and that we want to see.
        command = [fragloom, "render", *words, "-o", path]
        code = subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        assert code.returncode in (0, 1), command
    return io.imread(path)[..., :3]


def linear(picture):
    c = picture / 255.0
    return numpy.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def luma(picture):
    return picture.astype(float) @ numpy.array([0.299, 0.587, 0.114])


@numpy.errstate(divide="ignore")
def theirs(reference, picture):
    _, flip, _ = flip_evaluator.evaluate(
        (reference / 255.0).astype(numpy.float32), (picture / 255.0).astype(numpy.float32), "LDR"
    )
    return {
        "psnr": metrics.peak_signal_noise_ratio(reference, picture, data_range=255),
        "psnr_linear": metrics.peak_signal_noise_ratio(linear(reference), linear(picture), data_range=1),
        "ssim": metrics.structural_similarity(
            luma(reference),
            luma(picture),
            data_range=255,
            gaussian_weights=True,
            sigma=1.5,
            use_sample_covariance=False,
        ),
        "flip": flip,
    }


def ours(fragloom, reference, arguments):
    if arguments.startswith("pattern"):
        return None
    command = [fragloom, "render", *arguments.split(), "--reference", reference, "--metrics", "csv"]
    text = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout
    return next(csv.DictReader(text.splitlines()))


def main():
    fragloom = str(pathlib.Path(sys.argv[1]).resolve())
    flip_version = importlib.metadata.version("flip-evaluator")
    versions = f"scikit-image {skimage.__version__} and flip-evaluator {flip_version}"
    lines = [
        f"# What {versions} say of pictures (tests/metrics/check.py writes this).",
        "# name psnr psnr_linear ssim flip | reference | picture",
        "",
    ]
    worst = dict.fromkeys(BOUNDS, 0.0)
    with tempfile.TemporaryDirectory() as folder:
        for name, reference, picture in CASES:
            paths = [f"{folder}/{side}.png" for side in ("reference", "picture")]
            pictures = [draw(fragloom, text, path) for text, path in zip((reference, picture), paths)]
            found = theirs(*pictures)
            own = ours(fragloom, paths[0], picture)
            print(f"{name:14}", end="")
            for measure, value in found.items():
                print(f"{measure:>13} {value:.9f}", end="")
                if own:
                    # fragloom says nothing where pictures are equal, the others infinity.
                    mine = float(own[measure] or "inf")
                    apart = 0.0 if mine == value else abs(mine - value)
                    worst[measure] = max(worst[measure], apart)
                    print(f" ({apart:.0e} apart)", end="")
            print()
            numbers = " ".join(f"{value:.12f}" for value in found.values())
            lines.append(f"{name} {numbers} | {reference} | {picture}")
    print("at most apart:", ", ".join(f"{measure} {apart:.1e}" for measure, apart in worst.items()))
    (HERE / "ledger.txt").write_text("\n".join(lines) + "\n")
    assert all(worst[measure] <= bound for measure, bound in BOUNDS.items())


main()
