// SPDX-License-Identifier: MIT
// A run of one route leaves the other rows' days and versions as they were, in the file of results and under the table.
import assert from 'node:assert/strict'
import { makeTable, merge, summarise } from './summary.mjs'

const plan = [{ id: 'A', expect: 'exact' }, { id: 'B', expect: 'precise', remark: 'Read, not run' }]
const result = (id, state) => ({ id, expect: state, network: 1, math: 1, form: '', state, compared: 8 })
const first = { date: '2026-01-02', versions: { mesa: '1', webgpu: '' } }, second = { date: '2026-03-04', versions: { mesa: '2', webgpu: '5' } }

const whole = merge(undefined, true, [result('A', 'exact'), result('B', 'precise')], first)
let table = makeTable(summarise(whole, plan), plan)
assert.match(table, /\| A \| .* \| \*\*exact\*\*, 1 of 1, 8 numbers \|/)
assert.match(table, /\| B \| .* 8 numbers\. Read, not run \|/)
assert.match(table, /on 2026-01-02: mesa 1\.\*/)

const later = merge(whole, true, [result('B', 'precise')], second)
assert.deepEqual(later.results.map(({ id, run }) => [id, run.date]), [['A', '2026-01-02'], ['B', '2026-03-04']])
table = makeTable(summarise(later, plan), plan)
assert.match(table, /on 2026-01-02 \(A\): mesa 1\.\*/)
assert.match(table, /on 2026-03-04 \(B\): mesa 2, webgpu 5\.\*/)

// A short run is no part of a full one.
assert.deepEqual(merge(whole, false, [result('B', 'precise')], second).results.map(({ id }) => id), ['B'])
console.log('ok')
