// SPDX-License-Identifier: MIT
// Results of several runs of the stage become rows, and rows the README's table. A row remembers the run that it is of: its day, and the
// versions of what it went through.
import { maths, networks } from './tools.mjs'

export const begin = '<!-- shader compilers: made by tests/compilers/table.mjs -->', end = '<!-- shader compilers: end -->'

/// What stays of `before` ({all, results}, or nothing) when `results` of a run are added: rows of a run of the same kind that were not asked
/// for this time, as they were.
export function merge(before, all, results, run) {
  const others = before && before.all === all ? before.results.filter(old => !results.some(result => result.id === old.id)) : []
  return { all, results: [...others, ...results.map(result => ({ ...result, run }))] }
}

/// A row for every entry of the plan: how many jobs came out as expected, of what; and whatever else came out.
export function summarise({ results }, plan) {
  const runs = []
  const find = run => {
    const at = runs.findIndex(other => JSON.stringify(other) === JSON.stringify(run))
    return at >= 0 ? at : runs.push(run) - 1
  }
  const rows = []
  for (const { id, expect } of plan) {
    const own = results.filter(result => result.id === id)
    if (own.length === 0)
      continue
    const list = key => [...new Set(own.map(result => result[key]))]
    const others = own.filter(result => !result.skipped && result.state !== expect)
    rows.push({
      id, expect, run: find(own[0].run), jobs: own.length, good: own.filter(result => result.state === expect).length,
      networks: list('network').filter(Boolean), maths: list('math').filter(Boolean), forms: list('form').filter(Boolean),
      numbers: own.reduce((sum, result) => sum + (result.compared ?? 0), 0), others: others.map(result => result.state).slice(0, 3),
      ...(own[0].skipped ? { skipped: own[0].skipped } : {}),
    })
  }
  return { runs, rows }
}

const range = (numbers, names) => numbers.length > 2 && numbers.length === Math.max(...numbers) - Math.min(...numbers) + 1
  ? `${names[Math.min(...numbers) - 1]} … ${names[Math.max(...numbers) - 1]}` : numbers.map(number => names[number - 1]).join(', ')
const formNames = { dot: '`NTC_DOT4_SM64`', spirvDot: '`NTC_DOT4_SPIRV`', wide: '`NTC_WIDE_WEIGHT_LOADS`', floats: '`NTC_FLOAT_DOT`' }

function describeRun({ date, versions }, rows) {
  const named = Object.entries(versions).filter(([, version]) => version).map(([name, version]) => `${name} ${version.replace(/^Glslang Version: /, '')}`)
  return `*\`OPENNTC_STAGES="release compilers-all" bash tests/run.sh\` on ${date}${rows ? ` (${rows})` : ''}: ${named.join(', ')}.*`
}

/// `plan` has what is to be said of a row besides (`remark`).
export function makeTable({ runs, rows }, plan) {
  const remarks = new Map(plan.map(({ id, remark }) => [id, remark]))
  const lines = [begin, '', '| compiler, into | networks; maths modes; forms | result |', '|---|---|---|']
  for (const row of rows) {
    const what = [range(row.networks, networks), range(row.maths, maths), row.forms.map(form => formNames[form]).join(', ')]
    const numbers = row.numbers > 0 ? `, ${row.numbers} numbers` : ''
    const result = row.skipped ? `not run: ${row.skipped}`
      : `**${row.expect}**, ${row.good} of ${row.jobs}${numbers}` + (row.others.length > 0 ? `; else: ${row.others.join('; ')}` : '')
    const remark = remarks.get(row.id)
    lines.push(`| ${row.id} | ${what.filter(Boolean).join('; ')} | ${result}${remark ? `. ${remark}` : ''} |`)
  }
  for (const [i, run] of runs.entries())
    lines.push('', describeRun(run, runs.length > 1 ? rows.filter(row => row.run === i).map(row => row.id).join('; ') : ''))
  lines.push('', end)
  return lines.join('\n')
}
