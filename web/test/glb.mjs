// The Khronos validator on a glTF file: no errors, no warnings; and what the file says of itself.
//
//   node test/glb.mjs MOTION.glb
import { readFileSync } from 'node:fs'
import assert from 'node:assert/strict'
import validator from 'gltf-validator'

const [path] = process.argv.slice(2)
const report = await validator.validateBytes(new Uint8Array(readFileSync(path)))
const { numErrors, numWarnings, messages } = report.issues
assert.equal(numErrors + numWarnings, 0, JSON.stringify(messages.slice(0, 5), null, 1))
assert.ok(report.info.hasSkins && report.info.animationCount === 1, 'skinned and animated')
const { animationCount, totalVertexCount, totalTriangleCount } = report.info
console.log(`${path}: valid, ${JSON.stringify({ animationCount, totalVertexCount, totalTriangleCount })}`)
