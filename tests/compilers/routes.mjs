// SPDX-License-Identifier: MIT
// Ways from our headers to something that runs, or that can be looked at. A route takes jobs {name, network, math, form}, and
// answers each with one of
//   {different, compared}   it ran, and so many numbers differ from the C++ reference
//   {operations, inexact}   it was looked at: floating-point operations, and those that its compiler may change
//   {bytes}                 it was made, no more
//   {error}                 the compiler's first message
// A whole route that cannot be gone here answers {skip: reason} instead of a list.
import fs from 'node:fs'
import path from 'node:path'
import { file, firstLine, flatten, headers, here, inParallel, removeSourceLanguage, packages, root, run, runOnVulkan, source, wine, work } from './tools.mjs'

const processors = 2

/// Forms of the dot product and of weight loads: what has them, and the macro.
const forms = {
  dot: ['NTC_DOT4_SM64=1'],
  spirvDot: ['NTC_DOT4_SPIRV=1'],
  wide: ['NTC_WIDE_WEIGHT_LOADS=1'],
  floats: ['NTC_FLOAT_DOT=1'],
}

const getDefines = job => [`NETWORK_VERSION=${job.network}`, `NTC_MATH=${job.math}`, ...(forms[job.form] ?? [])]
const opaque = ['TEXELS_OPAQUE=1', 'NTC_NO_PRECISE=1']
const bare = [...opaque, 'NTC_NO_LOOP_ATTRIBUTES=1']

/// Calls step(job, state) for all that have no error yet, and notes what it throws.
async function forEach(jobs, states, step) {
  await inParallel(jobs.map((job, i) => [job, states[i]]), processors, async ([job, state]) => {
    if (state.error)
      return
    try {
      await step(job, state)
    } catch (error) {
      state.error = firstLine(String(error.message ?? error))
    }
  })
}

const start = jobs => jobs.map(() => ({}))

/// Runs a program; its first message is the error.
async function need(program, words, options) {
  const result = await run(program, words, options)
  if (result.code !== 0)
    throw new Error(firstLine(result.errors + result.output))
  return result
}

/// Texels.hlsl or Texels.comp as text for every job: state.text.
const flattenAll = (jobs, states, shader, defines) =>
  forEach(jobs, states, async (job, state) => {
    state.text = await flatten(job.name, shader, [...getDefines(job), ...defines])
  })

const compileByGlslang = (states, jobs, input, hlsl) =>
  forEach(jobs, states, async (job, state) => {
    state.spirv = file(`${job.name}-glslang`, 'spv')
    const language = hlsl ? ['-D', '-e', 'main'] : []
    await need('glslangValidator', ['-V', '--target-env', 'vulkan1.1', '-S', 'comp', ...language, '-o', state.spirv, input(state)])
  })

async function compareOnVulkan(name, jobs, states) {
  const good = states.map((state, i) => [state, jobs[i]]).filter(([state]) => !state.error)
  const answers = await runOnVulkan(name, good.map(([state, job]) => ({ path: state.spirv, network: job.network, math: job.math })))
  good.forEach(([state], i) => Object.assign(state, answers[i]))
  return states
}

/// Jobs for a process that answers by lines of JSON.
async function askProcess(script, words, jobs, env = {}) {
  const list = path.join(work, `${jobs[0].name}-${path.basename(script, '.mjs')}.json`)
  fs.writeFileSync(list, JSON.stringify(jobs))
  const result = await run('node', [path.join(here, script), ...words, list], { env, seconds: 3000 })
  const lines = result.output.split('\n').filter(line => line !== '').map(line => JSON.parse(line))
  return { lines, errors: result.errors }
}

/// Slang or naga, in one process for all jobs: state.made.
async function compileInWeb(compiler, target, ending, jobs, states) {
  const good = states.map((state, i) => [state, jobs[i]]).filter(([state]) => !state.error)
  if (good.length === 0)
    return
  for (const [state, job] of good)
    state.made = file(`${job.name}-${compiler}`, ending)
  const asked = good.map(([state, job]) => ({ name: job.name, compiler, target, input: state.text, output: state.made }))
  const { lines, errors } = await askProcess('web.mjs', [], asked)
  good.forEach(([state], i) => { if (!lines[i] || lines[i].error) state.error = lines[i]?.error ?? firstLine(errors) })
}

