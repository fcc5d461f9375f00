// Corrects the foot strikes and foot offs of a report in Chromium: drags, moves by keys, adds, deletes, and saves events.json.
//
//   node test/events.mjs REPORT.html OUT
import { mkdirSync, readFileSync } from 'node:fs'
import { resolve } from 'node:path'
import { pathToFileURL } from 'node:url'
import assert from 'node:assert/strict'
import { opened } from './browser.mjs'

const [report, out] = process.argv.slice(2)
mkdirSync(out, { recursive: true })
const { browser, page, faults, requests } = await opened({ width: 1100, height: 1200 })
try {
  await page.goto(pathToFileURL(resolve(report)).href)
  await page.waitForFunction(() => document.body.dataset.complete)
  const scene = JSON.parse(await page.locator('#scene').textContent())
  const marks = page.locator('.lane button')
  const names = () => marks.evaluateAll((all) => all.map((mark) => mark.title))
  const says = () => page.locator('#event-says').textContent()
  const save = page.locator('#event-save')
  async function saved() {
    const [file] = await Promise.all([page.waitForEvent('download'), save.click()])
    assert.equal(file.suggestedFilename(), 'events.json')
    await file.saveAs(`${out}/events.json`)
    return JSON.parse(readFileSync(`${out}/events.json`, 'utf8'))
  }

  // as found: every event of the report, at its own time
  const before = await saved()
  assert.equal(before.events.length, scene.events.length)
  assert.deepEqual([before.format, before.version, before.fps, before.first_frame, before.frames],
    ['maquette-events', 1, scene.fps, scene.first_frame, scene.frames])
  const times = [...scene.events].map((event) => event.time_s).sort((a, b) => a - b)
  before.events.forEach((event, i) => assert.ok(Math.abs(event.frame / scene.fps - times[i]) < 1e-5, `event ${i}`))

  // dragged by the mouse, which shows its frame
  const mark = marks.first()
  await page.locator('#events').scrollIntoViewIfNeeded()
  const { x, y, width, height } = await mark.boundingBox()
  const frames = (await page.locator('.lane').first().boundingBox()).width / (scene.frames - 1)
  await page.mouse.move(x + width / 2, y + height / 2)
  await page.mouse.down()
  await page.mouse.move(x + width / 2 + 4 * frames, y + height / 2, { steps: 5 })
  await page.mouse.up()
  const dragged = Number((await page.locator('.lane .chosen').getAttribute('title')).match(/frame (.+)/)[1])
  const old = before.events.find((event) => event.side === 'left').frame
  assert.ok(Math.abs(dragged - old - 4) <= 1, `dragged from ${old} to ${dragged}`)
  assert.equal(await page.evaluate(() => document.body.dataset.frame), String(dragged), 'the shown frame')

  // and by the keys
  await page.keyboard.press('ArrowRight')
  await page.keyboard.press('ArrowRight')
  await page.keyboard.press('ArrowLeft')
  const moved = await saved()
  const left = moved.events.filter((event) => event.side === 'left')
  assert.equal(left[0].frame, dragged + 1)
  assert.deepEqual(moved.events.filter((event) => event.side === 'right'), before.events.filter((event) => event.side === 'right'))

  // two of a kind in turn cannot be saved, and the page says why
  await page.locator('#time').fill(String(left[0].frame + 1 - scene.first_frame))
  await page.locator(`[data-side=left][data-kind=${left[0].kind}]`).click()
  assert.ok(await save.isDisabled())
  assert.match(await says(), /left foot .* without an? /)
  await page.locator('#events').screenshot({ path: `${out}/fault.png` })
  // without it they can
  await page.keyboard.press('Delete')
  assert.deepEqual(await saved(), moved)

  // everything deleted, and everything back
  for (let left = await marks.count(); left > 0; left--) {
    await marks.first().focus()
    await page.locator('#event-delete').click()
  }
  assert.deepEqual((await saved()).events, [])
  await page.locator('#event-undo').click()
  assert.deepEqual(await saved(), before)
  assert.equal((await names()).length, before.events.length)

  // for the program: the first left event three frames later
  await page.locator('.lane.left button').first().focus()
  for (let i = 0; i < 3; i++) await page.keyboard.press('ArrowRight')
  await saved()
  await page.locator('#motion').screenshot({ path: `${out}/motion.png` })
  assert.deepEqual(requests.filter((url) => !/^(file|data|blob):/.test(url)), [], 'requests')
  assert.deepEqual(faults, [], 'console')
  console.log(`${report}: ${before.events.length} events moved, added, deleted and saved`)
} finally {
  await browser.close()
}
