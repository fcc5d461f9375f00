// Joint angles over time, with a line at the frame that is shown.
import uPlot from 'uplot'
import 'uplot/dist/uPlot.min.css'
import { floats, type Scene, type Track } from './scene'
import { decimal, say } from './words'

const groups = (): [string, string[]][] => [
  [say('hip, knee, ankle'), ['hip_flexion', 'knee_flexion', 'ankle_dorsiflexion']],
  [say('pelvis'), ['pelvis_tilt', 'pelvis_obliquity', 'pelvis_rotation']],
  [say('hip'), ['hip_flexion', 'hip_adduction', 'hip_rotation']],
  [say('trunk'), ['trunk_tilt', 'trunk_obliquity', 'trunk_rotation']],
  [say('arms'), ['shoulder_flexion', 'shoulder_adduction', 'elbow_flexion']],
]

export class Curves {
  private charts: uPlot[] = []
  private at = 0

  constructor(
    private scene: Scene, private place: HTMLElement, private choice: HTMLSelectElement,
    private seek: (frame: number) => void,
  ) {
    const isThere = (name: string) => scene.tracks.some((track) => track.name === name)
    for (const [title, names] of groups()) {
      if (names.some(isThere)) choice.add(new Option(title, title))
    }
    choice.addEventListener('change', () => this.draw())
    new ResizeObserver(() => this.fit()).observe(place)
    this.draw()
  }

  /** Draws the chosen group anew, in the colours of the page. */
  draw() {
    this.charts.forEach((chart) => chart.destroy())
    const names = groups().find(([title]) => title === this.choice.value)?.[1] ?? []
    const of = (name: string) => this.scene.tracks.filter((track) => track.name === name)
    this.charts = names.map(of).filter((tracks) => tracks.length > 0).map((tracks) => this.chart(tracks))
    this.showSoon()
  }

  /** Draws the ticks of the events anew. */
  mark() {
    this.charts.forEach((chart) => chart.redraw(false, false))
  }

  /** Moves the line. */
  show(frame: number) {
    this.at = frame
    for (const chart of this.charts) {
      const left = chart.valToPos(frame / this.scene.fps, 'x')
      chart.setCursor({ left, top: -10 }, false)
    }
  }

  /** A chart that was made or changed knows its scales only when it is drawn, which is not at once. */
  private showSoon() {
    queueMicrotask(() => this.show(this.at))
  }

  /** Keeps the size, whatever the width of the page. */
  hold(holds: boolean) {
    this.place.style.width = holds ? `${this.place.clientWidth}px` : ''
  }

  private chart(tracks: Track[]): uPlot {
    const { fps, frames } = this.scene
    const times = Array.from({ length: frames }, (_, i) => i / fps)
    const known = (v: number) => (Number.isFinite(v) ? v : null)
    const values = tracks.map((track) => Array.from(floats(track.values), known))
    const colour = (side: string) => getComputedStyle(this.place).getPropertyValue(`--${side}`).trim()
    const start = this.scene.first_frame / fps
    const strikes = (chart: uPlot) => {
      for (const event of this.scene.events) {
        const x = chart.valToPos(event.time_s - start, 'x', true)
        chart.ctx.fillStyle = colour(event.side)
        const { top, height } = chart.bbox
        const tick = event.kind === 'strike' ? 12 : 6
        chart.ctx.fillRect(x, top + height - tick * devicePixelRatio, 1.5 * devicePixelRatio, tick * devicePixelRatio)
      }
    }
    const chart: uPlot = new uPlot({
      width: this.place.clientWidth, height: 150,
      title: `${tracks[0].title}   (${tracks[0].axis})`,
      legend: { show: false },
      cursor: {
        y: false, drag: { x: false, y: false },
        bind: {
          mousemove: (self, _, handler) => (event) => { this.pointed(self, event); return handler(event) },
          mouseleave: () => () => { this.show(this.at); return null },
        },
      },
      scales: { x: { time: false } },
      axes: [{ size: 24, font: '11px sans-serif', values: (_, at) => at.map((v) => `${decimal(v)} s`) },
        { size: 40, font: '11px sans-serif', values: (_, at) => at.map((v) => decimal(v)) }],
      series: [{}, ...tracks.map((track) => ({
        label: track.side, stroke: colour(track.side), width: 1.8, points: { show: false },
        dash: track.side === 'left' && document.body.classList.contains('cb') ? [6, 3] : undefined,
      }))],
      hooks: { draw: [strikes] },
    }, [times, ...values], this.place)
    return chart
  }

  private pointed(chart: uPlot, event: MouseEvent) {
    const left = event.clientX - chart.over.getBoundingClientRect().left
    const frame = Math.round(chart.posToVal(left, 'x') * this.scene.fps)
    if (event.buttons & 1) this.seek(frame)
  }

  private fit() {
    const { clientWidth: width } = this.place
    const changed = this.charts.filter((chart) => chart.width !== width)
    if (changed.length === 0) return
    changed.forEach((chart) => chart.setSize({ width, height: 150 }))
    this.showSoon()
  }
}