async function compareInDawn(backend, jobs, states) {
  const good = states.map((state, i) => [state, jobs[i]]).filter(([state]) => !state.error)
  if (good.length === 0)
    return states
  const asked = good.map(([state, job]) => ({ name: `${job.name}-${backend}`, wgsl: state.made, network: job.network, math: job.math }))
  const swiftShader = path.join(work, 'swiftshader/vk_swiftshader_icd.json')
  const env = backend === 'vulkan' ? { VK_ICD_FILENAMES: swiftShader, VK_DRIVER_FILES: swiftShader } : { EGL_PLATFORM: 'surfaceless', GALLIVM_PERF: 'nopt' }
  const { lines, errors } = await askProcess('dawn.mjs', [backend], asked, env)
  if (!lines[0] || lines[0].error)
    return { skip: lines[0]?.error ?? firstLine(errors) }
  good.forEach(([state], i) => Object.assign(state, lines[i + 1] ?? { error: firstLine(errors) }))
  return states
}

/// What HlslWindows.exe answers to lines of jobs, in their order: as many as it came to before it ended.
async function askOnWine(lines) {
  const dlls = path.join(packages, 'webgpu/dist/win32-x64')
  const env = { WINEPREFIX: path.join(work, 'wine'), WINEDEBUG: '-all', WINEDLLOVERRIDES: 'd3dcompiler_47=n;dxcompiler=n' }
  const result = await run(wine, [path.join(work, 'HlslWindows.exe'), path.join(dlls, 'dxcompiler.dll'), path.join(dlls, 'd3dcompiler_47.dll'), 'Z:' + headers],
    { input: lines.join(''), env, seconds: process.argv.includes('all') ? 3000 : 120 + 60 * lines.length })
  return result.output.split('\n').map(line => line.replace('\r', '')).filter(line => /^(ok|error)/.test(line))
}

/// Wine sometimes ends, or waits for ever, before a program has begun: what has no answer is asked again. A job without one in the end
/// is the compiler's fault if another job has one, else the machine's.
async function askPatiently(lines, probe) {
  const answers = []
  for (let attempt = 0; attempt < 3 && answers.length < lines.length; attempt++)
    answers.push(...await askOnWine(lines.slice(answers.length)))
  if (answers.length < lines.length) {
    const works = answers.length > 0 || (await askOnWine([probe])).length > 0
    while (answers.length < lines.length)
      answers.push(works ? 'error\tthe compiler ended without a word, three times' : '')
  }
  return answers
}

/// DXC or FXC under Wine, two processes for all jobs: state.made, with a listing beside it. `input` is a source of ours, with
/// the job's defines, or text that is compiled as it is.
async function compileOnWine(compiler, profile, jobs, states, input, defines) {
  const good = states.map((state, i) => [state, jobs[i]]).filter(([state]) => !state.error)
  for (const [state, job] of good)
    state.made = file(`${job.name}-${compiler}`, compiler === 'dxc' ? 'dxil' : 'dxbc')
  const lines = good.map(([state, job]) =>
    [compiler, 'Z:' + input(state), profile(job), 'Z:' + state.made, ...defines(job)].join('\t') + '\n')
  const probe = path.join(work, 'made/probe.hlsl')
  fs.writeFileSync(probe, '[numthreads(1, 1, 1)] void main() {}\n')
  const probeLine = [compiler, 'Z:' + probe, compiler === 'dxc' ? 'cs_6_0' : 'cs_5_0', 'Z:' + file('probe', compiler)].join('\t') + '\n'
  const parts = Array.from({ length: processors }, (_, k) => lines.map((line, i) => i).filter(i => i % processors === k))
  await inParallel(parts, processors, async part => {
    if (part.length === 0)
      return
    const answers = await askPatiently(part.map(i => lines[i]), probeLine)
    part.forEach((i, k) => {
      const state = good[i][0]
      if (answers[k] === '')
        Object.assign(state, { error: 'Wine ended without a word, three times', unanswered: true })
      else if (answers[k] !== 'ok')
        state.error = answers[k].split('\t')[1] || 'no message'
    })
  })
}

/// Operations of a listing of DXIL (LLVM's text), and those with flags that let a driver change them.
function inspectDxil(state) {
  const operations = fs.readFileSync(state.made + '.txt', 'utf8').match(/= f(add|sub|mul|div) [^\n]*/g) ?? []
  state.operations = operations.length
  state.inexact = operations.filter(line => /^= f\w+ .*\b(fast|reassoc|contract|arcp|nnan|ninf|nsz)\b/.test(line)).length
}

/// The same of DXBC: a mad, too, is one rounding or two as the driver likes.
function inspectDxbc(state) {
  const operations = fs.readFileSync(state.made + '.txt', 'utf8').match(/^ *(add|mul|mad|div) [^\n]*/gm) ?? []
  state.operations = operations.length
  state.inexact = operations.filter(line => !line.includes('[precise') || line.trim().startsWith('mad')).length
}

