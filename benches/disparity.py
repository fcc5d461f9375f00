"""OpenCV's StereoBM and StereoSGBM on the cones pair: run by benches/disparity.rs, or alone.

Needs opencv-python-headless and numpy. Argument: the folder of the pair. Prints `name milliseconds off density`.
"""

import sys
import time

import cv2
import numpy as np

folder = sys.argv[1]
read = lambda name: cv2.imread(f"{folder}/{name}", cv2.IMREAD_UNCHANGED)
left, right, truth = read("Cones_LEFT.tif"), read("Cones_RIGHT.tif"), read("Cones_LEFT_GT.tif")
visible = (truth > 0) & (cv2.imread(f"{folder}/Occlusion_LEFT.png", cv2.IMREAD_GRAYSCALE) > 0)
cv2.setNumThreads(2)

matchers = {
    "StereoBM": cv2.StereoBM_create(64, 15),
    "StereoSGBM": cv2.StereoSGBM_create(0, 64, 5, 200, 800, 1, 63, 10, 100, 2),
}
for name, matcher in matchers.items():
    times = []
    for _ in range(100):
        start = time.perf_counter()
        found = matcher.compute(left, right)
        times.append(time.perf_counter() - start)
    found = found / 16.0
    matched = visible & (found > 0)
    off = np.abs(found - truth)[matched] > 2
    density = matched.sum() / visible.sum()
    times.sort()
    print(f"{name} {1e3 * times[0]:.2f} {1e3 * times[50]:.2f} {100 * off.mean():.2f} {density:.3f}")
