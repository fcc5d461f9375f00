// The room with the body in it, seen from anywhere.
import {
  AmbientLight, Color, DirectionalLight, GridHelper, PerspectiveCamera, Scene as Room, Vector2, Vector3, WebGLRenderer,
} from 'three'
import { OrbitControls } from 'three/addons/controls/OrbitControls.js'
import type { Body } from './body'
import { floats, type Scene } from './scene'

/** What the pelvis does over time, roughly: the middle of all points. */
export function middle(scene: Scene, frame: number): Vector3 | null {
  const { names, places } = scene.points
  const values = (middles ??= floats(places))
  const sum = new Vector3()
  let n = 0
  for (let i = 0; i < names.length; i++) {
    const at = 3 * (frame * names.length + i)
    if (Number.isFinite(values[at])) { sum.add(new Vector3().fromArray(values, at)); n++ }
  }
  return n ? sum.divideScalar(n) : null
}
let middles: Float32Array | undefined

export class Stage {
  readonly renderer: WebGLRenderer
  readonly room = new Room()
  private grid = new GridHelper(12, 24, 0xb8b8b8, 0xdedede)
  private camera = new PerspectiveCamera(35, 1, 0.05, 100)
  private controls: OrbitControls
  private canvas: HTMLCanvasElement

  constructor(private scene: Scene, body: Body, canvas: HTMLCanvasElement) {
    this.canvas = canvas
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true })
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2))
    this.room.background = new Color(0xffffff)
    const sun = new DirectionalLight(0xffffff, 2.2)
    sun.position.set(2, -3, 5)
    this.room.add(new AmbientLight(0xffffff, 1.3), sun, body.object, this.grid)
    this.grid.rotation.x = Math.PI / 2
    this.grid.position.z = scene.floor_m
    this.camera.up.set(0, 0, 1)
    this.controls = new OrbitControls(this.camera, canvas)
    this.controls.enablePan = false
    this.controls.addEventListener('change', () => this.draw())
    this.lookFromTheSide()
    canvas.addEventListener('keydown', (event) => this.key(event))
  }

  /** From the right of where the body goes. */
  private lookFromTheSide() {
    const first = middle(this.scene, 0) ?? new Vector3(0, 0, 1)
    const last = middle(this.scene, this.scene.frames - 1) ?? first
    const way = last.clone().sub(first).setZ(0)
    if (way.length() < 0.3) way.set(1, 0, 0)
    way.normalize()
    const from = new Vector3(way.y, -way.x, 0).multiplyScalar(3.8).addScaledVector(way, 1.7).setZ(0.5)
    this.controls.target.copy(first)
    this.camera.position.copy(first).add(from)
    this.controls.update()
  }

  /** Moves the eye with the body. */
  follow(frame: number) {
    const target = middle(this.scene, frame)
    if (target) {
      this.camera.position.add(target.clone().sub(this.controls.target))
      this.controls.target.copy(target)
    }
    this.controls.update()
    this.draw()
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas
    if (!width || !height) return
    const size = this.renderer.getSize(new Vector2())
    if (size.x !== width || size.y !== height) this.renderer.setSize(width, height, false)
    this.camera.aspect = width / height
    this.camera.updateProjectionMatrix()
    this.renderer.render(this.room, this.camera)
  }

  private key(event: KeyboardEvent) {
    const offset = this.camera.position.clone().sub(this.controls.target)
    const turn = { ArrowLeft: -0.1, ArrowRight: 0.1 }[event.key]
    const lift = { ArrowUp: 0.15, ArrowDown: -0.15 }[event.key]
    const zoom = { '+': 0.9, '-': 1.1 }[event.key]
    if (turn) offset.applyAxisAngle(new Vector3(0, 0, 1), turn)
    else if (lift) offset.z += lift
    else if (zoom) offset.multiplyScalar(zoom)
    else return
    event.preventDefault()
    this.camera.position.copy(this.controls.target).add(offset)
    this.controls.update()
    this.draw()
  }
}
