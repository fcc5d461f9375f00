// Foot strikes and foot offs on a line of time for each foot: a person moves, adds and deletes them, and saves events.json.
import type { FootEvent, Scene, Side } from './scene'
import { decimal, say } from './words'

type Kind = FootEvent['kind']

/** An event by the number of its frame in the recording, which may lie between two. */
type Mark = { side: Side; kind: Kind; frame: number }

const SIDES: Side[] = ['left', 'right']
const SIGNS = { strike: '▼', off: '△' }
const get = <T extends HTMLElement>(id: string) => document.getElementById(id) as T

/** What is wrong with events as they stand, in words; as src/io/gait/events.rs checks them. */
function fault(marks: Mark[]): string | null {
  for (const side of SIDES) {
    const own = marks.filter((mark) => mark.side === side).sort((a, b) => a.frame - b.frame)
    for (let i = 1; i < own.length; i++) {
      const [before, after] = [own[i - 1], own[i]]
      const foot = nameOf(side)
      if (before.kind === after.kind) {
        const frames = { side: foot, before: text(before.frame), after: text(after.frame) }
        return after.kind === 'strike'
          ? say('The {side} foot strikes at frames {before} and {after}, without an off between.', frames)
          : say('The {side} foot leaves at frames {before} and {after}, without a strike between.', frames)
      }
      if (before.frame >= after.frame) return say('The {side} foot strikes and leaves at once, at frame {frame}.', { side: foot, frame: text(after.frame) })
    }
  }
  return null
}

const rounded = (frame: number) => Math.round(frame * 1e4) / 1e4
const text = (frame: number) => decimal(frame, { maximumFractionDigits: 1 })
const nameOf = (side: Side) => (side === 'left' ? say('left') : say('right'))

export class EventEditor {
  private found: Mark[]
  private marks: Mark[]
  private chosen: Mark | null = null
  private isSaved = true
  private at = 0
  private lanes = new Map<Side, HTMLElement>()

  constructor(private scene: Scene, private seek: (frame: number) => void, private changed: () => void) {
    this.found = scene.events.map(({ side, kind, time_s }) => ({ side, kind, frame: rounded(time_s * scene.fps) }))
    this.marks = this.found.map((mark) => ({ ...mark }))
    for (const side of SIDES) {
      const lane = document.createElement('div')
      lane.className = `lane ${side}`
      lane.addEventListener('keydown', (event) => this.pressed(event))
      this.lanes.set(side, lane)
      get('event-lanes').append(lane)
    }

    for (const button of document.querySelectorAll<HTMLButtonElement>('#events [data-kind]')) {
      button.addEventListener('click', () => this.add(button.dataset.side as Side, button.dataset.kind as Kind))
    }
    get('event-delete').addEventListener('click', () => this.remove())
    get('event-undo').addEventListener('click', () => this.undo())
    get('event-save').addEventListener('click', () => this.save())
    addEventListener('beforeunload', (event) => { if (!this.isSaved) event.preventDefault() })
    this.draw()
  }

  /** Moves the line to a frame, counted from the first one. */
  show(frame: number) {
    this.at = frame
    for (const line of document.querySelectorAll<HTMLElement>('.lane i')) line.style.left = this.place(this.scene.first_frame + frame)
  }

  // --- what a person does ----------------------------------------------------------------------------

  private add(side: Side, kind: Kind) {
    const mark = { side, kind, frame: this.scene.first_frame + this.at }
    this.marks.push(mark)
    this.chosen = mark
    this.edited()
  }

  private remove() {
    this.marks = this.marks.filter((mark) => mark !== this.chosen)
    this.chosen = null
    this.edited()
  }

  private undo() {
    this.marks = this.found.map((mark) => ({ ...mark }))
    this.chosen = null
    this.edited()
    this.isSaved = true
  }

  /** Moves a mark to a whole frame, and shows that frame. */
  private move(mark: Mark, frame: number) {
    const { first_frame: first, frames } = this.scene
    mark.frame = Math.min(Math.max(Math.round(frame), first), first + frames - 1)
    this.edited()
    this.seek(mark.frame - first)
  }

