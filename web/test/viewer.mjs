// Opens a page of the moving body alone in a frame of Chromium, moves it and says what it measured.
//
//   node test/viewer.mjs VIEWER.html OUT
import { mkdirSync, readFileSync } from 'node:fs'
import assert from 'node:assert/strict'
import { chromium } from 'playwright-core'

const [viewer, out] = process.argv.slice(2)
mkdirSync(out, { recursive: true })
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
})
try {
  const page = await browser.newPage({ viewport: { width: 900, height: 560 } })
  const faults = [], requests = []
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) faults.push(message.text()) })
  page.on('pageerror', (fault) => faults.push(fault.message))
  page.on('request', (request) => requests.push(request.url()))
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
