#!/usr/bin/env python3
"""Opens the glTF and BVH exports of a fit in Blender, compares them with the fit, and plants a fault in each.

usage: read_in_blender.py OUT      after the same commands as read_exports.py
needs: pip install -r tests/oracles/requirements-blender.txt, which needs the one Python version that Blender is built for
"""
import sys
import bpy
import numpy as np
from mathutils import Vector
from export_truth import most, run

PARTS = {f'{part}_{s}': s.upper() + joint for s in 'lr' for part, joint in
         (('thigh', 'Hip'), ('shank', 'Knee'), ('foot', 'Ankle'), ('upper_arm', 'Shoulder'), ('forearm', 'Elbow'), ('hand', 'Wrist'))} | {'neck': 'Neck'}
BONES = {f'{word}{bone}': letter + joint for word, letter in (('Left', 'L'), ('Right', 'R')) for bone, joint in
         (('UpLeg', 'Hip'), ('ForeArm', 'Elbow'), ('Hand', 'Wrist'), ('Leg', 'Knee'), ('Foot', 'Ankle'))} | {'Neck': 'Neck'}


def empty_scene(rate_hz):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = round(rate_hz)
    bpy.context.scene.render.fps_base = round(rate_hz) / rate_hz


def heads(truth, first, bones, limit_m):
    """Where bones begin in each frame, and where they should; Blender's world is Z up: the file's (x, y, z) is (x, −z, y) there."""
    armature = next(o for o in bpy.data.objects if o.type == 'ARMATURE')
    found = {bone: [] for bone in bones if bone in armature.pose.bones}
    for i in range(len(truth.points)):
        bpy.context.scene.frame_set(first + i)
        for bone, places in found.items():
            places.append((armature.matrix_world @ armature.pose.bones[bone].head)[:])
    yield 'bones', abs(len(found) - len(bones)), 0
    for bone, places in found.items():
        yield bones[bone] + ', m', most(np.array(places)[:, [0, 2, 1]] * [1, 1, -1] - truth.point(bones[bone])), limit_m


def read_glb(folder, truth):
    empty_scene(truth.rate_hz)
    bpy.ops.import_scene.gltf(filepath=str(folder / 'motion.glb'))
    yield from heads(truth, 0, PARTS, 2e-5)
    # the skin that the bones carry, against the fitted one of the same frame
    frame = len(truth.points) // 2
    bpy.context.scene.frame_set(frame)
    skin = bpy.data.objects['skin']
    carried = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    bpy.ops.wm.ply_import(filepath=str(folder / f'ply/frame_{truth.first + frame:06}.ply'), forward_axis='NEGATIVE_Z', up_axis='Y')
    fitted = bpy.context.object
    into = fitted.matrix_world.inverted() @ skin.matrix_world
    apart = []
    for vertex in carried.vertices:
        place = into @ vertex.co
        apart.append((Vector(fitted.closest_point_on_mesh(place)[1]) - place).length)
    yield 'skin, median distance, m', float(np.median(apart)), 0.003


def read_bvh(folder, truth):
    empty_scene(truth.rate_hz)
    bpy.ops.import_anim.bvh(filepath=str(folder / 'motion.bvh'), global_scale=0.01, frame_start=1, use_fps_scale=False)
    # in single precision Blender turns bones that hang straight down, as legs in T-pose do, by up to 4e-5 rad; the file itself is
    # held to 1e-5 m by the BVH reader of read_exports.py
    yield from heads(truth, 1, BONES, 5e-5)


READERS = {('blender', 'motion.glb'): read_glb, ('blender', 'motion.bvh'): read_bvh}

if __name__ == '__main__': sys.exit(run(READERS, __doc__))
