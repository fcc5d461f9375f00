"""OpenCV's MOG2 on the pictures of background.rs: pictures a second on two threads and on one.

pip install opencv-python-headless numpy
"""
import time

import cv2
import numpy as np


def pictures(count=24, width=1280, height=720):
    y, x = np.mgrid[:height, :width]
    empty = np.stack([x // 8 + 30, y // 5 + 40, (x + y) // 12 + 20], -1)
    random = np.random.default_rng(1)
    for t in range(count):
        picture = empty.copy()
        picture[150:600, 200 + 10 * t:400 + 10 * t] = (200, 120, 90)
        picture += random.integers(-4, 5, (height, width, 1))
        yield np.clip(picture, 0, 255).astype(np.uint8)


def main():
    frames = list(pictures())
    for threads in (1, 2):
        cv2.setNumThreads(threads)
        for shadows in (False, True):
            model = cv2.createBackgroundSubtractorMOG2(detectShadows=shadows)
            best = float("inf")
            for _ in range(10):
                start = time.perf_counter()
                for frame in frames:
                    model.apply(frame, learningRate=0.01)
                best = min(best, time.perf_counter() - start)
            print(f"{threads} threads, shadows {shadows}: {len(frames) / best:.0f} frames/s")


main()
