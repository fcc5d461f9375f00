// The moving part of the report: slider, body, cameras, curves. A page that shows the body alone has the first two.
import './report.css'
import { makeBody } from './body'
import { Curves } from './curves'
import { EventEditor } from './events'
import { Painter } from './picture'
import { readScene } from './scene'
import { Stage } from './stage'
import { decimal, say } from './words'

const scene = readScene()
const get = <T extends HTMLElement>(id: string) => document.getElementById(id) as T | null
const slider = get<HTMLInputElement>('time')!
const body = makeBody(scene)

let stage: Stage | null = null
let painter: Painter | null = null
try {
  stage = new Stage(scene, body, get<HTMLCanvasElement>('stage')!)
} catch {
  get('no-webgl')!.hidden = false
}
const place = get('curves')
const curves = place && new Curves(scene, place, get<HTMLSelectElement>('group')!, seek)
const editor = get('events') && new EventEditor(scene, seek, () => curves?.mark())

function seek(frame: number) {
  const at = Math.min(Math.max(Math.round(frame), 0), scene.frames - 1)
  slider.value = String(at)
  const number = scene.first_frame + at
  const isSeen = body.pose(at)
  const seconds = decimal(at / scene.fps, { minimumFractionDigits: 2, maximumFractionDigits: 2 })
  const text = say('frame {frame} · {s} s', { frame: number, s: seconds }) + (isSeen ? '' : ` · ${say('nobody seen')}`)
  get('clock')!.textContent = text
  slider.setAttribute('aria-valuetext', text)
  document.body.dataset.frame = String(number)
  stage?.follow(at)
  drawCamera(at)
  curves?.show(at)
  editor?.show(at)
}

function drawCamera(frame: number) {
  const canvas = get<HTMLCanvasElement>('camera')
  const choice = get<HTMLSelectElement>('camera-choice')
  if (!canvas || !choice || !painter) return
  const view = scene.views[Number(choice.value)]
  const draw = () => painter!.camera(view, frame, canvas, 420, get<HTMLInputElement>('camera-body')?.checked)
  draw()
  // a picture that had to be decoded first, unless another frame is shown by now
  painter.waiting(view, frame)?.then(() => {
    if (Number(slider.value) === frame && scene.views[Number(choice.value)] === view) draw()
  })
}

/** All cameras in one frame, for paper. */
async function fillSheet() {
  const sheet = get('sheet')
  if (!sheet || !painter) return
  const middle = Math.floor(scene.frames / 2)
  await Promise.all(scene.views.map((view) => painter!.waiting(view, middle)))
  body.pose(middle)
  for (const view of scene.views) {
    const figure = document.createElement('figure')
    const canvas = document.createElement('canvas')
    const caption = document.createElement('figcaption')
    caption.textContent = say('{camera}, frame {frame}', { camera: view.name, frame: scene.first_frame + middle })
    painter.camera(view, middle, canvas, 260)
    figure.append(canvas, caption)
    sheet.append(figure)
  }
}

function fillPortraits() {
  for (const image of document.querySelectorAll<HTMLImageElement>('img[data-portrait]')) {
    const picture = painter?.portrait(image.dataset.portrait as 'front' | 'side')
    if (picture) image.src = picture
    else image.closest('figure')?.remove()
  }
}

let playing = 0
function play() {
  const button = get('play')!
  if (playing) {
    cancelAnimationFrame(playing)
    playing = 0
  } else {
    let [last, at] = [performance.now(), Number(slider.value)]
    const tick = (now: number) => {
      at = (at + ((now - last) / 1000) * scene.fps * Number(get<HTMLSelectElement>('speed')!.value)) % scene.frames
      last = now
      seek(Math.floor(at))
      playing = requestAnimationFrame(tick)
    }
    playing = requestAnimationFrame(tick)
  }
  button.textContent = playing ? '⏸' : '▶'
  button.setAttribute('aria-label', playing ? say('Pause') : say('Play'))
}

slider.addEventListener('input', () => seek(Number(slider.value)))
get('play')!.addEventListener('click', play)
for (const id of ['camera-choice', 'camera-body']) {
  get(id)?.addEventListener('change', () => drawCamera(Number(slider.value)))
}
get<HTMLInputElement>('colour-blind')?.addEventListener('change', (event) => {
  document.body.classList.toggle('cb', (event.target as HTMLInputElement).checked)
  body.paint?.()
  stage?.draw()
  curves?.draw()
})
// on paper the curves keep the size that they have here: drawn anew they would lose their place
addEventListener('beforeprint', () => curves?.hold(true))
addEventListener('afterprint', () => curves?.hold(false))
addEventListener('resize', () => stage?.draw())
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => curves?.draw())

/**
 * Keeps the page loading until everything is drawn, for a browser that prints as soon as it has loaded: a document within it that is
 * being written. Gives what ends that.
 */
function keepLoading(): () => void {
  const frame = document.createElement('iframe')
  frame.hidden = true
  document.body.append(frame)
  const written = frame.contentDocument
  written?.open()
  return () => { written?.close(); frame.remove() }
}

seek(0)
document.body.dataset.ready = String(Math.round(performance.now()))
// what stands still can wait until the page answers
const loaded = keepLoading()
setTimeout(async () => {
  try {
    if (stage && document.querySelector('#camera, #sheet, img[data-portrait]')) painter = new Painter(body, scene.picture_every)
    fillPortraits()
    await fillSheet()
    // the camera's own picture too
    const view = scene.views[Number(get<HTMLSelectElement>('camera-choice')?.value)]
    if (view && painter) await painter.waiting(view, Number(slider.value))
    seek(Number(slider.value))
    document.body.dataset.complete = String(Math.round(performance.now()))
  } finally {
    // last: the page may count as loaded at once
    loaded()
  }
})
