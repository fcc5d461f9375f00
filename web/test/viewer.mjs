// Opens a page of the moving body alone in a frame of Chromium, moves it and says what it measured.
//
//   node test/viewer.mjs VIEWER.html OUT
import { mkdirSync, readFileSync } from 'node:fs'
import assert from 'node:assert/strict'
import { opened } from './browser.mjs'

const [viewer, out] = process.argv.slice(2)
mkdirSync(out, { recursive: true })
const { browser, page, faults, requests } = await opened({ width: 900, height: 560 })
try {
  // as a notebook shows it
  await page.setContent('<iframe sandbox="allow-scripts" width="100%" height="480"></iframe>')
  await page.evaluate((text) => { document.querySelector('iframe').srcdoc = text }, readFileSync(viewer, 'utf8'))
  const frame = await (await page.locator('iframe').elementHandle()).contentFrame()
  await frame.waitForFunction(() => document.body?.dataset.complete)
  assert.deepEqual(requests.filter((url) => !/^(about|data|blob):/.test(url)), [], 'requests')
  assert.deepEqual(faults, [], 'console')

  const picture = () => frame.evaluate(() => document.getElementById('stage').toDataURL())
  const before = await picture()
  await frame.locator('#time').focus()
  for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowRight')
  const moved = await picture()
  assert.notEqual(moved, before, 'the slider does not move the body')
  await frame.locator('#stage').focus()
  await page.keyboard.press('ArrowLeft')
  assert.notEqual(await picture(), moved, 'the arrow keys do not turn the body')
  // it fills its frame, and no more
  const { scroll, inner, stage } = await frame.evaluate(() => ({
    scroll: document.documentElement.scrollHeight, inner: innerHeight, stage: document.getElementById('stage').clientHeight,
  }))
  assert.ok(scroll <= inner && stage > 0.8 * inner, `${stage} of ${inner} px, ${scroll} px high`)
  await page.screenshot({ path: `${out}/viewer.png` })
  console.log(`viewer: ${stage} px high in a frame of ${inner} px`)
} finally {
  await browser.close()
}
