// Still pictures of the body: as a camera of the recording saw it, and portraits.
import { AmbientLight, Box3, Color, DirectionalLight, Matrix4, OrthographicCamera, Camera, Scene as Room, Vector3, WebGLRenderer } from 'three'
import type { Body } from './body'
import { outlines, type View } from './scene'

/** A part of a camera's image, px. */
export type Crop = { left: number; top: number; width: number; height: number }

/** The part that holds these lines, with some room; the whole image if there are none. */
export function cropOf(view: View, lines: Float32Array[]): Crop {
  const all = lines.flatMap((line) => Array.from(line))
  const [xs, ys] = [0, 1].map((k) => all.filter((_, i) => i % 2 === k))
  const ends = (values: number[], size: number) => {
    const [low, high] = values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity])
    return low < high ? [low, high] : [0, size]
  }
  const [left, right] = ends(xs, view.size_px[0]), [top, bottom] = ends(ys, view.size_px[1])
  const room = 0.12 * Math.max(right - left, bottom - top)
  const height = bottom - top + 2 * room
  const width = Math.max(right - left + 2 * room, 0.6 * height)
  return { left: (left + right - width) / 2, top: top - room, width, height }
}

/** The eye of a part of a calibrated camera: pixel (0, 0) is the centre of the top left pixel, y down, z ahead. */
export function eyeOf(view: View, crop: Crop): Camera {
  const { width, height } = crop
  const [fx, fy, , , skew] = view.intrinsics_px
  const [cx, cy] = [view.intrinsics_px[2] - crop.left, view.intrinsics_px[3] - crop.top]
  const [near, far] = [0.05, 100]
  const eye = new Camera()
  // clip = P · (x, y, z) of the camera with y down and z ahead
  eye.projectionMatrix.set(
    (2 * fx) / width, (2 * skew) / width, (2 * cx + 1) / width - 1, 0,
    0, (-2 * fy) / height, 1 - (2 * cy + 1) / height, 0,
    0, 0, (far + near) / (far - near), (-2 * far * near) / (far - near),
    0, 0, 1, 0,
  )
  eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert()
  const r = view.camera_from_world
  const world = new Matrix4().set(
    r[0], r[1], r[2], r[9], r[3], r[4], r[5], r[10], r[6], r[7], r[8], r[11], 0, 0, 0, 1,
  ).invert()
  eye.matrixAutoUpdate = false
  eye.matrix.copy(world)
  eye.matrixWorld.copy(world)
  eye.matrixWorldInverse.copy(world).invert()
  eye.matrixWorldAutoUpdate = false
  return eye
}

export class Painter {
  private renderer: WebGLRenderer
  private room = new Room()
  private seen = new Map<View, Float32Array[][]>()
  private ways = new Map<View, Float32Array[]>()

  constructor(private body: Body) {
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true })
    this.room.background = new Color(0xffffff)
    const sun = new DirectionalLight(0xffffff, 2)
    sun.position.set(2, -3, 5)
    this.room.add(new AmbientLight(0xffffff, 1.4), sun)
  }

  /** Draws the body with an eye, into its own canvas. */
  private shot(eye: Camera, width: number, height: number) {
    const home = this.body.object.parent
    this.room.add(this.body.object)
    this.renderer.setSize(width, height, false)
    this.renderer.render(this.room, eye)
    home?.add(this.body.object)
    return this.renderer.domElement
  }

  /** What a camera saw in a frame: the body in grey, the recorded outline over it. */
  camera(view: View, frame: number, canvas: HTMLCanvasElement, height: number, still: 'still' | 'moving') {
    if (!this.seen.has(view)) this.seen.set(view, outlines(view))
    const lines = this.seen.get(view)!
    const crop = cropOf(view, still === 'still' ? lines[frame] ?? [] : this.everything(view, lines))
    const scale = height / crop.height
    canvas.height = height
    canvas.width = Math.round(crop.width * scale)
    const pen = canvas.getContext('2d')!
    pen.drawImage(this.shot(eyeOf(view, crop), canvas.width, canvas.height), 0, 0)
    for (const [colour, thick] of [['#222', 3.4], ['#ffc400', 1.8]] as const) {
      pen.strokeStyle = colour
      pen.lineWidth = thick
      for (const line of lines[frame] ?? []) {
        pen.beginPath()
        for (let i = 0; i < line.length; i += 2) pen.lineTo((line[i] + 0.5 - crop.left) * scale, (line[i + 1] + 0.5 - crop.top) * scale)
        pen.closePath()
        pen.stroke()
      }
    }
  }

  /** Every tenth frame's lines: enough to know where the person goes. */
  private everything(view: View, lines: Float32Array[][]): Float32Array[] {
    if (!this.ways.has(view)) this.ways.set(view, lines.filter((_, i) => i % 10 === 0 || i === lines.length - 1).flat())
    return this.ways.get(view)!
  }

  /** The body at rest from the front or the side, as an address of a picture; null where it has no rest. */
  portrait(from: 'front' | 'side'): string | null {
    if (!this.body.rest()) return null
    const box = new Box3().setFromObject(this.body.object, true)
    const size = box.getSize(new Vector3()), centre = box.getCenter(new Vector3())
    const half = 0.53 * Math.max(size.z, size.y, 0.1)
    const eye = new OrthographicCamera(-0.62 * half, 0.62 * half, half, -half, 0.01, 20)
    // at rest the body faces x, with z up
    const way = from === 'front' ? new Vector3(1, 0, 0) : new Vector3(0, -1, 0)
    eye.up.set(0, 0, 1)
    eye.position.copy(centre).addScaledVector(way, 5)
    eye.lookAt(centre)
    eye.updateMatrixWorld()
    return this.shot(eye, 434, 700).toDataURL('image/png')
  }
}
