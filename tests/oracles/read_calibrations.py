#!/usr/bin/env python3
"""Reads refined calibrations with programs that are not ours, compares them with the fit, and plants a fault in each.

usage: read_calibrations.py CALIBRATION.toml FIT FOLDER
after: maquette fit … --out FIT; maquette calibrate FIT --out FOLDER/rig.toml, and intri.yml, rig.yml, rig.xml, rig.qca.txt, {camera}.xml
needs: pip install -r tests/oracles/requirements.txt (opencv-python-headless: FileStorage), tomllib and xml.etree of Python
What is expected is computed here from the calibration and result.json: a camera with the centre o, turned by R about it and displaced by t,
has the centre o + t and the rotation R_cam Rᵀ; its focal length is z times the calibrated one, and its lens D bends x as it bent z x before: D(z x) / z.
Exit code 0 if everything is the same and every planted fault is noticed; otherwise 1.
"""
import json, sys, tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import cv2
import numpy as np


def rodrigues(vector):
    return cv2.Rodrigues(np.asarray(vector, float).reshape(3))[0]


def cameras_of_toml(path):
    """Name → K, lens, R, centre; as Pose2Sim reads it: every table but the metadata is a camera."""
    tables = tomllib.loads(Path(path).read_text())
    found = {}
    for key, table in tables.items():
        if key in ('metadata', 'capture_volume', 'charuco', 'checkerboard'):
            continue
        rotation = rodrigues(table['rotation'])
        found[table['name']] = np.array(table['matrix']), np.array(table['distortions']), rotation, -rotation.T @ table['translation']
    return found


def zoomed(k, lens, zoom):
    """K and the coefficients k1, k2, p1, p2, k3 … k6 with a focal length that is so many times as long."""
    powers = np.array([2, 4, 1, 1, 6, 2, 4, 6])[: len(lens)]
    return k * [[zoom, zoom, 1], [1, zoom, 1], [1, 1, 1]], lens * zoom**powers


def expected(calibration, fit):
    result = json.loads((Path(fit) / 'result.json').read_text())
    offsets = {c['camera']: c['found'].get('pose') for c in result['quality']['cameras']}
    rig = {}
    for name, (k, lens, rotation, centre) in cameras_of_toml(calibration).items():
        if offsets.get(name):
            turn = rodrigues(np.radians(offsets[name]['turn_deg']))
            rotation, centre = rotation @ turn.T, centre + offsets[name]['displacement_m']
            k, lens = zoomed(k, lens, offsets[name]['zoom'])
        rig[name] = k, lens, rotation, centre
    return rig


def cameras_of_storage(paths, names=None):
    inner, outer = (cv2.FileStorage(str(p), cv2.FILE_STORAGE_READ) for p in (paths[0], paths[-1]))
    node = outer.getNode('names')
    names = names or [node.at(i).string() for i in range(node.size())]
    found = {}
    for name in names:
        rotation = outer.getNode(f'Rot_{name}').mat()
        assert np.allclose(rodrigues(outer.getNode(f'R_{name}').mat()), rotation, atol=1e-12)
        found[name] = inner.getNode(f'K_{name}').mat(), inner.getNode(f'dist_{name}').mat().ravel(), rotation, (-rotation.T @ outer.getNode(f'T_{name}').mat()).ravel()
    return found


def cameras_of_each(pattern, names):
    found = {}
    for name in names:
        file = cv2.FileStorage(str(pattern).replace('{camera}', name), cv2.FILE_STORAGE_READ)
        rotation = file.getNode('rotation_matrix').mat()
        found[name] = file.getNode('camera_matrix').mat(), file.getNode('distortion_coefficients').mat().ravel(), rotation, (-rotation.T @ file.getNode('translation_vector').mat()).ravel()
    return found


def cameras_of_qualisys(path):
    """As Pose2Sim's read_qca has it, but for the distortion (see src/io/calibration/qualisys.rs)."""
    found = {}
    for camera in ET.parse(path).getroot().iter('camera'):
        field, intrinsic, transform = (camera.find(name).attrib for name in ('fov_video', 'intrinsic', 'transform'))
        number = lambda key: float(intrinsic[key]) / 64
        k = np.array([[number('focalLengthU'), number('skew'), number('centerPointU') - float(field['left'])], [0, number('focalLengthV'), number('centerPointV') - float(field['top'])], [0, 0, 1]])
        lens = np.array([float(intrinsic[key]) for key in ('radialDistortion1', 'radialDistortion2', 'tangentalDistortion1', 'tangentalDistortion2', 'radialDistortion3')])
        rotation = np.diag([1, -1, -1]) @ np.array([[float(transform[f'r{i}{j}']) for j in (1, 2, 3)] for i in (1, 2, 3)])
        found[camera.attrib['serial']] = k, lens, rotation, np.array([float(transform[axis]) for axis in 'xyz']) / 1e3
    return found


def differs(found, rig):
    """The largest difference; lenses of fewer coefficients have zeros behind."""
    worst = 1.0 if found.keys() != rig.keys() else 0.0
    for name in found.keys() & rig.keys():
        (k, lens, rotation, centre), (k0, lens0, rotation0, centre0) = found[name], rig[name]
        both = [np.pad(l, (0, 8 - len(l))) for l in (lens, lens0)]
        worst = max([worst] + [np.abs(np.subtract(a, b)).max() for a, b in ((k, k0), both, (rotation, rotation0), (centre, centre0))])
    return worst


def main(calibration, fit, folder):
    folder, rig = Path(folder), expected(calibration, fit)
    readers = {
        'rig.toml': lambda p: cameras_of_toml(p),
        'extri.yml': lambda p: cameras_of_storage([p.with_name('intri.yml'), p]),
        'rig.yml': lambda p: cameras_of_storage([p]),
        'rig.xml': lambda p: cameras_of_storage([p]),
        'rig.qca.txt': lambda p: cameras_of_qualisys(p),
        f'{sorted(rig)[0]}.xml': lambda p: cameras_of_each(folder / '{camera}.xml', rig),
    }
    moved = max(np.linalg.norm(rig[name][3] - c[3]) for name, c in cameras_of_toml(calibration).items())
    bad = moved <= 1e-9
    print(f'largest displacement: {1e3 * moved:.2f} mm')
    for name, read in readers.items():
        path = folder / name
        worst = differs(read(path), rig)

        # a digit of the last camera's first number behind its translation or place is another
        text = path.read_text()
        keys = ['translation = [ ', 'x="', 'data>\n    ', 'data: [ ']
        key = next(k for k in keys if k in text)
        at = text.rindex(key) + len(key)
        at += text[at] == '-'
        planted = text[:at] + ('8' if text[at] == '3' else '3') + text[at + 1:]
        path.write_text(planted)
        noticed = differs(read(path), rig) > 1e-6
        path.write_text(text)
        bad |= worst > 1e-9 or not noticed
        print(f'{name}: differs by {worst:.1e}, planted fault {"noticed" if noticed else "NOT NOTICED"}')
    sys.exit(bool(bad))


main(*sys.argv[1:])
