#!/usr/bin/env python3
"""Reads the exports of a fit with programs that are not ours, compares them with the fit, and plants a fault in each.

usage: read_exports.py OUT
after: maquette fit … --body human-metaballs --out OUT; maquette gait OUT; maquette export OUT; the same --format ply --format obj
needs: pip install -r tests/oracles/requirements.txt; Blender's part is read_in_blender.py, glTF's validator web/test/glb.mjs
Exit code 0 if everything is the same to the formats' precision and every planted fault is noticed; otherwise 1.
"""
import csv, sys
import numpy as np
from export_truth import most, run


def read_ezc3d(folder, truth):
    import ezc3d
    file = ezc3d.c3d(str(folder / 'motion.c3d'))
    point, count = file['parameters']['POINT'], len(truth.names)
    labels, data = point['LABELS']['value'], file['data']['points']
    yield 'rate, Hz', abs(point['RATE']['value'][0] - truth.rate_hz), 1e-6
    yield 'first frame', abs(file['header']['points']['first_frame'] - truth.first), 0
    yield 'labels', sum(a != b for a, b in zip(labels, truth.names)), 0
    yield 'points, m', most(data[:3, :count].transpose(2, 1, 0) / 1e3 - truth.points), 1e-6
    for place, (axis, name) in {'LKneeAngles': (0, 'knee_flexion_l'), 'RHipAngles': (1, 'hip_adduction_r')}.items():
        yield name + ', deg', most(data[axis, labels.index(place)] - truth.angles[name]), 1e-3
    event = file['parameters']['EVENT']
    times = np.array(event['TIMES']['value']).reshape(2, -1)
    words = {'strike': 'Foot Strike', 'off': 'Foot Off'}
    yield 'events, s', most([60 * t[0] + t[1] - e['time_s'] for t, e in zip(times.T, truth.events, strict=True)]), 1e-5
    yield 'labels of events', sum(words[e['kind']] != l for e, l in zip(truth.events, event['LABELS']['value'])), 0


def read_c3d(folder, truth):
    # residuals: ezc3d takes the two bytes of the fourth word the other way round than c3d.org; this reader takes them so
    import c3d
    with open(folder / 'motion.c3d', 'rb') as file:
        rows = np.array([p for _, p, _ in c3d.Reader(file).read_frames()])[:, :len(truth.names)]
    yield 'points, m', most(rows[:, :, :3] / 1e3 - truth.points), 1e-6
    if truth.sd is not None:
        yield 'residual against SD, mm', most(rows[:, :, 3] - 1e3 * np.sqrt((truth.sd ** 2).mean(2))), 0.051


BONES = {f'{word}{bone}': letter + joint for word, letter in (('Left', 'L'), ('Right', 'R')) for bone, joint in
         (('ForeArm', 'Elbow'), ('Hand', 'Wrist'), ('Leg', 'Knee'), ('Foot', 'Ankle'))} | {'Neck': 'Neck'}


