"""Reference values for src/camera/distortion, by OpenCV. Run: python3 tests/oracles/opencv_distortion.py

Prints, for each lens model, the distorted normalised coordinates that OpenCV gives to a few points.
"""
import cv2
import numpy as np

POINTS = [(0.0, 0.0), (0.3, -0.2), (-0.55, 0.41), (0.1, 0.62)]
LENSES = {
    "brown_conrady_4": [-0.046183, 0.139983, 0.000608, 0.00069],
    "brown_conrady_5": [-0.36491489942628114, 0.18121989654726270, -6.7018293283073623e-05,
                        4.9368324991786452e-05, -0.049336011871207668],
    "brown_conrady_8": [0.31, -0.12, 0.0011, -0.0007, 0.02, 0.65, -0.05, 0.013],
    "fisheye": [-0.013, 0.021, -0.017, 0.004],
}


def distort(name, coefficients):
    points = np.array([(x, y, 1.0) for x, y in POINTS]).reshape(-1, 1, 3)
    if name == "fisheye":
        image, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(coefficients))
    else:
        image, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(coefficients))
    return image.reshape(-1, 2)


print("OpenCV", cv2.__version__)
for name, coefficients in LENSES.items():
    print(name)
    for (x, y), (u, v) in zip(POINTS, distort(name, coefficients)):
        print(f"    ({x!r}, {y!r}) -> ({float(u)!r}, {float(v)!r})")
