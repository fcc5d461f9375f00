// The moving body: a skin on bones, ellipsoids on bones, or lines between points where no body was fitted.
import {
  Bone, BufferAttribute, BufferGeometry, Color, Group, LineSegments, LineBasicMaterial, Matrix4, Mesh, MeshLambertMaterial,
  Quaternion, Skeleton, SkinnedMesh, SphereGeometry, Vector3,
} from 'three'
import { floats, indices, octets, type Ellipsoids, type Scene, type Skin } from './scene'

export type Body = {
  object: Group
  /** Shows a frame; false where nobody was seen. */
  pose(frame: number): boolean
  /** Shows the pose of rest; false where there is none. */
  rest(): boolean
  /** Draws in the colours of the page. */
  paint?(): void
}

const FLESH = new MeshLambertMaterial({ color: 0xd9b8a4 })

export function makeBody(scene: Scene): Body {
  return scene.body ? fitted(scene.body) : lines(scene)
}

function fitted(body: NonNullable<Scene['body']>): Body {
  const object = new Group()
  const poses = floats(body.poses)
  const atRest = floats(body.bind)
  const bones = Array.from({ length: body.parts }, () => new Bone())
  object.add(...bones)
  const place = (from: Float32Array, start: number) => {
    const isKnown = Number.isFinite(from[start])
    object.visible = isKnown
    bones.forEach((bone, i) => {
      const at = start + 7 * i
      if (!isKnown) return
      bone.position.fromArray(from, at)
      bone.quaternion.fromArray(from, at + 3)
    })
    object.updateMatrixWorld(true)
    return isKnown
  }
  place(atRest, 0)
  if (body.flesh.kind === 'skin') object.add(skin(body.flesh, bones))
  else addEllipsoids(body.flesh, bones)
  return {
    object,
    pose: (frame) => place(poses, frame * 7 * body.parts),
    rest: () => place(atRest, 0),
  }
}

/** A skin that hangs on the bones as they stand now. */
function skin(flesh: Skin, bones: Bone[]): SkinnedMesh {
  const geometry = new BufferGeometry()
  geometry.setAttribute('position', new BufferAttribute(floats(flesh.vertices), 3))
  geometry.setAttribute('normal', new BufferAttribute(floats(flesh.normals), 3))
  geometry.setAttribute('skinIndex', new BufferAttribute(octets(flesh.bones), 4))
  geometry.setAttribute('skinWeight', new BufferAttribute(floats(flesh.weights), 4))
  geometry.setIndex(new BufferAttribute(indices(flesh.triangles), 1))
  const mesh = new SkinnedMesh(geometry, FLESH)
  mesh.frustumCulled = false
  mesh.bind(new Skeleton(bones), new Matrix4())
  return mesh
}

function addEllipsoids(flesh: Ellipsoids, bones: Bone[]) {
  const sphere = new SphereGeometry(1, 32, 20)
  for (const { part, centre, turn, radii } of flesh.ellipsoids) {
    const mesh = new Mesh(sphere, FLESH)
    mesh.position.copy(new Vector3(...centre))
    mesh.quaternion.copy(new Quaternion(...turn))
    mesh.scale.copy(new Vector3(...radii))
    bones[part].add(mesh)
  }
}

const LINES = ['shoulder hip', 'hip knee', 'knee ankle', 'ankle heel', 'heel toe', 'ankle toe', 'shoulder elbow', 'elbow wrist']

/** Points of another system. */
function lines(scene: Scene): Body {
  const { names, places } = scene.points
  const values = floats(places)
  const find = (side: string, name: string) => names.indexOf(`${side} ${name}`)
  // the sides in the colours of the curves
  const lines = ['left', 'right'].flatMap((side) =>
    LINES.map((line) => ({ side, pair: line.split(' ').map((name) => find(side, name)) })))
  lines.push(...['hip', 'shoulder'].map((name) => ({ side: 'ink', pair: [find('left', name), find('right', name)] })))
  const known = lines.filter(({ pair }) => pair.every((i) => i >= 0))
  const geometry = new BufferGeometry()
  const attribute = new BufferAttribute(new Float32Array(6 * known.length), 3)
  geometry.setAttribute('position', attribute)
  const colours = new BufferAttribute(new Float32Array(6 * known.length), 3)
  geometry.setAttribute('color', colours)
  const paint = () => {
    const style = getComputedStyle(document.getElementById('stage') ?? document.body)
    known.forEach(({ side }, i) => {
      const colour = new Color(style.getPropertyValue(`--${side}`).trim())
      for (const end of [2 * i, 2 * i + 1]) colours.setXYZ(end, colour.r, colour.g, colour.b)
    })
    colours.needsUpdate = true
  }
  paint()
  const object = new Group()
  const drawn = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }))
  drawn.frustumCulled = false
  object.add(drawn)
  return {
    object,
    pose(frame) {
      const start = frame * 3 * names.length
      known.flatMap(({ pair }) => pair).forEach((point, i) => {
        for (let k = 0; k < 3; k++) attribute.array[3 * i + k] = values[start + 3 * point + k]
      })
      attribute.needsUpdate = true
      const isKnown = attribute.array.every(Number.isFinite)
      object.visible = isKnown
      return isKnown
    },
    rest: () => false,
    paint,
  }
}