  private pressed(event: KeyboardEvent) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key]
    if (!this.chosen) return
    if (step) this.move(this.chosen, this.chosen.frame + step)
    else if (event.key === 'Delete' || event.key === 'Backspace') this.remove()
    else return
    event.preventDefault()
  }

  private save() {
    const { fps, first_frame, frames } = this.scene
    const events = [...this.marks].sort((a, b) => a.frame - b.frame)
    const file = { format: 'maquette-events', version: 1, fps, first_frame, frames, events }
    const link = document.createElement('a')
    link.href = URL.createObjectURL(new Blob([JSON.stringify(file, null, 1)], { type: 'application/json' }))
    link.download = 'events.json'
    link.click()
    URL.revokeObjectURL(link.href)
    this.isSaved = true
    this.tell(say('Saved as events.json among the downloads.'))
  }

  // --- what is shown ---------------------------------------------------------------------------------

  private edited() {
    this.isSaved = false
    const { fps } = this.scene
    this.scene.events = this.marks.map(({ side, kind, frame }) => ({ side, kind, time_s: frame / fps }))
    this.draw()
    this.changed()
  }

  private draw() {
    for (const [side, lane] of this.lanes) {
      const name = document.createElement('span')
      name.textContent = nameOf(side)
      const own = this.marks.filter((mark) => mark.side === side).sort((a, b) => a.frame - b.frame)
      lane.replaceChildren(name, document.createElement('i'), ...own.map((mark) => this.button(mark)))
    }
    this.show(this.at)
    document.querySelector<HTMLElement>('.lane .chosen')?.focus({ preventScroll: true })

    const wrong = fault(this.marks)
    get<HTMLButtonElement>('event-delete').disabled = !this.chosen
    get<HTMLButtonElement>('event-save').disabled = wrong !== null
    this.tell(wrong ?? '')
  }

  private button(mark: Mark): HTMLElement {
    const button = document.createElement('button')
    button.type = 'button'
    button.textContent = SIGNS[mark.kind]
    const kind = mark.kind === 'strike' ? say('strike') : say('off')
    button.title = say('{side} foot {kind}, frame {frame}', { side: nameOf(mark.side), kind, frame: text(mark.frame) })
    button.setAttribute('aria-label', button.title)
    button.classList.toggle('chosen', mark === this.chosen)
    button.style.left = this.place(mark.frame)
    button.addEventListener('pointerdown', (event) => this.drag(mark, event))
    button.addEventListener('focus', () => this.choose(mark))
    return button
  }

  private choose(mark: Mark) {
    if (mark === this.chosen && document.activeElement?.classList.contains('chosen')) return
    this.chosen = mark
    this.draw()
    this.seek(Math.round(mark.frame) - this.scene.first_frame)
  }

  /** Follows the pointer until it is let go. Marks are drawn anew meanwhile, so that the page listens, not the mark. */
  private drag(mark: Mark, event: PointerEvent) {
    event.preventDefault()
    this.choose(mark)
    const lane = this.lanes.get(mark.side)!.getBoundingClientRect()
    const { first_frame: first, frames } = this.scene
    const follow = (moved: PointerEvent) => {
      const frame = Math.round(first + ((moved.clientX - lane.left) / lane.width) * (frames - 1))
      if (Math.abs(moved.clientX - event.clientX) > 2 && frame !== mark.frame) this.move(mark, frame)
    }
    const end = () => {
      removeEventListener('pointermove', follow)
      removeEventListener('pointerup', end)
      removeEventListener('pointercancel', end)
    }
    addEventListener('pointermove', follow)
    addEventListener('pointerup', end)
    addEventListener('pointercancel', end)
  }

  private place(frame: number): string {
    return `${(100 * (frame - this.scene.first_frame)) / Math.max(this.scene.frames - 1, 1)}%`
  }

  private tell(words: string) {
    get('event-says').textContent = words
  }
}