def read_bvh(folder, truth):
    from bvh import Bvh
    file = Bvh((folder / 'motion.bvh').read_text())
    turn = {'X': lambda c, s: [[1, 0, 0], [0, c, -s], [0, s, c]], 'Y': lambda c, s: [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            'Z': lambda c, s: [[c, -s, 0], [s, c, 0], [0, 0, 1]]}

    def places(name):
        chain = [name]
        while file.joint_parent(chain[-1]) is not None: chain.append(file.joint_parent(chain[-1]).name)
        channels = {bone: np.array(file.frames_joint_channels(bone, file.joint_channels(bone))) for bone in chain}
        for i in range(file.nframes):
            of = lambda bone, channel: channels[bone][i, file.joint_channels(bone).index(channel)]
            R, t = np.eye(3), np.array([of(chain[-1], a + 'position') for a in 'XYZ'])
            for bone in reversed(chain):
                if bone != chain[-1]: t = t + R @ np.array(file.joint_offset(bone))
                for axis in 'ZXY':
                    a = np.radians(of(bone, axis + 'rotation'))
                    R = R @ np.array(turn[axis](np.cos(a), np.sin(a)))
            yield t / 100

    yield 'time of a frame, s', abs(file.frame_time - 1 / truth.rate_hz), 1e-6
    for bone, point in BONES.items():
        yield point + ', m', most(np.array(list(places(bone))) - truth.point(point)), 1e-5


COORDINATES = {f'{theirs}_{s}': f'{ours}_{s}' for s in 'lr' for theirs, ours in
               (('knee_angle', 'knee_flexion'), ('hip_flexion', 'hip_flexion'), ('hip_adduction', 'hip_adduction'),
                ('hip_rotation', 'hip_rotation'), ('ankle_angle', 'ankle_dorsiflexion'), ('arm_flex', 'shoulder_flexion'),
                ('arm_add', 'shoulder_adduction'), ('arm_rot', 'shoulder_rotation'), ('elbow_flex', 'elbow_flexion'))}
ZERO = ['subtalar_angle', 'mtp_angle']


def read_opensim_motion(end, unit):
    def read(folder, truth):
        import opensim
        table = opensim.TimeSeriesTable(str(folder / f'motion{end}'))
        columns = {name: unit * table.getDependentColumn(name).to_numpy() for name in table.getColumnLabels()}
        times = np.array(table.getIndependentColumn())
        yield 'times, s', most(times - (truth.first + np.arange(len(truth.points))) / truth.rate_hz), 1e-6
        for theirs, ours in COORDINATES.items():
            if theirs in columns: yield theirs + ', deg', most(columns[theirs] - truth.angles[ours]), 1e-4
        rest = [n for n in columns if n not in COORDINATES and n.rsplit('_', 1)[0] in ZERO]
        yield 'what no fit knows is 0', most([columns[n] for n in rest]), 0
    return read


def read_opensim_trc(folder, truth):
    import opensim
    table = opensim.TimeSeriesTableVec3(str(folder / 'motion.trc'))
    columns = [table.getDependentColumn(name) for name in truth.names]
    values = np.array([[c[i].to_numpy() for c in columns] for i in range(table.getNumRows())])
    yield 'points, m', most(values - truth.points), 1e-6


def columns_of(truth):
    """What a table of a fit must hold."""
    columns = {'time_s': (truth.first + np.arange(len(truth.points))) / truth.rate_hz}
    for i, name in enumerate(truth.names):
        for axis, letter in enumerate('xyz'):
            columns[f'{name}_{letter}_m'] = truth.points[:, i, axis]
            if truth.sd is not None: columns[f'{name}_sd_{letter}_m'] = truth.sd[:, i, axis]
    return columns | {name + '_deg': values for name, values in truth.angles.items()}


def compare_table(values, truth):
    wanted = columns_of(truth)
    yield 'frames', most(values['frame'] - truth.first - np.arange(len(truth.points))), 0
    for unit, limit in (('_s', 1e-6), ('_m', 1e-6), ('_deg', 6e-5)):
        names = [n for n in wanted if n.endswith(unit)]
        both = [np.where(np.isnan(values[n]) & np.isnan(wanted[n]), 0, values[n] - wanted[n]) for n in names]
        yield f'columns in{unit.replace("_", " ")}', most(both), limit


def read_csv(folder, truth):
    rows = list(csv.DictReader(open(folder / 'motion.csv')))
    yield from compare_table({k: np.array([float(r[k] or 'nan') for r in rows]) for k in rows[0]}, truth)


def read_parquet(folder, truth):
    import pyarrow.parquet
    table = pyarrow.parquet.read_table(folder / 'motion.parquet')
    yield from compare_table({n: table.column(n).to_numpy() for n in table.column_names}, truth)


def read_mesh(end):
    def read(folder, truth):
        import trimesh
        own = sorted((folder / end).glob(f'*.{end}'))
        yield 'one for every frame', abs(len(own) - len(truth.points)), 0
        yield 'vertices that are no place', sum(not np.isfinite(trimesh.load(p, process=False).vertices).all() for p in own), 0
        for i in (0, len(own) // 2, len(own) - 1):
            other = folder / ('obj' if end == 'ply' else 'ply')
            [other] = other.glob(own[i].stem + '.*')
            mesh, twin = (trimesh.load(p, process=False, maintain_order=True) for p in (own[i], other))
            yield 'vertices, PLY against OBJ, m', most(mesh.vertices - twin.vertices), 1e-6
            yield 'open edges', 0 if mesh.is_watertight and mesh.is_winding_consistent else 1, 0
            joints = [truth.point(n)[i] for n in ('RHip', 'LKnee', 'RAnkle', 'LElbow', 'RShoulder')]
            # ellipsoids overlap where a joint is: it is within two
            yield 'joints outside', sum(not winding(mesh, joint) > 0.99 for joint in joints), 0
    return read


def winding(mesh, place):
    """How often a closed surface winds around a place: the sum of its triangles' solid angles (Van Oosterom & Strackee 1983)."""
    a, b, c = np.moveaxis(mesh.triangles - place, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    dot = lambda u, v: (u * v).sum(1)
    over = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return np.arctan2(dot(a, np.cross(b, c)), over).sum() / (2 * np.pi)


READERS = {
    ('ezc3d', 'motion.c3d'): read_ezc3d, ('c3d', 'motion.c3d'): read_c3d, ('bvh', 'motion.bvh'): read_bvh,
    ('opensim', 'motion.mot'): read_opensim_motion('.mot', 1.0), ('opensim', 'motion.sto'): read_opensim_motion('.sto', 180 / np.pi),
    ('opensim', 'motion.trc'): read_opensim_trc, ('python', 'motion.csv'): read_csv, ('pyarrow', 'motion.parquet'): read_parquet,
    ('trimesh', 'ply/*.ply'): read_mesh('ply'), ('trimesh', 'obj/*.obj'): read_mesh('obj'),
}

if __name__ == '__main__': sys.exit(run(READERS, __doc__))
