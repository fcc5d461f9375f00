// Chromium with a page that keeps what it asks for and what goes wrong in it.
import { chromium } from 'playwright-core'

export async function opened(viewport) {
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  })
  const page = await browser.newPage({ viewport })
  const faults = [], requests = []
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) faults.push(message.text()) })
  page.on('pageerror', (fault) => faults.push(fault.message))
  page.on('request', (request) => requests.push(request.url()))
  return { browser, page, faults, requests }
}
