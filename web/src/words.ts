// What the page's program says, in the language of the page: `say('frame {n}', { n: 3 })` in English, or what the page's JSON has for it.
import { readScene } from './scene'

const { words } = readScene()
const language = document.documentElement.lang

/** A text, with values in the place of `{name}`. */
export function say(english: string, values: Record<string, string | number> = {}): string {
  return (words[english] ?? english).replace(/{(\w+)}/g, (whole, name: string) => String(values[name] ?? whole))
}

/** A number with the decimal sign of the page's language. */
export function decimal(value: number, options: Intl.NumberFormatOptions = {}): string {
  return value.toLocaleString(language, { useGrouping: false, ...options })
}
