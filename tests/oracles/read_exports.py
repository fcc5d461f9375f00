#!/usr/bin/env python3
"""Reads the exports of a fit with programs that are not ours, and compares them with the fit.

usage: read_exports.py OUT        after: maquette fit … --out OUT; maquette gait OUT; maquette export OUT
needs: pip install -r tests/oracles/requirements.txt
Exit code 0 if everything is the same to the formats' precision; otherwise 1 with a line for each difference.
"""
import csv, json, sys
import numpy as np

WRONG = []

def check(what, difference, most):
    print(f'{what:42} {difference:.3g} (at most {most:g})')
    if not difference <= most: WRONG.append(what)

def fitted(out):
    result = json.load(open(f'{out}/result.json'))
    frames = [f for f in result['motion']['frames'] if f['views'] > 0]
    points = np.array([f['points_m'] for f in frames])[:, :, [1, 2, 0]]     # Y up
    sd = np.array([f['sd']['points_m'] for f in frames]) if frames[0]['sd'] else np.zeros_like(points)
    return result['motion']['points'], points, 1e3 * np.sqrt((sd ** 2).mean(2))

def read_c3d(path, out, names, points, sd_mm, angles):
    import c3d, ezc3d
    file = ezc3d.c3d(path)
    labels, data = file['parameters']['POINT']['LABELS']['value'], file['data']['points']
    check('ezc3d: points, m', np.abs(data[:3, :len(names)].transpose(2, 1, 0) / 1e3 - points).max(), 1e-6)
    check('ezc3d: labels', sum(a != b for a, b in zip(labels, names)), 0)
    check('ezc3d: knee angle, deg', np.abs(data[0, labels.index('LKneeAngles')] - angles['knee_flexion_l_deg']).max(), 1e-3)
    event, gait = file['parameters']['EVENT'], json.load(open(f'{out}/gait/gait.json'))['events']
    times = np.array(event['TIMES']['value']).reshape(2, -1)
    check('ezc3d: events, s', max(abs(60 * t[0] + t[1] - e['time_s']) for t, e in zip(times.T, gait)), 1e-5)
    words = {'strike': 'Foot Strike', 'off': 'Foot Off'}
    check('ezc3d: event labels', sum(words[e['kind']] != l for e, l in zip(gait, event['LABELS']['value'])), 0)
    # ezc3d takes the two bytes of the fourth word the other way round than c3d.org; the reader `c3d` takes them so
    rows = np.array([p for _, p, _ in c3d.Reader(open(path, 'rb')).read_frames()])
    check('c3d: residual against SD, mm', np.abs(rows[:, :len(names), 3] - sd_mm).max(), 0.051)

def read_bvh(path, names, points):
    from bvh import Bvh
    file = Bvh(open(path).read())
    turn = {'X': lambda c, s: [[1, 0, 0], [0, c, -s], [0, s, c]], 'Y': lambda c, s: [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            'Z': lambda c, s: [[c, -s, 0], [s, c, 0], [0, 0, 1]]}
    def place(frame, name):
        chain = [name]
        while file.joint_parent(chain[-1]) is not None: chain.append(file.joint_parent(chain[-1]).name)
        R, t = np.eye(3), np.array([file.frame_joint_channel(frame, chain[-1], a + 'position') for a in 'XYZ'])
        for bone in reversed(chain):
            if bone != chain[-1]: t = t + R @ np.array(file.joint_offset(bone))
            for axis in 'ZXY':
                a = np.radians(file.frame_joint_channel(frame, bone, axis + 'rotation'))
                R = R @ np.array(turn[axis](np.cos(a), np.sin(a)))
        return t / 100
    for bone, point in (('LeftForeArm', 'LElbow'), ('RightHand', 'RWrist'), ('LeftFoot', 'LAnkle'), ('Neck', 'Neck')):
        far = max(np.abs(place(f, bone) - points[f, names.index(point)]).max() for f in range(0, file.nframes, 7))
        check(f'bvh: {point}, m', far, 1e-5)

def read_opensim(stem, names, points, angles):
    import opensim
    for end, unit in (('.mot', 1.0), ('.sto', 180 / np.pi)):
        table = opensim.TimeSeriesTable(stem + end)
        for ours, theirs in (('knee_flexion_l', 'knee_angle_l'), ('hip_adduction_l', 'hip_adduction_l'), ('ankle_dorsiflexion_r', 'ankle_angle_r')):
            column = table.getDependentColumn(theirs)
            values = unit * np.array([column[i] for i in range(table.getNumRows())])
            check(f'opensim {end}: {theirs}, deg', np.abs(values - angles[ours + '_deg']).max(), 1e-4)
    table = opensim.TimeSeriesTableVec3(stem + '.trc')
    column = table.getDependentColumn('RKnee')
    values = np.array([[column[i][k] for k in range(3)] for i in range(table.getNumRows())])
    check('opensim .trc: RKnee, m', np.abs(values - points[:, names.index('RKnee')]).max(), 1e-6)

def main():
    if len(sys.argv) != 2: print(__doc__); return 2
    out = sys.argv[1]
    names, points, sd_mm = fitted(out)
    rows = list(csv.DictReader(open(f'{out}/export/motion.csv')))
    angles = {k: np.array([float(r[k]) for r in rows]) for k in rows[0]}
    read_c3d(f'{out}/export/motion.c3d', out, names, points, sd_mm, angles)
    read_bvh(f'{out}/export/motion.bvh', names, points)
    read_opensim(f'{out}/export/motion', names, points, angles)
    print('different: ' + ', '.join(WRONG) if WRONG else 'all the same')
    return 1 if WRONG else 0

if __name__ == '__main__': sys.exit(main())
