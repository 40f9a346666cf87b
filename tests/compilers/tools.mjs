// SPDX-License-Identifier: MIT
// What every part of the stage uses: where things are, programs run, shaders flattened, SPIR-V cleaned.
import { spawn } from 'node:child_process'
import fs from 'node:fs'
import path from 'node:path'
import { fileURLToPath } from 'node:url'

export const here = path.dirname(fileURLToPath(import.meta.url))
export const root = path.resolve(here, '../..')
export const work = path.join(root, 'build/compilers')
export const headers = path.join(root, 'shaders')
export const source = name => path.resolve(here, 'shaders', name)
export const packages = path.join(work, 'node_modules')
export const binary = name => path.join(root, 'build/release/bin', name)

export const networks = ['small', 'medium', 'large', 'xlarge', 'gen2', 'gen3'] // numbers count from 1
export const maths = ['INT8', 'INT8_HALF', 'FP8', 'FP16', 'FP32']

/// Runs a program to its end; `input` goes to its standard input. Never throws.
export function run(program, words, { input = '', env = {}, seconds = 600 } = {}) {
  return new Promise(resolve => {
    const child = spawn(program, words, { env: { ...process.env, ...env } })
    let output = '', errors = ''
    const timer = setTimeout(() => child.kill('SIGKILL'), 1000 * seconds)
    child.stdout.on('data', data => { output += data })
    child.stderr.on('data', data => { errors += data })
    child.stdin.on('error', () => {}) // a program that ends before it has read everything
    child.on('error', error => { clearTimeout(timer); resolve({ code: -1, output, errors: String(error.message) }) })
    child.on('close', (code, signal) => {
      clearTimeout(timer)
      resolve({ code: code ?? -1, output, errors: errors + (signal ? `ended by ${signal}` : '') })
    })
    child.stdin.end(input)
  })
}

export async function exists(program) {
  return (await run('sh', ['-c', `command -v "$1"`, 'sh', program])).code === 0
}

/// The first line of a message that says something.
export function firstLine(text) {
  const lines = text.split('\n').map(line => line.trim()).filter(line => line !== '')
  return (lines.find(line => /error/i.test(line)) ?? lines[0] ?? 'no message').slice(0, 300)
}

/// Where wine is: Debian has it outside of the path.
export const wine = fs.existsSync('/usr/lib/wine/wine64') ? '/usr/lib/wine/wine64' : 'wine'

/// What a job made, in the folder of the stage.
export const file = (name, ending) => path.join(work, 'made', `${name}.${ending}`)

/// One text of `shader` (Texels.hlsl or Texels.comp) for these defines; its path.
export async function flatten(name, shader, defines) {
  const folder = path.join(work, 'flat', name)
  fs.rmSync(folder, { recursive: true, force: true }) // the text of an earlier shader has another name
  const words = ['compile-shaders', source(shader), '--flatten', '-I', headers, '--output-dir', folder, '--jobs', '1']
  for (const define of defines)
    words.push('-D', define)
  const result = await run(binary('ntc'), words)
  if (result.code !== 0)
    throw new Error(firstLine(result.errors))
  const text = fs.readdirSync(folder).find(entry => /\.(glsl|hlsl)$/.test(entry))
  return path.join(folder, text)
}

/// SPIR-V without OpSource (3): Debian's validator does not know Slang as a language.
export function removeSourceLanguage(bytes) {
  const words = new Uint32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength))
  const kept = [...words.subarray(0, 5)]
  for (let at = 5; at < words.length;) {
    const count = Math.max(words[at] >>> 16, 1)
    if ((words[at] & 0xFFFF) !== 3)
      kept.push(...words.subarray(at, at + count))
    at += count
  }
  return Buffer.from(Uint32Array.from(kept).buffer)
}

/// Calls work(item) for all, as many at once as there are processors; the answers in the order of the items.
export async function inParallel(items, count, work_) {
  const answers = new Array(items.length)
  let next = 0
  const worker = async () => {
    while (next < items.length) {
      const i = next++
      answers[i] = await work_(items[i])
    }
  }
  await Promise.all(Array.from({ length: count }, worker))
  return answers
}

/// What SPIR-V gives on the Vulkan device. `jobs`: {path, network, math}; the answers: {different, compared} or {error}.
export async function runOnVulkan(name, jobs) {
  if (jobs.length === 0)
    return []
  const list = path.join(work, `${name}.jobs`)
  fs.writeFileSync(list, jobs.map(job => [job.path, job.network, job.math].join('\t') + '\n').join(''))
  fs.rmSync(`${list}.answers`, { force: true })
  const result = await run(binary('compilers_texels'), ['-tc=SPIR-V*'],
    { env: { OPENNTC_TEXELS_JOBS: list, GALLIVM_PERF: 'nopt', LP_NATIVE_VECTOR_WIDTH: '128' } })
  const skipped = /SKIP: .*/.exec(result.output)
  const lines = fs.existsSync(`${list}.answers`) ? fs.readFileSync(`${list}.answers`, 'utf8').split('\n') : []
  return jobs.map((_, i) => {
    const [first, second] = (lines[i] ?? '').split('\t')
    if (second === undefined)
      return { error: skipped ? skipped[0] : firstLine(result.errors || result.output) }
    return first === 'error' ? { error: second } : { different: Number(first), compared: Number(second) }
  })
}
