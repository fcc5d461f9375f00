// What the report's maker hands over: the program's side of src/report/scene.rs.

export type Side = 'left' | 'right'

export type Skin = {
  kind: 'skin'
  vertices: string
  normals: string
  triangles: string
  bones: string
  weights: string
}

export type Ellipsoids = {
  kind: 'ellipsoids'
  ellipsoids: { part: number; centre: number[]; turn: number[]; radii: number[] }[]
}

/** A part of an image without distortion, and when. */
export type Picture = { frame: number; left: number; top: number; width: number; height: number; jpeg: string }

export type View = {
  name: string
  size_px: [number, number]
  intrinsics_px: [number, number, number, number, number]
  camera_from_world: number[]
  outlines: string
  pictures: Picture[]
}

export type Track = { name: string; title: string; axis: string; side: Side; values: string }

/** A foot strike or foot off; its time counts from the recording's frame 0. */
export type FootEvent = { side: Side; kind: 'strike' | 'off'; time_s: number }

export type Scene = {
  fps: number
  first_frame: number
  frames: number
  floor_m: number
  body: { poses: string; bind: string; parts: number; flesh: Skin | Ellipsoids } | null
  points: { names: string[]; places: string }
  tracks: Track[]
  events: FootEvent[]
  views: View[]
  /** Every so many frames have pictures. */
  picture_every: number
  /** What the program says in another language than English. */
  words: Record<string, string>
}

let scene: Scene | undefined

export function readScene(): Scene {
  return (scene ??= JSON.parse(document.getElementById('scene')!.textContent!) as Scene)
}

function bytes(text: string): ArrayBuffer {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer
}

export const floats = (text: string) => new Float32Array(bytes(text))
export const indices = (text: string) => new Uint32Array(bytes(text))
export const octets = (text: string) => new Uint8Array(bytes(text))

/** The closed lines of each frame: x, y, x, y, … in pixels. */
export function outlines(view: View): Float32Array[][] {
  const row = new Int16Array(bytes(view.outlines))
  const frames: Float32Array[][] = []
  for (let at = 0; at < row.length; ) {
    const lines: Float32Array[] = []
    for (let left = row[at++]; left > 0; left--) {
      const length = row[at++]
      lines.push(Float32Array.from(row.subarray(at, at + length), (v) => v / 4))
      at += length
    }
    frames.push(lines)
  }
  return frames
}
