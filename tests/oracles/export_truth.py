"""What the exports of a fit must hold, how readers say that they do, and faults to see that they would notice.

A reader is a function of the export folder and the truth that yields (what, difference, most) for everything that it compares.
"""
import csv, json, pathlib, re, shutil, struct, sys, tempfile
import numpy as np


class Truth:
    """The fit itself: names and places (frames × points × 3, metres, Y up), their SD, angles by name, events."""

    def __init__(self, out):
        result = json.load(open(f'{out}/result.json'))
        frames = result['motion']['frames']
        if any(f['views'] == 0 for f in frames):
            sys.exit(f'{out}: expected a fit in which every frame was seen')
        self.names = result['motion']['points']
        self.points = np.array([f['points_m'] for f in frames])[:, :, [1, 2, 0]]
        has_sd = frames[0]['sd'] is not None
        self.sd = np.array([f['sd']['points_m'] for f in frames])[:, :, [1, 2, 0]] if has_sd else None
        self.rate_hz = result['recording']['fps']
        self.first = frames[0]['frame']
        rows = list(csv.DictReader(open(f'{out}/gait/angles.csv')))
        self.angles = {k.removesuffix('_deg'): np.array([float(r[k] or 'nan') for r in rows]) for k in rows[0] if k.endswith('_deg')}
        self.events = json.load(open(f'{out}/gait/gait.json'))['events']

    def point(self, name):
        return self.points[:, self.names.index(name)]


def most(difference):
    """The greatest difference; infinite where one of the two is no number."""
    difference = np.abs(np.asarray(difference, float))
    return float(np.where(np.isnan(difference), np.inf, difference).max())


def compare(readers, folder, truth, say=print):
    """Runs readers, {(program, file): function}; gives back the files that one of them refuses or reads differently."""
    wrong = {}
    for (program, file), reader in readers.items():
        try:
            for what, difference, limit in reader(folder, truth):
                say(f'  {program:9} {file:15} {what:28} {difference:.3g} (at most {limit:g})')
                if not difference <= limit:
                    wrong.setdefault(file, f'{program}: {what}')
        except Exception as fault:
            wrong.setdefault(file, f'{program} refuses it: {type(fault).__name__}: {fault}')
    return wrong


def run(readers, usage):
    """The program: compares, and then with a fault in each file; exit code 0 if all is the same and each fault is noticed."""
    if len(sys.argv) != 2:
        print(usage)
        return 2
    out = sys.argv[1]
    truth, folder = Truth(out), pathlib.Path(out) / 'export'
    wrong = compare(readers, folder, truth)
    files = sorted({file for _, file in readers})
    for file, why in wrong.items():
        print(f'{file}: {why}')
    unnoticed = [file for file in files if not notices(readers, folder, truth, file)]
    for file in unnoticed:
        print(f'{file}: a planted fault is not noticed')
    print(f'planted faults that the readers notice: {len(files) - len(unnoticed)} of {len(files)}')
    print(f'files that the independent readers refuse or read differently: {len(wrong)} of {len(files)}')
    return 1 if wrong or unnoticed else 0


def notices(readers, folder, truth, file):
    """Whether the readers of a file notice a fault in it."""
    own = {key: reader for key, reader in readers.items() if key[1] == file}
    with tempfile.TemporaryDirectory() as temporary:
        copy = pathlib.Path(temporary) / 'export'
        shutil.copytree(folder, copy)
        path = next(iter(sorted(copy.glob(file))))
        PLANT[path.suffix](path, truth)
        return bool(compare(own, copy, truth, say=lambda _: None))


def plant_number(path, truth):
    """Adds 0.02 to the ninth number, or the last, of a line of numbers a quarter down."""
    lines = path.read_text().splitlines(keepends=True)
    longest = max(len(number_cells(line)) for line in lines)
    rows = [i for i, line in enumerate(lines) if len(number_cells(line)) == longest]
    row = rows[len(rows) // 4]
    cell = number_cells(lines[row])[:9][-1]
    lines[row] = lines[row][:cell.start()] + f'{float(cell.group()) + 0.02:.6f}' + lines[row][cell.end():]
    path.write_text(''.join(lines))


def number_cells(line):
    return list(re.finditer(r'(?<![\w.])-?\d+\.\d+(?:e[-+]?\d+)?', line))


def shift(data, place, by):
    """Adds to the 32-bit float at a place."""
    struct.pack_into('<f', data, place, struct.unpack_from('<f', data, place)[0] + by)


def plant_c3d(path, truth):
    data = bytearray(path.read_bytes())
    points, start = struct.unpack_from('<H', data, 2)[0], 512 * (struct.unpack_from('<H', data, 16)[0] - 1)
    shift(data, start + 16 * (points * (len(truth.points) // 2) + 3), 1.0)
    path.write_bytes(data)


def plant_glb(path, truth):
    data = bytearray(path.read_bytes())
    length = struct.unpack_from('<I', data, 12)[0]
    document = json.loads(data[20:20 + length])
    # the turn of the right thigh in the middle of its keys
    node = next(i for i, n in enumerate(document['nodes']) if n.get('name') == 'thigh_r')
    animation = document['animations'][0]
    channel = next(c for c in animation['channels'] if c['target'] == {'node': node, 'path': 'rotation'})
    accessor = document['accessors'][animation['samplers'][channel['sampler']]['output']]
    start = 28 + length + document['bufferViews'][accessor['bufferView']].get('byteOffset', 0)
    shift(data, start + 16 * (accessor['count'] // 2), 0.05)
    path.write_bytes(data)


def plant_ply(path, truth):
    data = bytearray(path.read_bytes())
    start = data.index(b'end_header\n') + len('end_header\n')
    shift(data, start + 24 * 1000, 0.01)
    path.write_bytes(data)


def plant_parquet(path, truth):
    import pyarrow, pyarrow.parquet
    table = pyarrow.parquet.read_table(path)
    column = np.array(table.column('RKnee_x_m').to_numpy())
    column[len(column) // 2] += 0.01
    place = table.schema.get_field_index('RKnee_x_m')
    pyarrow.parquet.write_table(table.set_column(place, 'RKnee_x_m', pyarrow.array(column)), path)


PLANT = {'.c3d': plant_c3d, '.glb': plant_glb, '.ply': plant_ply, '.parquet': plant_parquet} | dict.fromkeys(
    ['.trc', '.mot', '.sto', '.bvh', '.csv', '.obj'], plant_number)
