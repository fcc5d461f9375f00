"""scikit-image's active_contour on the picture of benches/snake.rs: run by it, or alone.

Needs scikit-image and numpy. Prints `name fastest_ms median_ms off_px points`.
"""

import time

import numpy as np
from skimage.filters import gaussian
from skimage.segmentation import active_contour

W, H, CX, CY, A, B, START, N = 320, 240, 160.0, 120.0, 95.0, 70.0, 6.0, 400
y, x = np.mgrid[0:H, 0:W].astype(float)
outside = (np.hypot((x - CX) / A, (y - CY) / B) - 1) * B
picture = 60 + 140 * np.clip(0.5 - outside, 0, 1) + 28 * np.sin(0.35 * x + 0.2 * y) * np.sin(0.3 * y - 0.1 * x)
at = lambda n, grown: np.stack([CY + (B + grown) * np.sin(t := np.linspace(0, 2 * np.pi, n, endpoint=False)), CX + (A + grown) * np.cos(t)], 1)
truth = at(50_000, 0.0)

times = []
for _ in range(5):
    start = time.perf_counter()
    found = active_contour(
        gaussian(picture / 255, 1.2), at(N, START), alpha=0.01, beta=0.1, w_line=0, w_edge=5, gamma=0.01,
        max_num_iter=2500, convergence=0.1, boundary_condition="periodic",
    )
    times.append(1e3 * (time.perf_counter() - start))
times.sort()
off = np.mean([np.sqrt(((truth - p) ** 2).sum(1).min()) for p in found])
print(f"scikit-image {times[0]:.1f} {times[len(times) // 2]:.1f} {off:.3f} {len(found)}")
