// Opens a report from the file system in Chromium, moves it, prints it, and says what it measured.
//
//   node test/report.mjs REPORT.html OUT [gait|no-gait]
import { mkdirSync, statSync, writeFileSync } from 'node:fs'
import { resolve } from 'node:path'
import { pathToFileURL } from 'node:url'
import assert from 'node:assert/strict'
import { opened } from './browser.mjs'

const [report, out, kind = 'gait'] = process.argv.slice(2)
mkdirSync(out, { recursive: true })
const { browser, page, faults, requests } = await opened({ width: 1100, height: 1800 })
try {
  await page.addInitScript(() => addEventListener('load', () => { window.completeWhenLoaded = document.body.dataset.complete }))
  await page.goto(pathToFileURL(resolve(report)).href)
  // whoever prints the page when it has loaded prints all of it
  assert.ok(await page.evaluate(() => window.completeWhenLoaded), 'loaded before all was drawn')
  const { ready, complete } = await page.evaluate(() => ({ ...document.body.dataset }))

  // nothing is asked of a network, and nothing went wrong
  const foreign = requests.filter((url) => !/^(file|data|blob):/.test(url))
  assert.deepEqual(foreign, [], 'requests')
  assert.deepEqual(faults, [], 'console')

  // the slider moves the body, by mouse and by keyboard
  const picture = () => page.evaluate(() => document.getElementById('stage').toDataURL())
  const shown = () => page.evaluate(() => document.body.dataset.frame)
  const before = [await picture(), await shown()]
  await page.locator('#time').focus()
  for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowRight')
  const after = [await picture(), await shown()]
  assert.notEqual(after[0], before[0], 'the picture of the body does not change')
  assert.equal(Number(after[1]) - Number(before[1]), 12, 'frames by keyboard')
  await page.locator('#stage').focus()
  await page.keyboard.press('ArrowLeft')
  assert.notEqual(await picture(), after[0], 'the arrow keys do not turn the body')

  // it plays and stops
  await page.locator('#play').click()
  await page.waitForFunction((from) => document.body.dataset.frame !== from, after[1])
  await page.locator('#play').click()

  // every chart and control has a name
  const nameless = await page.evaluate(() => [...document.querySelectorAll('[role=img], input, select, button, img')]
    .filter((e) => !(e.getAttribute('aria-label') || e.getAttribute('alt') || e.closest('label')))
    .map((e) => e.outerHTML.slice(0, 80)))
  assert.deepEqual(nameless, [], 'without a name')
  const charts = await page.locator('#kinematics .chart').count()
  assert.ok(charts >= 6, `${charts} charts of angles`)
  const strides = await page.locator('#consistency .chart').count()
  assert.equal(strides > 0, kind === 'gait', 'charts of strides')

  // page by page, for people to look at
  await page.locator('#time').fill(String(Math.floor(await page.locator('#time').getAttribute('max') / 2)))
  for (const section of await page.locator('main section').all()) {
    await section.screenshot({ path: `${out}/${await section.getAttribute('id')}.png` })
  }
  const line = () => page.locator('#curves .u-cursor-x').first().evaluate((e) => e.style.transform)
  const standsAt = await line()
  await page.getByLabel('colour-blind safe').check()
  await page.locator('#kinematics').screenshot({ path: `${out}/kinematics-colour-blind.png` })
  await page.getByLabel('colour-blind safe').uncheck()
  assert.equal(await line(), standsAt, 'the line in the curves does not stay at its frame')
  await page.pdf({ path: `${out}/report.pdf`, preferCSSPageSize: true })
  assert.deepEqual(faults, [], 'console, at the end')

  const measured = { bytes: statSync(report).size, interactive_ms: Number(ready), complete_ms: Number(complete) }
  writeFileSync(`${out}/measured.json`, JSON.stringify(measured))
  console.log(`${report}: ${JSON.stringify(measured)}`)
  assert.ok(measured.bytes < 15e6, 'size')
} finally {
  await browser.close()
}
