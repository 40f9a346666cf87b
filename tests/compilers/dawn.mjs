// SPDX-License-Identifier: MIT
// A process of its own that runs WGSL in Dawn: node dawn.mjs BACKEND JOBS.json. A job is {wgsl, network, math}; a line of the
// output is an answer as JSON: {different, compared} or {error}. The first line names the adapter.
import fs from 'node:fs'
import path from 'node:path'
import { createRequire } from 'node:module'
import { packages, work, firstLine } from './tools.mjs'

const { create, globals } = createRequire(import.meta.url)(path.join(packages, 'webgpu/index.js'))
Object.assign(globalThis, globals)

const [backend, list] = process.argv.slice(2)
const say = value => fs.writeSync(1, JSON.stringify(value) + '\n')
const gpu = create([`backend=${backend}`])
const adapter = await gpu.requestAdapter({ featureLevel: backend === 'opengles' ? 'compatibility' : 'core' })
if (!adapter) {
  say({ error: `Dawn has no adapter for ${backend} here` })
  process.exit(0)
}
say({ adapter: adapter.info.description || adapter.info.device })
const device = await adapter.requestDevice()
const texels = JSON.parse(fs.readFileSync(path.join(work, 'texels/texels.json'), 'utf8'))

/// Subnormal numbers count as zero, as in the expected numbers.
const toBits = bits => ((bits & 0x7F800000) === 0 ? bits & 0x80000000 : bits) >>> 0

function makeBuffer(bytes, usage) {
  const size = Math.ceil(bytes.length / 4) * 4
  const buffer = device.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST })
  device.queue.writeBuffer(buffer, 0, Buffer.concat([bytes], size))
  return buffer
}

async function decode(job) {
  const read = ending => fs.readFileSync(path.join(work, `texels/n${job.network}m${job.math}.${ending}`))
  device.pushErrorScope('validation')
  const module = device.createShaderModule({ code: fs.readFileSync(job.wgsl, 'utf8') })
  const errors = (await module.getCompilationInfo()).messages.filter(message => message.type === 'error')
  if (errors.length > 0) {
    await device.popErrorScope()
    return { error: firstLine(errors[0].message) }
  }
  const pipeline = await device.createComputePipelineAsync({ layout: 'auto', compute: { module, entryPoint: 'main' } })
  const constants = makeBuffer(read('constants'), GPUBufferUsage.UNIFORM)
  const latents = makeBuffer(read('latents'), GPUBufferUsage.STORAGE)
  const weights = makeBuffer(read('weights'), GPUBufferUsage.STORAGE)
  const bytes = read('expected')
  const expected = new Uint32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length))
  let compared = 0, different = 0
  for (let mip = 0; mip < texels.mips; mip++) {
    const width = texels.width >> mip, height = texels.height >> mip
    const size = width * height * 64
    const request = makeBuffer(Buffer.from(Uint32Array.of(width, height, mip, 0).buffer), GPUBufferUsage.UNIFORM)
    const results = device.createBuffer({ size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC })
    const readback = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST })
    const group = device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: [constants, latents, weights, results, request].map((buffer, binding) => ({ binding, resource: { buffer } })),
    })
    const encoder = device.createCommandEncoder()
    const pass = encoder.beginComputePass()
    pass.setPipeline(pipeline)
    pass.setBindGroup(0, group)
    pass.dispatchWorkgroups(Math.ceil(width * height / 64))
    pass.end()
    encoder.copyBufferToBuffer(results, 0, readback, 0, size)
    device.queue.submit([encoder.finish()])
    await readback.mapAsync(GPUMapMode.READ)
    const outputs = new Uint32Array(readback.getMappedRange().slice(0))
    readback.unmap()
    for (const bits of outputs)
      different += toBits(bits) === expected[compared++] ? 0 : 1
  }
  const error = await device.popErrorScope()
  return error ? { error: firstLine(error.message) } : { different, compared }
}

for (const job of JSON.parse(fs.readFileSync(list, 'utf8'))) {
  try {
    say(await decode(job))
  } catch (error) {
    say({ error: firstLine(String(error.message ?? error)) })
  }
}
process.exit(0) // Dawn's threads would keep the process
