// Still pictures of the body: as a camera of the recording saw it, and portraits.
import { AmbientLight, Box3, DirectionalLight, Matrix4, OrthographicCamera, Camera, Scene as Room, Vector3, WebGLRenderer } from 'three'
import type { Body } from './body'
import { outlines, type Picture, type View } from './scene'

/** A part of a camera's image, px. */
export type Crop = { left: number; top: number; width: number; height: number }

/** The part that these lines take up; null if there are none. */
function boxOf(lines: Float32Array[]): Crop | null {
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity]
  for (const line of lines) {
    for (let i = 0; i < line.length; i += 2) {
      left = Math.min(left, line[i]), right = Math.max(right, line[i])
      top = Math.min(top, line[i + 1]), bottom = Math.max(bottom, line[i + 1])
    }
  }
  return left < right && top < bottom ? { left, top, width: right - left, height: bottom - top } : null
}

/** What a camera saw: the lines and the picture of each frame, and a size that holds the lines of any. */
class Seen {
  readonly lines: Float32Array[][]
  private size: { width: number; height: number }
  private pictures = new Map<number, { at: Picture; image: HTMLImageElement; loaded: Promise<void> }>()

  constructor(private view: View) {
    this.lines = outlines(view)
    const boxes = this.lines.map(boxOf).filter((box) => box !== null)
    const height = 1.2 * Math.max(...boxes.map((box) => box.height))
    for (const at of view.pictures) {
      const image = new Image()
      image.src = `data:image/jpeg;base64,${at.jpeg}`
      this.pictures.set(at.frame, { at, image, loaded: image.decode() })
    }
    this.size = { width: Math.max(...boxes.map((box) => 1.2 * box.width), 0.7 * height), height }
  }

  picture(frame: number) {
    return this.pictures.get(frame)
  }

  /** The part of the image around the person, always of one size; the whole image where nobody was seen. */
  crop(frame: number): Crop {
    const box = boxOf(this.lines[frame] ?? [])
    const [width, height] = this.view.size_px
    if (!box) return { left: -0.5, top: -0.5, width, height }
    const { size } = this
    return {
      left: box.left + (box.width - size.width) / 2, top: box.top + (box.height - size.height) / 2, ...size,
    }
  }
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
  private seen = new Map<View, Seen>()

  constructor(private body: Body, private every: number) {
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true, alpha: true })
    this.renderer.setClearColor(0xffffff, 0)
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

  private seenBy(view: View) {
    const seen = this.seen.get(view) ?? new Seen(view)
    this.seen.set(view, seen)
    return seen
  }

  /** The nearest frame before this one that is shown. */
  shown(view: View, frame: number) {
    return view.pictures.length ? frame - (frame % this.every) : frame
  }

  /** When the picture of a frame can be drawn; null if it can be, or there is none. */
  waiting(view: View, frame: number): Promise<void> | null {
    const picture = this.seenBy(view).picture(this.shown(view, frame))
    return picture && !picture.image.complete ? picture.loaded : null
  }

  /** What a camera saw in a frame: the recorded picture, the body, the recorded outline over both. */
  camera(view: View, at: number, canvas: HTMLCanvasElement, height: number, hasBody = true) {
    const seen = this.seenBy(view), frame = this.shown(view, at)
    if (frame !== at) this.body.pose(frame)
    const crop = seen.crop(frame)
    const scale = height / crop.height
    canvas.height = height
    canvas.width = Math.round(crop.width * scale)
    const pen = canvas.getContext('2d')!
    pen.fillStyle = '#fff'
    pen.fillRect(0, 0, canvas.width, canvas.height)
    const picture = seen.picture(frame)
    if (picture) {
      const { left, top, width, height } = picture.at
      pen.drawImage(picture.image, (left - crop.left) * scale, (top - crop.top) * scale, width * scale, height * scale)
      pen.globalAlpha = 0.5
    }
    if (hasBody || !picture) pen.drawImage(this.shot(eyeOf(view, crop), canvas.width, canvas.height), 0, 0)
    pen.globalAlpha = 1
    if (frame !== at) this.body.pose(at)
    for (const [colour, thick] of [['#222', 3.4], ['#ffc400', 1.8]] as const) {
      pen.strokeStyle = colour
      pen.lineWidth = thick
      for (const line of seen.lines[frame] ?? []) {
        pen.beginPath()
        for (let i = 0; i < line.length; i += 2) pen.lineTo((line[i] + 0.5 - crop.left) * scale, (line[i + 1] + 0.5 - crop.top) * scale)
        pen.closePath()
        pen.stroke()
      }
    }
  }

  /** The body at rest from the front or the side, as an address of a picture; null where it has no rest. */
  portrait(from: 'front' | 'side'): string | null {
    if (!this.body.rest()) return null
    const box = new Box3().setFromObject(this.body.object, true)
    const size = box.getSize(new Vector3()), centre = box.getCenter(new Vector3())
    const half = 0.53 * Math.max(size.z, 0.1)
    const wide = from === 'front' ? 0.53 * size.y : 0.3 * size.z
    const eye = new OrthographicCamera(-wide, wide, half, -half, 0.01, 20)
    // at rest the body faces x, with z up
    const way = from === 'front' ? new Vector3(1, 0, 0) : new Vector3(0, -1, 0)
    eye.up.set(0, 0, 1)
    eye.position.copy(centre).addScaledVector(way, 5)
    eye.lookAt(centre)
    eye.updateMatrixWorld()
    return this.shot(eye, Math.round((700 * wide) / half), 700).toDataURL('image/png')
  }
}