const inspect = (jobs, states, look) => forEach(jobs, states, async (_, state) => look(state))

const getBytes = (jobs, states) =>
  forEach(jobs, states, async (_, state) => { state.bytes = fs.statSync(state.made).size })

const getPass = job => path.join(headers, 'openntc/passes', `${job.form}.hlsl`)

const profileOf = job => job.form === 'dot' ? 'cs_6_4' : 'cs_6_0'

async function crossCompile(jobs, states, ending, options) {
  await flattenAll(jobs, states, 'Texels.comp', options.opaque ? bare : [])
  await compileByGlslang(states, jobs, state => state.text, false)
  await forEach(jobs, states, async (job, state) => {
    state.made = file(`${job.name}-cross`, ending)
    await need('spirv-cross', [state.spirv, '--output', state.made, ...options.words])
  })
}

export const routes = {
  async glslangGlsl(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.comp', [])
    await compileByGlslang(states, jobs, state => state.text, false)
    return compareOnVulkan(jobs[0].name, jobs, states)
  },
  async glslangHlsl(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', ['TEXELS_ATTRIBUTES=1'])
    await compileByGlslang(states, jobs, state => state.text, true)
    return compareOnVulkan(jobs[0].name, jobs, states)
  },
  async dxc(jobs, states = start(jobs)) {
    await compileOnWine('dxc', profileOf, jobs, states, () => source('Texels.hlsl'), getDefines)
    await inspect(jobs, states, inspectDxil)
    return states
  },
  /// Compute passes without a network: a job's form is the file.
  async passDxc(jobs, states = start(jobs)) {
    jobs.forEach((job, i) => { states[i].input = getPass(job) })
    await compileOnWine('dxc', profileOf, jobs, states, state => state.input, () => [])
    await getBytes(jobs, states)
    return states
  },
  async passSlang(jobs, states = start(jobs)) {
    await forEach(jobs, states, async (job, state) => { state.text = await flatten(job.name, getPass(job), ['NTC_HLSL=1']) })
    await compileInWeb('slang', 'SPIRV', 'spv', jobs, states)
    await getBytes(jobs, states)
    return states
  },
  /// Controls: what the comparisons above must notice. Without the qualifier; and as if it were the next network.
  async dxcWithoutPrecise(jobs, states = start(jobs)) {
    await compileOnWine('dxc', profileOf, jobs, states, () => source('Texels.hlsl'), job => [...getDefines(job), 'NTC_NO_PRECISE=1'])
    await inspect(jobs, states, inspectDxil)
    return states
  },
  async wrongNetwork(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.comp', [])
    await compileByGlslang(states, jobs, state => state.text, false)
    return compareOnVulkan(jobs[0].name, jobs.map(job => ({ ...job, network: job.network + 1 })), states)
  },
  async fxc(jobs, states = start(jobs)) {
    await compileOnWine('fxc', () => 'cs_5_0', jobs, states, () => source('Texels.hlsl'),
      job => [...getDefines(job), 'NTC_HLSL=1'])
    await inspect(jobs, states, inspectDxbc)
    return states
  },
  async slangSpirv(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', ['TEXELS_ATTRIBUTES=1', ...opaque])
    await compileInWeb('slang', 'SPIRV', 'raw', jobs, states)
    await forEach(jobs, states, async (job, state) => {
      state.spirv = file(`${job.name}-slang`, 'spv')
      fs.writeFileSync(state.spirv, removeSourceLanguage(fs.readFileSync(state.made)))
    })
    return compareOnVulkan(jobs[0].name, jobs, states)
  },
  async slangGlsl(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', ['TEXELS_ATTRIBUTES=1'])
    await compileInWeb('slang', 'GLSL', 'comp', jobs, states)
    await compileByGlslang(states, jobs, state => state.made, false)
    return compareOnVulkan(jobs[0].name, jobs, states)
  },
  async slangHlsl(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', [])
    await compileInWeb('slang', 'HLSL', 'hlsl', jobs, states)
    const inner = states.map(state => state.made)
    await compileOnWine('dxc', profileOf, jobs, states, state => inner[states.indexOf(state)], () => [])
    await inspect(jobs, states, inspectDxil)
    return states
  },
  async slangMetal(jobs, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', opaque)
    await compileInWeb('slang', 'METAL', 'metal', jobs, states)
    await getBytes(jobs, states)
    await forEach(jobs, states, async (_, state) => {
      if (/\bprecise\b/.test(fs.readFileSync(state.made, 'utf8')))
        throw new Error('the text has the word precise, which is not Metal')
    })
    return states
  },
  async slangWgsl(jobs, backend, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.hlsl', ['TEXELS_ATTRIBUTES=1', 'TEXELS_WORDS=1', ...opaque])
    await compileInWeb('slang', 'WGSL', 'wgsl', jobs, states)
    return compareInDawn(backend, jobs, states)
  },
  async nagaWgsl(jobs, backend, states = start(jobs)) {
    await flattenAll(jobs, states, 'Texels.comp', bare)
    await compileInWeb('naga', '', 'wgsl', jobs, states)
    return compareInDawn(backend, jobs, states)
  },
  async crossGlsl(jobs, states = start(jobs)) {
    await crossCompile(jobs, states, 'comp', { words: ['--version', '450', '--vulkan-semantics'] })
    await compileByGlslang(states, jobs, state => state.made, false)
    return compareOnVulkan(jobs[0].name, jobs, states)
  },
  async crossEssl(jobs, states = start(jobs)) {
    await crossCompile(jobs, states, 'comp', { words: ['--version', '310', '--es'], opaque: true })
    await forEach(jobs, states, async (_, state) => { await need('glslangValidator', ['-S', 'comp', state.made]) })
    await getBytes(jobs, states)
    return states
  },
  async crossHlsl(jobs, states = start(jobs)) {
    await crossCompile(jobs, states, 'hlsl', { words: ['--hlsl', '--shader-model', '60'] })
    const inner = states.map(state => state.made)
    await compileOnWine('dxc', profileOf, jobs, states, state => inner[states.indexOf(state)], () => [])
    await inspect(jobs, states, inspectDxil)
    return states
  },
  async crossMetal(jobs, states = start(jobs)) {
    await crossCompile(jobs, states, 'metal', { words: ['--msl', '--msl-version', '20300'] })
    await getBytes(jobs, states)
    return states
  },
  /// Functions alone, as docs/shaders.md shows them, in a fragment shader of WebGL 2.
  async webGl(jobs, states = start(jobs)) {
    const page = fs.readFileSync(path.join(headers, '../docs/shaders.md'), 'utf8')
    const block = /\/\/ ntc_functions\.glsl\n[^]*?(?=\n *```)/.exec(page)[0].replace(/^ {2}/gm, '')
    const functions = path.join(work, 'ntc_functions.glsl')
    fs.writeFileSync(functions, block + '\n')
    await flattenAll(jobs, states, functions, ['NTC_NO_PRECISE=1', 'NTC_NO_LOOP_ATTRIBUTES=1'])
    await forEach(jobs, states, async (job, state) => {
      state.made = file(`${job.name}-webgl`, 'frag')
      fs.writeFileSync(state.made, '#version 300 es\nprecision highp float; precision highp int; precision highp usampler2D;\n' +
        fs.readFileSync(state.text, 'utf8') + 'out vec4 color;\nuniform usampler2D latents, weights;\n' +
        'layout(std140) uniform Constants { NtcTextureSetConstants desc; };\nvoid main() {\n  float channels[16];\n' +
        '  SampleMaterial(desc, latents, weights, ivec2(gl_FragCoord.xy), 0, channels);\n  color = vec4(channels[0]);\n}\n')
      await need('glslangValidator', [state.made])
    })
    await getBytes(jobs, states)
    return states
  },
  /// The material of examples/engines, for every platform and API of Filament's; with every kind of light, of which each is a variant
  /// with the decoder in it, only in full.
  async filament(jobs, states = start(jobs)) {
    const folder = path.join(root, 'examples/engines/filament')
    const variants = process.argv.includes('all') ? [] : ['-V', 'directionalLighting,dynamicLighting,shadowReceiver,skinning,vsm,fog']
    await flattenAll(jobs, states, path.join(folder, 'functions.glsl'), [])
    const [before, after] = fs.readFileSync(path.join(folder, 'bricks.mat.in'), 'utf8').split('@OPENNTC_FUNCTIONS@')
    await forEach(jobs, states, async (job, state) => {
      state.made = file(`${job.name}-filament`, 'mat')
      fs.writeFileSync(state.made, before + fs.readFileSync(state.text, 'utf8') + after)
      await need('matc', ['-p', 'all', '-a', 'all', ...variants, '-o', `${state.made}.filamat`, state.made], { seconds: 1800 })
      state.bytes = fs.statSync(`${state.made}.filamat`).size
    })
    return states
  },
}
