// Reads pages as axe-core does, on a phone, a tablet, a screen and in the dark: no serious violation, nothing wider than the window.
// With VIEW=390 on a phone alone, where the words of another language need most room.
//
//   [VIEW=390] node test/axe.mjs OUT PAGE.html…
import { mkdirSync, readFileSync } from 'node:fs'
import { createRequire } from 'node:module'
import { basename, dirname, resolve } from 'node:path'
import { pathToFileURL } from 'node:url'
import assert from 'node:assert/strict'
import { opened } from './browser.mjs'

const VIEWS = [
  { name: '390', width: 390, scheme: 'light' },
  { name: '820', width: 820, scheme: 'light' },
  { name: '1440', width: 1440, scheme: 'light' },
  { name: 'dark', width: 1440, scheme: 'dark' },
]
const views = VIEWS.filter(({ name }) => [undefined, name].includes(process.env.VIEW))
assert.ok(views.length > 0, `VIEW: expected ${VIEWS.map(({ name }) => name).join(', ')}`)
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8')
const [out, ...pages] = process.argv.slice(2)
mkdirSync(out, { recursive: true })

/** What is wrong with the page as it stands, the worst first. */
async function violations(page) {
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }))
  return found.violations.map(({ id, impact, nodes }) => ({ id, impact, where: nodes.slice(0, 3).map((node) => node.html.slice(0, 160)) }))
}
const isSerious = ({ impact }) => ['serious', 'critical'].includes(impact)

const { browser, page } = await opened({ width: 1440, height: 1000 })
try {
  for (const path of pages) {
    const name = `${basename(dirname(resolve(path)))}-${basename(path, '.html')}`
    for (const { name: view, width, scheme } of views) {
      await page.setViewportSize({ width, height: 1000 })
      await page.emulateMedia({ colorScheme: scheme })
      await page.goto(pathToFileURL(resolve(path)).href)
      await page.evaluate(axe)
      const all = await violations(page)
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)
      console.log(`${name} ${view}: ${all.map(({ id, impact }) => `${id} (${impact})`).join(', ') || 'no violation'}`)
      await page.screenshot({ path: `${out}/${name}-${view}.png`, fullPage: true })
      assert.deepEqual(all.filter(isSerious), [], `${path}, ${view}`)
      assert.ok(wide <= 0, `${path}, ${view}: ${wide} px wider than the window`)
    }
  }

  // the check finds what it is there for
  const faint = views.at(-1).scheme === 'dark' ? '#444' : '#bbb'
  await page.evaluate((colour) => {
    document.documentElement.removeAttribute('lang')
    document.querySelector('h2').style.color = colour
  }, faint)
  const planted = (await violations(page)).filter(isSerious).map(({ id }) => id)
  assert.ok(planted.includes('html-has-lang') && planted.includes('color-contrast'), `planted: ${planted}`)
} finally {
  await browser.close()
}
